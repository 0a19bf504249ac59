"""Judges files that move, by readers that are not ours:

- a .glb by the Khronos validator (neither errors nor warnings) and by playing it: it has an animation, something moves,
  every place is finite;
- a .usda, .usdc or .usdz by all validators that OpenUSD has registered, and by playing it; a still has no samples;
- a .pvd by VTK's readers, which read every file at every time.

A picture that INPUT names but does not have beside it is handed on as a name; its absence is no fault of the file.
With --closed every mesh of a GLB has to be closed in the first, the middle and the last frame. Of several films the
places of all triangles are compared, so that a GLB and a USD of one film have to show the same.

Usage: python validate_film.py [--node-modules FOLDER] [--still] [--closed] [--within METRES] [--from INPUT]
           FILE...
"""

import argparse
import json
import re
import struct
import subprocess
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np

NUMBERS = {5121: "<u1", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}


class Fault(Exception):
    """What is wrong with a file."""


def require(holds, says):
    if not holds:
        raise Fault(says)


def turn_matrix(x, y, z, w):
    """The matrix of a unit quaternion."""
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


class Glb:
    """A GLB that is played by the formulas of the specification."""

    def __init__(self, path):
        data = path.read_bytes()
        (length,) = struct.unpack_from("<I", data, 12)
        self.json = json.loads(data[20 : 20 + length])
        self.binary = data[28 + length :]
        animations = self.json.get("animations", [])
        require(len(animations) == 1, f"{len(animations)} animations; one is expected")
        self.tracks = []
        times = []
        for channel in animations[0]["channels"]:
            sampler = animations[0]["samplers"][channel["sampler"]]
            keys = self.numbers(sampler["input"])[:, 0]
            require((np.diff(keys) > 0).all(), "times do not ascend")
            target = channel["target"]
            self.tracks.append((target["node"], target["path"], keys, self.numbers(sampler["output"])))
            times.append(keys)
        self.times = max(times, key=len)

    def numbers(self, index):
        accessor = self.json["accessors"][index]
        view = self.json["bufferViews"][accessor["bufferView"]]
        start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
        width = WIDTHS[accessor["type"]]
        count = accessor["count"]
        kind = np.dtype(NUMBERS[accessor["componentType"]])
        return np.frombuffer(self.binary, kind, count * width, start).reshape(count, width)

    def world(self, frame):
        parts = []
        for node in self.json["nodes"]:
            parts.append({k: np.array(node[k], float) for k in ("translation", "rotation", "scale", "matrix") if k in node})
        for node, path, keys, values in self.tracks:
            # Keys are frames; between them nothing is asked for.
            parts[node][path] = values[min(frame, len(keys) - 1)].astype(float)
        local = []
        for part in parts:
            matrix = np.eye(4)
            if "matrix" in part:
                matrix = part["matrix"].reshape(4, 4).T
            else:
                turn = part.get("rotation", np.array([0.0, 0, 0, 1]))
                matrix[:3, :3] = turn_matrix(*turn / np.linalg.norm(turn)) * part.get("scale", np.ones(3))
                matrix[:3, 3] = part.get("translation", 0)
            local.append(matrix)
        world = [None] * len(local)

        def walk(node, above):
            world[node] = above @ local[node]
            for child in self.json["nodes"][node].get("children", []):
                walk(child, world[node])

        for root in self.json["scenes"][0]["nodes"]:
            walk(root, np.eye(4))
        return world

    def play(self, frame):
        """For each node with a mesh: its name, and the corners of the triangles of each material."""
        world = self.world(frame)
        shown = []
        for index, node in enumerate(self.json["nodes"]):
            if "mesh" not in node:
                continue
            maps = None
            if "skin" in node:
                skin = self.json["skins"][node["skin"]]
                inverse = self.numbers(skin["inverseBindMatrices"]).astype(float).reshape(-1, 4, 4).transpose(0, 2, 1)
                maps = np.array([world[j] for j in skin["joints"]]) @ inverse
            parts = []
            for primitive in self.json["meshes"][node["mesh"]]["primitives"]:
                attributes = primitive["attributes"]
                points = self.numbers(attributes["POSITION"]).astype(float)
                points = np.concatenate([points, np.ones((len(points), 1))], 1)
                if maps is None:
                    placed = points @ world[index].T
                else:
                    placed = np.zeros_like(points)
                    number = 0
                    while f"JOINTS_{number}" in attributes:
                        joints = self.numbers(attributes[f"JOINTS_{number}"])
                        weights = self.numbers(attributes[f"WEIGHTS_{number}"]).astype(float)
                        for k in range(4):
                            moved = np.einsum("vij,vj->vi", maps[joints[:, k]], points)
                            placed += weights[:, k : k + 1] * moved
                        number += 1
                corners = self.numbers(primitive["indices"])[:, 0]
                parts.append(placed[corners, :3].reshape(-1, 3, 3))
            shown.append((node.get("name", ""), parts))
        return shown


