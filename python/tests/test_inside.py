"""Rings of sections, and the inside of stems as arrays."""

from __future__ import annotations

import json
import pickle
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import greenstick
from conftest import PROGRAM
from greenstick import errors


def section(onset: float = 0.2, rings: int = 6) -> dict[str, Any]:
    """A section whose outer rings lean to one side, and its rings as somebody may have drawn them."""
    angle = np.linspace(0, 2 * np.pi, 180, endpoint=False)
    ray = np.stack([np.cos(angle), np.sin(angle)], axis=1)

    def curve(share: float) -> list[list[float]]:
        lean = 0.3 * max(share - onset, 0) / (1 - onset)
        radius = 80 * share * (1 + lean * np.cos(angle - 0.7))
        points: list[list[float]] = (ray * radius[:, None] + [100, 90]).round(3).tolist()
        return points

    shares = [(k + 1) / rings for k in range(rings)]
    drawn = [{"label": str(k), "points": curve(share)} for k, share in enumerate(shares[:-1])]
    return {"outer_contour": curve(1), "pith": [100, 90], "rings": drawn, "units": "mm", "species": "spruce"}


def test_rings_are_those_of_the_program(tmp_path: Path) -> None:
    file = tmp_path / "section.json"
    file.write_text(json.dumps(section()))
    ours = greenstick.rings(file, fit=True, rings=12, picture_size=200)
    theirs, picture = tmp_path / "theirs.json", tmp_path / "theirs.png"
    command: list[str | Path] = [PROGRAM, "rings", file, "--rings", "12", "--fit", "-o", theirs]
    subprocess.run([*command, "--picture", picture, "--picture-size", "200"], check=True, capture_output=True)
    assert ours.json() == theirs.read_text()
    assert ours.picture().png() == picture.read_bytes() == ours._repr_png_()
    ours.write(tmp_path / "ours.json")
    assert (tmp_path / "ours.json").read_bytes() == theirs.read_bytes()
    written = json.loads(ours.json())
    assert len(ours) == len(ours.curves) == len(written["rings"]) == 12
    for curve, radius, ring in zip(ours.curves, ours.mean_radii, written["rings"]):
        assert np.allclose(curve, ring["points"], atol=1e-4)
        assert radius == pytest.approx(ring["mean_radius"])
    again = pickle.loads(pickle.dumps(ours))
    assert again.json() == ours.json() and again.picture().png() == ours.picture().png()
    assert again.eccentricity_onset == ours.eccentricity_onset is not None


def test_the_onset_of_eccentricity_is_fitted() -> None:
    # Rings of a tree that began to be eccentric late, as annotations.
    annotated = greenstick.rings(section(), eccentricity_onset=0.6).json()
    fitted = greenstick.rings(annotated, fit=True)
    assert fitted.eccentricity_onset == pytest.approx(0.6, abs=0.05)
    average = greenstick.rings(annotated)
    assert average.eccentricity_onset is None
    near, far = (np.mean([ring["model_percent"] for ring in rings.compare()]) for rings in (fitted, average))
    assert near < 0.2 and far > 1
    assert len(fitted.compare()) == 20 and fitted.compare()[0]["label"] == "1"


def test_sections_are_files_texts_dictionaries_and_arrays() -> None:
    content = section()
    outline = np.array(content["outer_contour"])
    alone = greenstick.rings(outline, widths=[20, 30, 10])
    assert alone.is_pith_guessed and alone.units == "px" and len(alone) == 3
    assert np.array_equal(alone.outline, outline)
    assert alone.outline.dtype == alone.pith.dtype == np.float64 and alone.pith.shape == (2,)
    assert np.allclose(np.diff(alone.mean_radii, prepend=0), [20, 30, 10], rtol=1e-6)
    known = greenstick.rings(outline, pith=[100, 90])
    assert not known.is_pith_guessed and known.pith.tolist() == [100, 90]
    assert greenstick.rings(content).json() == greenstick.rings(json.dumps(content)).json()


