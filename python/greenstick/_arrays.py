"""Tables and volumes, which the library makes as files in memory, as NumPy arrays."""

from __future__ import annotations

import csv
import io
import zlib
from typing import Any, NamedTuple
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

# Types of the formats, all little-endian.
_PLY = {"float": "<f4", "double": "<f8", "uchar": "u1", "uint": "<u4"}
_VTK = {"UInt8": "u1", "UInt16": "<u2"}


class Voxels(NamedTuple):
    """The voxels of a straight part of a stem. The first axis of arrays is z, along the stem; the second y, the third x."""

    ring: NDArray[Any]
    """Annual ring from 1 at the pith, 0 outside of the wood: shape (z, y, x), uint8, or uint16 with more than 255 rings."""
    zone: NDArray[np.uint8]
    """Tissue as a number, as in the documentation of the program's files: shape (z, y, x)."""
    colour: NDArray[np.uint8]
    """Red, green and blue of the wood in sRGB: shape (z, y, x, 3)."""
    origin: NDArray[np.float64]
    """The corner of the first voxel in the world: shape (3,), m."""
    spacing: NDArray[np.float64]
    """Edge lengths of a voxel along x, y and z: shape (3,), m."""
    directions: NDArray[np.float64]
    """Unit vectors along x, y and z in the world: shape (3, 3), one in each row."""


def _column(cells: list[str]) -> NDArray[Any]:
    """Whole numbers as int64, numbers as float64 with NaN for an empty cell, and all else as texts."""
    for dtype in (np.int64, np.float64):
        try:
            filled = cells if dtype is np.int64 else [cell or "nan" for cell in cells]
            return np.array(filled, dtype=np.str_).astype(dtype)
        except ValueError:
            continue
    return np.array(cells, dtype=np.str_)


def csv_columns(text: str) -> dict[str, NDArray[Any]]:
    """The columns of comma-separated values with a header line, each of shape (n,)."""
    header, *rows = csv.reader(io.StringIO(text))
    return {name: _column([row[k] for row in rows]) for k, name in enumerate(header)}


def _ply_columns(data: bytes) -> dict[str, NDArray[Any]]:
    """The properties of the vertices of a binary PLY file: views into its bytes."""
    end = data.index(b"end_header\n") + len(b"end_header\n")
    words = [line.split() for line in data[:end].decode().splitlines()]
    count = next(int(line[2]) for line in words if line[:2] == ["element", "vertex"])
    fields = [(line[2], _PLY[line[1]]) for line in words if line[0] == "property"]
    rows = np.frombuffer(data, dtype=np.dtype(fields), count=count, offset=end)
    return {name: rows[name] for name, _ in fields}


def columns(files: dict[str, bytes], name: str) -> dict[str, NDArray[Any]]:
    """The columns of a table among ``files``: of its PLY file, where it has one, or of its CSV file."""
    if f"{name}.ply" in files:
        return _ply_columns(files[f"{name}.ply"])
    if f"{name}.csv" in files:
        return csv_columns(files[f"{name}.csv"].decode())
    known = {file.rsplit(".", 1)[0] for file in files if file.endswith((".ply", ".csv"))}
    raise KeyError(f"there is no table {name!r}; expected one of {sorted(known)}")


def _values(array: ElementTree.Element, appended: bytes) -> NDArray[Any]:
    """The values of an array of a VTK file: blocks compressed by zlib behind their number and sizes."""
    offset = int(array.attrib["offset"])
    blocks = int(np.frombuffer(appended, "<u8", 1, offset)[0])
    sizes = np.frombuffer(appended, "<u8", blocks, offset + 24)
    ends = offset + 24 + 8 * blocks + np.cumsum(sizes).astype(np.int64)
    parts = (zlib.decompress(appended[end - size : end]) for size, end in zip(sizes.tolist(), ends.tolist()))
    return np.frombuffer(b"".join(parts), _VTK[array.attrib["type"]])


def _image(data: bytes) -> Voxels:
    """The voxels of a VTK image."""
    text, _, appended = data.partition(b'<AppendedData encoding="raw">\n_')
    image = ElementTree.fromstring(text.decode() + "</VTKFile>")[0]
    numbers = {name: np.array(image.attrib[name].split(), dtype=np.float64) for name in image.attrib}
    x, y, z = numbers["WholeExtent"][1::2].astype(int).tolist()
    values = {array.attrib["Name"]: _values(array, appended) for array in image.iterfind("Piece/CellData/DataArray")}
    return Voxels(
        values["ring"].reshape(z, y, x),
        values["zone"].reshape(z, y, x),
        values["colour"].reshape(z, y, x, 3),
        numbers["Origin"],
        numbers["Spacing"],
        # They are the columns of the matrix in the file.
        numbers["Direction"].reshape(3, 3).T,
    )


def voxels(files: dict[str, bytes]) -> list[Voxels]:
    """The voxels of each straight part of a stem, from its base on."""
    names = sorted(file for file in files if file.endswith(".vti"))
    if not names:
        raise KeyError("no voxels were made; expected \"volume\" in only=")
    return [_image(files[name]) for name in names]
