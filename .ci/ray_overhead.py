"""What a Ray cluster adds to a sweep: `python .ci/ray_overhead.py --cores 2 --tasks 40`, in an environment with greenstick and Ray.

The same variants are made in turns by tasks of a cluster on this machine, by as many threads of this process in the same parts, and by
as many threads as one sweep without parts. A part has as many variants as take `--seconds` of processor time. Printed are the seconds of
each round, and of the medians how much longer the cluster takes than either: than the parts, what Ray adds; than one sweep, what parts
add, too. Starting the cluster and the first tasks of each of its processes, which import the library, are not counted: a sweep has them
once. The machine should have nothing else to do; its load is printed."""

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

# Seeds from which on variants are timed; those of the first tasks are others.
FIRST_SEED = 1000


def description(variants: int, seed: int) -> dict[str, object]:
    return {
        "break.rings": 60,
        "sweep": {"file": "none", "sheet": 0, "textures": False},
        "vary": {"seed": {"from": seed, "to": seed + variants - 1}},
    }


def on_threads(variants: int, tasks: int, cores: int, folder: Path) -> float:
    """Seconds that threads of this process take."""
    made = description(variants, FIRST_SEED)
    start = time.monotonic()
    with ThreadPoolExecutor(cores) as pool:
        parts = [f"{number}/{tasks}" for number in range(1, tasks + 1)]
        list(pool.map(lambda part: greenstick.sweep(made, folder, part=part, threads=1), parts))
    greenstick.sweep(made, folder)
    return time.monotonic() - start


def as_one(variants: int, cores: int, folder: Path) -> float:
    """Seconds that one sweep without parts takes."""
    start = time.monotonic()
    greenstick.sweep(description(variants, FIRST_SEED), folder, threads=cores)
    return time.monotonic() - start


def on_cluster(variants: int, tasks: int, folder: Path, seed: int = FIRST_SEED) -> float:
    """Seconds that tasks of the cluster take."""
    start = time.monotonic()
    greenstick.sweep(description(variants, seed), folder, engine="ray", parts=tasks)
    return time.monotonic() - start


def variants_of_a_task(seconds: float, folder: Path) -> int:
    """Variants that are made in as many seconds of processor time."""
    count = 8
    greenstick.sweep(description(1, 1), folder / "first", threads=1)
    start = time.process_time()
    greenstick.sweep(description(count, FIRST_SEED), folder / "timed", threads=1)
    return max(1, round(seconds * count / (time.process_time() - start)))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--cores", type=int, default=2)
    parser.add_argument("--tasks", type=int, default=40, help="tasks in a round")
    parser.add_argument("--seconds", type=float, default=1.0, help="processor time of a task")
    parser.add_argument("--rounds", type=int, default=3)
    options = parser.parse_args()
    cores, tasks = options.cores, options.tasks
    print(f"load before: {os.getloadavg()[0]:.2f} on {os.cpu_count()} cores")
    times: dict[str, list[float]] = {"one sweep": [], "parts": [], "cluster": []}
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        variants = tasks * variants_of_a_task(options.seconds, folder)
        ray.init(num_cpus=cores, include_dashboard=False, log_to_driver=False)
        on_cluster(4 * cores, 4 * cores, folder / "warm", seed=1)
        for number in range(options.rounds):
            times["one sweep"].append(as_one(variants, cores, folder / f"one-{number}"))
            times["parts"].append(on_threads(variants, tasks, cores, folder / f"parts-{number}"))
            times["cluster"].append(on_cluster(variants, tasks, folder / f"cluster-{number}"))
    for name, seconds in times.items():
        print(f"{name:10} {'  '.join(f'{t:.1f} s' for t in seconds)}")
    one, parts, cluster = (statistics.median(seconds) for seconds in times.values())
    print(f"{tasks} tasks of {variants // tasks} variants; a core took {parts * cores / tasks:.2f} s for each")
    print(f"the cluster takes {100 * (cluster / parts - 1):.1f} % longer than the same parts by threads")
    print(f"the cluster takes {100 * (cluster / one - 1):.1f} % longer than one sweep by threads")


if __name__ == "__main__":
    main()
