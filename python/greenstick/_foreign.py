"""Meshes and tables as other packages have them, where those are installed."""

from __future__ import annotations

import io
from typing import Any

import numpy as np

from greenstick._native import Mesh


def _attributes(mesh: Mesh) -> dict[str, Any]:
    return {name: np.array(values) for name, values in mesh.attributes.items()}


def mesh_to_trimesh(mesh: Mesh) -> Any:
    """A ``trimesh.Trimesh`` with the attributes of the vertices. Nothing is merged or repaired."""
    import trimesh

    faces: dict[str, Any] = {} if mesh.materials is None else {"material": np.array(mesh.materials)}
    return trimesh.Trimesh(
        vertices=np.array(mesh.positions),
        faces=mesh.triangles.astype(np.int64),
        vertex_attributes=_attributes(mesh),
        face_attributes=faces,
        process=False,
    )


def mesh_from_trimesh(mesh: Any) -> Mesh:
    """A mesh of a ``trimesh.Trimesh`` with its attributes of the vertices that are numbers."""
    attributes = {}
    for name, values in mesh.vertex_attributes.items():
        values = np.asarray(values)
        if values.dtype.kind in "fiu" and values.ndim in (1, 2):
            attributes[name] = values
    materials = mesh.face_attributes.get("material")
    return Mesh(np.asarray(mesh.vertices), np.asarray(mesh.faces), attributes, materials)


def mesh_to_pyvista(mesh: Mesh) -> Any:
    """A ``pyvista.PolyData`` with the attributes of the vertices and the materials of the triangles."""
    import pyvista

    sides = np.full((len(mesh.triangles), 1), 3, dtype=np.int64)
    made = pyvista.PolyData(np.array(mesh.positions), np.hstack([sides, mesh.triangles.astype(np.int64)]))
    for name, values in _attributes(mesh).items():
        made.point_data[name] = values
    if mesh.materials is not None:
        made.cell_data["material"] = np.array(mesh.materials)
    return made


def parquet_table(files: dict[str, bytes], name: str) -> Any:
    """A ``pyarrow.Table`` of a Parquet file among ``files``."""
    import pyarrow.parquet

    known = [file.removesuffix(".parquet") for file in files if file.endswith(".parquet")]
    if name not in known:
        raise KeyError(f"there is no table {name!r}; expected one of {known}")
    return pyarrow.parquet.read_table(io.BytesIO(files[f"{name}.parquet"]))
