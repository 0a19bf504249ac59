"""Greenstick inside Blender: select an object, press *Break wood*."""

from . import operators, panel, settings

_MODULES = (settings, operators, panel)


def register() -> None:
    for module in _MODULES:
        module.register()


def unregister() -> None:
    for module in reversed(_MODULES):
        module.unregister()