class Usd:
    """A USD stage that is played by OpenUSD."""

    def __init__(self, path):
        from pxr import Usd as Pxr

        self.stage = Pxr.Stage.Open(str(path))
        first, last = self.stage.GetStartTimeCode(), self.stage.GetEndTimeCode()
        codes = {first, last}
        for prim in self.stage.Traverse():
            for attribute in prim.GetAttributes():
                codes.update(attribute.GetTimeSamples())
        require(min(codes) == first and max(codes) == last, f"samples outside {first} to {last}")
        self.codes = sorted(codes)
        self.times = np.array(self.codes) / self.stage.GetTimeCodesPerSecond()

    def play(self, frame):
        from pxr import UsdGeom, UsdShade

        code = self.codes[frame]
        shown = []
        for prim in self.stage.Traverse():
            if not prim.IsA(UsdGeom.Mesh):
                continue
            mesh = UsdGeom.Mesh(prim)
            points = np.array(mesh.GetPointsAttr().Get(code), float)
            extent = np.array(mesh.GetExtentAttr().Get(code), float)
            require(
                np.array_equal(extent, [points.min(0), points.max(0)]), f"{prim.GetPath()}: wrong extent at {code}"
            )
            counts = np.array(mesh.GetFaceVertexCountsAttr().Get(code))
            require((counts == 3).all(), f"{prim.GetPath()}: faces other than triangles")
            place = np.array(UsdGeom.Xformable(prim).ComputeLocalToWorldTransform(code), float)
            placed = np.concatenate([points, np.ones((len(points), 1))], 1) @ place
            corners = np.array(mesh.GetFaceVertexIndicesAttr().Get(code))
            triangles = placed[corners, :3].reshape(-1, 3, 3)
            material = np.full(len(triangles), -1)
            for number, part in enumerate(UsdShade.MaterialBindingAPI(prim).GetMaterialBindSubsets()):
                material[np.array(part.GetIndicesAttr().Get())] = number
            # In the order in which faces first use them, as in a GLB.
            order = sorted(set(material), key=list(material).index)
            name = prim.GetDisplayName() or prim.GetName()
            shown.append((name, [triangles[material == m] for m in order]))
        return shown


def validate_gltf(path, modules):
    script = Path(__file__).with_name("validate_gltf.mjs")
    done = subprocess.run(["node", script, modules, path], capture_output=True, text=True)
    print(done.stdout.strip())
    require(done.returncode == 0 and " 0 errors, 0 warnings" in done.stdout, f"the validator objects\n{done.stderr}")


def lacking(error, source):
    """Whether an objection is about a picture that the file's source names but does not have either."""
    names = re.findall("['@]([^'@]+)['@]", error.GetMessage())
    if source is None or error.GetName() not in ("UnresolvableDependency", "InvalidFile") or not names:
        return False
    return names[-1].encode() in source.read_bytes() and not (source.parent / names[-1]).exists()


def validate_usd(path, source):
    from pxr import Usd as Pxr
    from pxr import UsdGeom, UsdValidation

    stage = Pxr.Stage.Open(str(path))
    validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    errors = UsdValidation.ValidationContext(validators).Validate(stage)
    errors = [error for error in errors if not lacking(error, source)]
    for error in errors:
        print(f"  {error.GetErrorAsString()}")
    require(not errors, f"{len(errors)} objections of {len(validators)} validators")
    require(stage.GetDefaultPrim(), "no default prim")
    require(UsdGeom.GetStageMetersPerUnit(stage) == 1 and UsdGeom.GetStageUpAxis(stage) == "Y", "units or up axis")
    meshes = [p for p in stage.Traverse() if p.IsA(UsdGeom.Mesh)]
    print(f"{path}: no objections of {len(validators)} validators; {len(meshes)} meshes")
    return any(a.GetNumTimeSamples() for p in meshes for a in p.GetAttributes())


