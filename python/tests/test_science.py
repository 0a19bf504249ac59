"""The inside of stems, simulation and bending tests."""

from __future__ import annotations

import os
import pickle
import subprocess
from pathlib import Path

import numpy as np
import pytest

import greenstick
from greenstick import errors

ROOT = Path(__file__).parents[2]
SNAP = str(ROOT / ".ci/snap.toml")
PROGRAM = Path(os.environ.get("GREENSTICK_PROGRAM", ROOT / "target/release/greenstick"))


def test_the_inside_is_that_of_the_program(tmp_path: Path) -> None:
    made = greenstick.anatomy(only=["particles", "measures"], species="Sitka spruce", resolution=32)
    command: list[str | Path] = [PROGRAM, "anatomy", "-o", tmp_path / "inside", "--only", "particles,measures"]
    subprocess.run([*command, "--species", "Sitka spruce", "--resolution", "32", "--quiet"], check=True)
    theirs = {path.name: path.read_bytes() for path in (tmp_path / "inside").iterdir()}
    assert made.files.keys() == theirs.keys()
    assert made.files == theirs
    made.write(tmp_path / "ours")
    assert {path.name for path in (tmp_path / "ours").iterdir()} == theirs.keys()
    again = pickle.loads(pickle.dumps(made))
    assert again.files == made.files and again.report == made.report
    with pytest.raises(errors.ParameterError, match="did you mean"):
        greenstick.anatomy(specis="oak")


def test_particles_are_a_table() -> None:
    pytest.importorskip("pyarrow")
    made = greenstick.anatomy(only=["particles"], resolution=32)
    table = made.table("particles")
    assert table.num_rows == made.report["particles"]
    with pytest.raises(KeyError, match="particles"):
        made.table("none")


def test_a_run_tells_of_every_frame_and_stops_when_told() -> None:
    seen: list[greenstick.Frame] = []
    run = greenstick.simulate(SNAP, settings={"duration": 0.015}, frame=seen.append)
    assert len(run) == len(seen) > 1
    assert [frame.time for frame in seen] == run.times
    last = run.frame(len(run) - 1)
    assert np.array_equal(last.positions, seen[-1].positions)
    assert last.positions.shape == (last.rod_offsets[-1], 3)
    assert last.diameters.shape == last.parents.shape == (len(last.rod_offsets) - 1,)
    assert not last.positions.flags.owndata and not last.positions.flags.writeable
    assert np.isfinite(last.positions).all()

    def stop(frame: greenstick.Frame) -> None:
        if frame.step > 0:
            raise StopIteration("seen enough")

    with pytest.raises(StopIteration, match="seen enough"):
        greenstick.simulate(SNAP, frame=stop)
    with pytest.raises(errors.ParameterError, match="did you mean"):
        greenstick.simulate("ben")


def test_a_bending_test_is_beside_the_tables() -> None:
    report = greenstick.bend_test("white oak")
    assert report["species"] == "Oak, white"
    with pytest.raises(errors.SpeciesError):
        greenstick.bend_test("nothing")
    with pytest.raises(errors.ParameterError, match="moisture is -1"):
        greenstick.bend_test("white oak", moisture=-1)
