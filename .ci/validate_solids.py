"""Judges the pieces of a broken branch with two foreign libraries, trimesh and Manifold.

Pieces that the report calls closed must be closed and wound consistently when vertices are merged by position; their
volumes must be those of the report and add up to the input's; Manifold must accept each; no two may overlap.

Usage: python validate_solids.py BROKEN.glb REPORT.json [--closed]
With --closed a piece that the report does not call closed is a fault too.
"""

import io
import itertools
import json
import struct
import sys

import manifold3d
import numpy as np
import trimesh

# Relative. Positions in the file are single precision: 6e-8 of a metre against centimetres of thickness.
VOLUME_OF_PIECE = 1e-4
VOLUMES_TOGETHER = 1e-5
# Of the whole volume.
OVERLAP = 1e-6


def read_report(text):
    """The JSON object in `text`, which may have other lines around it."""
    start, end = text.find("{"), text.rfind("}")
    if start < 0 or end < start:
        raise ValueError("the report holds no JSON object")
    return json.loads(text[start : end + 1])


def merged(vertices, faces):
    """The mesh with vertices merged by exact position, without triangles that lose a corner by it."""
    points, number = np.unique(np.asarray(vertices) + 0.0, axis=0, return_inverse=True)
    faces = number.reshape(-1)[np.asarray(faces)]
    a, b, c = faces.T
    faces = faces[(a != b) & (b != c) & (c != a)]
    return trimesh.Trimesh(points, faces, process=False, validate=False)


def numbered(path):
    """A glTF file whose nodes are named by their numbers, since several may have one name; and their own names."""
    with open(path, "rb") as file:
        data = file.read()
    binary = data[:4] == b"glTF"
    (size,) = struct.unpack("<I", data[12:16]) if binary else (0,)
    document = json.loads(data[20 : 20 + size] if binary else data)
    names = {}
    for number, node in enumerate(document.get("nodes", [])):
        names[f"node {number}"] = node.get("name")
        node["name"] = f"node {number}"
    text = json.dumps(document).encode()
    if binary:
        text += b" " * (-len(text) % 4)
        rest = data[20 + size :]
        head = struct.pack("<4sIII4s", b"glTF", 2, 20 + len(text) + len(rest), len(text), b"JSON")
        text = head + text + rest
    return io.BytesIO(text), "glb" if binary else "gltf", names


def read_pieces(path):
    """(name, mesh in world coordinates) of every node with triangles, in the order of the file."""
    file, kind, names = numbered(path)
    scene = trimesh.load_scene(file, file_type=kind, process=False, skip_materials=True)
    parts = {}
    for node in scene.graph.nodes_geometry:
        transform, geometry = scene.graph[node]
        mesh = scene.geometry[geometry]
        if isinstance(mesh, trimesh.Trimesh) and len(mesh.faces):
            # A mesh of several materials has become a child for each, under the node that has the number.
            number = node if node in names else scene.graph.transforms.parents[node]
            parts.setdefault(number, []).append((transform, mesh))
    pieces = []
    for number in (n for n in names if n in parts):
        transforms, meshes = zip(*parts[number])
        # Merged before it is placed: placing may part equal positions.
        starts = np.cumsum([0] + [len(m.vertices) for m in meshes])
        faces = np.concatenate([m.faces + start for m, start in zip(meshes, starts)])
        whole = merged(np.concatenate([m.vertices for m in meshes]), faces)
        if not np.array_equal(transforms[0], np.eye(4)):
            whole.apply_transform(transforms[0])
        pieces.append((names[number], whole))
    return pieces


def pair_up(told, found):
    """Pairs of an entry of the report and a mesh: by name, else by place in the list."""
    by_name = dict(found)
    if all(str(t.get("name")) in by_name for t in told):
        return [(t, by_name[str(t["name"])]) for t in told]
    if len(told) == len(found):
        return [(t, mesh) for t, (_, mesh) in zip(told, found)]
    names, told_names = [n for n, _ in found], [t.get("name") for t in told]
    raise ValueError(f"the file has nodes {names}, the report pieces {told_names}")


