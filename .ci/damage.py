#!/usr/bin/env python3
"""Damages files of every kind that the program reads, and sees that it says so.

Usage: damage.py GREENSTICK [--files N | --seconds-per-reader S] [--reader NAME...] [--seed K] [--keep FOLDER]

Files are made by the program itself and taken from tests/data, then changed. Half of the changes know nothing of the format:
bytes are flipped, runs of them cut out, doubled or replaced, numbers made huge, negative or no numbers, files cut short or
joined. The others keep it: values of JSON and TOML get another type, size or place, lines and words of texts are moved,
numbers, lengths and counts of binary files become their neighbours, nothing or too large, chunks of GLB files and records of
frames are given the right length and checksum again, so that what lies behind them is reached. Each file is then read. An exit
code other than 0, 1 and 2, a panic, more than 30 s, or more memory than twelve times the file and 200 MB over what the sound
file takes is a fault. `--files` is the number over all readers, `--seconds-per-reader` the time of each. What a seed makes does
not depend on the machine. LAZ files are made by laspy: pip install 'laspy[lazrs]'.
"""

import argparse
import json
import math
import os
import random
import re
import resource
import shutil
import struct
import subprocess
import sys
import tempfile
import time
import zlib
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
DATA = ROOT / "tests" / "data"
LIMIT_S = 30
FREE_BYTES = 200 << 20
TIMES_FILE = 12
NUMBERS = [b"nan", b"inf", b"-1", b"0", b"1e300", b"-1e-300", b"1e19", b"99999999999999999999", b"4294967296", b""]


def stem_points(count: int = 500) -> list[tuple[float, float, float]]:
    """Points on the bark of a stem 40 cm thick and 2 m high."""
    dice = random.Random(7)
    points = []
    for _ in range(count):
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


def laz(uncompressed: Path, file: Path) -> None:
    """Writes a LAS file as LAZ."""
    try:
        import laspy

        laspy.read(uncompressed).write(file, do_compress=True)
    except ImportError as missing:
        sys.exit(f"LAZ files cannot be made: {missing}; pip install 'laspy[lazrs]' helps")


def png(width: int, height: int, gray: bytes) -> bytes:
    """A gray picture (PNG, third edition)."""

    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    rows = b"".join(b"\0" + gray[y * width : (y + 1) * width] for y in range(height))
    head = struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")


def sawn_end() -> bytes:
    """A photograph of a sawn end with a radial crack, drawn."""

    def gray(x: int, y: int) -> int:
        radius, turn = math.hypot(x - 60, y - 60), math.atan2(y - 60, x - 60)
        if radius > 50:
            return 255
        return 20 if abs(turn) < 0.05 and radius > 10 else 150 + round(20 * math.sin(radius))

    return png(120, 120, bytes(gray(x, y) for y in range(120) for x in range(120)))


def section() -> str:
    """The annotation of a section: a pith, an outer contour and four rings."""
    circle = [(math.cos(math.tau * i / 60), math.sin(math.tau * i / 60)) for i in range(60)]
    contours = [[[100 + r * x, 100 + r * y] for x, y in circle] for r in (20, 40, 60, 80)]
    rings = [{"points": c} for c in contours]
    return json.dumps({"pith": [100, 100], "outer_contour": contours[-1], "rings": rings})


