"""Meshes from Blender to Greenstick and back, by glTF: Blender's own exporter and importer keep materials, texture
coordinates, modifiers and axes."""

import json
import math
import struct
import tempfile
from pathlib import Path
from typing import Any

import bpy
import greenstick
from mathutils import Matrix, Vector

# The first words of a GLB, and the type of its first chunk.
_MAGIC, _VERSION, _JSON = 0x46546C67, 2, 0x4E4F534A


class ExchangeError(Exception):
    """An object that cannot be broken, with what would be right."""


def unit_scale(context: bpy.types.Context) -> float:
    """Metres in a unit of the scene."""
    settings = context.scene.unit_settings
    return settings.scale_length if settings.system != "NONE" else 1.0


def to_library(point: Vector, scale: float) -> tuple[float, float, float]:
    """A point of Blender (z up) in the coordinates of glTF (y up), m."""
    return (point.x * scale, point.z * scale, -point.y * scale)


def scene_of(context: bpy.types.Context, item: bpy.types.Object) -> greenstick.Scene:
    """The object as Greenstick reads it: with its modifiers, in the world, in metres."""
    if item.type != "MESH":
        raise ExchangeError(f'"{item.name}" is a {item.type.lower()}; select a mesh, or convert it to one')
    evaluated = item.evaluated_get(context.evaluated_depsgraph_get())
    if not evaluated.data.polygons:
        raise ExchangeError(f'"{item.name}" has no faces')
    if abs(item.matrix_world.determinant()) < 1e-12:
        raise ExchangeError(f'"{item.name}" is scaled to nothing along an axis; apply another scale')
    with tempfile.TemporaryDirectory(prefix="greenstick-") as folder:
        file = Path(folder) / "object.glb"
        with _alone(context, item):
            bpy.ops.export_scene.gltf(
                filepath=str(file),
                export_format="GLB",
                use_selection=True,
                export_apply=True,
                export_animations=False,
                export_skins=False,
                export_morph=False,
                # Materials come back by their names: their images need not go out.
                export_image_format="NONE",
            )
        _scale(file, unit_scale(context))
        return greenstick.Scene.read(file)


class _alone:
    """Selects one object, without its children, and afterwards what was selected before."""

    def __init__(self, context: bpy.types.Context, item: bpy.types.Object) -> None:
        self.context, self.item = context, item

    def __enter__(self) -> None:
        self.selected = list(self.context.selected_objects)
        self.active = self.context.view_layer.objects.active
        for other in self.selected:
            other.select_set(False)
        self.hidden = self.item.hide_get()
        self.item.hide_set(False)
        self.item.select_set(True)
        self.context.view_layer.objects.active = self.item

    def __exit__(self, *_: object) -> None:
        self.item.select_set(False)
        self.item.hide_set(self.hidden)
        for other in self.selected:
            other.select_set(True)
        self.context.view_layer.objects.active = self.active


def _scale(file: Path, scale: float) -> None:
    """Scales the scene of a GLB."""
    if math.isclose(scale, 1.0):
        return
    content = file.read_bytes()
    length = struct.unpack_from("<I", content, 12)[0]
    document: dict[str, Any] = json.loads(content[20 : 20 + length])
    for scene in document["scenes"]:
        document["nodes"].append({"children": scene["nodes"], "scale": [scale] * 3})
        scene["nodes"] = [len(document["nodes"]) - 1]
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    rest = content[20 + length :]
    head = struct.pack("<5I", _MAGIC, _VERSION, 20 + len(text) + len(rest), len(text), _JSON)
    file.write_bytes(head + text + rest)


def bring_in(context: bpy.types.Context, item: bpy.types.Object, broken: greenstick.Broken) -> bpy.types.Collection:
    """Makes objects of the pieces in a collection of their own, with the materials of the object that was broken, and hides
    that object. Strands of torn fibre are children of their pieces. Pieces of the same object that are there already are
    replaced."""
    before = set(bpy.data.objects)
    known = {material.name: material for material in bpy.data.materials}
    with tempfile.TemporaryDirectory(prefix="greenstick-") as folder:
        for name, content in broken.encode("pieces.glb").items():
            (Path(folder) / Path(name).name).write_bytes(content)
        bpy.ops.import_scene.gltf(filepath=str(Path(folder) / "pieces.glb"))
    pieces = [made for made in bpy.data.objects if made not in before]
    strands = {made: made.parent for made in pieces if _is_strands(made)}
    # Objects that were just made have no place in the world before. The importer turns metres into units of the scene; the
    # exporter does not turn them into metres.
    context.view_layer.update()
    worlds = {made: made.matrix_world.copy() for made in pieces}
    collection = _emptied(context, item)
    for made in pieces:
        for home in list(made.users_collection):
            home.objects.unlink(made)
    for made in [p for p in pieces if p.type != "MESH"]:
        pieces.remove(made)
        bpy.data.objects.remove(made)
    for made in pieces:
        made.parent = None
        made.matrix_world = worlds[made]
        _centre(made)
        _own_materials(made, item, known)
        made.name = f"{item.name} {made.name.split('.')[0]}"
        made["greenstick_strands" if made in strands else "greenstick_source"] = item.name
        collection.objects.link(made)
    # Strands go where their piece goes.
    context.view_layer.update()
    for made, piece in strands.items():
        made.parent = piece
        made.matrix_parent_inverse = piece.matrix_world.inverted()
    item.hide_set(True)
    item.hide_render = True
    return collection


def _is_strands(made: bpy.types.Object) -> bool:
    """Whether an object only adds strands of torn fibre to the piece that is its parent."""
    return made.parent is not None and made.name.split(".")[0].endswith("_fuzz")


def _emptied(context: bpy.types.Context, item: bpy.types.Object) -> bpy.types.Collection:
    name = f"{item.name} broken"
    collection = bpy.data.collections.get(name)
    if collection is None:
        collection = bpy.data.collections.new(name)
        context.scene.collection.children.link(collection)
    for old in list(collection.objects):
        if item.name in (old.get("greenstick_source"), old.get("greenstick_strands")):
            mesh = old.data
            bpy.data.objects.remove(old)
            if mesh.users == 0:
                bpy.data.meshes.remove(mesh)
    return collection


def _centre(made: bpy.types.Object) -> None:
    """Moves the origin of an object to the middle of its box."""
    corners = [Vector(corner) for corner in made.bound_box]
    middle = sum(corners, Vector()) / len(corners)
    made.data.transform(Matrix.Translation(-middle))
    made.matrix_world = made.matrix_world @ Matrix.Translation(middle)


def _own_materials(
    made: bpy.types.Object, item: bpy.types.Object, known: dict[str, bpy.types.Material]
) -> None:
    """Gives a piece the materials of the object that was broken where it has one of the same name."""
    own = {slot.material.name for slot in item.material_slots if slot.material}
    for slot in made.material_slots:
        if slot.material is None:
            continue
        # The importer numbers names that are taken.
        name = slot.material.name
        stem = name.rsplit(".", 1)[0] if name not in own and name not in known else name
        if stem in own and slot.material != known[stem]:
            copy = slot.material
            slot.material = known[stem]
            if copy.users == 0:
                bpy.data.materials.remove(copy)
