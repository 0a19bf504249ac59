"""*Simulate* in a Blender without a window: the film stands where the object stood and moves; what fails changes nothing."""

import time
from types import SimpleNamespace

import bpy
import pytest
from greenstick_wood import exchange, operators
from greenstick_wood.job import Simulation
from greenstick_wood.settings import SCENES
from mathutils import Matrix

# A film of a few frames of a coarse stick.
QUICK = "duration = 0.02; frames_per_second = 200; rods.number = 12"


@pytest.fixture
def stick(scene, tmp_path):
    """A stick of half a metre that stands away from the origin, askew, with a material."""
    bpy.ops.mesh.primitive_cylinder_add(vertices=16, radius=0.01, depth=0.5, location=(1.0, 2.0, 0.5), rotation=(0.3, 1.2, 0.1))
    item = bpy.context.active_object
    item.name = "Stick of ash"
    item.data.materials.append(bpy.data.materials.new("Bark of ash"))
    scene.greenstick.texture_size = 64
    scene.greenstick.simulation_keys = QUICK
    scene.greenstick.simulation_cache = str(tmp_path / "cache")
    bpy.context.view_layer.update()
    return item


def choose(item):
    for other in bpy.context.selected_objects:
        other.select_set(False)
    item.select_set(True)
    bpy.context.view_layer.objects.active = item


def film(item):
    return [o for o in bpy.data.objects if o.get("greenstick_simulated") == item.name and o.type == "MESH"]


def points(items):
    graph = bpy.context.evaluated_depsgraph_get()
    found = []
    for item in items:
        shown = item.evaluated_get(graph)
        found += [shown.matrix_world @ v.co for v in shown.data.vertices]
    return found


def box(found):
    return [(min(p[k] for p in found), max(p[k] for p in found)) for k in range(3)]


def amounts():
    kinds = ("objects", "meshes", "materials", "images", "collections", "cache_files", "worlds")
    return {kind: len(getattr(bpy.data, kind)) for kind in kinds}


def test_the_film_begins_where_the_object_stood_and_moves(scene, stick, tmp_path):
    whole = box(points([stick]))
    assert bpy.ops.greenstick.simulate() == {"FINISHED"}
    (file,) = (tmp_path / "cache").glob("*.usdc")
    assert file.name == "Stick_of_ash_bend.usdc"
    assert stick.hide_get() and stick.hide_render
    assert {c.name for o in film(stick) for c in o.users_collection} == {"Stick of ash simulated"}
    assert scene.frame_start == 0 and 3 <= scene.frame_end <= 10
    scene.frame_set(scene.frame_start)
    first = points(film(stick))
    for (a, b), (c, d) in zip(box(first), whole, strict=True):
        assert abs(a - c) < 2e-3 and abs(b - d) < 2e-3, (box(first), whole)
    scene.frame_set(scene.frame_end)
    last = points(film(stick))
    assert max((a - b).length for a, b in zip(first, last, strict=True)) > 1e-4
    used = {s.material for o in film(stick) for s in o.material_slots}
    assert bpy.data.materials["Bark of ash"] in used
    assert not any(m.name.startswith("Bark_of_ash") for m in bpy.data.materials)
    # Once more, with the film selected, replaces it.
    before = amounts()
    choose(film(stick)[0])
    assert bpy.ops.greenstick.simulate() == {"FINISHED"}
    assert amounts() == before


def test_units_of_the_scene_count(scene, stick):
    scene.unit_settings.scale_length = 0.01
    stick.scale = (100.0, 100.0, 100.0)
    bpy.context.view_layer.update()
    whole = box(points([stick]))
    assert bpy.ops.greenstick.simulate() == {"FINISHED"}
    scene.frame_set(scene.frame_start)
    for (a, b), (c, d) in zip(box(points(film(stick))), whole, strict=True):
        assert abs(a - c) < 0.2 and abs(b - d) < 0.2


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"simulation_keys": "duration"}, "has no value"),
        ({"simulation_keys": "durration = 1"}, "durration"),
        ({"simulation_keys": "duration = -1"}, "duration"),
        ({"simulation_cache": "//films"}, "was not saved yet"),
        ({"simulation_cache": "/dev/null/films"}, "cannot be made"),
        ({"species": "Unobtainium"}, "Unobtainium"),
    ],
)
def test_what_is_wrong_is_told_and_nothing_changes(scene, stick, change, text):
    for name, value in change.items():
        setattr(scene.greenstick, name, value)
    before = amounts()
    with pytest.raises(RuntimeError, match=text):
        bpy.ops.greenstick.simulate()
    assert amounts() == before and not stick.hide_get()


