"""Requests: keys, layers, messages."""

from __future__ import annotations

import copy
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import greenstick
from greenstick import Request, errors

# What a type checker refuses, too.
Untyped: Any = Request


def test_layers_and_keys() -> None:
    request = Request("brash", text="species = 'white oak'\n", settings={"high.height": 2}, seed=7, part="3 cm")
    assert (request.seed, request["break.seed"], request["high.height"]) == (7, 7, 2.0)
    assert (request.species, request.part, request.moisture) == ("Oak, white", 0.03, None)
    request["moisture"] = np.float32(30)
    request["annual_rings"] = np.int64(40)
    assert (request.moisture, request.annual_rings) == (30.0, 40)
    assert "slab_height" in request and "slab_hight" not in request
    assert request.changed()["break.seed"] == 7
    assert request.as_dict()["part"] == 0.03
    assert request.about("part")["kind"]["number"]["unit"] == "metre"
    assert copy.copy(request) == request == copy.deepcopy(request) != Request()
    assert Request(text=request.to_toml()).hash() == request.hash()


def test_breaks_start_from_the_request() -> None:
    request = Request(seed=3, texture_size=64, rings=6, sectors=12)
    request.add_break(at=0.3)
    request.add_break(at=0.7, seed=5)
    assert request.break_count == 2
    assert request.changed()["breaks[1].at"] == "0.7"
    names = [node.name for node in greenstick.break_wood(request).scene.nodes]
    assert names[:3] == ["piece_0", "piece_1", "piece_2"]
    assert all(name.endswith("_fuzz") for name in names[3:])


@pytest.mark.parametrize(
    ("make", "error", "message"),
    [
        (lambda: Untyped(slab_hight=1), errors.ParameterError, 'unknown parameter "slab_hight"; did you mean "slab_height"'),
        (lambda: Request(moisture=float("nan")), errors.ParameterError, "moisture is NaN, but it must be"),
        (lambda: Request(moisture=-1), errors.ParameterError, "moisture is -1, but it must be"),
        (lambda: Untyped(seed=1.5), errors.ParameterError, "seed is 1.5, but it must be"),
        (lambda: Request(seed=10**60), errors.ParameterError, "out of any range"),
        (lambda: Untyped(part={}), errors.ParameterError, "part is"),
        (lambda: Request("brsh"), errors.ParameterError, 'did you mean "brash"'),
        (lambda: Request(species="wite oak"), errors.ParameterError, 'did you mean "Oak, white"'),
        (lambda: Request(text="part = '3 kg'"), errors.ParameterError, "line 1, column 8: "),
        (lambda: greenstick.Species("xyz"), errors.SpeciesError, "xyz"),
        (lambda: Request.read("none.toml"), errors.FileError, "none.toml: cannot be read"),
        (lambda: greenstick.Scene.read("none.glb"), errors.FileError, "none.glb: cannot be read"),
        (lambda: greenstick.break_wood(Request(input="none.glb")), errors.FileError, "none.glb: cannot be read"),
        (lambda: greenstick.break_wood(Request(at="7 m")), errors.StemError, "m"),
    ],
)
def test_messages_say_what_would_be_right(make: object, error: type[Exception], message: str) -> None:
    assert callable(make)
    with pytest.raises(error) as caught:
        make()
    assert message in str(caught.value)
    assert isinstance(caught.value, greenstick.GreenstickError)
    assert caught.value.kind in ("request", "work")


def test_a_wrong_value_changes_nothing() -> None:
    request = Request(seed=7)
    before = request.to_toml()
    with pytest.raises(errors.ParameterError):
        request.update(part=0.1, moisture=-1)
    with pytest.raises(AttributeError):
        Untyped().no_such_key
    assert request.to_toml() == before


def test_a_file_that_cannot_be_written(tmp_path: Path) -> None:
    scene = greenstick.built_in_branch()
    with pytest.raises(errors.FileError, match="there is no folder"):
        scene.write(tmp_path / "none" / "x.glb")
    with pytest.raises(errors.FileError, match="ends in"):
        scene.write(tmp_path / "x.docx")
    assert list(tmp_path.iterdir()) == []


def test_species() -> None:
    names = [one.name for one in greenstick.species()]
    assert len(names) > 50 and "Oak, white" in names
    oak = greenstick.Species("Quercus alba")
    assert oak.name == "Oak, white"
    assert oak.as_dict()["dry"]["modulus_of_rupture"] == pytest.approx(105e6)
    assert "brash" in greenstick.presets()
