"""Reads what `greenstick anatomy` wrote with foreign readers: VTK's own, pyarrow, numpy, trimesh.

Usage: validate_anatomy.py FOLDER [--open]
With --open the mesh was open, so its volume is not known. Needs vtk, pyarrow, numpy and trimesh.
"""

import json
import pathlib
import shutil
import subprocess
import sys
import tempfile

import numpy as np
import pyarrow.parquet
import trimesh
import vtk
from vtk.util.numpy_support import vtk_to_numpy

NO_WOOD = 255
# A stem is no prism: its taper, and the grain that follows it, are not in beam theory.
MAX_BENDING_ERROR = 0.05
# Part by which the volume of hexahedra is off that of the sections.
MAX_VOLUME_ERROR = 5e-3
MAX_BOARD_VOLUME_ERROR = 1e-2
# Part of its length by which a stem that counts as straight may leave its chord.
MAX_OFF_STRAIGHT = 0.02


def read(reader, path):
    reader.SetFileName(str(path))
    reader.Update()
    assert reader.GetErrorCode() == 0, path
    return reader.GetOutput()


def arrays(data):
    return {data.GetArrayName(i): vtk_to_numpy(data.GetArray(i)) for i in range(data.GetNumberOfArrays())}


def check_volume(folder, report):
    total = 0.0
    for segment in report["segments"]:
        image = read(vtk.vtkXMLImageDataReader(), folder / segment["file"])
        n = segment["voxels"]
        assert image.GetDimensions() == (n + 1,) * 3, image.GetDimensions()
        assert np.allclose(image.GetSpacing(), segment["voxel_m"], rtol=1e-12)
        cells = arrays(image.GetCellData())
        assert set(cells) == {"ring", "zone", "colour"}, set(cells)
        ring, zone, colour = cells["ring"], cells["zone"], cells["colour"]
        assert len(ring) == n**3 and colour.shape == (n**3, 3)
        wood = ring > 0
        assert ring.max() <= report["rings"]
        assert np.array_equal(wood, zone != NO_WOOD) and zone[wood].max() < len(report["zones"])
        assert colour[wood].max() > 0 and colour[~wood].max(initial=0) == 0
        volume = wood.sum() * np.prod(image.GetSpacing())
        assert abs(volume / segment["volume_m3"] - 1) < 1e-9 if volume else segment["volume_m3"] == 0
        total += volume
        # The image stands where the stem is: the middle of its wood is on the centreline, within a part of its width.
        places = np.argwhere(wood.reshape(n, n, n))[:, ::-1].mean(axis=0) + 0.5
        world = np.zeros(3)
        image.TransformContinuousIndexToPhysicalPoint(places, world)
        line = np.array(report["centreline_m"])
        step = np.linalg.norm(np.diff(line, axis=0), axis=1).max()
        nearest = np.linalg.norm(line - world, axis=1).min()
        assert nearest < step + 0.5 * report["radius_m"] + segment["off_straight_m"], nearest
    if report["mesh_volume_m3"] is not None:
        assert abs(total / report["mesh_volume_m3"] - 1) < 0.03, (total, report["mesh_volume_m3"])
    listed = folder / "volume.vtm"
    if len(report["segments"]) > 1:
        blocks = read(vtk.vtkXMLMultiBlockDataReader(), listed)
        assert blocks.GetNumberOfBlocks() == len(report["segments"])
        assert blocks.GetBlock(0).GetNumberOfCells() == report["segments"][0]["voxels"] ** 3
    return total


