#!/usr/bin/env python3
"""Fuzzes the readers: changes files, keeps those that reach code that none before has, and changes these again.

Usage: fuzz.py GREENSTICK [--seconds S] [--reader NAME...] [--jobs N] [--folder FOLDER]

The targets are in fuzz/fuzz_targets, one a reader: any bytes have to be read or refused. A panic, a number that overflows, more than
30 s or more than 2 GB for one input is a finding. It is kept in FOLDER (target/fuzz without the option), and fails the script; the
message says how to try it again. What was learned stays in FOLDER too, so that the next run goes on from there. The files that it
begins with are made by the program, or are from tests/data. It takes the compiler of the workspace and one for C++; no sanitizer, which
would need a nightly compiler: the readers have no `unsafe` code of their own. LAZ files are made by laspy: pip install 'laspy[lazrs]'.
"""

import argparse
import os
import re
import shutil
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from damage import readers

ROOT = Path(__file__).resolve().parent.parent
LIMIT_S = 30
LIMIT_MB = 2048
# Counters of the branches that were taken, and the numbers that were compared, as libFuzzer reads them; as cargo-fuzz sets them.
COVERAGE = "-Cpasses=sancov-module " + " ".join(
    f"-Cllvm-args=-sanitizer-coverage-{what}" for what in ("level=4", "inline-8bit-counters", "pc-table", "trace-compares")
)
# The files of damage.py that each target begins with, by their endings.
SEEDS = {
    "gltf": ("glb", "gltf"),
    "obj": ("obj",),
    "ply": ("ply",),
    "stl": ("stl",),
    "off": ("off",),
    "ply_cloud": ("ply",),
    "xyz": ("xyz",),
    "las": ("las",),
    "laz": ("laz",),
    "frames": ("gsf",),
    "recipe": ("recipe",),
    "scene": ("scene",),
    "section": ("section", "anatomy"),
}
# Larger files are changed too seldom where it matters.
MOST_BYTES = 200_000


def build() -> Path:
    """Builds all targets; the folder they are in."""
    host = re.search(r"^host: (.*)$", subprocess.run(["rustc", "-vV"], check=True, capture_output=True, text=True).stdout, re.M)[1]
    # With a target named, the flags are not those of build scripts and macros, which run without libFuzzer.
    subprocess.run(
        ["cargo", "build", "--release", "--quiet", "--locked", "--manifest-path", ROOT / "fuzz" / "Cargo.toml", "--target", host,
         "--target-dir", ROOT / "target" / "fuzz-build"],
        check=True, env={**os.environ, "RUSTFLAGS": f"{COVERAGE} --cfg fuzzing"},
    )
    return ROOT / "target" / "fuzz-build" / host / "release"


def seed(program: Path, names: list[str], corpus: Path) -> None:
    """Puts small sound files into the folders of the targets."""
    with tempfile.TemporaryDirectory() as scratch:
        for name, file, _ in readers(program, Path(scratch)):
            for target in names:
                folder = corpus / target
                folder.mkdir(parents=True, exist_ok=True)
                if {name, file.suffix[1:]} & set(SEEDS[target]) and file.stat().st_size <= MOST_BYTES:
                    shutil.copy(file, folder / f"sound-{file.name}")


def fuzz(target: Path, options: argparse.Namespace) -> tuple[str, int, str]:
    """Runs a target; its name, how many inputs it tried, and what is wrong."""
    corpus, found = options.folder / "corpus" / target.name, options.folder / f"found-{target.name}-"
    done = subprocess.run(
        [target, f"-max_total_time={options.seconds}", f"-timeout={LIMIT_S}", f"-rss_limit_mb={LIMIT_MB}",
         f"-artifact_prefix={found}", f"-max_len={MOST_BYTES}", "-print_final_stats=1", corpus],
        stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace",
    )
    runs = re.search(r"stat::number_of_executed_units: *(\d+)", done.stdout)
    fault = "" if done.returncode == 0 else f"code {done.returncode}:\n{done.stdout[-2500:]}"
    return target.name, int(runs[1]) if runs else 0, fault


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program", type=Path)
    parser.add_argument("--seconds", type=int, default=600, help="time of each reader, s")
    parser.add_argument("--reader", action="append", choices=sorted(SEEDS), help="a reader, by the name of its target; without it, all")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="readers at a time")
    parser.add_argument("--folder", type=Path, default=ROOT / "target" / "fuzz", help="where inputs are kept")
    options = parser.parse_args()
    missing = {file.stem for file in (ROOT / "fuzz" / "fuzz_targets").glob("*.rs")} ^ set(SEEDS)
    if missing:
        sys.exit(f"targets without sound files, or sound files without a target: {sorted(missing)}")
    names = options.reader or list(SEEDS)
    built = build()
    seed(options.program.resolve(), names, options.folder / "corpus")
    with ThreadPoolExecutor(options.jobs) as pool:
        done = list(pool.map(lambda name: fuzz(built / name, options), names))
    for name, runs, fault in done:
        print(f"{name}: {runs} inputs, {'a finding' if fault else 'no finding'}")
    for name, runs, fault in done:
        if fault or not runs:
            print(f"\n{name}, {fault or 'tried nothing'}\nagain: {built / name} {options.folder}/found-{name}-…")
    return 1 if any(fault or not runs for _, runs, fault in done) else 0


if __name__ == "__main__":
    sys.exit(main())
