#!/usr/bin/env python3
"""Runs the commands of README.md and docs/*.md, each page in a folder of its own with the files that it names.

Usage: documentation.py GREENSTICK [--page NAME] [--folder FOLDER]

What runs are the lines of blocks marked `sh` and the spans of code in paragraphs that begin with `greenstick` and are whole: no
names of commands alone, no placeholders such as FILE, no `…`. What a page's commands write stays for the next. A command fails
that ends with another code than 0, or takes longer than 60 s. Results that many commands share, such as `simulate bend -o run`,
are made once. So that all of it takes four minutes on two cores, pictures are drafts, textures small, simulations end early (`SHORTER`,
`FEWER`), and bend tests have fewer specimens; the shared run ends after its stem has broken. That changes how long commands take,
not whether they run. What is left out stands in `EXCLUDED`, with the reason. Needs laspy with lazrs, and trimesh.
"""

import argparse
import math
import os
import random
import re
import shutil
import subprocess
import sys
import tempfile
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from damage import laz, las, sawn_end, section, stem_points

ROOT = Path(__file__).resolve().parent.parent
DATA = ROOT / "tests" / "data"
LIMIT_S = 60
"""Limit of one command on two free cores; a machine that does other work gets more by GREENSTICK_PATIENCE, a factor."""
AT_A_TIME = 2
"""Commands that run beside each other: most keep one core busy."""

# Commands that begin so are not run.
EXCLUDED = {
    "greenstick bend-test --all-species": "several minutes for 121 species; one species is run",
    'greenstick bend-test --species "yellow birch" --specimens 200 --measured birch_bending_lmfor.csv':
        "measurements that may not be redistributed; others are read in science.md",
    "greenstick fracture-test": "one to three minutes each; `cargo test -p greenstick-cli --test toughness` runs a short one",
    "greenstick simulate three-blocks -o film.glb": "a film of a whole run; that of `bend` is made",
    "greenstick simulate three-blocks --seed 1": "a part of a command, in a table",
    "greenstick simulate as-published": "minutes: the published numbers of rods and steps",
    "greenstick simulate twist --solver implicit": "minutes: the implicit solver",
    "greenstick simulate bend -o slow --solver implicit": "minutes: the implicit solver",
    "greenstick simulate falling-trunk": "minutes: the explicit solver at the stiffness of wood",
    "greenstick simulate three-blocks pole.ply --unit mm": "a part of a command, in a paragraph",
    "greenstick break --from-run bent": "needs a whole run on the scanned pole; that of the branch is broken",
    "greenstick break pole.ply --unit mm --simulate bend": "minutes: a whole run on the scanned pole",
    "greenstick skin run --faces rods --frame 45": "needs a whole run of three-blocks",
    "greenstick skin run -o film.mp4": "needs ffmpeg; `.ci/run` makes videos of a smaller run",
    "greenstick skin run -o near.mp4": "needs ffmpeg",
    "greenstick skin run -o strain.mp4": "needs ffmpeg",
    "greenstick skin run --pictures frames": "a picture of each of 60 frames",
    "greenstick simulate bend.toml -o run": "the scene with one key changed by hand",
}

# What is added to commands that begin so, the first that fits. Pictures and durations only.
SHORTER = {
    "greenstick simulate bend -o run": "--duration 0.2 --no-pictures",
    "greenstick simulate": "--duration 0.02 --no-pictures",
    "greenstick break": "--draft --texture-size 128",
    "greenstick skin": "--draft",
}

# Words of commands, and those that stand for them here.
FEWER = {"--specimens 200": "--specimens 6", "--duration 0.006": "--duration 0.001"}

# Commands whose results are made once for all pages: what is in the folder they write.
SHARED = {
    "greenstick simulate bend -o run": "run",
    'greenstick anatomy pole.ply --unit mm -o inside --species "Sitka spruce"': "inside",
}


def commands(page: Path) -> list[str]:
    """The commands of a page in their order, as in apps/cli/src/documented_commands.rs; of spans only whole ones."""
    found, block, paragraph = [], None, ""
    for line in [*page.read_text().replace("\\\n", " ").split("\n"), ""]:
        if line.startswith("```"):
            block = (line == "```sh") if block is None else None
        elif block is not None:
            if block and line.startswith("greenstick "):
                found.append(line.strip())
        elif line.strip():
            paragraph += line + " "
        else:
            spans = (span for span in paragraph.split("`")[1::2] if span.startswith("greenstick "))
            found += [span for span in spans if is_whole(span)]
            paragraph = ""
    return found


