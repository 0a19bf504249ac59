"""Reads what `greenstick anatomy` wrote with foreign readers: VTK's own, pyarrow, numpy, trimesh.

Usage: validate_anatomy.py FOLDER [--open]
With --open the mesh was open, so its volume is not known. Needs vtk, pyarrow, numpy and trimesh.
"""

import json
import pathlib
import sys

import numpy as np
import pyarrow.parquet
import trimesh
import vtk
from vtk.util.numpy_support import vtk_to_numpy

NO_WOOD = 255


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