def validate_series(path):
    import vtk

    entries = list(ElementTree.parse(path).getroot().iter("DataSet"))
    require(entries, "no files")
    times = [float(e.get("timestep")) for e in entries]
    require(times == sorted(times) and len(set(times)) > 1, "times do not ascend")
    faults = []
    fields = {}
    for entry in entries:
        file = path.parent / entry.get("file")
        require(file.is_file(), f"{file} is not there")
        reader = vtk.vtkXMLPolyDataReader()
        for event in ("ErrorEvent", "WarningEvent"):
            reader.AddObserver(event, lambda *_: faults.append(file.name))
        reader.SetFileName(str(file))
        reader.Update()
        data = reader.GetOutput()
        require(data.GetNumberOfLines() > 0 and data.GetNumberOfPoints() > 0, f"{file} holds no lines")
        names = []
        for kind in (data.GetPointData(), data.GetCellData()):
            for k in range(kind.GetNumberOfArrays()):
                array = kind.GetArray(k)
                names.append((array.GetName(), array.GetNumberOfComponents()))
                require(np.isfinite(array.GetRange(-1)).all(), f"{file}: {array.GetName()} is not finite")
        part = entry.get("part")
        require(fields.setdefault(part, names) == names, f"{file} has other fields than those before it")
    require(not faults, f"VTK objects to {faults}")
    print(f"{path}: VTK reads {len(entries)} files at {len(set(times))} times; fields {fields}")


def judge_motion(path, film):
    frames = [0, len(film.times) // 2, len(film.times) - 1]
    shown = [film.play(frame) for frame in frames]
    every = [np.concatenate([np.concatenate(parts).reshape(-1, 3) for _, parts in s]) for s in shown]
    require(all(np.isfinite(e).all() for e in every), "places that are not finite")
    farthest = np.linalg.norm(every[0] - every[-1], axis=1).max()
    require(farthest > 0, "nothing moves")
    print(f"{path}: {len(film.times)} frames, {film.times[-1]:.3f} s, the farthest way is {farthest:.4g} m")
    return shown


def judge_closed(shown):
    import trimesh

    for at, frame in zip(("first", "middle", "last"), shown):
        for name, parts in frame:
            corners = np.concatenate(parts).reshape(-1, 3)
            # Corners at the very same place are one point: within a tolerance, those of a twig's finest splinters would be, too.
            points, of_corner = np.unique(corners, axis=0, return_inverse=True)
            mesh = trimesh.Trimesh(points, of_corner.reshape(-1, 3), process=False)
            require(mesh.is_watertight and mesh.is_winding_consistent, f"{name} is open in the {at} frame")


def gape(path):
    """How far cracks of a GLB, whose weights are fixed, gape before they open, m: as far as it may be from other formats
    before its last frame."""
    if path.suffix != ".glb":
        return 0.0
    data = path.read_bytes()
    (length,) = struct.unpack_from("<I", data, 12)
    nodes = json.loads(data[20 : 20 + length])["nodes"]
    return max([node.get("extras", {}).get("gape_m", 0.0) for node in nodes], default=0.0)


def compare(films, within):
    (path, first), *others = films
    for other, second in others:
        require(len(first) == len(second), f"{path} and {other} have different frames")
        open_by = max(gape(path), gape(other))
        last = worst = 0.0
        for number, (one, two) in enumerate(zip(first, second), 1):
            one, two = sorted(one, key=lambda n: n[0]), sorted(two, key=lambda n: n[0])
            require([n for n, _ in one] == [n for n, _ in two], f"{path} and {other} show different meshes")
            for (name, parts), (_, others) in zip(one, two):
                require([p.shape for p in parts] == [p.shape for p in others], f"{name} differs in its triangles")
                far = max([0.0] + [np.linalg.norm(p - q, axis=2).max() for p, q in zip(parts, others)])
                worst = max(worst, far)
                last = max(last, far) if number == len(first) else last
        print(f"{path} and {other} differ by {worst:.3g} m at most, by {last:.3g} m in the last frame")
        require(last <= within, f"more than {within} m in the last frame")
        require(worst <= within + open_by, f"more than {within} m and the {open_by:.3g} m by which cracks gape")


def judge(path, options):
    """What is shown in three frames of a film; None for what is no mesh over time."""
    if path.suffix == ".pvd":
        validate_series(path)
        return None
    if path.suffix == ".glb":
        if options.node_modules:
            validate_gltf(path, options.node_modules)
        film = Glb(path)
    else:
        moving = validate_usd(path, options.source)
        require(moving != options.still, "samples over time in a still" if moving else "no samples over time")
        if options.still:
            return None
        film = Usd(path)
    shown = judge_motion(path, film)
    if options.closed and path.suffix == ".glb":
        judge_closed(shown)
    return shown


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--node-modules")
    parser.add_argument("--still", action="store_true")
    parser.add_argument("--closed", action="store_true")
    parser.add_argument("--within", type=float, default=1e-5)
    parser.add_argument("--from", dest="source", type=Path)
    parser.add_argument("files", nargs="+", type=Path)
    options = parser.parse_args()
    films = []
    for path in options.files:
        try:
            shown = judge(path, options)
            if shown is not None:
                films.append((path, shown))
        except Fault as fault:
            print(f"{path}: {fault}")
            return 1
    try:
        if len(films) > 1:
            compare(films, options.within)
    except Fault as fault:
        print(fault)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
