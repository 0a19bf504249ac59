#!/usr/bin/env python3
"""Damages files of every kind that the program reads, and sees that it says so.

Usage: damage.py GREENSTICK [--files N | --seconds S] [--seed K] [--keep FOLDER]

Files are made by the program itself and taken from tests/data, then changed: bytes are flipped, runs of them cut out,
doubled or replaced, numbers made huge, negative or no numbers, files cut short or joined. Each is then read. An exit code
other than 0, 1 and 2, a panic, more than 30 s, or more memory than twelve times the file and 200 MB over what the sound
file takes is a fault. `--files` is the number over all readers, `--seconds` the time of each. What a seed makes does not
depend on the machine.
"""

import argparse
import json
import math
import os
import random
import resource
import shutil
import struct
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
DATA = ROOT / "tests" / "data"
LIMIT_S = 30
FREE_BYTES = 200 << 20
TIMES_FILE = 12
NUMBERS = [b"nan", b"inf", b"-1", b"0", b"1e300", b"-1e-300", b"1e19", b"99999999999999999999", b"4294967296", b""]


def stem_points() -> list[tuple[float, float, float]]:
    """Points on the bark of a stem 40 cm thick and 2 m high."""
    dice = random.Random(7)
    points = []
    for _ in range(4000):
        turn, radius = dice.uniform(0, math.tau), dice.gauss(0.2, 0.002)
        points.append((radius * math.cos(turn), radius * math.sin(turn), dice.uniform(0, 2)))
    return points


def las(points: list[tuple[float, float, float]]) -> bytes:
    """A LAS 1.2 file of point format 0 (ASPRS, LAS Specification 1.2), in tenths of a millimetre."""
    scale = 1e-4
    low, high = ([f(p[i] for p in points) for i in range(3)] for f in (min, max))
    bounds = [v for pair in zip(high, low) for v in pair]
    counts = [len(points), *[0] * 5]
    header = struct.pack("<4sHHIHH8sBB32s32sHHHIIBHI5I3d3d6d", b"LASF", 0, 0, 0, 0, 0, b"", 1, 2, b"", b"", 1, 2020, 227, 227, 0,
                         0, 20, *counts, *[scale] * 3, *[0.0] * 3, *bounds)
    records = (struct.pack("<3iHBBbBH", *(round(v / scale) for v in p), 0, 9, 0, 0, 0, 0) for p in points)
    return header + b"".join(records)


def readers(program: Path, folder: Path) -> list[tuple[str, Path, list[str]]]:
    """Name, sound file and command of every reader; `{}` stands for the file."""

    def made(*arguments: str) -> None:
        subprocess.run([program, *arguments], cwd=folder, check=True, stdout=subprocess.DEVNULL)

    small = ["--texture-size", "16", "--set", "rings=6", "--set", "sectors=12", "--quiet"]
    for ending in ("glb", "gltf", "obj", "ply", "stl", "off"):
        made("break", "-o", f"wood.{ending}", *small)
    made("break", "-o", "recipe.glb", "--save-recipe", "recipe.toml", *small)
    shutil.copy(ROOT / ".ci" / "snap.toml", folder)
    made("simulate", "snap.toml", "-o", "run", "--no-pictures", "--quiet")
    made("simulate", "bend", "--save-scene", "scene.toml")
    made("anatomy", "-o", "inside", "--resolution", "32", "--quiet")
    points = stem_points()
    (folder / "cloud.xyz").write_text("".join(f"{x:.5f} {y:.5f} {z:.5f}\n" for x, y, z in points))
    (folder / "cloud.las").write_bytes(las(points))
    circle = [(math.cos(math.tau * i / 60), math.sin(math.tau * i / 60)) for i in range(60)]
    contours = [[[100 + r * x, 100 + r * y] for x, y in circle] for r in (20, 40, 60, 80)]
    section = {"pith": [100, 100], "outer_contour": contours[-1], "rings": [{"points": c} for c in contours]}
    (folder / "section.json").write_text(json.dumps(section))
    found = [(e, folder / f"wood.{e}", ["check", "{}"]) for e in ("glb", "gltf", "obj", "ply", "stl", "off")]
    found += [
        ("textured glb", DATA / "stump.glb", ["check", "{}"]),
        ("ply cloud", DATA / "pole.ply", ["check", "{}", "--unit", "mm"]),
        ("obj, broken", DATA / "kaykit_Tree_Bare_1_C_Color1.obj", ["break", "{}", "-o", "out.glb", *small]),
        ("xyz, broken", folder / "cloud.xyz", ["break", "{}", "-o", "out.glb", *small]),
        ("las, broken", folder / "cloud.las", ["break", "{}", "-o", "out.glb", *small]),
        ("recipe", folder / "recipe.toml", ["break", "--recipe", "{}", "-o", "out.glb", *small]),
        ("scene", folder / "scene.toml", ["simulate", "{}", "--save-scene", "out.toml"]),
        ("section", folder / "section.json", ["rings", "{}", "-o", "out.json"]),
        ("anatomy", folder / "inside" / "anatomy.json", ["break", "--rings-from", "{}", "-o", "out.glb", *small]),
        ("frames", folder / "run" / "frames.gsf", ["skin", "{run}", "--frame", "-1", "-o", "out.glb", "--texture-size", "16", "--quiet"]),
    ]
    return found