def is_whole(span: str) -> bool:
    """Whether a span of code is a command to type, and not the name of one or of an option."""
    words = span.split()
    return len(words) > 2 and words[-1][:2] != "--"


def has_placeholder(command: str) -> bool:
    """Whether there is something to fill in."""
    words = command.split("#")[0].split()
    names = [re.split("[/=]", word)[-1] for word in words]
    return "…" in command or any(re.fullmatch(r"[A-Z]{3,}(\.\w+)?", name) for name in names)


def cylinder(file: Path, radius: float, length: float, foot: tuple[float, float, float], up: int) -> None:
    import numpy
    import trimesh

    mesh = trimesh.creation.cylinder(radius, length, sections=48)
    for _ in range(2):
        mesh = mesh.subdivide()
    points = mesh.vertices + [0, 0, length / 2]
    if up == 1:
        points = points[:, [1, 2, 0]]
    trimesh.Trimesh(points + numpy.array(foot), mesh.faces).export(file)


def make_files(folder: Path) -> None:
    """The files that the pages name and that no command makes."""
    for file in DATA.iterdir():
        if file.name.startswith(("homecart", "quaternius_DeadTree_1")):
            shutil.copy(file, folder)
    shutil.copy(DATA / "homecart_cutting_board.gltf", folder / "board.gltf")
    shutil.copy(DATA / "pole.ply", folder)
    cylinder(folder / "log.glb", 0.1, 4.0, (0, 0, 0), 2)
    cylinder(folder / "log.ply", 0.1, 2.0, (0, 0, 0), 2)
    cylinder(folder / "branch.glb", 0.02, 0.6, (0, 0, 0), 2)
    cylinder(folder / "tree.glb", 0.15, 4.0, (0.3, 0, -0.4), 1)
    # A stem 4 m high, and another 5 m away.
    points = [(x, y, 2 * z) for x, y, z in stem_points(12_000)]
    (folder / "plot").mkdir()
    (folder / "tree.las").write_bytes(las(points))
    for name in ("scan.laz", "tree.laz", "plot/1.laz", "plot/2.laz"):
        laz(folder / "tree.las", folder / name)
    (folder / "scan.xyz").write_text("".join(f"{x:.5f} {y:.5f} {z:.5f}\n" for x, y, z in points))
    (folder / "section.json").write_text(section())
    (folder / "sawn_end.png").write_bytes(sawn_end())
    dice = random.Random(3)
    rows = ((d, 150 * d + dice.gauss(0, 8)) for d in (dice.gauss(0.62, 0.05) for _ in range(60)))
    (folder / "birch.csv").write_text("Density,Resistance\n" + "".join(f"{d:.3f},{r:.1f}\n" for d, r in rows))
    (folder / "twigs.toml").write_text(
        'texture_size = 16\n[break]\nrings = 6\nsectors = 12\n[sweep]\nsheet = 0\n[vary]\nseed = { from = 1, to = 18 }\n'
    )
    (folder / "variant.toml").write_text('preset = "brash"\n')
    shutil.copy(ROOT / ".ci" / "snap.toml", folder / "variant-scene.toml")
    (folder / "film.glb").write_bytes((folder / "log.glb").read_bytes())


