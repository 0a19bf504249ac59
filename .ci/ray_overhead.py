"""What a Ray cluster adds to a sweep: `python .ci/ray_overhead.py --cores 2 --tasks 40`, in an environment with greenstick and Ray.

The same parts of a sweep, of one variant each, are made by threads of this process and by tasks of a cluster on this machine with
as many cores, in turns. Printed are the seconds of each round, and of the medians how much longer the cluster takes. Starting the
cluster and the first task of each of its processes, which imports the library, are not counted: a sweep has them once. The machine
should have nothing else to do."""

import argparse
import os
import statistics
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import greenstick

# Tasks of Ray yield to everything else on a machine (niceness 15), which threads of this process do not: here both have the same rank.
os.environ.setdefault("RAY_worker_niceness", "0")
import ray  # noqa: E402


def seconds(tasks: int, cores: int, folder: Path, on_ray: bool, seed: int) -> float:
    description = {
        "break.rings": 60,
        "sweep": {"file": "none", "sheet": 0, "textures": False},
        "vary": {"seed": {"from": seed, "to": seed + tasks - 1}},
    }
    start = time.monotonic()
    if on_ray:
        greenstick.sweep(description, folder, engine="ray", parts=tasks)
    else:
        with ThreadPoolExecutor(cores) as pool:
            parts = [f"{number}/{tasks}" for number in range(1, tasks + 1)]
            list(pool.map(lambda part: greenstick.sweep(description, folder, part=part, threads=1), parts))
        greenstick.sweep(description, folder)
    return time.monotonic() - start


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--cores", type=int, default=2)
    parser.add_argument("--tasks", type=int, default=40, help="variants in a round")
    parser.add_argument("--rounds", type=int, default=3)
    options = parser.parse_args()
    ray.init(num_cpus=options.cores, include_dashboard=False, log_to_driver=False)
    times: dict[bool, list[float]] = {False: [], True: []}
    with tempfile.TemporaryDirectory() as folder:
        seconds(4 * options.cores, options.cores, Path(folder) / "first", True, 1)
        for number in range(options.rounds):
            for on_ray in (False, True):
                place = Path(folder) / f"{number}-{on_ray}"
                times[on_ray].append(seconds(options.tasks, options.cores, place, on_ray, 1000))
    for on_ray, name in ((False, "threads"), (True, "cluster")):
        print(f"{name}  {'  '.join(f'{t:.1f} s' for t in times[on_ray])}")
    threads, cluster = (statistics.median(times[k]) for k in (False, True))
    print(f"a task  {threads * options.cores / options.tasks:.2f} s")
    print(f"the cluster takes {100 * (cluster / threads - 1):.1f} % longer")


if __name__ == "__main__":
    main()
