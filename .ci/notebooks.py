"""Runs the notebooks of a folder, each from its first cell on in a kernel of this Python, and prints the time of each.

    notebooks.py NOTEBOOKS [PICTURES]

With PICTURES, the pictures that they show are written there as NOTEBOOK_CELL.png. The notebooks themselves are not changed;
one that holds outputs is refused, as the repository keeps none.
"""

import base64
import sys
import time
from pathlib import Path

import nbformat
from nbclient import NotebookClient

SECONDS = 120


def pictures(notebook, name, folder):
    for number, cell in enumerate(notebook.cells):
        shown = [o.data["image/png"] for o in cell.get("outputs", []) if "image/png" in o.get("data", {})]
        for picture in shown:
            (folder / f"{name}_{number}.png").write_bytes(base64.b64decode(picture))


def main():
    folder, *rest = map(Path, sys.argv[1:])
    paths = sorted(folder.glob("*.ipynb"))
    if not paths:
        sys.exit(f"{folder}: there are no notebooks")
    for path in paths:
        notebook = nbformat.read(path, as_version=4)
        nbformat.validate(notebook)
        if any(cell.get("outputs") or cell.get("execution_count") for cell in notebook.cells):
            sys.exit(f"{path}: it holds outputs; clear them before it is committed")
        start = time.monotonic()
        NotebookClient(notebook, timeout=SECONDS, kernel_name="python3").execute(cwd=str(folder))
        print(f"{path.name}: {time.monotonic() - start:.1f} s")
        for pictures_folder in rest:
            pictures(notebook, path.stem, pictures_folder)


main()