class Runner:
    def __init__(self, program: Path, top: Path):
        bin_folder = top / "bin"
        bin_folder.mkdir()
        (bin_folder / "greenstick").symlink_to(program)
        self.environment = {**os.environ, "PATH": f"{bin_folder}:{os.environ['PATH']}"}
        self.limit_s = LIMIT_S * float(os.environ.get("GREENSTICK_PATIENCE", "1"))
        self.top = top
        self.places, self.all_places = threading.Semaphore(AT_A_TIME), threading.Lock()

    def run(self, command: str, folder: Path) -> tuple[float, str]:
        """Runs a command; its seconds, and what is wrong with how it ended. One that takes too long beside another is run again
        alone: the limit is that of one command on both cores."""
        with self.places:
            outcome = self.run_once(command, folder)
        if outcome is None:
            with self.all_places:
                for _ in range(AT_A_TIME):
                    self.places.acquire()
            remove_run(command, folder)
            outcome = self.run_once(command, folder)
            self.places.release(AT_A_TIME)
        return outcome or (self.limit_s, f"longer than {self.limit_s:.0f} s, alone on both cores")

    def run_once(self, command: str, folder: Path) -> tuple[float, str] | None:
        """The same without a second try; None where it took too long."""
        started = time.monotonic()
        try:
            done = subprocess.run(
                ["bash", "-euc", command], cwd=folder, env=self.environment, stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=self.limit_s,
            )
        except subprocess.TimeoutExpired:
            return None
        fault = f"code {done.returncode}: {done.stdout.strip()[-400:]}" if done.returncode else ""
        return time.monotonic() - started, fault

    def page(self, page: Path) -> list[tuple[str, float, str]]:
        """The commands of a page that were run, with seconds and faults."""
        folder = self.top / page.stem
        shutil.copytree(self.top / "files", folder)
        outcomes, seen = [], set()
        for command in commands(page):
            if has_placeholder(command) or command in seen or any(command.startswith(e) for e in EXCLUDED):
                continue
            seen.add(command)
            shared = SHARED.get(command.split("#")[0].strip())
            remove_run(command, folder)
            if shared:
                shutil.rmtree(folder / shared, ignore_errors=True)
                shutil.copytree(self.top / "files" / shared, folder / shared)
                continue
            outcomes.append((command, *self.run(shortened(command), folder)))
        print(f"{page.relative_to(ROOT)}: {len(outcomes)} commands in {sum(o[1] for o in outcomes):.0f} s", flush=True)
        for command, seconds, fault in outcomes:
            if fault or seconds > 10:
                print(f"{seconds:6.1f} s  {command}{f': {fault}' if fault else ''}", flush=True)
        return outcomes


def remove_run(command: str, folder: Path) -> None:
    """Removes what a command would record a run in, as a run is not written over another one."""
    written = re.search(r"simulate .*-o (\w+)", command)
    if written and "--resume" not in command:
        shutil.rmtree(folder / written[1], ignore_errors=True)


def shortened(command: str) -> str:
    """A command as it is run here."""
    for words, fewer in FEWER.items():
        command = command.replace(words, fewer)
    if "--list" in command or "--save-scene" in command:
        return command
    for start, more in SHORTER.items():
        if command.startswith(start):
            options = re.findall(r"--\S+(?: [^-]\S*)?", more)
            return " ".join([command.split(" #")[0].rstrip(), *(o for o in options if o.split()[0] not in command)])
    return command


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program", type=Path)
    parser.add_argument("--page", help="one page, such as skin.md")
    parser.add_argument("--folder", type=Path, help="an empty folder to work in, which stays")
    options = parser.parse_args()
    pages = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
    pages = [page for page in pages if options.page in (None, page.name)]
    everything = [command for page in pages for command in commands(page)]
    unused = [e for e in [*EXCLUDED, *SHARED, *SHORTER] if not any(c.startswith(e) for c in everything)]
    unused += [words for words in FEWER if not any(words in c for c in everything)]
    if unused and not options.page:
        print("treated apart, but in no page:", *unused, sep="\n  ")
        return 1
    with tempfile.TemporaryDirectory() as scratch:
        top = options.folder.resolve() if options.folder else Path(scratch)
        (top / "files").mkdir(parents=True)
        make_files(top / "files")
        runner = Runner(options.program.resolve(), top)
        faults = []
        with ThreadPoolExecutor(AT_A_TIME) as pool:
            for text, (seconds, fault) in zip(SHARED, pool.map(lambda c: runner.run(shortened(c), top / "files"), SHARED)):
                print(f"{seconds:6.1f} s  {text}  (shared)", flush=True)
                faults += [f"{text}: {fault}"] if fault else []
            # Those that take longest first, so that none is waited for alone.
            longest = sorted(pages, key=lambda page: -len(commands(page)))
            done = list(pool.map(runner.page, longest))
        for page, outcomes in zip(longest, done):
            faults += [f"{page.relative_to(ROOT)}: {command}\n  {fault}" for command, _, fault in outcomes if fault]
    count = sum(map(len, done))
    print(f"{count} commands run, {len(faults)} failed; {len(EXCLUDED)} left out, see EXCLUDED")
    print(*faults, sep="\n")
    return 1 if faults or not count else 0


if __name__ == "__main__":
    sys.exit(main())
