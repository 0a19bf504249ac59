"""Tests of validate_solids.py on files that are sound or have one known fault."""

import base64
import contextlib
import io
import json
import os
import tempfile

import numpy as np
import trimesh

from validate_solids import judge, read_report


def halves(gap=0.0):
    """A cylinder's two halves, the upper one moved up by `gap`."""
    lower = trimesh.creation.cylinder(0.02, 0.5, sections=40)
    upper = lower.copy()
    lower.apply_translation([0, 0, -0.25])
    upper.apply_translation([0, 0, 0.25 + gap])
    return lower, upper


def with_seams(mesh):
    """The mesh with three vertices of its own for every triangle, as flat shading has it."""
    return trimesh.Trimesh(mesh.vertices[mesh.faces].reshape(-1, 3), np.arange(3 * len(mesh.faces)).reshape(-1, 3), process=False)


def faults_of(meshes, whole=None, closed=True, names=("lower", "upper")):
    """What is found in a file of these meshes and a report made from their undisturbed forms."""
    lower, upper = halves()
    scene = trimesh.Scene()
    for name, mesh in zip(names, meshes):
        scene.add_geometry(with_seams(mesh), node_name=name, geom_name=name, transform=np.eye(4))
    pieces = [{"name": n, "volume_m3": m.volume, "closed": closed} for n, m in zip(("lower", "upper"), (lower, upper))]
    report = {"input": {"volume_m3": whole or lower.volume + upper.volume}, "pieces": pieces}
    with tempfile.TemporaryDirectory() as folder, contextlib.redirect_stdout(io.StringIO()):
        path = os.path.join(folder, "broken.glb")
        scene.export(path)
        return judge(path, report)


def in_two_materials(path):
    """Writes a cube as one mesh of two primitives with a material each, on two nodes, the second one placed, which
    carries two more of one name."""
    cube = trimesh.creation.box((1, 1, 1))
    corners = cube.vertices[cube.faces].reshape(-1, 3).astype("<f4")
    views, accessors, primitives = [], [], []
    for k, (start, end) in enumerate([(0, 15), (15, 36)]):
        views.append({"buffer": 0, "byteOffset": 12 * start, "byteLength": 12 * (end - start)})
        accessors.append({"bufferView": k, "componentType": 5126, "count": end - start, "type": "VEC3"})
        primitives.append({"attributes": {"POSITION": k}, "material": k})
    nodes = [{"name": "lower", "mesh": 0}, {"name": "upper", "mesh": 0, "translation": [0, 1.5, 0], "scale": [1, 2, 1], "children": [2, 3]}]
    nodes += [{"name": "upper_twig", "mesh": 1, "translation": [x, 0, 0]} for x in (2, 4)]
    data = base64.b64encode(corners.tobytes()).decode()
    document = {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 1]}], "nodes": nodes,
        "meshes": [{"name": "cube", "primitives": primitives}, {"name": "twig", "primitives": primitives[:1]}], "materials": [{"name": "bark"}, {"name": "wood"}],
        "accessors": accessors, "bufferViews": views,
        "buffers": [{"uri": "data:application/octet-stream;base64," + data, "byteLength": corners.nbytes}],
    }
    with open(path, "w", encoding="utf-8") as file:
        json.dump(document, file)


def only(faults, text):
    assert faults and all(text in f for f in faults), f"expected only {text!r}, found {faults}"


lower, upper = halves()
assert faults_of((lower, upper)) == [], faults_of((lower, upper))
assert faults_of((lower, upper), names=("a", "b")) == []
only(faults_of((lower, halves(-1e-4)[1])), "overlap by")
only(faults_of((lower, upper), whole=1.01 * (lower.volume + upper.volume)), "together")
opened = upper.copy()
opened.update_faces(np.arange(len(opened.faces)) != 7)
assert any("3 edges are unpaired" in f for f in faults_of((lower, opened)))
assert any("Manifold refuses" in f for f in faults_of((lower, opened)))
assert faults_of((lower, opened), closed=False) == []
turned = upper.copy()
turned.faces[7] = turned.faces[7][::-1]
assert any("upper: the report says closed" in f for f in faults_of((lower, turned)))
inverted = upper.copy()
inverted.invert()
assert any("is not positive" in f for f in faults_of((lower, inverted)))
with tempfile.TemporaryDirectory() as folder, contextlib.redirect_stdout(io.StringIO()):
    path = os.path.join(folder, "cubes.gltf")
    in_two_materials(path)
    pieces = [{"name": "upper", "volume_m3": 2.0, "closed": True}, {"name": "lower", "volume_m3": 1.0, "closed": True}]
    assert judge(path, {"input": {"volume_m3": 3.0}, "pieces": pieces}) == []
    pieces[0]["closed"] = False
    only(judge(path, {"input": {"volume_m3": 3.0}, "pieces": pieces}, must_close=True), "does not call it closed")
assert read_report('breaking ...\n{"pieces": []}\n') == {"pieces": []}
print("validate_solids.py finds each fault and no other")
