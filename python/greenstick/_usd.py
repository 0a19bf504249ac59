"""Scenes of USD stages, by usd-core: their meshes, where they stand, and which of them are the same."""

from __future__ import annotations

import os
from collections.abc import Iterator
from fnmatch import fnmatchcase
from typing import Any

import numpy as np

from greenstick._native import Mesh, Node, Scene
from greenstick.errors import InputError

# Where z is up, what turns it to y: x stays, z becomes y, y becomes -z.
_Z_TO_Y = np.array([[1, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1]], dtype=float)


def scene_from_usd(path: str | os.PathLike[str], groups: str | None = None, time: float | None = None) -> Scene:
    """The meshes of a USD file as a scene in metres, y up. Needs ``usd-core``.

    Meshes of the same points and faces are instances of one mesh, whether they are instances of USD, of a point instancer, or
    copies. Faces become triangles; names are those of the prims. What is hidden or a guide is left out, and so are materials,
    texture coordinates and normals: bark gets Greenstick's own.

    Parameters
    ----------
    path
        A file (.usd, .usda, .usdc, .usdz).
    groups
        Names of groups that are one thing, such as "Tree_*": their first mesh has the name of the group and carries the others.
        Instances of a point instancer are groups, each with its name and its number, "Forest_0017".
    time
        Time code of what moves; the first without it.

    Raises
    ------
    InputError
        Where the file cannot be opened or holds no meshes.
    """
    try:
        from pxr import Tf, Usd, UsdGeom
    except ImportError as error:
        raise ImportError("USD files need usd-core: pip install usd-core") from error
    try:
        stage = Usd.Stage.Open(os.fspath(path))
    except Tf.ErrorException as error:
        raise InputError(f"{os.fspath(path)} cannot be opened: {error}") from error
    code = Usd.TimeCode.EarliestTime() if time is None else Usd.TimeCode(time)
    world = np.diag([UsdGeom.GetStageMetersPerUnit(stage)] * 3 + [1.0])
    if UsdGeom.GetStageUpAxis(stage) == UsdGeom.Tokens.z:
        world = _Z_TO_Y @ world
    meshes: dict[tuple[bytes, bytes], Mesh] = {}
    nodes: list[Node] = []
    first: dict[str, int] = {}
    for prim, group, placed in _placed(stage.GetPseudoRoot(), code, groups):
        mesh = _mesh(UsdGeom.Mesh(prim), code, meshes)
        if mesh is None:
            continue
        name, key = group or (prim.GetName(), "")
        parent = first.get(key) if key else None
        if key:
            first.setdefault(key, len(nodes))
        nodes.append(Node(name if parent is None else prim.GetName(), mesh, world @ placed, parent))
    if not nodes:
        raise InputError(f"{os.fspath(path)} holds no meshes that are shown")
    return Scene(nodes)


def _matrix(matrix: Any) -> np.ndarray[Any, Any]:
    """A matrix of USD, which is for rows, for columns."""
    return np.array(matrix, dtype=float).T


def _placed(root: Any, code: Any, groups: str | None) -> Iterator[tuple[Any, tuple[str, str] | None, Any]]:
    """The meshes below a prim: each with the name and the key of its group, if it has one, and its matrix to the stage."""
    from pxr import Usd, UsdGeom

    cache = UsdGeom.XformCache(code)
    walk = iter(Usd.PrimRange(root, Usd.TraverseInstanceProxies()))
    for prim in walk:
        imageable = UsdGeom.Imageable(prim)
        if imageable and not _is_shown(imageable, code):
            walk.PruneChildren()
        elif prim.IsA(UsdGeom.PointInstancer):
            # Its prototypes usually stand below it; they show at its points only.
            walk.PruneChildren()
            yield from _instanced(prim, code, _matrix(cache.GetLocalToWorldTransform(prim)))
        elif prim.IsA(UsdGeom.Mesh):
            yield prim, _group(prim, groups), _matrix(cache.GetLocalToWorldTransform(prim))


def _is_shown(imageable: Any, code: Any) -> bool:
    visibility = imageable.GetVisibilityAttr().Get(code)
    purpose = imageable.GetPurposeAttr().Get(code)
    return visibility != "invisible" and purpose not in ("guide", "proxy")


def _group(prim: Any, groups: str | None) -> tuple[str, str] | None:
    """The name and the path of the group farthest up that a prim is in."""
    found = None
    while groups is not None and not prim.IsPseudoRoot():
        if fnmatchcase(prim.GetName(), groups):
            found = prim.GetName(), str(prim.GetPath())
        prim = prim.GetParent()
    return found


def _instanced(prim: Any, code: Any, placed: Any) -> Iterator[tuple[Any, tuple[str, str], Any]]:
    """The meshes of a point instancer."""
    from pxr import UsdGeom

    instancer = UsdGeom.PointInstancer(prim)
    kinds = instancer.GetProtoIndicesAttr().Get(code) or []
    paths = instancer.GetPrototypesRel().GetForwardedTargets()
    prototypes = []
    for path in paths:
        prototype = prim.GetStage().GetPrimAtPath(path)
        # The transforms of instances contain those of prototypes, but not what is above these.
        above = UsdGeom.XformCache(code).GetLocalToWorldTransform(prototype)
        inverse = np.linalg.inv(_matrix(above))
        prototypes.append([(mesh, inverse @ matrix) for mesh, _, matrix in _placed(prototype, code, None)])
    include, apply = UsdGeom.PointInstancer.IncludeProtoXform, UsdGeom.PointInstancer.ApplyMask
    transforms = instancer.ComputeInstanceTransformsAtTime(code, code, include, apply)
    mask = instancer.ComputeMaskAtTime(code)
    shown = [i for i in range(len(kinds)) if not mask or mask[i]]
    for number, transform in zip(shown, transforms, strict=True):
        key = f"{prim.GetPath()}[{number}]"
        for mesh, inside in prototypes[kinds[number]]:
            yield mesh, (f"{prim.GetName()}_{number:04d}", key), placed @ _matrix(transform) @ inside


def _mesh(mesh: Any, code: Any, known: dict[tuple[bytes, bytes], Mesh]) -> Mesh | None:
    """The mesh of a prim, the known one of equal points and triangles; none without any."""
    from pxr import UsdGeom

    points = np.array(mesh.GetPointsAttr().Get(code), dtype=np.float64).reshape(-1, 3)
    counts = np.array(mesh.GetFaceVertexCountsAttr().Get(code), dtype=np.int64).reshape(-1)
    corners = np.array(mesh.GetFaceVertexIndicesAttr().Get(code), dtype=np.int64).reshape(-1)
    holes = mesh.GetHoleIndicesAttr().Get(code) or []
    starts = np.cumsum(counts) - counts
    starts, counts = np.delete(starts, holes), np.delete(counts, holes)
    # Fans: corner 0 of each face with its corners k and k + 1.
    fans = [
        np.stack([corners[starts[counts > k + 1] + j] for j in (0, k, k + 1)], axis=1)
        for k in range(1, int(counts.max(initial=0)) - 1)
    ]
    if not fans:
        return None
    triangles = np.concatenate(fans)
    if mesh.GetOrientationAttr().Get(code) == UsdGeom.Tokens.leftHanded:
        triangles = triangles[:, ::-1]
    triangles = np.ascontiguousarray(triangles, dtype=np.uint32)
    key = points.tobytes(), triangles.tobytes()
    if key not in known:
        known[key] = Mesh(points, triangles)
    return known[key]
