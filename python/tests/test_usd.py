"""Stages of USD as scenes: instances of every kind, axes, units, groups; and a forest of them that breaks."""

from __future__ import annotations

import json
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import greenstick
from conftest import needs
from greenstick import errors

# A closed stem along z of a stage in centimetres: 12 corners in each of 9 sections.
SIDES, SECTIONS, HEIGHT = 12, 9, 300.0


def stem() -> tuple[Any, list[int], list[int]]:
    """Points, corners in each face, and corners: quadrilaterals, and a polygon at each end."""
    angles = 2 * np.pi * np.arange(SIDES) / SIDES
    radii = np.linspace(12.0, 6.0, SECTIONS)
    points = [
        (r * np.cos(a), r * np.sin(a), z) for r, z in zip(radii, np.linspace(0.0, HEIGHT, SECTIONS)) for a in angles
    ]
    faces: list[list[int]] = [list(range(SIDES))[::-1], [(SECTIONS - 1) * SIDES + k for k in range(SIDES)]]
    for section in range(SECTIONS - 1):
        for side in range(SIDES):
            a, b = section * SIDES + side, section * SIDES + (side + 1) % SIDES
            faces.append([a, b, b + SIDES, a + SIDES])
    return points, [len(face) for face in faces], [corner for face in faces for corner in face]


@pytest.fixture
def stage(tmp_path: Path) -> Path:
    """Three trees that are instances of one prim, one that is a copy, and four of a point instancer."""
    needs("pxr", "GREENSTICK_NEEDS_USD")
    from pxr import Gf, Usd, UsdGeom

    path = tmp_path / "forest.usda"
    made = Usd.Stage.CreateNew(str(path))
    UsdGeom.SetStageUpAxis(made, UsdGeom.Tokens.z)
    UsdGeom.SetStageMetersPerUnit(made, 0.01)

    def mesh(at: str, shape: tuple[Any, list[int], list[int]]) -> None:
        one = UsdGeom.Mesh.Define(made, at)
        one.CreatePointsAttr([Gf.Vec3f(*map(float, p)) for p in shape[0]])
        one.CreateFaceVertexCountsAttr(shape[1])
        one.CreateFaceVertexIndicesAttr(shape[2])

    leaf = ([(0, 0, 0), (20, 0, 0), (20, 20, 0), (0, 20, 0)], [4], [0, 1, 2, 3])
    made.CreateClassPrim("/Kinds")
    UsdGeom.Xform.Define(made, "/Kinds/Oak")
    mesh("/Kinds/Oak/wood", stem())
    mesh("/Kinds/Oak/leaf", leaf)
    UsdGeom.Xform.Define(made, "/World")
    for k in range(3):
        tree = UsdGeom.Xform.Define(made, f"/World/Tree_{k:03d}")
        tree.AddTranslateOp().Set(Gf.Vec3d(400.0 * k, 100.0, 0.0))
        tree.AddRotateZOp().Set(30.0 * k)
        tree.GetPrim().GetReferences().AddInternalReference("/Kinds/Oak")
        tree.GetPrim().SetInstanceable(True)
    mesh("/World/Tree_copy", stem())
    hidden = UsdGeom.Mesh.Define(made, "/World/hidden")
    hidden.CreateVisibilityAttr("invisible")
    instancer = UsdGeom.PointInstancer.Define(made, "/World/Row")
    mesh("/World/Row/Kinds/pine", stem())
    instancer.CreatePrototypesRel().SetTargets(["/World/Row/Kinds/pine"])
    instancer.CreateProtoIndicesAttr([0] * 4)
    instancer.CreatePositionsAttr([Gf.Vec3f(0.0, 300.0 + 200.0 * k, 50.0) for k in range(4)])
    made.GetRootLayer().Save()
    return path


