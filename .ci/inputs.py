#!/usr/bin/env python3
"""Breaks every mesh and scan of some folders and prints a table of what came of it, in Markdown.

Usage: inputs.py GREENSTICK FOLDER_OF_NODE_MODULES [FOLDER...] [--preset NAME]

The folders are tests/data unless named. For each input: its triangles or points and size, processor time and memory of
`break` with default settings and no picture, triangles and size of the pieces as GLB, errors and warnings of the Khronos glTF
validator, whether the input and the pieces are closed, and how far the pieces' volumes are off the input's. It fails where the
validator finds errors, where pieces of a closed input are open, or where volumes differ by more than 1e-5. A scan's bark is
the input there.
"""

import argparse
import json
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
ENDINGS = (".glb", ".gltf", ".obj", ".ply", ".stl", ".off", ".xyz", ".las", ".laz")
VOLUME_TOLERANCE = 1e-5
# What the program must be told about a file that it cannot know; the first that is part of its name.
TOLD = {
    "pole.ply": ["--unit", "mm"],
    "DeadTree_1": ["--at", "0.1"],
}


def spent(command: list[str], folder: Path) -> tuple[int, str, str, float, int]:
    """Runs a command; its code, what it printed, its processor time (s) and its memory (bytes)."""
    with open(folder / "out", "w+") as out, open(folder / "err", "w+") as err:
        process = subprocess.Popen(command, cwd=folder, stdout=out, stderr=err)
        _, status, used = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        out.seek(0)
        err.seek(0)
        return process.returncode, out.read(), err.read(), used.ru_utime + used.ru_stime, used.ru_maxrss << 10


def size(number: int) -> str:
    return f"{number / 1e6:.1f} MB" if number >= 1e5 else f"{number / 1e3:.0f} kB"


def row(options: argparse.Namespace, file: Path, folder: Path) -> tuple[list[str], list[str]]:
    """The cells of an input, and what is wrong with it."""
    told = next((words for part, words in TOLD.items() if part in file.name), [])
    preset = ["--preset", options.preset] if options.preset else []
    command = [options.program, "break", file, *told, *preset, "-o", "broken.glb", "--json"]
    code, out, err, seconds, memory = spent(command, folder)
    name = " ".join([file.name, *told])
    files = [file, *(b for b in (file.with_suffix(".bin"),) if file.suffix == ".gltf" and b.exists())]
    read = sum(f.stat().st_size for f in files)
    if code:
        said = err.strip().splitlines()
        return [name, "", size(read), f"{seconds:.1f} s", size(memory), f"refused: {said[0][:120] if said else code}", *[""] * 4], []
    report = json.loads(out)
    pieces, source = report["pieces"], report["input"]
    broken = folder / "broken.glb"
    validator = subprocess.run(
        ["node", ROOT / ".ci" / "validate_gltf.mjs", options.modules, broken, file], capture_output=True, text=True
    )
    counted = re.search(r"(\d+) errors, (\d+) warnings", validator.stdout)
    verdict = f"{counted[1]} / {counted[2]}" if counted else validator.stdout.strip()[:80]
    closed = [piece["closed"] for piece in pieces]
    faults = [f"{file.name}: the validator finds {verdict}"] if validator.returncode else []
    if source["closed"] and not all(closed):
        faults.append(f"{file.name}: closed, but its pieces are not")
    volumes = [piece["volume_m3"] for piece in pieces]
    off = ""
    if source["volume_m3"] and all(volumes):
        part = abs(sum(volumes) + (report.get("crack_volume_m3") or 0) - source["volume_m3"]) / source["volume_m3"]
        off = f"{part:.0e}" if part else "0"
        if part > VOLUME_TOLERANCE:
            faults.append(f"{file.name}: volumes differ by {off}")
    shown = f"{'closed' if source['closed'] else 'open'} → " + ", ".join("closed" if c else "open" for c in closed)
    triangles = sum(piece["triangles"] for piece in pieces)
    cells = [name, f"{source['triangles']:,}", size(read), f"{seconds:.1f} s", size(memory), f"{triangles:,}", size(broken.stat().st_size), verdict, shown, off]
    return cells, faults


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program", type=lambda p: Path(p).resolve())
    parser.add_argument("modules", type=lambda p: Path(p).resolve(), help="folder with node_modules/gltf-validator")
    parser.add_argument("folders", type=Path, nargs="*", default=[ROOT / "tests" / "data"])
    parser.add_argument("--preset", help="how they break")
    options = parser.parse_args()
    print("| input | triangles | size | time | memory | triangles of pieces | size | validator: errors / warnings | closed | volume off by |")
    print("|---|--:|--:|--:|--:|--:|--:|---|---|--:|")
    faults, seen = [], set()
    with tempfile.TemporaryDirectory() as folder:
        for top in options.folders:
            for file in sorted(top.rglob("*")):
                # The same file may be in several folders.
                if file.suffix.lower() not in ENDINGS or file.name in seen:
                    continue
                seen.add(file.name)
                cells, wrong = row(options, file.resolve(), Path(folder))
                print("| " + " | ".join(cells) + " |", flush=True)
                faults += wrong
    print(*faults, sep="\n", file=sys.stderr)
    return 1 if faults or not seen else 0


if __name__ == "__main__":
    sys.exit(main())