SWEEP = """preset = "brash"
texture_size = 16
[break]
rings = 6
sectors = 12
[sweep]
samples = 3
file = "none"
sheet = 0
[vary]
seed = [1, 2]
inclination = { from = 0, to = 30, steps = 4 }
moisture = { between = [8, 30] }
"""


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
    made("anatomy", "-o", "inside", "--resolution", "32", "--only", "measures", "--quiet")
    points = stem_points()
    (folder / "cloud.xyz").write_text("".join(f"{x:.5f} {y:.5f} {z:.5f}\n" for x, y, z in points))
    (folder / "cloud.las").write_bytes(las(points))
    laz(folder / "cloud.las", folder / "cloud.laz")
    (folder / "end.png").write_bytes(sawn_end())
    (folder / "sweep.toml").write_text(SWEEP)
    (folder / "measured.csv").write_text("density_kg_per_m3,modulus_of_rupture_Pa\n" + "".join(f"{550 + 3 * i},{9e7 + 5e5 * i}\n" for i in range(40)))
    (folder / "section.json").write_text(section())
    tree = DATA / "kaykit_Tree_Bare_1_C_Color1.obj"
    found = [(e, folder / f"wood.{e}", ["check", "{}"]) for e in ("glb", "gltf", "obj", "ply", "stl", "off")]
    found += [
        ("textured glb", DATA / "stump.glb", ["check", "{}"]),
        ("ply cloud", DATA / "pole.ply", ["check", "{}", "--unit", "mm"]),
        ("obj, broken", tree, ["break", "{}", "-o", "out.glb", *small]),
        ("xyz, broken", folder / "cloud.xyz", ["break", "{}", "-o", "out.glb", *small]),
        ("las, broken", folder / "cloud.las", ["break", "{}", "-o", "out.glb", *small]),
        ("laz, broken", folder / "cloud.laz", ["break", "{}", "-o", "out.glb", *small]),
        ("recipe", folder / "recipe.toml", ["break", str(tree), "--recipe", "{}", "-o", "out.glb", *small]),
        ("scene", folder / "scene.toml", ["simulate", "{}", "--save-scene", "out.toml"]),
        ("section", folder / "section.json", ["rings", "{}", "-o", "out.json"]),
        ("photograph", folder / "end.png", ["cracks", "--from", "{}", "-o", "out.toml"]),
        ("sweep", folder / "sweep.toml", ["sweep", "{}", "--show", "1"]),
        ("anatomy", folder / "inside" / "anatomy.json", ["break", str(tree), "--rings-from", "{}", "-o", "out.glb", *small]),
        ("frames", folder / "run" / "frames.gsf", ["skin", "{run}", "--frame", "-1", "-o", "out.glb", "--texture-size", "16", "--quiet"]),
    ]
    return found


def damaged(sound: bytes, name: str, dice: random.Random) -> bytes:
    """The bytes of a file of this name with one change or more."""
    if dice.randrange(2):
        return structured(sound, name, dice)
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


ODD = [None, True, -1, 0, 1, 1e300, -1e300, 1e-300, 2**31, 2**32, 2**63, 2**64, "", "nan", "\0", "x" * 5000, [], {}, [[]] * 50]


def change_value(value: object, dice: random.Random) -> object:
    """A value of JSON with one of its parts replaced, left out, doubled or moved, at any depth."""
    if isinstance(value, dict) and value and dice.random() < 0.85:
        key, copy = dice.choice(list(value)), dict(value)
        match dice.randrange(8):
            case 0:
                del copy[key]
            case 1:
                copy[dice.choice(list(value))] = value[key]
            case _:
                copy[key] = change_value(value[key], dice)
        return copy
    if isinstance(value, list) and value and dice.random() < 0.85:
        at, copy = dice.randrange(len(value)), list(value)
        match dice.randrange(8):
            case 0:
                del copy[at]
            case 1:
                copy[at:at] = copy[dice.randrange(len(value)) :]
            case _:
                copy[at] = change_value(value[at], dice)
        return copy
    if isinstance(value, (int, float)) and not isinstance(value, bool) and dice.random() < 0.6:
        return dice.choice([value + 1, value - 1, -value, 2 * value, value * 1000, value / 1000, 1 << 31, (1 << 32) - 1, 1 << 40])
    return dice.choice(ODD)


def change_text(text: str, dice: random.Random) -> str:
    """A text of lines and words with some moved, doubled or left out, or with a number changed."""
    lines = text.split("\n")
    at, other = dice.randrange(len(lines)), dice.randrange(len(lines))
    match dice.randrange(6):
        case 0:
            del lines[at]
        case 1:
            lines[at:at] = [lines[other]]
        case 2:
            lines[at], lines[other] = lines[other], lines[at]
        case 3:
            words = lines[at].split(" ")
            words[dice.randrange(len(words))] = dice.choice(lines[other].split(" "))
            lines[at] = " ".join(words)
        case _:
            spans = [m.span() for m in re.finditer(r"-?[0-9][0-9.eE+-]*", lines[at])]
            if spans:
                start, end = dice.choice(spans)
                number = lines[at][start:end]
                near = [str(int(number) + 1), str(int(number) - 1), number + "0" * 4] if number.isdigit() else ["-" + number]
                lines[at] = lines[at][:start] + dice.choice([*near, *(n.decode() for n in NUMBERS)]) + lines[at][end:]
    return "\n".join(lines)


