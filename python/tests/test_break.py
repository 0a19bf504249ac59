"""Breaks: the same bytes as from the program, stages that are kept, pieces that add up."""

from __future__ import annotations

import pickle
import subprocess
import threading
from pathlib import Path

import numpy as np
import pytest

import greenstick
from conftest import PROGRAM, ROOT
from greenstick import Request, Session, errors

RECIPE = """
preset = "splintering-tension"
species = "white oak"
part = "3 cm"
texture_size = 64
picture_size = "80x60"
samples = 1
[break]
seed = 7
"""


@pytest.fixture(scope="module")
def small() -> Request:
    """A request that takes a fraction of a second."""
    return Request(texture_size=64, rings=8, sectors=12, seed=7)


@pytest.mark.parametrize("source", ["built-in", "quaternius_DeadTree_1.gltf"])
def test_the_same_recipe_gives_the_same_bytes_as_the_program(
    tmp_path: Path, source: str
) -> None:
    text = RECIPE
    if source != "built-in":
        text = f'input = "{ROOT / "tests/data" / source}"\nat = 0.1\n{RECIPE}'
    recipe = tmp_path / "recipe.toml"
    recipe.write_text(text)
    ours, theirs = tmp_path / "ours.glb", tmp_path / "theirs.glb"
    command: list[str | Path] = [PROGRAM, "break", "--recipe", recipe, "-o", theirs, "--picture", tmp_path / "theirs.png", "--quiet"]
    subprocess.run(command, check=True)
    broken = greenstick.break_wood(Request.read(recipe))
    assert broken.write(ours) == [ours]
    broken.picture().write(tmp_path / "ours.png")
    assert ours.read_bytes() == theirs.read_bytes()
    assert (tmp_path / "ours.png").read_bytes() == (tmp_path / "theirs.png").read_bytes()
    assert broken.encode("theirs.glb") == {"theirs.glb": theirs.read_bytes()}


def test_pieces_add_up_and_are_closed(small: Request) -> None:
    broken = greenstick.break_wood(small)
    assert [node.name for node in broken.scene.nodes[:2]] == ["lower", "upper"]
    whole = broken.report["input"]["volume_m3"]
    pieces = Session().pieces(small)
    assert sum(piece.mesh.volume for piece in pieces) == pytest.approx(whole, rel=1e-6)
    for piece in pieces:
        found = piece.mesh.check(self_intersections=False)
        assert found["closed"] and found["oriented"]


def test_a_session_makes_anew_what_a_change_touches(small: Request) -> None:
    session = Session()
    request = small.copy()
    session.pieces(request)
    again = session.pieces(request)
    assert session.started_at is None
    request.inclination = 10
    fork = session.fork()
    changed = session.pieces(request)
    assert session.started_at == "heights"
    assert not np.array_equal(changed[0].mesh.positions, again[0].mesh.positions)
    # The fork does not know of it.
    assert np.array_equal(fork.pieces(small)[0].mesh.positions, again[0].mesh.positions)
    assert fork.started_at is None
    # Afresh, the same.
    afresh = Session().pieces(request)
    assert np.array_equal(changed[0].mesh.positions, afresh[0].mesh.positions)


def test_a_session_loads_the_input_of_each_request(small: Request) -> None:
    session = Session()
    session.pieces(small)
    tree = Request(input=str(ROOT / "tests/data/quaternius_DeadTree_1.gltf"), at=0.1, rings=8, sectors=12)
    of_tree = session.pieces(tree)[0].mesh
    given = Session(greenstick.Scene.read(tree.input or "")).pieces(tree)[0].mesh
    assert of_tree == given
    assert session.pieces(small)[0].mesh != of_tree


def test_results_and_requests_pickle(small: Request) -> None:
    broken = greenstick.break_wood(small)
    again = pickle.loads(pickle.dumps(broken))
    assert again.encode("x.glb") == broken.encode("x.glb")
    assert again.report == broken.report
    for value in (small, broken.scene, broken.scene.nodes[0].mesh, Session().pieces(small)[0].mesh):
        assert pickle.loads(pickle.dumps(value)) == value
    given = greenstick.break_wood(small, greenstick.built_in_branch())
    assert pickle.loads(pickle.dumps(given)).encode("x.glb") == given.encode("x.glb")
    scene = pickle.loads(pickle.dumps(broken.scene))
    assert scene.encode("x.glb") == broken.encode("x.glb")
    white_oak = greenstick.Species("white oak")
    assert pickle.loads(pickle.dumps(white_oak)) == white_oak


def test_pictures_are_arrays_and_png(small: Request) -> None:
    picture = greenstick.break_wood(small).picture(picture_size="64x48", samples=1)
    array = picture.array
    assert array.shape == (48, 64, 3) and array.dtype == np.uint8
    assert array.std() > 10
    assert not array.flags.owndata and not array.flags.writeable
    assert picture.png() == picture._repr_png_() == pickle.loads(pickle.dumps(picture)).png()
    assert picture.png().startswith(b"\x89PNG")
    assert np.asarray(picture).shape == (48, 64, 3)


def test_progress_is_told_and_may_stop_the_work() -> None:
    request = Request(texture_size=256)
    seen: list[tuple[str, float]] = []
    greenstick.break_wood(request, progress=lambda stage, fraction: seen.append((stage, fraction)))
    fractions = [fraction for _, fraction in seen]
    assert fractions == sorted(fractions) and 0 <= fractions[0] <= fractions[-1] <= 1

    def stop(stage: str, fraction: float) -> None:
        raise RuntimeError(f"enough of {stage}")

    with pytest.raises(RuntimeError, match="enough"):
        greenstick.break_wood(Request(texture_size=4096), progress=stop)
    with pytest.raises(errors.InputError, match="neither a bool nor callable"):
        greenstick.break_wood(request, progress=3)  # type: ignore[arg-type]


def test_ctrl_c_stops_the_work(tmp_path: Path) -> None:
    script = (
        "import greenstick, signal, threading, os, time\n"
        # Where tests run in the background, shells have it ignored.
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        "threading.Timer(0.5, lambda: os.kill(os.getpid(), signal.SIGINT)).start()\n"
        "try:\n"
        "    greenstick.break_wood(greenstick.Request(texture_size=16384))\n"
        "except KeyboardInterrupt:\n"
        "    print('stopped')\n"
    )
    import sys

    found = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=60)
    assert found.stdout == "stopped\n", found.stderr


def test_other_threads_run_meanwhile() -> None:
    counted = 0
    done = threading.Event()

    def count() -> None:
        nonlocal counted
        while not done.is_set():
            counted += 1
            done.wait(0.001)

    thread = threading.Thread(target=count)
    thread.start()
    greenstick.break_wood(Request(texture_size=1024))
    done.set()
    thread.join()
    assert counted > 10


def test_a_session_of_two_threads_is_refused() -> None:
    session = Session()
    session.pieces(Request())
    caught: list[Exception] = []
    started = threading.Event()

    def work() -> None:
        session.broken(Request(texture_size=2048), progress=lambda *_: started.set())

    thread = threading.Thread(target=work)
    thread.start()
    assert started.wait(30)
    try:
        session.pieces(Request())
    except errors.BusyError as error:
        caught.append(error)
    thread.join()
    assert caught and "fork()" in str(caught[0])
