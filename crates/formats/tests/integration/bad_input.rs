//! Invalid files, by symptom: readers return an error that says what is wrong and where, and never panic.

use crate::common::{read_alone, two_cubes};
use greenstick_formats::{Format, FormatError, LengthUnit, UnknownUnit, write};

/// Asserts that reading fails with a message that contains all of `parts`.
fn refused(format: Format, bytes: impl AsRef<[u8]>, parts: &[&str]) -> FormatError {
    let error = read_alone(format, bytes.as_ref()).expect_err("the file was read");
    let text = error.to_string();
    assert!(text.starts_with("sample: "), "{text}");
    for part in parts {
        assert!(text.contains(part), "no `{part}` in: {text}");
    }
    error
}

fn ply(vertices: &str, faces: &str) -> String {
    let count = |text: &str| text.lines().count();
    format!(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
         element face {}\nproperty list uchar int vertex_indices\nend_header\n{vertices}\n{faces}\n",
        count(vertices),
        count(faces)
    )
}

/// A glTF file with one triangle, whose JSON is modified by `change`.
fn gltf(change: impl Fn(&mut serde_json::Value)) -> Vec<u8> {
    let mut bytes = Vec::new();
    for v in [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0] {
        bytes.extend(v.to_le_bytes());
    }
    bytes.extend([0, 0, 1, 0, 2, 0]);
    let escaped: String = bytes.iter().map(|b| format!("%{b:02X}")).collect();
    let mut json = serde_json::json!({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5123, "count": 3, "type": "SCALAR"}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}, {"buffer": 0, "byteOffset": 36, "byteLength": 6}],
        "buffers": [{"byteLength": 42, "uri": format!("data:application/octet-stream,{escaped}")}]
    });
    change(&mut json);
    json.to_string().into_bytes()
}

fn binary_stl(claimed: u32, facets: &[[f32; 12]]) -> Vec<u8> {
    let mut bytes = vec![b' '; 80];
    bytes.extend(claimed.to_le_bytes());
    for facet in facets {
        facet.iter().for_each(|v| bytes.extend(v.to_le_bytes()));
        bytes.extend([0, 0]);
    }
    bytes
}

