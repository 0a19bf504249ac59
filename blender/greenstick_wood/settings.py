"""What the panel shows: properties made from the library's own declarations, so that none is written twice."""

from typing import Any

import bpy
import greenstick

# Keys that have no place in a panel: files, pictures of the library's own, scans, lists.
_LEFT_OUT = {"input", "unit", "at", "picture_size", "samples", "draft", "view", "close_up", "as_scan", "bark_only"}
_UNIT_NAMES = {"degree": "°", "metre": "m", "radius": "radii", "percent": "%", "pixel": "px", "one": ""}
# Integers of Blender's properties have 32 bits.
_MOST = 2**31 - 1
# Enumerations refer to texts that Python must keep.
_kept: list[Any] = []


def property_name(key: str) -> str:
    """The name of a key as an attribute."""
    return key.replace(".", "__")


def auto_name(key: str) -> str:
    """The name of the switch that leaves a key to the library."""
    return f"auto__{property_name(key)}"


def _declared() -> dict[str, dict[str, Any]]:
    request = greenstick.Request()
    found = {}
    for key in request.keys():
        about = request.about(key)
        kind = about["kind"]
        is_list = isinstance(kind, dict) and "list" in kind
        is_scan = about["group"] in _scan_groups(request)
        if not (key in _LEFT_OUT or is_list or is_scan or key.startswith(("crack_groups.", "heights."))):
            found[key] = about
    return found


def _scan_groups(request: greenstick.Request) -> set[str]:
    return {request.about("outliers")["group"]}


def _label(key: str, unit: str) -> str:
    name = key.removeprefix("break.").replace(".", " ").replace("_", " ").capitalize()
    suffix = _UNIT_NAMES.get(unit, unit)
    return f"{name} ({suffix})" if suffix else name


def _property(key: str, about: dict[str, Any], update: Any) -> Any:
    """The property of a key; `None` for a kind that has none."""
    kind, doc = about["kind"], about["doc"]
    default = None if about["default"] == "auto" else about["default"]
    if kind == "flag":
        return bpy.props.BoolProperty(name=_label(key, ""), description=doc, default=bool(default), update=update)
    if "number" in kind:
        number = kind["number"]
        return bpy.props.FloatProperty(
            name=_label(key, number.get("unit", "")),
            description=doc,
            min=number["min"],
            max=number["max"],
            default=number["min"] if default is None else default,
            precision=3,
            update=update,
        )
    if "integer" in kind:
        integer = kind["integer"]
        return bpy.props.IntProperty(
            name=_label(key, integer.get("unit", "")),
            description=doc,
            min=max(integer["min"], -_MOST),
            max=min(integer["max"], _MOST),
            default=integer["min"] if default is None else default,
            update=update,
        )
    if "choice" in kind:
        choice = kind["choice"]
        items = list(zip(choice["options"], choice["labels"], choice["docs"], strict=True))
        _kept.append(items)
        first = choice["options"][0] if default is None else default
        return bpy.props.EnumProperty(name=_label(key, ""), description=doc, items=items, default=first, update=update)
    if "text" in kind:
        return bpy.props.StringProperty(
            name=_label(key, ""), description=f"{doc} Empty: chosen by the library", default=default or "", update=update
        )
    return None


def _presets() -> list[tuple[str, str, str]]:
    names = greenstick.presets()
    # The ways in which wood breaks first, the figures of the paper after them.
    ordered = sorted(names, key=lambda n: n.startswith("fig"))
    return [("default", "Default", "Fibrous wood, torn")] + [(n, n, names[n]) for n in ordered]


def _preset_changed(settings: bpy.types.PropertyGroup, _context: bpy.types.Context) -> None:
    settings.take(settings.base())


def _scenes() -> list[tuple[str, str, str]]:
    about = greenstick.scenes()
    return [(name, name.replace("-", " ").capitalize(), about[name]) for name in about]


