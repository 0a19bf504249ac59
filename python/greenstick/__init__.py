"""Break wood: branches, trunks, logs and boards.

>>> import greenstick
>>> broken = greenstick.break_wood(greenstick.Request("brash", seed=7, texture_size=64))
>>> broken.scene.nodes[0].name
'lower'
"""

from greenstick import errors
from greenstick._arrays import Voxels
from greenstick._native import (
    Anatomy,
    BendTest,
    Broken,
    Film,
    Frame,
    Mesh,
    Node,
    Picture,
    Piece,
    Request,
    Rings,
    Run,
    Scene,
    Session,
    Skin,
    Species,
    __version__,
    anatomy,
    bend_test,
    break_wood,
    built_in_branch,
    presets,
    rings,
    scenes,
    simulate,
    species,
)
from greenstick._sweeps import Sweep, sweep
from greenstick._usd import scene_from_usd
from greenstick.errors import Cancelled, GreenstickError

__all__ = [
    "Anatomy",
    "BendTest",
    "Broken",
    "Cancelled",
    "Film",
    "Frame",
    "GreenstickError",
    "Mesh",
    "Node",
    "Picture",
    "Piece",
    "Request",
    "Rings",
    "Run",
    "Scene",
    "Session",
    "Skin",
    "Species",
    "Sweep",
    "Voxels",
    "__version__",
    "anatomy",
    "bend_test",
    "break_wood",
    "built_in_branch",
    "errors",
    "presets",
    "rings",
    "scene_from_usd",
    "scenes",
    "simulate",
    "species",
    "sweep",
]
