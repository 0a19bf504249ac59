"""Spoils files that `validate_film.py` finds good and demands that it finds the fault: a judge that passes everything is
none. Needs what `cargo run -p greenstick-formats --example film` writes.

Usage: python test_validate_film.py FOLDER
"""

import json
import struct
import subprocess
import sys
import tempfile
from pathlib import Path

JUDGE = Path(__file__).with_name("validate_film.py")


def judge(*arguments):
    done = subprocess.run([sys.executable, JUDGE, *map(str, arguments)], capture_output=True, text=True)
    return done.returncode, done.stdout + done.stderr


def with_json(data, change):
    """A GLB with its JSON changed."""
    (length,) = struct.unpack_from("<I", data, 12)
    document = json.loads(data[20 : 20 + length])
    change(document)
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    rest = data[20 + length :]
    head = struct.pack("<4sIIII", b"glTF", 2, 20 + len(text) + len(rest), len(text), 0x4E4F534A)
    return head + text + rest


def expect(says, *arguments):
    code, told = judge(*arguments)
    assert code == 1 and says in told, f"{arguments}: expected {says!r}, was told {code}: {told}"
    print(f"found: {says}")


def main():
    folder = Path(sys.argv[1])
    code, told = judge(folder / "film.glb", folder / "film.usdc")
    assert code == 0, told
    glb = (folder / "film.glb").read_bytes()
    usd = (folder / "still.usda").read_text()
    with tempfile.TemporaryDirectory() as place:
        spoiled = Path(place) / "spoiled.glb"
        spoiled.write_bytes(with_json(glb, lambda d: d.pop("animations")))
        expect("0 animations", spoiled)
        spoiled.write_bytes(with_json(glb, lambda d: d["animations"][0].update(channels=d["animations"][0]["channels"][:2])))
        expect("nothing moves", spoiled)
        spoiled.write_bytes(glb[:-4] + struct.pack("<f", float("nan")))
        expect("not finite", spoiled)
        expect("more than 1e-05 m", folder / "film.glb", folder / "few.glb")
        expect("samples over time in a still", "--still", folder / "film.usdc")
        text = Path(place) / "spoiled.usda"
        for was, becomes in [
            ('    upAxis = "Y"\n', ""),
            ("prepend apiSchemas", "prepend otherSchemas"),
            ('"UsdPreviewSurface"', '"UsdPreviewSurfeit"'),
        ]:
            assert was in usd, was
            text.write_text(usd.replace(was, becomes))
            expect("objections of", "--still", text)
        series = Path(place) / "spoiled.pvd"
        lines = (folder / "film.pvd").read_text()
        series.write_text(lines)
        expect("is not there", series)
        for file in folder.glob("*.vtp"):
            (Path(place) / file.name).write_bytes(file.read_bytes())
        assert judge(series)[0] == 0
        (Path(place) / "rods_0003.vtp").write_bytes((folder / "bonds_0003.vtp").read_bytes())
        expect("other fields", series)
        cut = (folder / "rods_0004.vtp").read_bytes()
        (Path(place) / "rods_0003.vtp").write_bytes(cut[: len(cut) // 2])
        expect("rods_0003.vtp", series)


if __name__ == "__main__":
    main()