def check_particles(folder, report):
    count = report["particles"]
    csv = np.genfromtxt(folder / "particles.csv", delimiter=",", names=True)
    table = pyarrow.parquet.read_table(folder / "particles.parquet")
    assert len(csv) == table.num_rows == count
    assert list(csv.dtype.names) == table.column_names
    notes = table.schema.metadata or pyarrow.parquet.read_metadata(folder / "particles.parquet").metadata
    assert notes[b"area_m2.unit"] == b"m2"
    for name in table.column_names:
        assert np.array_equal(csv[name], table[name].to_numpy().astype(float)), name
    eroded = report["rings_by"] != "field"
    if eroded:
        # A sector of an inner ring may have no pixel; slimmer sections have fewer rings.
        assert 0.9 * report["equation_1"] < count <= report["equation_1"] <= report["layers"] * sum(report["sectors"])
    elif report["kind"] == "round":
        assert count == report["equation_1"] == report["layers"] * sum(report["sectors"])
    assert csv["ring"].min() >= 1 and csv["ring"].max() == report["rings"]
    assert csv["zone"].max() < len(report["zones"])
    # The bundles of a layer make up its section.
    for layer in (0, report["layers"] // 2, report["layers"] - 1):
        section = report["sections"][layer]
        bundles = csv["area_m2"][csv["s_m"] == section["length_m"]].sum()
        assert abs(bundles / section["area_m2"] - 1) < 0.05, (layer, bundles, section["area_m2"])
        assert abs(sum(section["rings"]["area_m2"]) / bundles - 1) < 1e-9
    places = np.stack([csv["x_m"], csv["y_m"], csv["z_m"]], axis=1)
    points = read(vtk.vtkXMLPolyDataReader(), folder / "particles.vtp")
    assert points.GetNumberOfPoints() == points.GetNumberOfVerts() == count
    assert np.array_equal(vtk_to_numpy(points.GetPoints().GetData()), places)
    data = arrays(points.GetPointData())
    for name in set(csv.dtype.names) - {"x_m", "y_m", "z_m"}:
        assert np.array_equal(data[name], csv[name]), name
    ply = read(vtk.vtkPLYReader(), folder / "particles.ply")
    assert np.allclose(vtk_to_numpy(ply.GetPoints().GetData()), places, atol=1e-6 * (1 + np.abs(places).max()))
    cloud = trimesh.load(folder / "particles.ply", process=False)
    assert len(cloud.vertices) == count
    return places


def check_surface(folder, report, places):
    for name in ("surface_rings.glb", "surface_sectors.glb"):
        if report["kind"] == "board":
            assert not (folder / name).exists()
            continue
        mesh = trimesh.load(folder / name, force="mesh", process=False)
        blocks = read(vtk.vtkGLTFReader(), folder / name)
        found = vtk.vtkCompositeDataSet.SafeDownCast(blocks).NewIterator()
        colours = arrays(found.GetCurrentDataObject().GetPointData())["COLOR_0"]
        told_apart = report["rings"] if "rings" in name else max(report["sectors"])
        assert len(np.unique(colours, axis=0)) >= min(told_apart, 12) - 2, colours
        if report["rings_by"] == "field":
            # Particles of eroded rings lie in the middles of pixels, several in one near the pith.
            mesh.merge_vertices(merge_tex=True, merge_norm=True)
        assert mesh.is_watertight and mesh.is_winding_consistent and mesh.volume > 0, name
        between = report["layer_distance_m"] * sum(s["area_m2"] for s in report["sections"][1:])
        assert abs(mesh.volume / between - 1) < 0.06, (mesh.volume, between)
        low, high = places.min(axis=0), places.max(axis=0)
        assert (mesh.bounds[0] >= low - 1e-4).all() and (mesh.bounds[1] <= high + 1e-4).all()


def texts(data):
    """The strings of a data set's field data."""
    fields = data.GetFieldData()
    count = fields.GetNumberOfArrays()
    return {fields.GetArrayName(i): fields.GetAbstractArray(i).GetVariantValue(0).ToString() for i in range(count)}


def check_provenance(folder, report):
    """All files say where they come from, and alike."""
    told = report["provenance"]
    assert told["program"] == "greenstick" and told["version"] and len(told["origin_m"]) == 3
    notes = json.loads((folder / "csv-metadata.json").read_text())["notes"][0]
    found = [notes]
    found.append(texts(read(vtk.vtkXMLImageDataReader(), folder / report["segments"][0]["file"])))
    found.append(texts(read(vtk.vtkXMLPolyDataReader(), folder / "particles.vtp")))
    metadata = pyarrow.parquet.read_metadata(folder / "particles.parquet").metadata
    found.append({k.decode(): v.decode() for k, v in metadata.items() if b"." not in k and k != b"ARROW:schema"})
    for one in found:
        assert one == notes, (one, notes)
    assert notes["version"] == told["version"] and notes.get("input") == told["input"]
    comments = (folder / "particles.ply").read_bytes().split(b"end_header")[0].decode()
    assert f"comment version: {told['version']}" in comments


def check_tables(folder, report):
    """The tables are what their metadata say, and what the report says of them."""
    described = json.loads((folder / "csv-metadata.json").read_text())
    for table in described["tables"]:
        columns = [c["name"] for c in table["tableSchema"]["columns"]]
        rows = np.genfromtxt(folder / table["url"], delimiter=",", names=True)
        assert list(rows.dtype.names) == columns, table["url"]
    sections = np.genfromtxt(folder / "sections.csv", delimiter=",", names=True)
    for under, over in (("under_bark", "over_bark"),):
        assert (np.diff(sections[f"volume_{over}_m3"]) > 0).all()
        assert (sections[f"volume_{under}_m3"] <= sections[f"volume_{over}_m3"] * (1 + 1e-12)).all()
    assert (sections["diameter_by_tape_m"] <= sections["diameter_by_girth_m"] * (1 + 1e-9)).all()
    assert (sections["calliper_least_m"] <= sections["calliper_greatest_m"]).all()
    measures = report["measures"]
    whole = measures["volume_over_bark_m3"]
    if report["mesh_volume_m3"] is not None:
        assert abs(whole / report["mesh_volume_m3"] - 1) < 0.02, (whole, report["mesh_volume_m3"])
    assert sections["volume_over_bark_m3"][-1] <= whole


def check_cores(folder, report):
    """Ring widths in the Tucson format are those of the table."""
    if report["kind"] == "board" or report["rings_by"] != "field":
        assert not (folder / "rings.rwl").exists()
        return
    table = np.genfromtxt(folder / "ring_widths.csv", delimiter=",", names=True)
    for name, order in (("rings.rwl", 1), ("rings_inwards.rwl", -1)):
        series, years = {}, {}
        for line in (folder / name).read_text().splitlines()[3:]:
            core, year = line[:8].strip(), int(line[8:12])
            values = [int(line[i : i + 6]) for i in range(12, len(line), 6)]
            have = series.setdefault(core, [])
            years.setdefault(core, year)
            assert year == years[core] + len(have) and (year % 10 == 0 or not have)
            have += values
        assert len(series) == len(np.unique(table["direction_rad"]))
        for core, values in series.items():
            assert values[-1] == -9999 and len(values) > 1
            own = np.isclose(np.degrees(table["direction_rad"]), int(core[1:]), atol=0.6)
            widths = table["width_m"][own][::order]
            assert np.allclose(np.array(values[:-1]) * 1e-6, widths, atol=0.51e-6), core


def check_elements(folder, report):
    """The hexahedra are sound, fill the stem, and have axes at right angles."""
    grid = read(vtk.vtkXMLUnstructuredGridReader(), folder / "stem.vtu")
    told = report["elements"]
    assert grid.GetNumberOfCells() == told["hexahedra"] and grid.GetNumberOfPoints() == told["nodes"]
    sizes = vtk.vtkCellSizeFilter()
    sizes.SetInputData(grid)
    sizes.Update()
    volumes = vtk_to_numpy(sizes.GetOutput().GetCellData().GetArray("Volume"))
    cells = arrays(grid.GetCellData())
    # VTK divides a hexahedron into tetrahedra, which differs where its faces are warped.
    assert (volumes > 0).all() and abs(volumes.sum() / told["volume_m3"] - 1) < 2e-3
    assert abs(cells["volume_m3"].sum() / told["volume_m3"] - 1) < 1e-9
    # What gapes in a board is bounded by steps.
    most = MAX_BOARD_VOLUME_ERROR if report["kind"] == "board" else MAX_VOLUME_ERROR
    assert abs(told["volume_m3"] / told["sections_volume_m3"] - 1) < most, told
    axes = [cells[name] for name in ("longitudinal", "radial", "tangential")]
    for i, a in enumerate(axes):
        for j, b in enumerate(axes):
            assert np.allclose((a * b).sum(axis=1), float(i == j), atol=1e-9)
    quality = vtk.vtkMeshQuality()
    quality.SetInputData(grid)
    quality.SetHexQualityMeasureToScaledJacobian()
    quality.Update()
    jacobians = vtk_to_numpy(quality.GetOutput().GetCellData().GetArray("Quality"))
    assert jacobians.min() > 0.05, jacobians.min()
    if (folder / "stem.inp").exists():
        line = np.array(report["centreline_m"])
        chord = line[-1] - line[0]
        off = np.linalg.norm(np.cross(line - line[0], chord), axis=1).max() / (chord @ chord)
        check_deck(folder / "stem.inp", told, off < MAX_OFF_STRAIGHT)


def read_deck(path):
    """The keywords of an input file with their lines."""
    blocks = []
    for line in path.read_text().splitlines():
        if line.startswith("*") and not line.startswith("**"):
            blocks.append((line, []))
        elif not line.startswith("**"):
            blocks[-1][1].append(line)
    return blocks


def rows_of(blocks, keyword):
    """The numbers below a keyword, a row each."""
    lines = next(lines for name, lines in blocks if name == keyword)
    return [[float(x) for x in line.split(",") if x.strip()] for line in lines]


def check_deck(path, told, straight):
    """The input of CalculiX: its solid has the volume of the wood, and if straight bends like a beam where CalculiX is
    installed."""
    blocks = read_deck(path)
    nodes = np.array([row[1:] for row in rows_of(blocks, "*NODE, NSET=NALL")])
    elements = np.array([row[1:] for row in rows_of(blocks, "*ELEMENT, TYPE=C3D8, ELSET=EALL")], dtype=int) - 1
    sets = [rows_of(blocks, name) for name, _ in blocks if name.startswith("*ELSET")]
    assert sorted(int(x) for rows in sets for row in rows for x in row) == list(range(1, len(elements) + 1))
    assert len(rows_of(blocks, "*DISTRIBUTION, NAME=GRAIN")) == len(elements) + 1
    gauss = np.array([-1, 1]) / np.sqrt(3)
    corners = np.array([(-1, -1, -1), (1, -1, -1), (1, 1, -1), (-1, 1, -1), (-1, -1, 1), (1, -1, 1), (1, 1, 1), (-1, 1, 1)])
    points, weights = [], []
    for x in np.stack(np.meshgrid(gauss, gauss, gauss), -1).reshape(-1, 3):
        factors = (1 + corners * x) / 2
        slopes = corners / 2 * np.stack([np.delete(factors, k, axis=1).prod(axis=1) for k in range(3)], axis=1)
        weights.append(np.linalg.det(np.einsum("enk,nl->ekl", nodes[elements], slopes)))
        points.append(np.einsum("enk,n->ek", nodes[elements], factors.prod(axis=1)))
    weights, points = np.array(weights), np.array(points)
    assert (weights > 0).all()
    assert abs(weights.sum() / told["wood_volume_m3"] - 1) < 1e-5, (weights.sum(), told)
    butt = sum(len(row) for row in rows_of(blocks, "*NSET, NSET=BUTT"))
    # Where sections differ, as in a board with a hole, it is no beam.
    if straight and len(nodes) % butt == 0 and shutil.which("ccx"):
        check_bending(path, blocks, nodes, points, weights)


def check_bending(path, blocks, nodes, points, weights):
    """Held at its butt and pulled aside at its top, a stem bends as beam theory says: E I of every slab, and shear."""
    butt, top = (
        [int(x) - 1 for row in rows_of(blocks, f"*NSET, NSET={name}") for x in row] for name in ("BUTT", "TOP")
    )
    ends = [nodes[side].mean(axis=0) for side in (butt, top)]
    along = ends[1] - ends[0]
    length = np.linalg.norm(along)
    along /= length
    side = np.cross(along, np.eye(3)[np.abs(along).argmin()])
    side /= np.linalg.norm(side)
    elastic = rows_of(blocks, "*ELASTIC, TYPE=ENGINEERING CONSTANTS")[0]
    modulus, shear = elastic[0], elastic[6]
    # Elements come slab by slab, as many in each.
    slabs = round(len(nodes) / len(butt)) - 1
    per_slab = (8, slabs, -1)
    height = ((points - ends[0]) @ along).reshape(per_slab)
    across = ((points - ends[0]) @ side).reshape(per_slab)
    volume = weights.reshape(per_slab)
    areas = volume.sum(axis=(0, 2)) / (length / slabs)
    middle = (volume * across).sum(axis=(0, 2)) / volume.sum(axis=(0, 2))
    inertia = (volume * (across - middle[:, None]) ** 2).sum(axis=(0, 2)) / (length / slabs)
    arm = length - (volume * height).sum(axis=(0, 2)) / volume.sum(axis=(0, 2))
    expected = (length / slabs) * (arm**2 / (modulus * inertia) + 1.11 / (shear * areas)).sum()
    force = [f"TOP,{k + 1},{side[k] / len(top):.9e}" for k in range(3)]
    step = ["*BOUNDARY", "BUTT,1,3", "*STEP", "*STATIC", "*CLOAD", *force, "*NODE PRINT, NSET=TOP", "U", "*END STEP", ""]
    with tempfile.TemporaryDirectory() as work:
        deck = pathlib.Path(work) / "bend"
        deck.with_suffix(".inp").write_text(path.read_text() + "\n".join(step))
        subprocess.run(["ccx", "-i", str(deck)], check=True, stdout=subprocess.DEVNULL, cwd=work)
        rows = [line.split() for line in deck.with_suffix(".dat").read_text().splitlines()]
    moved = np.array([[float(x) for x in row[1:]] for row in rows if len(row) == 4 and row[0].isdigit()])
    found = (moved.mean(axis=0) @ side).item()
    print(f"{path.parent.name}: CalculiX moves the tip by {found:.5g} m/N, beam theory by {expected:.5g}")
    assert abs(found / expected - 1) < MAX_BENDING_ERROR, (found, expected)


def main():
    folder = pathlib.Path(sys.argv[1])
    vtk.vtkObject.GlobalWarningDisplayOff()
    report = json.loads((folder / "anatomy.json").read_text())
    assert (report["schema"], report["version"]) == ("greenstick-anatomy", 1)
    assert "--open" in sys.argv or report["mesh_volume_m3"] is not None
    assert len(report["sections"]) == report["layers"]
    total = check_volume(folder, report)
    places = check_particles(folder, report)
    check_surface(folder, report, places)
    check_provenance(folder, report)
    check_tables(folder, report)
    check_cores(folder, report)
    check_elements(folder, report)
    pictures = list(folder.glob("section_*.png")) + [folder / "longitudinal.png"]
    for path in pictures:
        image = read(vtk.vtkPNGReader(), path)
        levels = vtk_to_numpy(image.GetPointData().GetScalars())
        assert levels.std() > 5, path
    print(
        f"{folder.name}: {len(report['segments'])} segments, {total:.6g} m³ of voxels, {len(places)} particles, "
        f"{len(pictures)} pictures: read by vtk {vtk.vtkVersion().GetVTKVersion()}, pyarrow, numpy, trimesh"
    )


if __name__ == "__main__":
    main()
