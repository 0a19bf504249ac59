"""Blender as a module (PyPI `bpy`), with the extension registered once."""

import sys
from pathlib import Path

import bpy
import pytest

sys.path.insert(0, str(Path(__file__).parents[1]))
import greenstick_wood  # noqa: E402


@pytest.fixture(scope="session", autouse=True)
def registered():
    greenstick_wood.register()
    yield
    greenstick_wood.unregister()


@pytest.fixture
def scene():
    """An empty scene with the settings as they come."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    return bpy.context.scene


@pytest.fixture
def data():
    return Path(__file__).parents[2] / "tests" / "data"
