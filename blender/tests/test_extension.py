"""The extension in a Blender without a window: what an artist breaks, and what must not change anything."""

import math
import time

import bpy
import greenstick
import pytest
from greenstick_wood import exchange, operators
from greenstick_wood.job import Job
from greenstick_wood.settings import DECLARED
from mathutils import Matrix, Vector, kdtree


def branch(folder):
    """The branch that comes with the library, as Blender imports it."""
    file = folder / "branch.glb"
    greenstick.built_in_branch().write(file)
    bpy.ops.import_scene.gltf(filepath=str(file))
    item = next(o for o in bpy.data.objects if o.type == "MESH")
    choose(item)
    return item


def choose(item):
    for other in bpy.context.selected_objects:
        other.select_set(False)
    item.select_set(True)
    bpy.context.view_layer.objects.active = item


def pieces(item):
    return [o for o in bpy.data.objects if o.get("greenstick_source") == item.name]


def strands(piece):
    return [o for o in piece.children if "greenstick_strands" in o]


def box(items):
    corners = [o.matrix_world @ v.co for o in items for v in o.data.vertices]
    return [(min(c[k] for c in corners), max(c[k] for c in corners)) for k in range(3)]


def assert_same_box(ours, theirs, within):
    for (a, b), (c, d) in zip(ours, theirs, strict=True):
        assert abs(a - c) < within and abs(b - d) < within, (ours, theirs)


def quick(scene):
    scene.greenstick.texture_size = 64


def test_the_built_in_branch_breaks_into_pieces_with_bark_and_inner_wood(scene, tmp_path):
    item = branch(tmp_path)
    quick(scene)
    whole = box([item])
    assert bpy.ops.greenstick.break_wood() == {"FINISHED"}
    made = pieces(item)
    assert sorted(o.name for o in made) == [f"{item.name} lower", f"{item.name} upper"]
    assert item.hide_get() and item.hide_render
    assert_same_box(box(made), whole, 1e-4)
    for piece in made:
        for name in ("bark", "inner_wood"):
            material = next(s.material for s in piece.material_slots if s.material.name.startswith(name))
            assert any(n.type == "TEX_IMAGE" for n in material.node_tree.nodes)
        assert piece.data.uv_layers
        # The origin is in the middle of the piece.
        middle = sum((Vector(c) for c in piece.bound_box), Vector()) / 8
        assert middle.length < 1e-4
    # Once more replaces them, strands too.
    before = len(bpy.data.objects)
    scene.greenstick.break__seed = 5
    choose(made[0])
    assert bpy.ops.greenstick.break_wood() == {"FINISHED"}
    assert len(pieces(item)) == 2
    assert len(bpy.data.objects) == before


def test_strands_stand_on_their_piece_and_follow_it(scene, tmp_path):
    item = branch(tmp_path)
    quick(scene)
    assert bpy.ops.greenstick.break_wood() == {"FINISHED"}
    for piece in pieces(item):
        (grown,) = strands(piece)
        # What they grow on is the broken face, not the far end of the piece.
        wood = {
            v
            for p in piece.data.polygons
            if piece.material_slots[p.material_index].material.name.startswith("inner_wood")
            for v in p.vertices
        }
        tree = kdtree.KDTree(len(wood))
        for number, vertex in enumerate(wood):
            tree.insert(piece.matrix_world @ piece.data.vertices[vertex].co, number)
        tree.balance()
        assert max(tree.find(grown.matrix_world @ v.co)[2] for v in grown.data.vertices) < 0.02
        place = grown.matrix_world.translation.copy()
        piece.location.x += 1.0
        bpy.context.view_layer.update()
        assert (grown.matrix_world.translation - place - Vector((1.0, 0.0, 0.0))).length < 1e-6


def test_volumes_of_the_pieces_are_that_of_the_branch(scene, tmp_path):
    item = branch(tmp_path)
    quick(scene)
    whole = operators.volume(item)
    bpy.ops.greenstick.break_wood()
    assert math.isclose(sum(map(operators.volume, pieces(item))), whole, rel_tol=1e-4)


def test_a_textured_tree_keeps_its_material(scene, data):
    bpy.ops.import_scene.gltf(filepath=str(data / "quaternius_DeadTree_1.gltf"))
    item = next(o for o in bpy.data.objects if o.type == "MESH")
    choose(item)
    quick(scene)
    own = {s.material for s in item.material_slots}
    scene.greenstick.fraction = 0.1
    assert bpy.ops.greenstick.break_wood() == {"FINISHED"}
    for piece in pieces(item):
        assert own & {s.material for s in piece.material_slots}
        assert not any(s.material.name.startswith(next(iter(own)).name + ".") for s in piece.material_slots)


def test_a_scaled_and_turned_object_breaks_where_the_cursor_is(scene, tmp_path):
    item = branch(tmp_path)
    quick(scene)
    item.matrix_world = (
        Matrix.Translation((3.0, -2.0, 1.0))
        @ Matrix.Rotation(1.1, 4, Vector((1.0, 2.0, 0.5)).normalized())
        @ Matrix.Diagonal((-2.0, 2.0, 2.0, 1.0))
        @ item.matrix_world
    )
    bpy.context.view_layer.update()
    whole = box([item])
    ends = sorted((item.matrix_world @ v.co for v in item.data.vertices), key=lambda p: p.z)
    at = ends[0].lerp(ends[-1], 0.35)
    scene.cursor.location = at
    scene.greenstick.place = "CURSOR"
    assert bpy.ops.greenstick.break_wood() == {"FINISHED"}
    made = pieces(item)
    assert len(made) == 2
    assert_same_box(box(made), whole, 1e-3)
    near = min((o.matrix_world @ v.co - at).length for o in made for v in o.data.vertices)
    wood = [
        o.matrix_world @ o.data.vertices[v].co
        for o in made
        for p in o.data.polygons
        if o.material_slots[p.material_index].material.name.startswith("inner_wood")
        for v in p.vertices
    ]
    middle = sum(wood, Vector()) / len(wood)
    assert (middle - at).length < 0.2, (middle, at, near)


