#!/usr/bin/env python3
"""Checks what `greenstick schema` prints with a foreign reader of JSON Schema.

Usage: validate_schema.py GREENSTICK FOLDER

The schema must itself be valid (draft 2020-12), must take every recipe that the program writes and those that the
guides show, and must refuse wrong ones. FOLDER is empty and takes the recipes.
"""

import json
import pathlib
import re
import subprocess
import sys
import tomllib

from jsonschema import Draft202012Validator

WRONG = [
    ("an unknown key", "slab_height = 1"),
    ("a number out of range", "[break]\nslab_height = 21"),
    ("a length without a unit", "part = 3"),
    ("an unknown word", "[break]\nsurface = 'shiny'"),
    ("a crack without its kind", "[[crack]]\nangle = 3"),
    ("a key of the other kind of crack", "[[crack]]\nkind = 'radial'\nring = 0.5"),
    ("an odd number of pixels", "texture_size = 9"),
]


def main(greenstick: str, folder: pathlib.Path) -> None:
    def run(*arguments: str) -> str:
        return subprocess.run([greenstick, *arguments], check=True, capture_output=True, text=True).stdout

    everything = json.loads(run("schema"))
    Draft202012Validator.check_schema(everything)
    names = sorted(everything["$defs"])
    for name in names:
        Draft202012Validator.check_schema(json.loads(run("schema", name)))
    recipes = json.loads(run("schema", "break"))
    validator = Draft202012Validator(recipes)

    saved = folder / "recipe.toml"
    texts = {}
    for preset in ["fig17", "fig20", "twist", "green-stick"]:
        run("break", "--preset", preset, "--set", "rings=8", "--texture-size", "8", "-o", str(folder / "a.ply"),
            "--save-recipe", str(saved), "--quiet")
        texts[preset] = saved.read_text()
    guides = pathlib.Path(__file__).parent.parent / "docs"
    for guide in ["artists.md"]:
        for number, block in enumerate(re.findall(r"```toml\n(.*?)```", (guides / guide).read_text(), re.S)):
            texts[f"{guide}, example {number}"] = block
    for name, text in texts.items():
        for error in validator.iter_errors(tomllib.loads(text)):
            sys.exit(f"{name}: {error.json_path}: {error.message}")
    for name, text in WRONG:
        if validator.is_valid(tomllib.loads(text)):
            sys.exit(f"the schema takes {name}: {text!r}")
    print(f"schemas of {', '.join(names)}: valid; {len(texts)} recipes taken, {len(WRONG)} wrong ones refused")


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(sys.argv[1], pathlib.Path(sys.argv[2]))