@pytest.mark.parametrize(
    ("given", "keys", "error", "message"),
    [
        (np.zeros((5, 3)), {}, errors.InputError, "section has the shape (5, 3); expected an array of shape (n, 2)"),
        (np.full((5, 2), np.nan), {}, errors.InputError, "section[0, 0] is NaN"),
        ({"pith": [0, 0]}, {}, errors.SectionError, "`outer_contour` is missing"),
        ("{", {}, errors.SectionError, "the section is no JSON"),
        ("none.json", {}, errors.FileError, "none.json: cannot be read"),
        (section(), {"rings": 4, "widths": [1]}, errors.ParameterError, "rings and widths are both given"),
        (section(), {"ring": 4}, errors.ParameterError, 'did you mean "rings"'),
        (section() | {"rings": []}, {"fit": True}, errors.SectionError, "no annotated `rings`"),
    ],
)
def test_wrong_sections_are_refused(given: Any, keys: dict[str, Any], error: type[Exception], message: str) -> None:
    with pytest.raises(error) as caught:
        greenstick.rings(given, **keys)
    assert message in str(caught.value)


def test_particles_are_arrays() -> None:
    made = greenstick.anatomy(only=["particles", "measures"], resolution=32)
    particles = made.arrays("particles")
    assert {"x", "y", "z", "ring"} <= particles.keys()
    assert all(column.shape == (made.report["particles"],) for column in particles.values())
    # They look into the bytes of the file.
    assert not particles["ring"].flags.owndata and not particles["ring"].flags.writeable
    table = pytest.importorskip("pyarrow") and made.table("particles")
    # Names in Parquet end with the unit; positions in PLY are in single precision.
    columns = {name.split("_")[0]: table[name].to_numpy() for name in table.column_names}
    assert particles.keys() == columns.keys()
    for name, column in particles.items():
        assert np.allclose(column, columns[name], atol=1e-6), name
    areas = made.arrays("sections")
    assert all(len(column) == len(next(iter(areas.values()))) for column in areas.values())
    with pytest.raises(KeyError, match="particles"):
        made.arrays("none")


def test_voxels_are_arrays(tmp_path: Path) -> None:
    made = greenstick.anatomy(only=["volume"], resolution=32)
    parts = made.voxels()
    names = sorted(name for name in made.files if name.endswith(".vti"))
    assert len(parts) == len(names) == len(made.report["segments"]) > 0
    for part in parts:
        z, y, x = part.ring.shape
        assert part.zone.shape == (z, y, x) and part.colour.shape == (z, y, x, 3)
        # Wood has a ring, a tissue and a colour, or none of them.
        assert np.array_equal(part.ring > 0, part.zone != 255)
        assert not part.colour[part.ring == 0].any()
        assert np.allclose(part.directions @ part.directions.T, np.eye(3))
        assert part.spacing.shape == part.origin.shape == (3,)
    pyvista = pytest.importorskip("pyvista")
    made.write(tmp_path / "inside")
    for part, name in zip(parts, names):
        image = pyvista.read(tmp_path / "inside" / name)
        assert np.array_equal(image.cell_data["ring"], part.ring.ravel())
        assert np.array_equal(image.cell_data["colour"], part.colour.reshape(-1, 3))
        assert np.allclose(image.origin, part.origin) and np.allclose(image.spacing, part.spacing)
        # The middle of a voxel in the world, by both.
        k, j, i = np.argwhere(part.ring > 0)[0].tolist()
        centre = image.get_cell(int(np.ravel_multi_index((k, j, i), part.ring.shape))).center
        steps = (np.array([i, j, k]) + 0.5) * part.spacing
        assert np.allclose(part.origin + steps @ part.directions, centre)
    with pytest.raises(KeyError, match="volume"):
        greenstick.anatomy(only=["measures"], resolution=32).voxels()
