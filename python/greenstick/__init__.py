"""Break wood: branches, trunks, logs and boards.

>>> import greenstick
>>> broken = greenstick.break_wood(greenstick.Request("brash", seed=7, texture_size=64))
>>> broken.scene.nodes[0].name
'lower'
"""

from greenstick import errors
from greenstick._native import (
    Anatomy,
    Broken,
    Frame,
    Mesh,
    Node,
    Picture,
    Piece,
    Request,
    Run,
    Scene,
    Session,
    Species,
    __version__,
    anatomy,
    bend_test,
    break_wood,
    built_in_branch,
    presets,
    simulate,
    species,
)
from greenstick.errors import Cancelled, GreenstickError

__all__ = [
    "Anatomy",
    "Broken",
    "Cancelled",
    "Frame",
    "GreenstickError",
    "Mesh",
    "Node",
    "Picture",
    "Piece",
    "Request",
    "Run",
    "Scene",
    "Session",
    "Species",
    "__version__",
    "anatomy",
    "bend_test",
    "break_wood",
    "built_in_branch",
    "errors",
    "presets",
    "simulate",
    "species",
]