def test_modifiers_and_the_unit_of_the_scene_count(scene, tmp_path):
    item = branch(tmp_path)
    quick(scene)
    scene.unit_settings.system = "METRIC"
    scene.unit_settings.scale_length = 0.01
    item.scale = (100.0, 100.0, 100.0)
    bend = item.modifiers.new("twice", "ARRAY")
    bend.count = 1
    stretch = item.modifiers.new("longer", "CAST")
    stretch.factor = 0.0
    bpy.context.view_layer.update()
    whole = box([item])
    request = scene.greenstick.request([0.5])
    job = Job(greenstick.Session(exchange.scene_of(bpy.context, item)))
    job.run(request)
    assert job.state == "done", job.message
    # 60 units of a centimetre are 0.6 m.
    assert math.isclose(job.result.report["place"]["stem_length_m"], 0.6, rel_tol=0.02)
    exchange.bring_in(bpy.context, item, job.result)
    assert_same_box(box(pieces(item)), whole, 0.05)


def test_empties_break_one_stem_in_several_places(scene, tmp_path):
    item = branch(tmp_path)
    quick(scene)
    ends = sorted((item.matrix_world @ v.co for v in item.data.vertices), key=lambda p: p.z)
    for fraction in (0.3, 0.7):
        empty = bpy.data.objects.new("here", None)
        scene.collection.objects.link(empty)
        empty.location = ends[0].lerp(ends[-1], fraction)
        empty.select_set(True)
    bpy.context.view_layer.update()
    scene.greenstick.place = "EMPTIES"
    assert bpy.ops.greenstick.break_wood() == {"FINISHED"}
    assert len(pieces(item)) == 3


@pytest.mark.parametrize("kind", ["open", "empty", "light"])
def test_what_cannot_be_broken_is_told_and_nothing_changes(scene, kind):
    if kind == "open":
        bpy.ops.mesh.primitive_plane_add()
    elif kind == "empty":
        bpy.ops.object.add(type="MESH")
    else:
        bpy.ops.object.light_add()
    item = bpy.context.active_object
    before = (len(bpy.data.objects), len(bpy.data.meshes), len(bpy.data.materials), len(bpy.data.collections))
    with pytest.raises(RuntimeError) as caught:
        bpy.ops.greenstick.break_wood()
    assert len(str(caught.value)) > 20
    after = (len(bpy.data.objects), len(bpy.data.meshes), len(bpy.data.materials), len(bpy.data.collections))
    assert after == before
    assert not item.hide_get()


def test_a_preset_shows_its_values_and_only_changes_are_asked_for(scene):
    settings = scene.greenstick
    assert settings.request([0.5]).changed() == greenstick.Request(at="0.5").changed()
    settings.preset = "brash"
    assert settings.request([0.5]).changed() == greenstick.Request("brash", at="0.5").changed()
    assert math.isclose(settings.break__inclination, 6.0)
    settings.break__inclination = 12.0
    assert settings.request([0.5])["break.inclination"] == 12.0
    assert {"break.seed", "species", "break.high.height", "moisture"} <= DECLARED.keys()


def test_a_job_reports_stops_and_starts_again():
    job = Job(greenstick.Session())
    assert job.state == "idle"
    job.start(greenstick.Request(texture_size=4096))
    assert job.state == "running"
    job.cancel()
    start = time.monotonic()
    job.wait()
    assert job.state == "cancelled" and time.monotonic() - start < 5
    job.run(greenstick.Request(texture_size=64))
    assert job.state == "done" and len(job.result.report["pieces"]) == 2
    job.run(greenstick.Request(texture_size=64, at="9 m"))
    assert job.state == "failed" and "is off the stem" in job.message


def test_rigid_bodies_have_hulls_and_the_mass_of_wood(scene, tmp_path):
    item = branch(tmp_path)
    quick(scene)
    bpy.ops.greenstick.break_wood()
    for piece in pieces(item):
        piece.select_set(True)
    scene.greenstick.density = 700.0
    assert bpy.ops.greenstick.rigid_bodies() == {"FINISHED"}
    masses = [p.rigid_body.mass for p in pieces(item)]
    assert math.isclose(sum(masses), 700.0 * operators.volume(item), rel_tol=1e-3)
    assert all(p.rigid_body.collision_shape == "CONVEX_HULL" for p in pieces(item))


def test_a_click_puts_the_cursor_on_the_wood(scene, tmp_path):
    item = branch(tmp_path)
    at = item.data.vertices[len(item.data.vertices) // 2]
    out = item.matrix_world.to_3x3() @ at.normal
    wood = item.matrix_world @ at.co
    heard = []

    class Clicked:
        """The operator's own part of a click, without a window."""

        place = operators.GREENSTICK_OT_place.place

        def report(self, kind, text):
            heard.append(text)

    assert Clicked().place(bpy.context, wood + out, -out) == {"FINISHED"}
    assert (scene.cursor.location - wood).length < 1e-3 and scene.greenstick.place == "CURSOR"
    assert Clicked().place(bpy.context, wood + out, out) == {"CANCELLED"}
    assert heard == ["nothing is there"]
