"""The panel in the sidebar of the 3D view (N)."""

import bpy

from .settings import AUTOMATIC, DECLARED, auto_name, property_name


def _groups() -> dict[str, list[str]]:
    groups: dict[str, list[str]] = {}
    for key, about in DECLARED.items():
        groups.setdefault(about["group"], []).append(key)
    return groups


class _Panel:
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Greenstick"


class GREENSTICK_PT_main(_Panel, bpy.types.Panel):
    bl_label = "Break Wood"
    bl_idname = "GREENSTICK_PT_main"

    def draw(self, context: bpy.types.Context) -> None:
        layout, settings = self.layout, context.scene.greenstick
        layout.use_property_split = True
        layout.use_property_decorate = False
        layout.prop(settings, "preset")
        layout.prop(settings, property_name("break.seed"))
        layout.prop(settings, "species")
        layout.prop(settings, "place")
        if settings.place == "FRACTION":
            layout.prop(settings, "fraction", slider=True)
        layout.operator("greenstick.place", icon="EYEDROPPER")
        row = layout.row(align=True)
        row.scale_y = 1.4
        row.operator("greenstick.break_wood", icon="MOD_EXPLODE")
        row.operator("greenstick.break_live", text="", icon="PLAY")
        layout.prop(settings, "density")
        layout.operator("greenstick.rigid_bodies", icon="RIGID_BODY")


class GREENSTICK_PT_simulate(_Panel, bpy.types.Panel):
    bl_label = "Simulate"
    bl_idname = "GREENSTICK_PT_simulate"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        layout, settings = self.layout, context.scene.greenstick
        layout.use_property_split = True
        layout.use_property_decorate = False
        for name in ("simulation_scene", "species", "simulation_keys", "simulation_cache"):
            layout.prop(settings, name)
        row = layout.row()
        row.scale_y = 1.4
        row.operator("greenstick.simulate", icon="PHYSICS")


def _sub_panel(number: int, group: str, keys: list[str]) -> type:
    def draw(self: bpy.types.Panel, context: bpy.types.Context) -> None:
        layout, settings = self.layout, context.scene.greenstick
        layout.use_property_split = True
        layout.use_property_decorate = False
        for key in keys:
            row = layout.row()
            if auto_name(key) in AUTOMATIC:
                row.prop(settings, auto_name(key), text="Auto", toggle=True)
                row = row.row()
                row.enabled = not getattr(settings, auto_name(key))
            row.prop(settings, property_name(key))

    return type(
        f"GREENSTICK_PT_group_{number}",
        (_Panel, bpy.types.Panel),
        {
            "bl_label": group[:1].upper() + group[1:],
            "bl_parent_id": "GREENSTICK_PT_main",
            "bl_options": {"DEFAULT_CLOSED"},
            "draw": draw,
        },
    )


_CLASSES = [
    GREENSTICK_PT_main,
    *[_sub_panel(i, g, keys) for i, (g, keys) in enumerate(_groups().items())],
    GREENSTICK_PT_simulate,
]


def register() -> None:
    for item in _CLASSES:
        bpy.utils.register_class(item)


def unregister() -> None:
    for item in reversed(_CLASSES):
        bpy.utils.unregister_class(item)