def edge_faults(mesh):
    """Numbers of edges without a partner in the other direction, and of edges used repeatedly in one direction."""
    edges = np.concatenate([mesh.faces[:, [0, 1]], mesh.faces[:, [1, 2]], mesh.faces[:, [2, 0]]]).astype(np.int64)
    count = len(mesh.vertices)
    keys, uses = np.unique(edges[:, 0] * count + edges[:, 1], return_counts=True)
    lonely = ~np.isin(keys, edges[:, 1] * count + edges[:, 0])
    return int(lonely.sum()), int((uses > 1).sum())


def as_manifold(mesh):
    """The mesh as Manifold takes it."""
    vertices = np.ascontiguousarray(mesh.vertices, dtype=np.float64)
    return manifold3d.Manifold(manifold3d.Mesh64(vertices, np.ascontiguousarray(mesh.faces, dtype=np.uint64)))


def judge(glb, report, must_close=False):
    """Faults of the file at `glb` by its report, a list of sentences."""
    faults = []
    told = report.get("pieces") or []
    if len(told) < 2:
        faults.append(f"the report has {len(told)} pieces; a break gives at least two")
    solids, volume, all_closed = [], 0.0, True
    for entry, mesh in pair_up(told, read_pieces(glb)):
        name = entry.get("name")
        if not np.isfinite(mesh.vertices).all():
            faults.append(f"{name}: positions that are not finite")
            continue
        lonely, repeated = edge_faults(mesh)
        print(
            f"{name}: {len(mesh.faces)} triangles, volume {mesh.volume:.6g} m³,"
            f" {lonely} unpaired edges, {repeated} edges used repeatedly in one direction"
        )
        if not entry.get("closed"):
            all_closed = False
            if must_close:
                faults.append(f"{name}: the report does not call it closed")
            continue
        if not (mesh.is_watertight and mesh.is_winding_consistent) or lonely or repeated:
            faults.append(f"{name}: the report says closed, but {lonely} edges are unpaired and {repeated} repeated")
        if mesh.volume <= 0:
            faults.append(f"{name}: volume {mesh.volume:.6g} m³ is not positive")
        said = entry.get("volume_m3")
        if said is None or abs(mesh.volume - said) > VOLUME_OF_PIECE * abs(said):
            faults.append(f"{name}: volume {mesh.volume:.9g} m³, in the report {said}")
        volume += mesh.volume
        solid = as_manifold(mesh)
        if solid.status() != manifold3d.Error.NoError:
            faults.append(f"{name}: Manifold refuses it: {solid.status()}")
        else:
            solids.append((name, mesh.bounds, solid))
    whole = (report.get("input") or {}).get("volume_m3")
    if whole and all_closed and told:
        print(f"together {volume:.9g} m³, input {whole:.9g} m³")
        if abs(volume - whole) > VOLUMES_TOGETHER * whole:
            faults.append(f"the pieces have {volume:.9g} m³ together, the input {whole:.9g} m³")
    elif told and all_closed:
        faults.append("all pieces are closed, but the report has no input.volume_m3")
    faults += overlaps(solids, whole or volume)
    return faults


def overlaps(solids, whole):
    """Faults for every pair of solids that share more than a trace of the whole volume."""
    faults = []
    for (a, (a_low, a_high), first), (b, (b_low, b_high), second) in itertools.combinations(solids, 2):
        if (a_low < b_high).all() and (b_low < a_high).all():
            shared = abs((first ^ second).volume())
            print(f"{a} and {b} share {shared:.3g} m³")
            if not shared < OVERLAP * whole:
                faults.append(f"{a} and {b} overlap by {shared:.6g} m³, {shared / whole:.2g} of the whole")
    return faults


if __name__ == "__main__":
    arguments = [a for a in sys.argv[1:] if a != "--closed"]
    if len(arguments) != 2:
        sys.exit(__doc__)
    with open(arguments[1], encoding="utf-8") as file:
        found = judge(arguments[0], read_report(file.read()), "--closed" in sys.argv)
    for fault in found:
        print(f"FAULT {fault}")
    sys.exit(bool(found))
