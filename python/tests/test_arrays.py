"""Arrays: views without copies, and arrays of users of any kind."""

from __future__ import annotations

import gc
from typing import Any

import numpy as np
import pytest

import greenstick
from greenstick import Mesh, Node, Scene, errors

POSITIONS = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]])
TRIANGLES = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])


def tetrahedron(**more: Any) -> Mesh:
    return Mesh(POSITIONS, TRIANGLES, **more)


def test_views_share_memory_outlive_the_mesh_and_are_read_only() -> None:
    mesh = tetrahedron()
    first, second = mesh.positions, mesh.positions
    assert np.shares_memory(first, second)
    owner: object = first.base
    assert owner is mesh
    assert first.dtype == np.float64 and mesh.triangles.dtype == np.uint32
    del mesh
    gc.collect()
    assert np.array_equal(first, POSITIONS)
    with pytest.raises(ValueError, match="read-only"):
        first[0, 0] = 1
    with pytest.raises(ValueError):
        first.setflags(write=True)


def test_volume_and_check() -> None:
    mesh = tetrahedron()
    assert mesh.volume == pytest.approx(1 / 6)
    found = mesh.check()
    assert found["closed"] and found["oriented"] and found["self_intersections"]["crossing"] == 0


@pytest.mark.parametrize(
    ("positions", "triangles"),
    [
        (POSITIONS.astype(np.float32), TRIANGLES.astype(np.uint16)),
        (POSITIONS.astype(">f8"), TRIANGLES.astype(">i4")),
        (np.asfortranarray(POSITIONS), np.asfortranarray(TRIANGLES)),
        (np.repeat(POSITIONS, 2, axis=0)[::2], np.repeat(TRIANGLES, 2, axis=1)[:, ::2]),
        (POSITIONS.astype(int), TRIANGLES.tolist()),
        (POSITIONS.tolist(), TRIANGLES),
    ],
)
def test_arrays_of_any_layout_are_taken(positions: Any, triangles: Any) -> None:
    if isinstance(positions, np.ndarray):
        positions.setflags(write=False)
    mesh = Mesh(positions, triangles)
    assert mesh == tetrahedron()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((POSITIONS[:, :2], TRIANGLES), "positions has the shape (4, 2); expected an array of shape (n, 3)"),
        ((POSITIONS[0], TRIANGLES), "positions has the shape (3,)"),
        ((POSITIONS.astype(complex), TRIANGLES), "positions has the dtype complex128"),
        ((POSITIONS.astype(str), TRIANGLES), "positions has the dtype <U"),
        ((np.array([[0, np.nan, 0]] * 4), TRIANGLES), "positions[0, 1] is NaN; expected finite numbers"),
        ((np.array([[0, 0, np.inf]] * 4), TRIANGLES), "positions[0, 2] is inf"),
        ((POSITIONS, TRIANGLES.astype(float)), "triangles has the dtype float64"),
        ((POSITIONS, TRIANGLES + 1), "triangles[1, 2] is 4; there are 4 vertices"),
        ((POSITIONS, TRIANGLES - 1), "triangles[0, 0] is -1"),
        ((POSITIONS, TRIANGLES, {"_X": np.zeros(3)}), "the attribute _X has the shape [3]; expected (4, k)"),
        ((POSITIONS, TRIANGLES, None, [1, 2]), "materials has 2 numbers; expected 4"),
        ((POSITIONS, TRIANGLES, None, [1, 2, 3, -4]), "materials has numbers beyond"),
    ],
)
def test_wrong_arrays_are_refused(arguments: tuple[Any, ...], message: str) -> None:
    with pytest.raises(errors.InputError) as caught:
        Mesh(*arguments)
    assert message in str(caught.value)


def test_scenes_of_arrays_are_written_and_read(tmp_path: Any) -> None:
    mesh = tetrahedron(attributes={"TEXCOORD_0": np.zeros((4, 2)), "_RING": np.arange(4)})
    assert {name: a.shape for name, a in mesh.attributes.items()} == {"TEXCOORD_0": (4, 2), "_RING": (4, 1)}
    transform = np.eye(4)
    transform[:3, 3] = 1, 2, 3
    scene = Scene([Node("a", mesh, transform), Node("b", mesh, parent=0)])
    assert scene.nodes[0].mesh == mesh
    assert np.array_equal(scene.nodes[0].transform, transform)
    assert np.array_equal(scene.nodes[0].world_mesh().positions, POSITIONS + [1, 2, 3])
    scene.write(tmp_path / "x.glb")
    read = Scene.read(tmp_path / "x.glb")
    assert [node.name for node in read.nodes] == ["a", "b"]
    assert np.array_equal(read.nodes[0].world_mesh().positions, POSITIONS + [1, 2, 3])
    with pytest.raises(errors.InputError, match="no parent"):
        Scene([Node("a", mesh, parent=4)])
    with pytest.raises(errors.InputError, match="no affine map"):
        Node("a", mesh, np.ones((4, 4)))


def test_instances_are_one_object() -> None:
    mesh = tetrahedron()
    nodes = Scene([Node("a", mesh), Node("b", mesh)]).nodes
    assert nodes[0].mesh is nodes[1].mesh


def test_trimesh_there_and_back() -> None:
    trimesh = pytest.importorskip("trimesh")
    piece = greenstick.Session().pieces(greenstick.Request(rings=6, sectors=12))[0].mesh
    made = piece.to_trimesh()
    assert isinstance(made, trimesh.Trimesh)
    back = Mesh.from_trimesh(made)
    assert np.array_equal(back.positions, piece.positions)
    assert np.array_equal(back.triangles, piece.triangles)
    assert set(back.attributes) == set(piece.attributes)
    assert made.volume == pytest.approx(piece.volume)


def test_pyvista_has_attributes() -> None:
    pyvista = pytest.importorskip("pyvista")
    piece = greenstick.Session().pieces(greenstick.Request(rings=6, sectors=12))[0].mesh
    made = piece.to_pyvista()
    assert isinstance(made, pyvista.PolyData)
    assert made.n_cells == len(piece.triangles)
    assert set(piece.attributes) <= set(made.point_data.keys())