class GreenstickSettings(bpy.types.PropertyGroup):
    """What *Break wood* and *Simulate* do."""

    def base(self) -> greenstick.Request:
        """The request of the preset alone."""
        return greenstick.Request() if self.preset == "default" else greenstick.Request(self.preset)

    def take(self, request: greenstick.Request) -> None:
        """Shows the values of a request."""
        for key in DECLARED:
            value = request[key]
            is_auto = value is None or value == "auto"
            if auto_name(key) in AUTOMATIC:
                self[auto_name(key)] = is_auto
            if not is_auto:
                setattr(self, property_name(key), value)
            elif isinstance(getattr(self, property_name(key)), str) and "text" in DECLARED[key]["kind"]:
                setattr(self, property_name(key), "")

    def request(self, places: list[tuple[float, float, float] | float]) -> greenstick.Request:
        """The request that the panel shows, at these places: points, m, or fractions of the length."""
        request = self.base()
        changes = {}
        for key in DECLARED:
            value = getattr(self, property_name(key))
            if auto_name(key) in AUTOMATIC:
                value = None if getattr(self, auto_name(key)) else value
            elif value == "" and DECLARED[key]["auto"]:
                value = None
            now = request[key]
            now = None if now == "auto" else now
            same = abs(value - now) <= 1e-6 * abs(now) if isinstance(value, float) and isinstance(now, float) else value == now
            if not same:
                changes[key] = value
        texts = [p if isinstance(p, float) else ",".join(f"{x:.9g}" for x in p) for p in places]
        if len(texts) == 1:
            changes["at"] = str(texts[0])
        request.update(changes)
        if len(texts) > 1:
            for text in texts:
                request.add_break(at=str(text))
        return request


def _add_properties() -> None:
    """Gives the settings the properties of all declared keys."""
    notes = GreenstickSettings.__annotations__ = dict(getattr(GreenstickSettings, "__annotations__", {}))
    notes["preset"] = bpy.props.EnumProperty(
        name="Preset", description="How it breaks; sets all that is below", items=PRESETS, update=_preset_changed
    )
    notes["place"] = bpy.props.EnumProperty(
        name="Where",
        description="Where it breaks",
        items=[
            ("FRACTION", "Fraction", "A fraction of the length of the stem from its base"),
            ("CURSOR", "3D cursor", "At the 3D cursor, on the limb that is nearest"),
            ("EMPTIES", "Empties", "At every selected empty"),
        ],
    )
    notes["fraction"] = bpy.props.FloatProperty(
        name="Fraction", description="Fraction of the stem's length from its base", min=0.0, max=1.0, default=0.5
    )
    notes["density"] = bpy.props.FloatProperty(
        name="Density (kg/m³)", description="Density of the wood, for rigid bodies", min=10.0, max=2000.0, default=600.0
    )
    notes["simulation_scene"] = bpy.props.EnumProperty(
        name="Scene", description="What happens to the wood", items=SCENES, default="bend"
    )
    notes["simulation_keys"] = bpy.props.StringProperty(
        name="Keys",
        description="Keys of the scene that are changed, as in the reference: duration = 0.5; rods.number = 40",
    )
    notes["simulation_cache"] = bpy.props.StringProperty(
        name="Cache",
        description="Folder of the film, which Blender reads as it plays; // is that of the file",
        subtype="DIR_PATH",
        options={"PATH_SUPPORTS_BLEND_RELATIVE"},
        default="//greenstick",
    )
    for key, about in DECLARED.items():
        made = _property(key, about, None)
        if made is not None:
            notes[property_name(key)] = made
        if auto_name(key) in AUTOMATIC:
            notes[auto_name(key)] = bpy.props.BoolProperty(
                name="Auto", description="Leave it to the library", default=True
            )


DECLARED = _declared()
AUTOMATIC = {
    auto_name(key)
    for key, about in DECLARED.items()
    if about["auto"] and isinstance(about["kind"], dict) and "text" not in about["kind"]
}
PRESETS = _presets()
SCENES = _scenes()
_add_properties()


def register() -> None:
    bpy.utils.register_class(GreenstickSettings)
    bpy.types.Scene.greenstick = bpy.props.PointerProperty(type=GreenstickSettings)


def unregister() -> None:
    del bpy.types.Scene.greenstick
    bpy.utils.unregister_class(GreenstickSettings)