def change_fields(data: bytearray, first: int, end: int, dice: random.Random) -> None:
    """Changes a number of four or eight bytes between two places of binary data."""
    size = dice.choice((4, 4, 4, 8, 2))
    if end - first < size:
        return
    at = first + dice.randrange(end - first - size + 1) // size * size
    number = int.from_bytes(data[at : at + size], "little")
    values = [number + 1, number - 1, 2 * number, number << 16, 0, 1, len(data), (1 << 8 * size) - 1, 1 << 8 * size - 1]
    if size > 2:
        packed = [struct.pack("<f" if size == 4 else "<d", v) for v in (math.nan, math.inf, -1e30, 1e30, 1e-40)]
        values += [int.from_bytes(p, "little") for p in packed]
    data[at : at + size] = (dice.choice(values) % (1 << 8 * size)).to_bytes(size, "little")


def glb(data: bytes, dice: random.Random) -> bytes:
    """A GLB file with its JSON or its buffer changed, and the lengths of its chunks right again."""
    length = int.from_bytes(data[12:16], "little")
    text, rest = data[20 : 20 + length], bytearray(data[20 + length :])
    if dice.randrange(4):
        text = json.dumps(change_value(json.loads(text), dice)).encode()
        text += b" " * (-len(text) % 4)
    elif len(rest) > 8:
        change_fields(rest, 8, len(rest), dice)
    total = 20 + len(text) + len(rest)
    return data[:8] + struct.pack("<II", total, len(text)) + data[16:20] + text + bytes(rest)


def checksum(data: bytes) -> int:
    """The checksum of records of frames (greenstick_fibre::store::checksum)."""
    every, hash_ = (1 << 64) - 1, 0xCBF29CE484222325
    words = [int.from_bytes(data[i : i + 8], "little") for i in range(0, len(data), 8)]
    for word in (*words, len(data)):
        hash_ = (hash_ ^ word) * 0x100000001B3 & every
        hash_ ^= hash_ >> 29
    return hash_


def frames(data: bytes, dice: random.Random) -> bytes:
    """Frames of a run with numbers of one record changed, and its checksum right again."""
    records, at = [], 16
    while at + 8 <= len(data):
        length = int.from_bytes(data[at : at + 8], "little")
        records.append((at + 8, length))
        at += 16 + length
    # Films and stills read the last frame first.
    first, length = dice.choice([records[0], records[-1], records[-1]])
    content = bytearray(data[first : first + length])
    for _ in range(dice.choice((1, 1, 3))):
        # The counts, then the table of rods, are at the front.
        change_fields(content, 0, dice.choice((32, 200, len(content))), dice)
    if dice.randrange(6) == 0:
        del content[dice.randrange(len(content)) :]
    head = data[: first - 8] + struct.pack("<Q", len(content))
    return head + bytes(content) + struct.pack("<Q", checksum(bytes(content))) + data[first + length + 8 :]


def structured(sound: bytes, name: str, dice: random.Random) -> bytes:
    """A file that keeps its format, with something in it that does not belong there."""
    ending = name.rsplit(".", 1)[-1]
    for _ in range(dice.choice((1, 1, 2, 4))):
        if ending == "glb":
            sound = glb(sound, dice)
        elif ending == "gsf":
            sound = frames(sound, dice)
        elif ending in ("gltf", "json"):
            sound = json.dumps(change_value(json.loads(sound), dice)).encode()
        elif b"\0" not in sound[:4096]:
            sound = change_text(sound.decode("latin-1"), dice).encode("latin-1")
        else:
            data = bytearray(sound)
            # Headers are short: a third of the changes is there.
            change_fields(data, 0, dice.choice((400, len(data), len(data))), dice)
            sound = bytes(data)
    return sound


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
    while number < files if files is not None else time.monotonic() - started < options.seconds_per_reader:
        data = damaged(bytes_, sound.name, random.Random(f"{options.seed} {name} {number}"))
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
    parser.add_argument("--seconds-per-reader", type=float, default=20.0, help="time of each reader, s")
    parser.add_argument("--reader", action="append", help="a reader, by its name; without it, all")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--keep", type=Path, help="folder for the files that were faults")
    options = parser.parse_args()
    program = options.program.resolve()
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    with tempfile.TemporaryDirectory() as top:
        top = Path(top)
        (top / "sound").mkdir()
        all_readers = readers(program, top / "sound")
        unknown = set(options.reader or ()) - {name for name, _, _ in all_readers}
        if unknown:
            sys.exit(f"no reader {sorted(unknown)}; there are {', '.join(name for name, _, _ in all_readers)}")
        all_readers = [reader for reader in all_readers if not options.reader or reader[0] in options.reader]
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
