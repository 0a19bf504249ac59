"""Break wood: branches, trunks, logs and boards.

>>> import greenstick
>>> broken = greenstick.break_wood(greenstick.Request("brash", seed=7, texture_size=64))
>>> broken.scene.nodes[0].name
'lower'
"""

from greenstick import errors
from greenstick._native import (
    Broken,
    Mesh,
    Node,
    Picture,
    Piece,
    Request,
    Scene,
    Session,
    Species,
    __version__,
    break_wood,
    built_in_branch,
    presets,
    species,
)
from greenstick.errors import Cancelled, GreenstickError

__all__ = [
    "Broken",
    "Cancelled",
    "GreenstickError",
    "Mesh",
    "Node",
    "Picture",
    "Piece",
    "Request",
    "Scene",
    "Session",
    "Species",
    "__version__",
    "break_wood",
    "built_in_branch",
    "errors",
    "presets",
    "species",
]
