"""How much faster several threads make a sweep than one: `python3 .ci/sweep_scaling.py target/release/greenstick`.

The sweep is the one of docs/sweep.md; `--textures` bakes textures, too. One thread, several threads, and as many processes of one
thread each, which share nothing but the machine, make the same variants in turns. Where the processes are not faster than the
threads, it is the machine that limits both. Printed are the seconds of each round, processor time of user and system, and the ratios
of the medians. The machine should have nothing else to do; its load is printed. Needs Linux or macOS."""

import argparse
import os
import resource
import shutil
import statistics
import subprocess
import tempfile
import time
from pathlib import Path

SWEEP = """
[break]
rings = 40
sectors = 40
[sweep]
textures = {textures}
sheet = 0
file = "{file}"
[vary]
seed = {{ from = 1, to = {variants} }}
"""


def measure(program: Path, sweep: Path, folder: Path, threads: int, processes: int) -> tuple[float, float, float]:
    """Seconds by the clock, and of the processors as user and system, that a sweep takes."""
    # What was written before is on the disk, so that nothing waits for it.
    os.sync()
    command = [program, "sweep", sweep, "-o", folder, "--threads", str(threads), "--quiet"]
    parts = [["--part", f"{n}/{processes}"] for n in range(1, processes + 1)] if processes > 1 else [[]]
    before, start = resource.getrusage(resource.RUSAGE_CHILDREN), time.monotonic()
    running = [subprocess.Popen([*command, *part]) for part in parts]
    if any([process.wait() for process in running]):
        raise SystemExit("the sweep failed")
    seconds, after = time.monotonic() - start, resource.getrusage(resource.RUSAGE_CHILDREN)
    shutil.rmtree(folder)
    return seconds, after.ru_utime - before.ru_utime, after.ru_stime - before.ru_stime


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program", type=Path)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--variants", type=int, default=200)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--textures", action="store_true", help="bake textures, which takes about twenty times as long")
    parser.add_argument("--file", default="glb", choices=("glb", "none"), help="whether pieces are written")
    parser.add_argument("--folder", type=Path, help="where the files are written; a temporary folder without it")
    options = parser.parse_args()
    threads = options.threads
    ways = {"one thread": (1, 1), f"{threads} threads": (threads, 1), f"{threads} processes": (1, threads)}
    times: dict[str, list[tuple[float, float, float]]] = {name: [] for name in ways}
    print(f"load before: {os.getloadavg()[0]:.2f} on {os.cpu_count()} cores")
    with tempfile.TemporaryDirectory(dir=options.folder) as name:
        sweep = Path(name) / "sweep.toml"
        sweep.write_text(
            SWEEP.format(textures=str(options.textures).lower(), file=options.file, variants=options.variants)
        )
        for number in range(options.rounds):
            for way, (each, processes) in ways.items():
                times[way].append(measure(options.program, sweep, Path(name) / f"{number}", each, processes))
    for way, found in times.items():
        clock, user, system = (statistics.median(column) for column in zip(*found, strict=True))
        rounds = "  ".join(f"{seconds:.2f}" for seconds, *_ in found)
        print(f"{way + ':':14} {rounds}  s, median {clock:.2f} s; processors {user:.2f} s user, {system:.2f} s system")
    one, several, apart = (statistics.median(seconds for seconds, *_ in found) for found in times.values())
    print(f"{threads} threads are {one / several:.2f} times as fast as one; {threads} processes {one / apart:.2f} times")


if __name__ == "__main__":
    main()
