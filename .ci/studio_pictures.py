#!/usr/bin/env python3
"""Draws the pictures of docs/studio.md anew: the window's from the states that the snapshot tests bring about, the page's from what
page.mjs has left in a folder.

Usage: studio_pictures.py [FOLDER_OF_PAGE_MJS]. Needs a Vulkan driver (mesa-vulkan-drivers) and pngquant. Look at each picture."""

import os
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
TO = ROOT / "docs/pictures/studio"
# Picture, and the snapshot that shows the same state.
PICTURES = {
    "branch": "branch",
    "rings": "colours",
    "ductile": "ductile",
    "painted": "painted",
    "several": "several",
    "cracks": "cracks",
    "section": "dragged",
    "photograph": "photograph",
    "simulation": "simulation",
    "holds": "holds",
    "pulling": "pulling",
}
PAGE = "slid"
COLOURS = "192"


def reduce(drawn, name):
    """Writes a picture with few colours, as the documentation has them: a third of the bytes."""
    to = TO / f"{name}.png"
    command = ["pngquant", "--force", "--strip", "--speed", "1", "--output", to, COLOURS, drawn]
    subprocess.run(command, check=True)
    print(f"{to.relative_to(ROOT)}: {to.stat().st_size // 1000} kB")


def main():
    with tempfile.TemporaryDirectory() as folder:
        environment = dict(os.environ, GREENSTICK_WHOLE_SNAPSHOTS=folder, GREENSTICK_NEEDS_ADAPTER="1")
        environment.setdefault("XDG_RUNTIME_DIR", folder)
        test = ["cargo", "test", "-p", "greenstick-studio", "--test", "integration", "snapshots"]
        subprocess.run(test, cwd=ROOT, env=environment, check=True)
        missing = [p for p in PICTURES.values() if not (pathlib.Path(folder) / f"{p}.png").is_file()]
        if missing:
            sys.exit(f"the tests drew no {', '.join(missing)}")
        for name, snapshot in PICTURES.items():
            reduce(pathlib.Path(folder) / f"{snapshot}.png", name)
    for page in sys.argv[1:]:
        reduce(pathlib.Path(page) / f"{PAGE}.png", "page")


if __name__ == "__main__":
    main()
