"""What can be done: break the selected object, at once or live while sliders move, simulate it, and prepare pieces for physics."""

import bpy
import greenstick
from bpy_extras import view3d_utils
from mathutils import Vector

from .exchange import ExchangeError, bring_in, scene_of, to_library, unit_scale
from .job import Job, Simulation
from .simulating import MARK, bring_in_film, cache_file, keys_of

# Seconds between two looks at a running job.
_PAUSE = 0.05


def places(context: bpy.types.Context) -> list[tuple[float, float, float] | float]:
    """Where the settings ask for breaks.

    Raises
    ------
    ExchangeError
        Where no empty is selected that should say so.
    """
    settings, scale = context.scene.greenstick, unit_scale(context)
    if settings.place == "CURSOR":
        return [to_library(context.scene.cursor.location, scale)]
    if settings.place == "EMPTIES":
        empties = [o for o in context.selected_objects if o.type == "EMPTY"]
        if not empties:
            raise ExchangeError("no empty is selected; select the empties that stand where it shall break, too")
        return [to_library(o.matrix_world.translation, scale) for o in empties]
    return [float(settings.fraction)]


def target(context: bpy.types.Context) -> bpy.types.Object:
    """The object to break: the active mesh, or the one that the active piece came from."""
    item = context.active_object
    for mark in ("greenstick_source", "greenstick_strands"):
        if item is not None and mark in item:
            item = bpy.data.objects.get(item[mark], item)
    if item is None:
        raise ExchangeError("no object is active; click on the one to break")
    return item


def simulated(context: bpy.types.Context) -> bpy.types.Object:
    """The object to simulate: the active mesh, or the one that the active object of a film came from."""
    item = target(context)
    return bpy.data.objects.get(item[MARK], item) if MARK in item else item


class GREENSTICK_OT_break_wood(bpy.types.Operator):
    """Break the active object as the panel says; its pieces appear in a collection of their own"""

    bl_idname = "greenstick.break_wood"
    bl_label = "Break Wood"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return context.mode == "OBJECT" and context.active_object is not None

    def execute(self, context: bpy.types.Context) -> set[str]:
        try:
            item = target(context)
            request = context.scene.greenstick.request(places(context))
            job = Job(greenstick.Session(scene_of(context, item)))
            job.run(request)
            if job.state != "done":
                raise ExchangeError(job.message or job.state)
            collection = bring_in(context, item, job.result)
        except (ExchangeError, greenstick.GreenstickError) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        _tell(self, job.result, collection)
        return {"FINISHED"}


class GREENSTICK_OT_break_live(bpy.types.Operator):
    """Break the active object again whenever the panel changes, until Return; Esc takes it all back"""

    bl_idname = "greenstick.break_live"
    bl_label = "Break Wood Live"
    bl_options = {"REGISTER", "UNDO"}

    poll = GREENSTICK_OT_break_wood.poll

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        try:
            self.item = target(context)
            self.job = Job(greenstick.Session(scene_of(context, self.item)))
        except (ExchangeError, greenstick.GreenstickError) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self.asked = ""
        self.timer = context.window_manager.event_timer_add(_PAUSE, window=context.window)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        if event.type == "ESC":
            self.job.cancel()
            self.job.wait()
            self._end(context)
            return {"CANCELLED"}
        if event.type in {"RET", "NUMPAD_ENTER"}:
            self._end(context)
            return {"FINISHED"}
        if event.type == "TIMER":
            self.step(context)
        return {"PASS_THROUGH"}

    def step(self, context: bpy.types.Context) -> None:
        """Takes what is done, and starts what is asked for."""
        try:
            request = context.scene.greenstick.request(places(context))
        except (ExchangeError, greenstick.GreenstickError) as error:
            context.workspace.status_text_set(str(error))
            return
        wanted = request.hash()
        if self.job.state == "done" and self.job.result is not None:
            result, self.job.result = self.job.result, None
            bring_in(context, self.item, result)
            context.workspace.status_text_set("Return: keep it   Esc: take it back")
        elif self.job.state == "failed":
            context.workspace.status_text_set(self.job.message)
        elif self.job.state == "running":
            context.workspace.status_text_set(f"{self.job.stage} {100 * self.job.fraction:.0f} %   Esc: stop")
        if wanted != self.asked:
            self.asked = wanted
            self.job.start(request)

    def _end(self, context: bpy.types.Context) -> None:
        context.window_manager.event_timer_remove(self.timer)
        context.workspace.status_text_set(None)


