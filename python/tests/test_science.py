"""The inside of stems, simulation and bending tests."""

from __future__ import annotations

import json
import pickle
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import greenstick
from conftest import PROGRAM
from conftest import SNAP as SNAP_FILE
from greenstick import errors

SNAP = str(SNAP_FILE)


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


@pytest.mark.parametrize(
    ("options", "species", "keys", "table"),
    [
        ((), "white oak", {}, "load-deflection"),
        (("--moisture", "30", "--rods", "25"), "Sitka spruce", {"moisture": 30, "rods": 25}, "events"),
        (("--specimens", "3", "--rods", "16"), "white oak", {"specimens": 3, "rods": 16}, "specimens"),
    ],
)
def test_bending_tests_are_those_of_the_program(
    tmp_path: Path, options: tuple[str, ...], species: str, keys: dict[str, Any], table: str
) -> None:
    ours = greenstick.bend_test(species, **keys)
    command: list[str | Path] = [PROGRAM, "bend-test", "--species", species, *options, "-o", tmp_path / "theirs", "--json"]
    printed = json.loads(subprocess.run(command, check=True, capture_output=True).stdout)
    theirs = {path.name: path.read_bytes() for path in (tmp_path / "theirs").iterdir()}
    assert ours.files == theirs
    assert ours.report.items() <= printed.items()
    columns = ours.arrays(table)
    header = theirs[f"{table}.csv"].decode().partition("\n")[0]
    assert list(columns) == header.split(",")
    ours.write(tmp_path / "ours")
    assert {path.name for path in (tmp_path / "ours").iterdir()} == theirs.keys()
    again = pickle.loads(pickle.dumps(ours))
    assert again.files == ours.files and again.report == ours.report
    assert (ours._repr_png_() or b"").startswith(b"\x89PNG")


def test_a_bending_test_is_beside_the_tables() -> None:
    test = greenstick.bend_test("white oak")
    assert test.report["species"] == "Oak, white"
    curve = test.arrays("load-deflection")
    assert curve["load_N"].max() == pytest.approx(test.report["maximum"]["load_n"])
    assert curve["load_N"].dtype == np.float64 and curve["rods_broken"].dtype == np.int64
    assert (np.diff(curve["deflection_m"]) >= 0).all()
    with pytest.raises(errors.SpeciesError):
        greenstick.bend_test("nothing")
    with pytest.raises(errors.ParameterError, match="moisture is -1"):
        greenstick.bend_test("white oak", moisture=-1)
    with pytest.raises(errors.InputError, match="specimens are of one species"):
        greenstick.bend_test(specimens=5)
    with pytest.raises(KeyError, match="load-deflection"):
        test.arrays("none")
