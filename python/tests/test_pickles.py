"""Pickles of runs and of what is made of them: whole, the same wherever a run is, and refused where they are damaged."""

from __future__ import annotations

import copy
import pickle
import shutil
import struct
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import greenstick
import numpy as np
import pytest
from conftest import PROGRAM, ROOT
from greenstick import Request, Run, Session, errors

POLE = ROOT / "tests/data/pole.ply"
# A scene with a mesh, a body that is a mesh, and rods that break soon.
SCENE = """
duration = 0.012
frames_per_second = 500.0
[rods]
number = 12
edge = ["8 cm", "10 cm"]
[[clamp]]
to = 0.1
[[body]]
name = "press"
at = 0.9
touch = [0, 0, 1]
velocity = [0, 0, -15]
shape = "hull"
file = "press.ply"
"""


@pytest.fixture(scope="module")
def scene(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The scene with the mesh of its body beside it."""
    folder = tmp_path_factory.mktemp("pickles")
    (folder / "scene.toml").write_text(SCENE)
    corners = 0.025 * np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]])
    triangles = [[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]]
    greenstick.Scene(greenstick.Mesh(corners, triangles)).write(folder / "press.ply", unit="m")
    return folder / "scene.toml"


@pytest.fixture(scope="module")
def folder(scene: Path) -> Path:
    """A run that the program made."""
    folder = scene.parent / "run"
    command: list[str | Path] = [PROGRAM, "simulate", scene, POLE, "--unit", "mm", "-o", folder]
    subprocess.run([*command, "--no-pictures", "--quiet"], check=True)
    return folder


def simulated(scene: Path) -> Run:
    """The same run in memory."""
    return greenstick.simulate(str(scene), greenstick.Scene.read(POLE, unit="mm"))


@pytest.fixture(scope="module")
def run(scene: Path) -> Run:
    return simulated(scene)


def apart(value: object) -> tuple[Callable[..., Any], tuple[Any, ...]]:
    """What a pickle of a value holds: what makes it again, and the arguments of that."""
    reduced = value.__reduce__()
    assert isinstance(reduced, tuple)
    return reduced[0], reduced[1]


def assert_same(ours: Run, theirs: Run) -> None:
    assert ours.times == theirs.times and ours.events == theirs.events
    for a, b in ((ours.energies, theirs.energies), (ours.forces, theirs.forces)):
        assert a.keys() == b.keys()
        assert all(np.array_equal(a[name], b[name]) for name in a)
    names = ("positions", "rod_offsets", "diameters", "parents", "bonds")
    for number in range(len(theirs)):
        frames = ours.frame(number), theirs.frame(number)
        assert frames[0].time == frames[1].time and frames[0].step == frames[1].step
        assert all(np.array_equal(getattr(frames[0], name), getattr(frames[1], name)) for name in names)


def test_runs_are_the_same_afterwards(folder: Path, run: Run) -> None:
    assert len(run) > 5 and run.events
    for made in (run, Run.read(folder)):
        for again in (pickle.loads(pickle.dumps(made)), copy.deepcopy(made)):
            assert_same(again, run)
            assert again.report == made.report
            assert again.skin(texture_size=16).encode("a.glb") == run.skin(texture_size=16).encode("a.glb")
    frame = run.frame(1)
    again = pickle.loads(pickle.dumps(frame))
    assert (again.time, again.step) == (frame.time, frame.step)
    assert np.array_equal(again.positions, frame.positions) and np.array_equal(again.bonds, frame.bonds)


def test_bytes_are_the_same_wherever_a_run_is(
    scene: Path, folder: Path, run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    in_folder = pickle.dumps(Run.read(folder))
    shutil.copytree(folder, tmp_path / "elsewhere")
    monkeypatch.chdir(tmp_path)
    assert pickle.dumps(Run.read(Path("elsewhere"))) == in_folder
    assert pickle.dumps(pickle.loads(in_folder)) == in_folder
    in_memory = pickle.dumps(run)
    assert pickle.dumps(pickle.loads(in_memory)) == in_memory
    assert pickle.dumps(simulated(scene)) == in_memory
    # The report alone is not in the folder.
    ours, theirs = list(apart(run)[1]), list(apart(Run.read(folder))[1])
    assert ours.pop(1) is not None and theirs.pop(1) is None
    assert pickle.dumps(ours) == pickle.dumps(theirs)


def test_skins_and_films_are_made_again(run: Run) -> None:
    settings = {"texture_size": 16, "lod": [0.5, 0.1]}
    still = run.skin(-1, settings, faces="rods", field="damage", slabs=0.37)
    film = run.film(settings, frames="1..4", no_bodies=True, influences=3)
    pickled = pickle.dumps(still), pickle.dumps(film)
    settings["texture_size"] = 32
    for made, content, name in ((still, pickled[0], "still.glb"), (film, pickled[1], "film.glb")):
        again = pickle.loads(content)
        assert again.report == made.report
        assert again.encode(name) == made.encode(name)
        assert pickle.dumps(again) == content
    # The same is asked with other words.
    last = len(run) - 1
    same = run.skin(last, faces="rods", field="damage", texture_size=16, lod=[0.5, 0.1], slabs=0.37, only_rods=False)
    assert pickle.dumps(same) == pickled[0]
    # Another process has nothing of this one.
    program = "import pickle, sys; a = pickle.load(sys.stdin.buffer); sys.stdout.buffer.write(a.encode('a.glb')['a.glb'])"
    theirs = subprocess.run([sys.executable, "-c", program], input=pickled[0], stdout=subprocess.PIPE, check=True)
    assert theirs.stdout == still.encode("a.glb")["a.glb"]


def test_sessions_keep_their_scene(run: Run) -> None:
    request = Request(rings=8, sectors=12, texture_size=64)
    for session in (Session(), Session(greenstick.built_in_branch())):
        session.pieces(request)
        changed = request.copy()
        changed.update(inclination=20, seed=5)
        pieces = session.pieces(changed)
        assert session.started_at != "stem"
        again, asked = pickle.loads(pickle.dumps((session, changed)))
        assert asked == changed
        made = again.pieces(asked)
        assert again.started_at == "stem"
        assert [p.name for p in made] == [p.name for p in pieces]
        assert all(a.mesh == b.mesh for a, b in zip(made, pieces, strict=True))
        # It works on as the first one does.
        request.seed = 9
        assert again.broken(request).encode("a.glb") == session.broken(request).encode("a.glb")


def checksum(content: bytes) -> int:
    """FNV-1a over words of 8 bytes, the length last, whose high bits are mixed into the low ones."""
    padded = content + bytes(-len(content) % 8)
    value = 0xCBF29CE484222325
    for word in (*struct.unpack(f"<{len(padded) // 8}Q", padded), len(content)):
        value = (value ^ word) * 0x100000001B3 % 2**64
        value ^= value >> 29
    return value


def of_version(sealed: bytes, version: str) -> bytes:
    """Sealed bytes as another version writes them."""
    length = sealed[8]
    assert sealed[9 : 9 + length].decode() == greenstick.__version__
    body = sealed[:8] + bytes([len(version)]) + version.encode() + sealed[9 + length : -8]
    return body + struct.pack("<Q", checksum(body))


def test_pickles_of_other_versions_are_refused_with_what_to_do(run: Run) -> None:
    expected = (
        f"was made by greenstick 9.8.7-rc, and this is {greenstick.__version__}; unpickle it with 9.8.7-rc, or make it again "
        "with this version"
    )
    broken = greenstick.break_wood(Request(rings=8, sectors=12, texture_size=64))
    rings = greenstick.rings(np.array([[0, 0], [9, 0], [9, 8], [0, 8]]), rings=3)
    scene = run.skin(texture_size=16).scene
    for value, place in ((run, 0), (run, 1), (run.frame(0), 0), (scene, 1), (broken, 0), (rings, 0)):
        again, parts = apart(value)
        changed = list(parts)
        changed[place] = of_version(parts[place], greenstick.__version__)
        assert changed[place] == parts[place]
        changed[place] = of_version(parts[place], "9.8.7-rc")
        with pytest.raises(errors.PickleError, match=expected) as raised:
            again(*changed)
        assert isinstance(raised.value, pickle.UnpicklingError) and raised.value.kind == "request"
        changed[place] = parts[place][17:]
        with pytest.raises(errors.PickleError, match="make it again with this version"):
            again(*changed)


def test_damage_is_found_wherever_it_is(run: Run) -> None:
    again, parts = apart(run)
    assert_same(again(*parts), run)
    for place in (0, 1):
        whole = parts[place]
        for at in range(0, len(whole), max(len(whole) // 200, 1)):
            for other in (whole[:at], whole[:at] + bytes([whole[at] ^ 1 << at % 8]) + whole[at + 1 :]):
                changed = list(parts)
                changed[place] = other
                with pytest.raises(errors.PickleError, match="the pickle of a run is damaged"):
                    again(*changed)
    head, report, frames, mesh, bodies = parts
    assert len(mesh.nodes) == 1 and [len(body.nodes) for body in bodies] == [1]
    last = frames[-1]
    for at in range(0, len(last), len(last) // 300):
        for other in (last[:at], last[:at] + bytes([last[at] ^ 1 << at % 8]) + last[at + 1 :]):
            with pytest.raises(errors.PickleError, match="the pickle of a run is damaged"):
                again(head, report, [*frames[:-1], other], mesh, bodies)
    for other in (frames[:-1], [*frames, last], [frames[1], frames[0], *frames[2:]]):
        with pytest.raises(errors.PickleError, match="the pickle of a run is damaged: (it has|frame 0 is)"):
            again(head, report, other, mesh, bodies)
    # One number of a mesh.
    again, (nodes, rest, path) = apart(mesh)
    node = nodes[0]
    positions = node.mesh.positions.copy()
    positions[7, 1] += 1e-12
    moved = greenstick.Mesh(positions, node.mesh.triangles, node.mesh.attributes, node.mesh.materials)
    nodes[0] = greenstick.Node(node.name, moved, node.transform)
    with pytest.raises(errors.PickleError, match="the pickle of a scene is damaged: the checksum of a mesh is wrong"):
        again(nodes, rest, path)
