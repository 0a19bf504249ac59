"""Simulating the selected object: scenes of the library on its mesh, and the film of a run as objects of Blender."""

import json
import re
from pathlib import Path
from typing import Any

import bpy
from mathutils import Matrix

from .exchange import ExchangeError, unit_scale
from .settings import AUTOMATIC, auto_name, property_name

# The mark of objects of a film: the name of the object that was simulated.
MARK = "greenstick_simulated"


def keys_of(settings: bpy.types.PropertyGroup) -> dict[str, Any]:
    """What the panel changes in a scene: wood, seed, and keys written as `key = value; key = value`.

    Raises
    ------
    ExchangeError
        Where a key has no value.
    """
    keys: dict[str, Any] = {"seed": getattr(settings, property_name("break.seed"))}
    if settings.species:
        keys["wood.species"] = settings.species
    if not (auto_name("moisture") in AUTOMATIC and getattr(settings, auto_name("moisture"))):
        keys["wood.moisture"] = settings.moisture
    for part in filter(None, map(str.strip, settings.simulation_keys.split(";"))):
        key, equals, value = part.partition("=")
        if not equals:
            raise ExchangeError(f'"{part}" has no value; write keys of a scene as duration = 0.5; rods.number = 40')
        try:
            keys[key.strip()] = json.loads(value)
        except ValueError:
            keys[key.strip()] = value.strip()
    return keys


def cache_file(settings: bpy.types.PropertyGroup, item: bpy.types.Object) -> Path:
    """Where the film of an object goes.

    Raises
    ------
    ExchangeError
        Where there is no such folder: the cache stands beside a file that was not saved.
    """
    folder = settings.simulation_cache
    if folder.startswith("//") and not bpy.data.filepath:
        raise ExchangeError(
            f"the film goes into {folder} beside the file, which was not saved yet; save it, or choose another folder"
        )
    path = Path(bpy.path.abspath(folder))
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ExchangeError(f"{path} cannot be made: {error.strerror}") from error
    name = re.sub(r"[^\w.-]+", "_", item.name)
    return path / f"{name}_{settings.simulation_scene}.usdc"


def bring_in_film(
    context: bpy.types.Context, item: bpy.types.Object, file: Path, transform: Any
) -> bpy.types.Collection:
    """Imports a film into a collection of its own, where the object that was simulated stands and with its materials, and hides that
    object. An earlier film of the object is replaced. `transform` is the map from the object's world to that of the film, y up,
    in metres.

    Raises
    ------
    ExchangeError
        Where Blender cannot read the film; then nothing is changed.
    """
    before = {kind: set(getattr(bpy.data, kind)) for kind in ("objects", "materials")}
    selected = [one.name for one in context.selected_objects]
    known = {slot.material.name: slot.material for slot in item.material_slots if slot.material}
    try:
        done = bpy.ops.wm.usd_import(
            filepath=str(file),
            import_cameras=False,
            import_lights=False,
            create_world_material=False,
            set_frame_range=True,
            scale=1.0 / unit_scale(context),
        )
        problem = "" if done == {"FINISHED"} else "the importer gave up"
    except RuntimeError as error:
        problem = str(error).strip()
    made = [o for o in bpy.data.objects if o not in before["objects"]]
    if problem or not any(o.type == "MESH" for o in made):
        for one in made:
            bpy.data.objects.remove(one)
        raise ExchangeError(f"{file} cannot be imported: {problem or 'it holds no meshes'}")
    collection = _emptied(context, item)
    back = _to_object(transform, unit_scale(context))
    context.view_layer.update()
    for one in [o for o in made if o.parent is None]:
        one.matrix_world = back @ one.matrix_world
    for one in made:
        for home in list(one.users_collection):
            home.objects.unlink(one)
        one[MARK] = item.name
        collection.objects.link(one)
        if one.type == "MESH":
            _own_materials(one, known)
    _remove_unused(set(bpy.data.materials) - before["materials"])
    for one in context.selected_objects:
        one.select_set(False)
    # Of those that were selected, the objects of an earlier film are gone.
    for one in filter(None, map(bpy.data.objects.get, selected)):
        one.select_set(True)
    context.view_layer.objects.active = item
    item.hide_set(True)
    item.hide_render = True
    return collection


def _to_object(transform: Any, scale: float) -> Matrix:
    """From the world of a film to that of its object, both with z up and in units of the scene."""
    y_up = Matrix(((1, 0, 0, 0), (0, 0, 1, 0), (0, -1, 0, 0), (0, 0, 0, 1)))
    back = y_up.inverted() @ Matrix([list(row) for row in transform]).inverted() @ y_up
    back.translation /= scale
    return back


def _emptied(context: bpy.types.Context, item: bpy.types.Object) -> bpy.types.Collection:
    """The collection of an object's films, without the one before."""
    name = f"{item.name} simulated"
    collection = bpy.data.collections.get(name)
    if collection is None:
        collection = bpy.data.collections.new(name)
        context.scene.collection.children.link(collection)
    films = [o for o in collection.objects if o.get(MARK) == item.name]
    held = {o.data for o in films} | {slot.material for o in films for slot in o.material_slots}
    held |= {m.cache_file for o in films for m in o.modifiers if m.type == "MESH_SEQUENCE_CACHE"}
    bpy.data.batch_remove(films)
    _remove_unused(held)
    return collection


def _remove_unused(held: set[Any]) -> None:
    """Removes what nothing uses any more, and the images of materials among it."""
    held = {one for one in held if one is not None}
    # Meshes hold materials, and these hold images: each kind is only free when the one before is gone.
    materials = {one for one in held if isinstance(one, bpy.types.Material)}
    nodes = [node for one in materials if one.node_tree for node in one.node_tree.nodes]
    images = {node.image for node in nodes if node.type == "TEX_IMAGE" and node.image}
    for kind in (held - materials, materials, images):
        bpy.data.batch_remove([one for one in kind if one.users == 0])


def _plain(name: str) -> str:
    """A name as USD has it, without the number that Blender gives to names that are taken."""
    return re.sub(r"\W", "_", re.sub(r"\.\d{3}$", "", name))


def _own_materials(made: bpy.types.Object, known: dict[str, bpy.types.Material]) -> None:
    """Gives an object the materials of the one that was simulated where it has one of the same name."""
    plain = {_plain(name): material for name, material in known.items()}
    exact = {re.sub(r"\W", "_", name): material for name, material in known.items()}
    for slot in made.material_slots:
        if slot.material is not None:
            name = slot.material.name
            slot.material = exact.get(name) or plain.get(_plain(name)) or slot.material