class GREENSTICK_OT_simulate(bpy.types.Operator):
    """Simulate the scene of the panel on the active object; its film appears in a collection of its own. Esc stops"""

    bl_idname = "greenstick.simulate"
    bl_label = "Simulate"
    bl_options = {"REGISTER", "UNDO"}

    poll = GREENSTICK_OT_break_wood.poll

    def prepare(self, context: bpy.types.Context) -> None:
        """Starts to simulate."""
        settings = context.scene.greenstick
        self.item = simulated(context)
        self.file = cache_file(settings, self.item)
        mesh, keys = scene_of(context, self.item), keys_of(settings)
        self.work = Simulation(settings.simulation_scene, mesh, keys, settings.texture_size)
        self.work.start(self.file)

    def finish(self, context: bpy.types.Context) -> set[str]:
        """Brings in what was made, or tells why nothing was."""
        if self.work.state == "cancelled":
            self.report({"INFO"}, "stopped; nothing was changed")
            return {"CANCELLED"}
        try:
            if self.work.state != "done":
                raise ExchangeError(self.work.message or self.work.state)
            transform, notes = self.work.result
            collection = bring_in_film(context, self.item, self.file, transform)
        except ExchangeError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        for note in notes:
            self.report({"WARNING"}, note)
        self.report({"INFO"}, f"{collection.name}: {self.file}")
        return {"FINISHED"}

    def execute(self, context: bpy.types.Context) -> set[str]:
        try:
            self.prepare(context)
        except (ExchangeError, greenstick.GreenstickError) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self.work.wait()
        return self.finish(context)

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        try:
            self.prepare(context)
        except (ExchangeError, greenstick.GreenstickError) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self.timer = context.window_manager.event_timer_add(_PAUSE, window=context.window)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        if event.type == "ESC":
            self.work.cancel()
            self.work.wait()
        elif event.type != "TIMER":
            return {"PASS_THROUGH"}
        if self.work.state == "running":
            context.workspace.status_text_set(f"{self.work.stage} {100 * self.work.fraction:.0f} %   Esc: stop")
            return {"PASS_THROUGH"}
        context.window_manager.event_timer_remove(self.timer)
        context.workspace.status_text_set(None)
        return self.finish(context)


class GREENSTICK_OT_place(bpy.types.Operator):
    """Click on the wood: the 3D cursor goes there, and it breaks there"""

    bl_idname = "greenstick.place"
    bl_label = "Place by Click"
    bl_options = {"REGISTER", "UNDO"}

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        context.window_manager.modal_handler_add(self)
        context.workspace.status_text_set("Click on the wood   Esc: leave it")
        return {"RUNNING_MODAL"}

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        if event.type in {"ESC", "RIGHTMOUSE"}:
            context.workspace.status_text_set(None)
            return {"CANCELLED"}
        if event.type == "LEFTMOUSE" and event.value == "PRESS":
            context.workspace.status_text_set(None)
            at = (event.mouse_region_x, event.mouse_region_y)
            region, view = context.region, context.region_data
            origin = view3d_utils.region_2d_to_origin_3d(region, view, at)
            return self.place(context, origin, view3d_utils.region_2d_to_vector_3d(region, view, at))
        return {"PASS_THROUGH"}

    def place(self, context: bpy.types.Context, origin: Vector, direction: Vector) -> set[str]:
        """Puts the cursor where a ray meets the scene."""
        graph = context.evaluated_depsgraph_get()
        hit, point, *_ = context.scene.ray_cast(graph, origin, direction)
        if not hit:
            self.report({"WARNING"}, "nothing is there")
            return {"CANCELLED"}
        context.scene.cursor.location = point
        context.scene.greenstick.place = "CURSOR"
        return {"FINISHED"}


class GREENSTICK_OT_rigid_bodies(bpy.types.Operator):
    """Make rigid bodies of the selected pieces: convex hulls, masses from their volumes and the density of the wood"""

    bl_idname = "greenstick.rigid_bodies"
    bl_label = "Make Rigid Bodies"
    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context: bpy.types.Context) -> set[str]:
        pieces = [o for o in context.selected_objects if "greenstick_source" in o]
        if not pieces:
            self.report({"ERROR"}, "no pieces are selected; break something, and select its pieces")
            return {"CANCELLED"}
        if context.scene.rigidbody_world is None:
            bpy.ops.rigidbody.world_add()
        density = context.scene.greenstick.density
        active = context.view_layer.objects.active
        for piece in pieces:
            context.view_layer.objects.active = piece
            if piece.rigid_body is None:
                bpy.ops.rigidbody.object_add()
            piece.rigid_body.collision_shape = "CONVEX_HULL"
            piece.rigid_body.mass = max(density * volume(piece) * unit_scale(context) ** 3, 1e-6)
        context.view_layer.objects.active = active
        return {"FINISHED"}


def volume(piece: bpy.types.Object) -> float:
    """The volume of a closed mesh in the world, in units of the scene cubed."""
    mesh = piece.data
    mesh.calc_loop_triangles()
    points = [piece.matrix_world @ v.co for v in mesh.vertices]
    sixth = sum(points[a].dot(points[b].cross(points[c])) for a, b, c in (t.vertices for t in mesh.loop_triangles))
    return abs(sixth) / 6.0


def _tell(operator: bpy.types.Operator, broken: greenstick.Broken, collection: bpy.types.Collection) -> None:
    report = broken.report
    for note in report["notes"]:
        operator.report({"WARNING"}, note)
    parts = ", ".join(f"{p['name']} {_volume_text(p['volume_m3'])}" for p in report["pieces"])
    operator.report({"INFO"}, f"{collection.name}: {parts}")


def _volume_text(volume_m3: float | None) -> str:
    return "open" if volume_m3 is None else f"{1e6 * volume_m3:.1f} cm³"


_CLASSES = (
    GREENSTICK_OT_break_wood,
    GREENSTICK_OT_break_live,
    GREENSTICK_OT_simulate,
    GREENSTICK_OT_place,
    GREENSTICK_OT_rigid_bodies,
)


def _menu(menu: bpy.types.Menu, _context: bpy.types.Context) -> None:
    menu.layout.separator()
    menu.layout.operator(GREENSTICK_OT_break_wood.bl_idname)
    menu.layout.operator(GREENSTICK_OT_simulate.bl_idname)


def register() -> None:
    for item in _CLASSES:
        bpy.utils.register_class(item)
    bpy.types.VIEW3D_MT_object.append(_menu)


def unregister() -> None:
    bpy.types.VIEW3D_MT_object.remove(_menu)
    for item in reversed(_CLASSES):
        bpy.utils.unregister_class(item)