#[test]
fn the_unmodified_samples_are_valid() {
    assert_eq!(
        read_alone(Format::Gltf, &gltf(|_| ())).unwrap().nodes[0]
            .mesh
            .triangles
            .len(),
        1
    );
    read_alone(
        Format::Ply,
        ply("0 0 0\n1 0 0\n0 1 0", "3 0 1 2").as_bytes(),
    )
    .unwrap();
    let facet = [0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    read_alone(Format::Stl, &binary_stl(1, &[facet])).unwrap();
}

#[test]
fn empty_files() {
    for format in Format::ALL {
        assert!(matches!(
            refused(format, "", &["empty"]),
            FormatError::Empty { .. }
        ));
        refused(format, " \n\r\n", &["empty"]);
    }
}

#[test]
fn other_content() {
    let prose = "Dear Sir,\nplease find enclosed no mesh at all.\n";
    for format in Format::ALL {
        refused(
            format,
            prose,
            &["sample", format.name().trim_start_matches("GLB")],
        );
        refused(format, [0xff, 0xfe, 0x00, 0x80].repeat(50), &["sample"]);
    }
    refused(Format::Gltf, "{\"asset\": \"\u{fffd}\"", &["JSON"]);
    refused(Format::Gltf, b"{\"asset\": \"\xff\xff\"}", &["JSON"]);
    refused(Format::Gltf, "{}", &["asset"]);
}

#[test]
fn coordinates_that_are_not_finite() {
    refused(
        Format::Obj,
        "v 0 0 0\nv 1 nan 0\nv 0 1 0\nf 1 2 3",
        &["line 2", "vertex 1", "NaN"],
    );
    refused(Format::Obj, "v 0 0 0\nv 1 x 0\nf 1 2 3", &["line 2", "`x`"]);
    refused(Format::Obj, "v 0 0\n", &["line 1", "three numbers"]);
    refused(
        Format::Ply,
        ply("0 0 0\n1 0 0\n0 inf 0", "3 0 1 2"),
        &["vertex 2", "inf"],
    );
    refused(
        Format::Off,
        "OFF\n3 1 0\n0 0 0\n1 nan 0\n0 1 0\n3 0 1 2",
        &["vertex 1", "NaN"],
    );
    let mut facet = [0.0; 12];
    facet[7] = f32::INFINITY;
    refused(
        Format::Stl,
        binary_stl(1, &[facet]),
        &["facet 0", "vertex 1", "inf"],
    );
    let text = "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 nan 0\n";
    refused(Format::Stl, text, &["line 5", "NaN"]);
    let nan: String = "%00%00%C0%7F".repeat(9);
    let uri = format!("data:,{nan}{}", "%00".repeat(6));
    refused(
        Format::Gltf,
        gltf(|j| j["buffers"][0]["uri"] = uri.clone().into()),
        &["meshes[0].primitives[0] POSITION", "vertex 0", "NaN"],
    );
}

#[test]
fn faces_with_vertices_that_do_not_exist() {
    refused(
        Format::Obj,
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4",
        &["line 4", "vertex 4", "of 3"],
    );
    refused(
        Format::Obj,
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nf -1 -2 -4",
        &["line 4", "-4"],
    );
    refused(
        Format::Obj,
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 0 1 2",
        &["line 4", "vertex 0"],
    );
    refused(
        Format::Obj,
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1/1 2/1 3/1",
        &["`vt`"],
    );
    refused(
        Format::Ply,
        ply("0 0 0\n1 0 0\n0 1 0", "3 0 1 2\n3 0 1 -1"),
        &["face 1", "vertex -1"],
    );
    refused(
        Format::Off,
        "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3",
        &["face 0", "vertex 3"],
    );
    refused(
        Format::Gltf,
        gltf(|j| j["bufferViews"][1]["byteOffset"] = 30.into()),
        &["meshes[0].primitives[0]", "vertex", "of 3"],
    );
}

#[test]
fn huge_counts() {
    let header = ply("0 0 0", "3 0 0 0").replace("vertex 1\n", "vertex 1000000000\n");
    let error = refused(Format::Ply, &header, &["vertex claims 1000000000"]);
    assert!(matches!(error, FormatError::CountTooLarge { .. }));
    let binary = header.replace("ascii", "binary_little_endian");
    refused(Format::Ply, binary, &["vertex claims 1000000000"]);
    let list = ply("0 0 0\n1 0 0\n0 1 0", "3 0 1 2").replace("list uchar", "list uint");
    refused(
        Format::Ply,
        list.replace("\n3 0 1", "\n1000000000 0 1"),
        &["list in row 0 of face"],
    );
    refused(
        Format::Off,
        "OFF\n1000000000 1 0\n0 0 0\n",
        &["vertices claims 1000000000"],
    );
    refused(
        Format::Off,
        "OFF\n1 1000000000 0\n0 0 0\n",
        &["faces claims 1000000000"],
    );
    refused(
        Format::Stl,
        binary_stl(1_000_000_000, &[]),
        &["facets claims 1000000000"],
    );
    let big = 1_000_000_000;
    for accessor in 0..2 {
        let bytes = gltf(|j| j["accessors"][accessor]["count"] = big.into());
        refused(Format::Gltf, bytes, &["claims 1000000000", "accessors["]);
    }
    let unbacked = gltf(|j| {
        j["accessors"][0]["count"] = big.into();
        j["accessors"][0]
            .as_object_mut()
            .unwrap()
            .remove("bufferView");
    });
    refused(Format::Gltf, unbacked, &["claims 1000000000"]);
    let zeros = gltf(|j| {
        let accessor = j["accessors"][0].as_object_mut().unwrap();
        accessor.remove("bufferView");
    });
    refused(
        Format::Gltf,
        zeros,
        &["accessors[0]", "neither a bufferView"],
    );
}

#[test]
fn truncated_files() {
    refused(
        Format::Ply,
        "ply\nformat ascii 1.0\nelement vertex 3\n",
        &["header", "end too early"],
    );
    let whole = ply("0 0 0\n1 0 0\n0 1 0", "3 0 1 2");
    refused(
        Format::Ply,
        whole.replace("\n3 0 1 2", "\n3 0 1"),
        &["face", "row 0"],
    );
    refused(
        Format::Off,
        "OFF\n3 1 0\n0 0 0\n1 0 0\n",
        &["vertices", "after 2"],
    );
    let text = "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n";
    refused(Format::Stl, text, &["facet at line 2", "after 2 vertices"]);
    let glb = &write(Format::Glb, &two_cubes(), "x.glb", LengthUnit::Metre).unwrap()[0].bytes;
    refused(
        Format::Glb,
        &glb[..glb.len() - 8],
        &["GLB header", "too early"],
    );
    refused(Format::Gltf, &gltf(|_| ())[..200], &["JSON", "too early"]);
    let short = gltf(|j| j["buffers"][0]["byteLength"] = 50.into());
    refused(Format::Gltf, short, &["buffers[0]", "42 bytes", "50 bytes"]);
}

#[test]
fn missing_companions() {
    let bytes = gltf(|j| j["buffers"][0]["uri"] = "gone%20away.bin".into());
    refused(Format::Gltf, bytes, &["gone away.bin"]);
    let scene = read_alone(
        Format::Obj,
        b"mtllib a.mtl\nusemtl x\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3",
    );
    let scene = scene.unwrap();
    assert!(scene.notes[0].contains("a.mtl") && scene.materials[0].name == "x");
}

#[test]
fn cyclic_nodes() {
    let bytes =
        gltf(|j| j["nodes"] = serde_json::json!([{"children": [1]}, {"children": [0], "mesh": 0}]));
    refused(Format::Gltf, bytes, &["nodes[0]", "second time"]);
    let bytes = gltf(|j| j["nodes"] = serde_json::json!([{"children": [7]}]));
    refused(Format::Gltf, bytes, &["nodes[7]", "does not exist"]);
}

#[test]
fn too_many_instances_of_a_mesh() {
    let placed = |times: usize| {
        gltf(|j| {
            j["nodes"] = vec![serde_json::json!({"mesh": 0}); times].into();
            j["scenes"][0]["nodes"] = (0..times).collect::<Vec<_>>().into();
            j["accessors"][0] = serde_json::json!({
                "componentType": 5126, "count": 1 << 20, "type": "VEC3",
                "sparse": {
                    "count": 3,
                    "indices": {"bufferView": 1, "componentType": 5123},
                    "values": {"bufferView": 0},
                },
            });
        })
    };
    assert_eq!(read_alone(Format::Gltf, &placed(3)).unwrap().nodes.len(), 3);
    refused(
        Format::Gltf,
        placed(200),
        &["nodes", "with every instance counted"],
    );
}

#[test]
fn unsupported_features() {
    let required = |name: &str| gltf(|j| j["extensionsRequired"] = serde_json::json!([name]));
    refused(
        Format::Gltf,
        required("KHR_draco_mesh_compression"),
        &["Draco", "export it again"],
    );
    refused(Format::Gltf, required("VENDOR_odd"), &["VENDOR_odd"]);
    read_alone(Format::Gltf, &required("KHR_materials_unlit")).unwrap();
    refused(
        Format::Gltf,
        gltf(|j| j["asset"]["version"] = "1.0".into()),
        &["version 1.0"],
    );
    refused(Format::Off, "OFF BINARY\n", &["binary OFF"]);
}

#[test]
fn meshes_without_faces() {
    refused(
        Format::Obj,
        "v 0 0 0\nv 1 0 0\n",
        &["2 points and no faces"],
    );
    refused(
        Format::Off,
        "OFF\n1 0 0\n0 0 0\n",
        &["1 points and no faces"],
    );
    refused(
        Format::Gltf,
        gltf(|j| j["meshes"][0]["primitives"][0]["mode"] = 0.into()),
        &["no triangles"],
    );
    refused(Format::Stl, "solid a\nendsolid a\n", &["no triangles"]);
}

#[test]
fn scenes_that_cannot_be_written() {
    let broken = |change: &dyn Fn(&mut greenstick_geometry::Scene), part: &str| {
        for format in Format::ALL {
            let mut scene = two_cubes();
            change(&mut scene);
            let error = write(format, &scene, "x", LengthUnit::Metre)
                .unwrap_err()
                .to_string();
            assert!(error.contains(part), "{format:?}: {error}");
        }
    };
    broken(
        &|s| s.nodes[1].mesh_mut().triangles[3][1] = 99,
        "triangle 3 of node 1 (twig)",
    );
    broken(
        &|s| s.nodes[0].mesh_mut().positions[5].y = f64::NAN,
        "vertex 5 of node 0 (base)",
    );
    broken(&|s| s.nodes[0].mesh_mut().positions[5].y = 1e39, "32-bit");
    broken(&|s| s.nodes.clear(), "no triangles");
    broken(
        &|s| {
            s.nodes[0]
                .mesh_mut()
                .attributes
                .get_mut("_RING")
                .unwrap()
                .data
                .truncate(3)
        },
        "_RING",
    );
    assert_eq!(
        "ft".parse::<LengthUnit>(),
        Err(UnknownUnit("ft".to_owned()))
    );
}

#[test]
fn content_takes_precedence_over_the_name() {
    let glb = &write(Format::Glb, &two_cubes(), "x.glb", LengthUnit::Metre).unwrap()[0].bytes;
    let scene = read_alone(Format::Gltf, glb).unwrap();
    assert!(scene.notes[0].contains("holds GLB"), "{:?}", scene.notes);
    let text = ply("0 0 0\n1 0 0\n0 1 0", "3 0 1 2");
    assert_eq!(
        read_alone(Format::Stl, text.as_bytes())
            .unwrap()
            .nodes
            .len(),
        1
    );
}
