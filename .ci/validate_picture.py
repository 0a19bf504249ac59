"""Judges a picture: a PNG that decodes to its full size and is not of one colour.

Usage: python validate_picture.py FILE.png
"""

import struct
import sys
import zlib


def judge(data):
    """Faults of the PNG in `data`, a list of sentences."""
    if data[:8] != b"\x89PNG\r\n\x1a\n":
        return ["is no PNG"]
    at, header, packed, ended = 8, None, b"", False
    while at + 12 <= len(data):
        size, kind = struct.unpack(">I4s", data[at : at + 8])
        body = data[at + 8 : at + 8 + size]
        if data[at + 8 + size : at + 12 + size] != struct.pack(">I", zlib.crc32(kind + body)):
            return [f"chunk {kind!r} has a wrong checksum"]
        if kind == b"IHDR":
            header = struct.unpack(">IIBBBBB", body)
        elif kind == b"IDAT":
            packed += body
        ended = kind == b"IEND"
        at += 12 + size
    if header is None or not ended:
        return ["is cut short"]
    width, height, depth, colour = header[:4]
    channels = {0: 1, 2: 3, 3: 1, 4: 2, 6: 4}[colour]
    row = 1 + (width * channels * depth + 7) // 8
    try:
        pixels = zlib.decompress(packed)
    except zlib.error as error:
        return [f"does not decompress: {error}"]
    if len(pixels) != row * height:
        return [f"has {len(pixels)} bytes of pixels, {row * height} expected"]
    # Filtered rows of one colour are zero but for the first pixel.
    if sum(byte != 0 for byte in pixels) < width:
        return ["shows nothing"]
    print(f"picture: {width} × {height} pixels")
    return []


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    with open(sys.argv[1], "rb") as file:
        faults = judge(file.read())
    for fault in faults:
        print(f"{sys.argv[1]} {fault}")
    sys.exit(bool(faults))