def test_what_has_no_stem_is_told_and_leaves_no_file(scene, stick, tmp_path):
    bpy.ops.mesh.primitive_plane_add()
    plane = bpy.context.active_object
    before = amounts()
    with pytest.raises(RuntimeError):
        bpy.ops.greenstick.simulate()
    assert amounts() == before and not plane.hide_get()
    assert not list((tmp_path / "cache").glob("*.usdc"))


class Driven:
    """The operator's own part of a modal run, without a window."""

    bl_idname = operators.GREENSTICK_OT_simulate.bl_idname
    prepare = operators.GREENSTICK_OT_simulate.prepare
    finish = operators.GREENSTICK_OT_simulate.finish
    modal = operators.GREENSTICK_OT_simulate.modal
    timer = None

    def __init__(self):
        self.heard = []

    def report(self, kind, text):
        self.heard.append((kind, text))


def window(scene):
    """A context with a status line that is kept, and timers that are none."""
    said = []
    real = bpy.context
    return said, SimpleNamespace(
        scene=scene,
        active_object=real.active_object,
        selected_objects=real.selected_objects,
        view_layer=real.view_layer,
        evaluated_depsgraph_get=real.evaluated_depsgraph_get,
        workspace=SimpleNamespace(status_text_set=said.append),
        window_manager=SimpleNamespace(event_timer_remove=lambda timer: None),
    )


def test_esc_stops_it_and_nothing_changes(scene, stick, tmp_path):
    scene.greenstick.simulation_keys = "duration = 1000; rods.number = 60"
    before = amounts()
    run, (said, context) = Driven(), window(scene)
    run.prepare(context)
    deadline = time.monotonic() + 60
    while not said or "0 %" in said[-1] and time.monotonic() < deadline and len(said) < 20:
        assert run.modal(context, SimpleNamespace(type="TIMER")) == {"PASS_THROUGH"}
        time.sleep(0.05)
    assert run.modal(context, SimpleNamespace(type="MOUSEMOVE")) == {"PASS_THROUGH"}
    start = time.monotonic()
    assert run.modal(context, SimpleNamespace(type="ESC")) == {"CANCELLED"}
    assert time.monotonic() - start < 5
    assert said[-1] is None and run.heard == [({"INFO"}, "stopped; nothing was changed")]
    assert amounts() == before and not stick.hide_get()
    assert not list((tmp_path / "cache").iterdir())


def test_a_modal_run_ends_with_the_film(scene, stick):
    run, (said, context) = Driven(), window(scene)
    run.prepare(context)
    deadline = time.monotonic() + 120
    ended = {"PASS_THROUGH"}
    while ended == {"PASS_THROUGH"} and time.monotonic() < deadline:
        ended = run.modal(context, SimpleNamespace(type="TIMER"))
        time.sleep(0.02)
    assert ended == {"FINISHED"} and film(stick) and said[-1] is None
    assert run.heard[-1][0] == {"INFO"}


def test_a_film_that_cannot_be_read_changes_nothing(scene, stick, tmp_path):
    from greenstick_wood.simulating import bring_in_film

    (tmp_path / "none.usdc").write_bytes(b"nothing")
    before = amounts()
    with pytest.raises(exchange.ExchangeError, match="cannot be imported"):
        bring_in_film(bpy.context, stick, tmp_path / "none.usdc", Matrix.Identity(4))
    assert amounts() == before and not stick.hide_get()


def test_all_scenes_of_the_library_are_there():
    assert {"bend", "snow", "knee"} <= {name for name, _, _ in SCENES}
    assert all(about for _, _, about in SCENES)


def test_a_simulation_that_fails_says_why(stick, tmp_path):
    work = Simulation("bend", exchange.scene_of(bpy.context, stick), {"duration": "long"}, 64)
    work.start(tmp_path / "film.usdc")
    work.wait()
    assert work.state == "failed" and "duration" in work.message