def test_instances_of_all_kinds_share_their_mesh_and_stand_where_usd_has_them(stage: Path) -> None:
    from pxr import Usd, UsdGeom

    scene = greenstick.scene_from_usd(stage, groups="Tree_*")
    names = [node.name for node in scene.nodes]
    assert sorted(n for n in names if n != "leaf") == [
        *[f"Row_{k:04d}" for k in range(4)],
        *[f"Tree_{k:03d}" for k in range(3)],
        "Tree_copy",
    ]
    assert names.count("leaf") == 3
    leaves = [node for node in scene.nodes if node.name == "leaf"]
    assert [names[leaf.parent] for leaf in leaves if leaf.parent is not None] == ["Tree_000", "Tree_001", "Tree_002"]
    # Boxes in the world, by USD's own reckoning: centimetres, z up.
    opened = Usd.Stage.Open(str(stage))
    cache = UsdGeom.BBoxCache(Usd.TimeCode.Default(), [UsdGeom.Tokens.default_], False)
    for name, path in [("Tree_001", "/World/Tree_001/wood"), ("Tree_copy", "/World/Tree_copy")]:
        vertices = scene.nodes[names.index(name)].world_mesh().positions
        bound = cache.ComputeWorldBound(opened.GetPrimAtPath(path))
        # A box of the points themselves would be smaller where the tree is turned.
        middle = np.array(bound.ComputeCentroid()) / 100.0
        assert np.allclose((vertices.min(0) + vertices.max(0)) / 2, [middle[0], middle[2], -middle[1]], atol=1e-5)
    row = scene.nodes[names.index("Row_0002")].world_mesh().positions
    assert np.allclose([row[:, 1].min(), row[:, 1].max(), row[:, 2].mean()], [0.5, 3.5, -7.0], atol=1e-5)
    # Turned outwards, the volume of the frustum: equal meshes are in a file once.
    area = SIDES / 2 * np.sin(2 * np.pi / SIDES)
    volume = area * 3.0 / 3 * (0.12**2 + 0.12 * 0.06 + 0.06**2)
    assert np.isclose(scene.nodes[names.index("Row_0000")].world_mesh().volume, volume, rtol=1e-6)
    content = scene.encode("forest.glb")["forest.glb"]
    document = json.loads(content[20 : 20 + struct.unpack_from("<I", content, 12)[0]])
    assert len(document["meshes"]) == 2 and len(document["nodes"]) == 11


def test_a_forest_of_usd_breaks(stage: Path, tmp_path: Path) -> None:
    greenstick.scene_from_usd(stage, groups="Tree_*").write(tmp_path / "forest.glb")
    made = greenstick.sweep(
        {
            "sweep": {
                "kind": "forest",
                "input": str(tmp_path / "forest.glb"),
                "nodes": "Tree_*, Row_*",
                "only": "Tree_00?, Row_0001",
                "textures": False,
                "sheet": 0,
            },
            "break.rings": 6,
            "break.sectors": 12,
            "vary": {"moisture": {"between": [10, 30]}},
        },
        tmp_path / "storm",
    )
    rows = made.table().to_pylist()
    assert len(rows) == 8 and made.report["failed"] == 0
    assert {row["tree"] for row in rows if row["broken"]} == {"Tree_000", "Tree_001", "Tree_002", "Row_0001"}
    assert len({row["seed"] for row in rows}) == 8
    for row in rows:
        assert not row["broken"] or np.isclose(row["volume_m3"], row["input_volume_m3"], rtol=1e-6)
    names = [node.name for node in greenstick.Scene.read(made.report["scene"]).nodes]
    assert {"Tree_001_lower", "Tree_001_upper", "Row_0001_lower", "Tree_copy", "Row_0000"} <= set(names)
    assert "Tree_001" not in names and names.count("leaf") == 3


def test_what_is_no_stage_is_told(tmp_path: Path) -> None:
    needs("pxr", "GREENSTICK_NEEDS_USD")
    (tmp_path / "none.usda").write_text("#usda 1.0\n")
    with pytest.raises(errors.InputError, match="no meshes"):
        greenstick.scene_from_usd(tmp_path / "none.usda")
    with pytest.raises(errors.InputError, match="cannot be opened"):
        greenstick.scene_from_usd(tmp_path / "absent.usda")
