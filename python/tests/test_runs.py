"""Runs: their tables, stills and films, the same as the program's."""

from __future__ import annotations

import subprocess
from pathlib import Path
from typing import Literal

import numpy as np
import pytest

import greenstick
from conftest import PROGRAM, ROOT, SNAP
from greenstick import Run, errors


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run that the program made."""
    folder = tmp_path_factory.mktemp("run") / "run"
    subprocess.run([PROGRAM, "simulate", SNAP, "-o", folder, "--no-pictures", "--quiet"], check=True)
    return folder


@pytest.fixture(scope="module")
def run() -> Run:
    """The same run in memory."""
    return greenstick.simulate(str(SNAP))


def skin(folder: Path, output: Path, *options: str) -> bytes:
    """What the program makes of a run."""
    subprocess.run([PROGRAM, "skin", folder, "-o", output, "--texture-size", "64", *options, "--quiet"], check=True)
    return output.read_bytes()


def test_runs_are_those_of_the_program(folder: Path, run: Run) -> None:
    read = Run.read(folder)
    assert read.times == run.times and read.events == run.events and read.report is None
    for number in range(len(run)):
        assert np.array_equal(read.frame(number).positions, run.frame(number).positions)
    for ours, theirs in ((run.energies, read.energies), (run.forces, read.forces)):
        assert ours.keys() == theirs.keys()
        assert all(np.array_equal(ours[name], theirs[name]) for name in ours)
    header = (folder / "energy.csv").read_text().partition("\n")[0]
    assert list(run.energies) == header.split(",")
    assert run.energies["time_s"].dtype == np.float64 and run.energies["time_s"][-1] == run.times[-1]
    assert set(run.forces["holder"]) == {"clamp 0", "press"}


@pytest.mark.parametrize("faces", [None, "rods"])
def test_stills_and_films_are_those_of_the_program(
    folder: Path, run: Run, tmp_path: Path, faces: Literal["rods"] | None
) -> None:
    options = [] if faces is None else ["--faces", faces]
    theirs = skin(folder, tmp_path / "still.glb", "--frame", "-1", *options)
    for made in (run, Run.read(folder)):
        still = made.skin(-1, faces=faces, texture_size=64)
        assert still.encode("still.glb") == {"still.glb": theirs}
    assert still.write(tmp_path / "ours.glb") == [tmp_path / "ours.glb"]
    assert (tmp_path / "ours.glb").read_bytes() == theirs
    film = run.film(faces=faces, texture_size=64)
    assert len(film) == len(run) == film.report["frames"]
    for name in ("film.glb", "film.usdc"):
        theirs = skin(folder, tmp_path / name, *options)
        assert film.encode(name)[name] == theirs
        (tmp_path / "ours").mkdir(exist_ok=True)
        assert film.write(tmp_path / "ours" / name)[0] == tmp_path / "ours" / name
        assert (tmp_path / "ours" / name).read_bytes() == theirs


def test_a_film_moves_its_pieces(run: Run) -> None:
    film = run.film(faces="rods", texture_size=16, no_bodies=True)
    first, last = film.scene(0), film.scene(-1)
    assert [node.name for node in first.nodes] == [node.name for node in last.nodes]
    moved = [
        np.abs(a.world_mesh().positions - b.world_mesh().positions).max() for a, b in zip(first.nodes, last.nodes)
    ]
    assert max(moved) > 1e-3
    assert len(run.film(frames="1..3", texture_size=16)) == 2
    picture = film.picture(-1, picture_size="64x48", samples=1)
    assert picture.array.shape == (48, 64, 3) and picture.array.std() > 5
    with pytest.raises(errors.InputError, match="there is no frame 99"):
        film.scene(99)
    with pytest.raises(errors.InputError, match="written as .glb, .usdc or .usdz"):
        film.write("film.obj")


def test_skins_have_pieces_and_pictures(run: Run) -> None:
    still = run.skin(texture_size=16)
    names = [node.name for node in still.scene.nodes]
    assert names and still.report["frames"] == 1
    assert still.picture(picture_size="64x48", samples=1).array.std() > 5
    strained = run.skin(0, field="strain", texture_size=16).scene.nodes[0].mesh.attributes
    assert any("STRAIN" in name.upper() for name in strained), strained.keys()
    with pytest.raises(errors.InputError, match="frame is 99"):
        run.skin(99)
    with pytest.raises(errors.InputError, match='expected "drawn", "rods" or None'):
        run.skin(faces="round")  # type: ignore[arg-type]
    with pytest.raises(errors.InputError, match="slabs applies to the skin of the rods"):
        run.skin(faces="drawn", slabs=0.5)
    with pytest.raises(errors.ParameterError, match="did you mean"):
        run.skin(texture_sise=4)
    with pytest.raises(errors.SimulateError, match="holds no simulation"):
        Run.read(ROOT / "docs")


SHORT = """
duration = 0.001
frames_per_second = 2000.0
[rods]
number = 12
edge = ["8 cm", "10 cm"]
[[clamp]]
to = 0.1
[[body]]
name = "press"
at = 0.9
touch = [0, 0, 1]
velocity = [0, 0, -1.5]
size = ["5 cm", "5 cm", "5 cm"]
"""


def test_a_mesh_is_simulated_as_by_the_program(tmp_path: Path) -> None:
    pole = ROOT / "tests/data/pole.ply"
    (tmp_path / "short.toml").write_text(SHORT)
    command: list[str | Path] = [PROGRAM, "simulate", tmp_path / "short.toml", pole, "--unit", "mm", "-o", tmp_path / "run"]
    subprocess.run([*command, "--no-pictures", "--quiet"], check=True)
    ours = greenstick.simulate(SHORT, greenstick.Scene.read(pole, unit="mm"))
    theirs = Run.read(tmp_path / "run")
    assert len(ours) == len(theirs) > 1
    assert np.array_equal(ours.frame(len(ours) - 1).positions, theirs.frame(len(theirs) - 1).positions)
    still = skin(tmp_path / "run", tmp_path / "still.glb", "--frame", "-1", "--faces", "rods")
    assert ours.skin(faces="rods", texture_size=64).encode("still.glb") == {"still.glb": still}
