"""Sweeps: equal to the program's, stopped and gone on with, and on a cluster."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import greenstick
import pytest
from conftest import PROGRAM, needs

TOML = """
[break]
rings = 6
sectors = 12
[sweep]
textures = false
sheet = 2
[vary]
seed = { from = 1, to = 4 }
inclination = [0, 20]
"""
DESCRIPTION: dict[str, Any] = {
    "break.rings": 6,
    "break.sectors": 12,
    "sweep": {"textures": False, "sheet": 2},
    "vary": {"seed": [1, 2, 3]},
}
COUNT = 500
# Many variants without files, which take two processes some seconds.
MANY: dict[str, Any] = {
    "break.rings": 12,
    "break.sectors": 24,
    "break.fuzz": 0,
    "sweep": {"file": "none", "sheet": 0},
    "vary": {"seed": {"from": 1, "to": COUNT}},
}


def rows(sweep: greenstick.Sweep) -> list[dict[str, Any]]:
    table = sweep.table()
    return [{k: v for k, v in row.items() if k != "seconds_s"} for row in table.to_pylist()]


def pieces(folder: Path) -> dict[str, bytes]:
    return {str(p.relative_to(folder)): p.read_bytes() for p in sorted(folder.glob("variants/**/*")) if p.is_file()}


def test_rows_and_pieces_are_those_of_the_program(tmp_path: Path) -> None:
    file = tmp_path / "sweep.toml"
    file.write_text(TOML)
    subprocess.run([PROGRAM, "sweep", file, "-o", tmp_path / "theirs", "--quiet"], check=True)
    ours = greenstick.sweep(file, tmp_path / "ours")
    theirs = greenstick.sweep(file, tmp_path / "theirs")
    assert len(ours) == 8 and ours.report["made"] == 8 and theirs.report["made"] == 0
    assert rows(ours) == rows(theirs)
    assert len(pieces(ours.folder)) >= 8 and pieces(ours.folder) == pieces(theirs.folder)
    assert (ours.folder / "sheet.png").exists()


def test_a_dictionary_is_a_description_and_dots_are_tables(tmp_path: Path) -> None:
    file = tmp_path / "sweep.toml"
    file.write_text("[break]\nseed = 3\n[sweep]\nfile = 'none'\nsheet = 0\n[vary]\nhigh.height = [1, 2]\n")
    described = greenstick.sweep(
        {"break.seed": 3, "sweep": {"file": "none", "sheet": 0}, "vary": {"high.height": [1, 2]}},
        tmp_path / "described",
    )
    assert rows(described) == rows(greenstick.sweep(file, tmp_path / "read"))


def test_a_variant_that_cannot_be_made_is_a_row(tmp_path: Path) -> None:
    made = greenstick.sweep({"sweep": {"file": "none", "sheet": 0}, "vary": {"at": ["0.5", "9 m"]}}, tmp_path / "v")
    assert made.report["failed"] == 1
    errors = [row["error"] for row in rows(made)]
    assert not errors[0] and "off the stem" in errors[1]


def test_what_was_stopped_goes_on_and_nothing_is_made_twice(tmp_path: Path) -> None:
    def stop(_stage: str, fraction: float) -> None:
        if fraction > 0.2:
            raise KeyError("enough")

    with pytest.raises(KeyError):
        greenstick.sweep(MANY, tmp_path / "v", progress=stop)
    rest = greenstick.sweep(MANY, tmp_path / "v")
    assert rest.report["found"] >= COUNT // 10 and rest.report["found"] + rest.report["made"] == COUNT
    assert [row["variant"] for row in rows(rest)] == list(range(COUNT))


def test_parts_are_taken_over(tmp_path: Path) -> None:
    for part in ("1/2", "2/2"):
        made = greenstick.sweep(DESCRIPTION, tmp_path / "v", part=part)
        with pytest.raises(greenstick.errors.InputError, match="a part has no table"):
            made.table()
    whole = greenstick.sweep(DESCRIPTION, tmp_path / "v")
    assert (whole.report["found"], whole.report["made"]) == (3, 0)


@pytest.mark.parametrize(
    ("description", "options", "kind", "text"),
    [
        ({"vary": {"sead": [1]}}, {}, "ParameterError", "sead"),
        ({"vary": {"seed": {"from": 1, "to": 20000}}}, {}, "InputError", "many=True"),
        ({"vary": {"seed": [None]}}, {}, "InputError", "null"),
        ({"vary": {"seed": [1]}}, {"part": "3/2"}, "InputError", "1/8"),
        ({"vary": {"seed": [1]}}, {"threads": 0}, "InputError", "at least 1"),
        ({"vary": {"seed": [1]}}, {"engine": "dask"}, "InputError", "expected"),
        ({"vary": {"seed": [1]}}, {"parts": 3}, "InputError", 'engine="ray"'),
    ],
)
def test_what_is_wrong_is_said_before_anything_is_written(
    description: dict[str, Any], options: dict[str, Any], kind: str, text: str, tmp_path: Path
) -> None:
    with pytest.raises(getattr(greenstick.errors, kind), match=text):
        greenstick.sweep(description, tmp_path / "v", **options)
    assert not (tmp_path / "v" / "variants.parquet").exists()


def test_the_folder_of_another_sweep_is_refused(tmp_path: Path) -> None:
    greenstick.sweep({"sweep": {"file": "none", "sheet": 0}, "vary": {"seed": [1]}}, tmp_path / "v")
    with pytest.raises(greenstick.errors.SweepError, match="holds another sweep"):
        greenstick.sweep({"sweep": {"file": "none", "sheet": 0}, "vary": {"seed": [1, 2]}}, tmp_path / "v")


@pytest.fixture(scope="module")
def cluster() -> Any:
    ray = needs("ray", "GREENSTICK_NEEDS_RAY")
    ray.init(num_cpus=2, include_dashboard=False, log_to_driver=False, object_store_memory=100_000_000)
    yield ray
    ray.shutdown()


def kill_a_worker() -> bool:
    """Kills a process that makes a part; whether there was one."""
    for entry in Path("/proc").glob("[0-9]*/cmdline"):
        try:
            command = entry.read_bytes()
        except OSError:
            continue
        if b"ray::_make_part" in command:
            os.kill(int(entry.parent.name), signal.SIGKILL)
            return True
    return False


def test_a_cluster_makes_the_same_though_a_worker_is_killed(cluster: Any, tmp_path: Path) -> None:
    killed: list[bool] = []

    def kill_one(_stage: str, _fraction: float) -> None:
        if not any(killed):
            killed.append(kill_a_worker())

    ours = greenstick.sweep(MANY, tmp_path / "cluster", engine="ray", parts=4, progress=kill_one)
    assert any(killed)
    assert rows(ours) == rows(greenstick.sweep(MANY, tmp_path / "local"))


def test_a_worker_that_dies_again_and_again_is_an_error_and_nothing_is_lost(cluster: Any, tmp_path: Path) -> None:
    with pytest.raises(greenstick.errors.SweepError, match="died 4 times"):
        greenstick.sweep(
            MANY, tmp_path / "v", engine="ray", parts=1, progress=lambda _stage, _fraction: kill_a_worker()
        )
    assert [row["variant"] for row in rows(greenstick.sweep(MANY, tmp_path / "v"))] == list(range(COUNT))


def test_a_wrong_sweep_on_a_cluster_has_the_same_error(cluster: Any, tmp_path: Path) -> None:
    greenstick.sweep({"sweep": {"file": "none", "sheet": 0}, "vary": {"seed": [1]}}, tmp_path / "v", part="1/2")
    with pytest.raises(greenstick.errors.SweepError, match="holds another sweep"):
        greenstick.sweep(
            {"sweep": {"file": "none", "sheet": 0}, "vary": {"seed": [1, 2]}}, tmp_path / "v", engine="ray", parts=2
        )


def test_a_cluster_that_does_not_answer_is_an_error() -> None:
    needs("ray", "GREENSTICK_NEEDS_RAY")
    code = (
        "import greenstick\n"
        "try:\n"
        "    greenstick.sweep({'vary': {'seed': [1]}}, 'v', engine='ray', address='127.0.0.1:9')\n"
        "except greenstick.errors.SweepError as error:\n"
        "    assert 'does not answer' in str(error)\n"
        "else:\n"
        "    raise SystemExit(1)\n"
    )
    start = time.monotonic()
    subprocess.run([sys.executable, "-c", code], check=True)
    assert time.monotonic() - start < 40