def damaged(sound: bytes, dice: random.Random) -> bytes:
    data = bytearray(sound)
    for _ in range(dice.choice((1, 1, 2, 5))):
        if not data:
            break
        at = dice.randrange(len(data))
        length = dice.randrange(1, 64)
        match dice.randrange(8):
            case 0:
                data[at] ^= 1 << dice.randrange(8)
            case 1:
                data[at : at + length] = dice.randbytes(length)
            case 2:
                del data[at : at + length]
            case 3:
                data[at:at] = data[at : at + length]
            case 4:
                del data[at:]
            case 5:
                data[at : at + 4] = dice.choice((b"\xff\xff\xff\xff", b"\x00\x00\x00\x80", b"\x00\x00\xc0\x7f", b"\0\0\0\0"))
            case 6:
                digits = [i for i in range(at, min(at + 200, len(data))) if chr(data[i]).isdigit()]
                if digits:
                    end = digits[0]
                    while end < len(data) and chr(data[end]) in "0123456789.eE+-":
                        end += 1
                    data[digits[0] : end] = dice.choice(NUMBERS)
            case 7:
                data += data[: dice.randrange(len(data)) + 1]
    return bytes(data)


def measured(program: Path, command: list[str], file: Path, folder: Path, codes: tuple[int, ...] = (0, 1, 2)) -> tuple[str, int]:
    """Runs a command; what is wrong with how it ended, if anything, and the most memory it took, in bytes."""
    words = [w.replace("{run}", str(file.parent)).replace("{}", str(file)) for w in command]
    with open(folder / "errors", "wb") as errors:
        process = subprocess.Popen([program, *words], cwd=folder, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=errors)
        started = time.monotonic()
        while True:
            pid, status, used = os.wait4(process.pid, os.WNOHANG)
            if pid:
                break
            if time.monotonic() - started > LIMIT_S:
                process.kill()
                os.wait4(process.pid, 0)
                return f"more than {LIMIT_S} s", 0
            time.sleep(0.005)
    process.returncode = code = os.waitstatus_to_exitcode(status)
    told = (folder / "errors").read_bytes()
    if b"panicked" in told:
        return told.decode(errors="replace").strip().splitlines()[0], used.ru_maxrss << 10
    if code not in codes:
        return f"exit code {code}", used.ru_maxrss << 10
    if code != 0 and b"error: " not in told:
        return f"exit code {code} without a message", used.ru_maxrss << 10
    return "", used.ru_maxrss << 10


def attack(program: Path, reader: tuple[str, Path, list[str]], options: argparse.Namespace, files: int | None, top: Path) -> tuple[str, int, list[str]]:
    name, sound, command = reader
    folder = top / name.replace(" ", "-").replace(",", "")
    home = folder / "in"
    if sound.name == "frames.gsf":
        shutil.copytree(sound.parent, home)
    else:
        home.mkdir(parents=True)
        for beside in sound.parent.glob(f"{sound.stem}*"):
            if beside.is_file():
                shutil.copy(beside, home)
    file, bytes_ = home / sound.name, sound.read_bytes()
    fault, base = measured(program, command, file, folder, (0,))
    faults = [f"{name}, sound: {fault}"] if fault else []
    started, number = time.monotonic(), 0
    while number < files if files is not None else time.monotonic() - started < options.seconds:
        data = damaged(bytes_, random.Random(f"{options.seed} {name} {number}"))
        file.write_bytes(data)
        fault, used = measured(program, command, file, folder)
        if not fault and used > base + FREE_BYTES + TIMES_FILE * len(data):
            fault = f"{used >> 20} MiB of memory for {len(data)} bytes, {base >> 20} MiB for the sound file"
        if fault:
            faults.append(f"{name}, number {number}: {fault}")
            if options.keep:
                options.keep.mkdir(parents=True, exist_ok=True)
                (options.keep / f"{folder.name}-{number}-{sound.name}").write_bytes(data)
        number += 1
    return name, number, faults


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program", type=Path)
    parser.add_argument("--files", type=int, help="files over all readers")
    parser.add_argument("--seconds", type=float, default=20.0, help="time of each reader, s")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--keep", type=Path, help="folder for the files that were faults")
    options = parser.parse_args()
    program = options.program.resolve()
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    with tempfile.TemporaryDirectory() as top:
        top = Path(top)
        (top / "sound").mkdir()
        all_readers = readers(program, top / "sound")
        each = None if options.files is None else -(-options.files // len(all_readers))
        with ThreadPoolExecutor(os.cpu_count()) as pool:
            done = list(pool.map(lambda r: attack(program, r, options, each, top), all_readers))
    faults = [fault for _, _, found in done for fault in found]
    for name, number, found in done:
        print(f"{name}: {number} files, {len(found)} faults")
    for fault in faults:
        print(fault)
    print(json.dumps({"files": sum(n for _, n, _ in done), "faults": len(faults)}))
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
