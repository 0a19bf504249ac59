//! Seams of texture coordinates whose sides differ in the last bits are no holes, and edges at which sheets meet none either.

use crate::support::data::data;
use glam::{DAffine3, DVec3};
use greenstick::fibre::scene;
use greenstick::fracture::recipe::Recipe;
use greenstick::geometry::{Attribute, Context, Mesh, Node, Scene};
use greenstick::simulate::{MemoryRun, SceneMeshes, SimulateRequest, simulate};
use greenstick::{Break, BreakRequest, break_scene};
use std::f64::consts::TAU;

/// A closed tube with a column of vertices of its own on either side of its seam, as sine and cosine make them.
fn tube() -> Mesh {
    let (rows, around) = (24u32, 20u32);
    let mut mesh = Mesh::default();
    let mut coordinates = Vec::new();
    for i in 0..=rows {
        let along = f64::from(i) / f64::from(rows);
        for j in 0..=around {
            let turn = f64::from(j) / f64::from(around);
            let (sin, cos) = (TAU * turn).sin_cos();
            mesh.positions
                .push(DVec3::new(0.03 * cos, 0.6 * along, 0.03 * sin));
            coordinates.extend([turn as f32, along as f32]);
        }
    }
    let columns = around + 1;
    for i in 0..rows {
        for j in 0..around {
            let (a, b) = (i * columns + j, (i + 1) * columns + j);
            mesh.triangles.extend([[a, b, b + 1], [a, b + 1, a + 1]]);
        }
    }
    for (row, y) in [(0, 0.0), (rows, 0.6)] {
        let middle = mesh.positions.len() as u32;
        mesh.positions.push(DVec3::new(0.0, y, 0.0));
        coordinates.extend([0.5, 0.5]);
        for j in 0..around {
            let (a, b) = (row * columns + j, row * columns + j + 1);
            mesh.triangles.push(if row == 0 {
                [middle, a, b]
            } else {
                [middle, b, a]
            });
        }
    }
    let data = Attribute {
        width: 2,
        data: coordinates,
    };
    mesh.attributes.insert("TEXCOORD_0".to_owned(), data);
    mesh
}

fn scene_of(mesh: Mesh) -> Scene {
    Scene {
        nodes: vec![Node::new("tube", DAffine3::IDENTITY, mesh)],
        ..Scene::default()
    }
}

#[test]
fn a_seam_that_differs_in_its_last_bits_is_closed_and_reported() {
    let mesh = tube();
    assert!(!mesh.check().closed, "its seam is open to the last bit");
    let vertices = mesh.positions.len();
    let scene = scene_of(mesh);
    let request = BreakRequest {
        texture_width: 16,
        ..BreakRequest::default()
    };
    let broken = break_scene(scene, &request, &Context::quiet()).unwrap();
    let input = &broken.report.input;
    assert!(input.closed, "{}", broken.report);
    let note = input.repairs.iter().find(|n| n.contains("seams"));
    let note = note.unwrap_or_else(|| panic!("{}", broken.report));
    assert!(
        note.contains("vertices were moved onto others within 6.1e-7 m"),
        "{note}"
    );
    for piece in &broken.report.pieces {
        assert!(piece.closed, "{}", broken.report);
    }
    // Either side keeps its own texture coordinates, beside those of the bark that it got.
    assert!(vertices > 24 * 20);
    let data = &broken.scene.nodes[0].mesh.attributes["TEXCOORD_1"].data;
    let us = || data.iter().step_by(2);
    assert!(us().any(|u| *u == 0.0) && us().any(|u| *u == 1.0));
}

#[test]
fn a_seam_that_differs_in_its_last_bits_is_closed_and_reported_in_simulations() {
    let text = "duration = 0.002\n[stem]\nkind = \"input\"\n[wood]\nstiffness = 0.002\n\
                [rods]\nnumber = 12\nedge = [\"10 cm\", \"12 cm\"]\n[[clamp]]\nto = 0.2\n";
    let request = SimulateRequest {
        scene: scene::Scene::read(text).unwrap(),
        meshes: SceneMeshes {
            input: Some(scene_of(tube())),
            ..SceneMeshes::default()
        },
        ..SimulateRequest::default()
    };
    let report = simulate(&request, &mut MemoryRun::new(), &Context::quiet()).unwrap();
    let notes = &report.notes;
    let seams: Vec<&String> = notes.iter().filter(|n| n.contains("seams")).collect();
    assert_eq!(seams.len(), 1, "{notes:?}");
    assert!(
        seams[0].contains("vertices were moved onto others within 6.1e-7 m"),
        "{notes:?}"
    );
    let filled = greenstick::fibre::simulate::fill_scene_stem(
        &request.scene,
        request.meshes.input.as_ref(),
        &Context::quiet(),
    );
    let mesh = &filled.unwrap().scene.nodes[0].mesh;
    assert!(mesh.check().closed, "what skins of the run are made of");
}

/// The scanned stump has an edge of four triangles, across which this break goes.
#[test]
fn a_break_goes_across_an_edge_of_more_than_two_triangles() {
    let scene = greenstick::files::read(&data("stump.glb"), None).unwrap();
    let report = scene.nodes[0].mesh.check();
    assert_eq!(report.non_manifold_edges, 1, "{report}");
    let request = BreakRequest {
        texture_width: 16,
        ..BreakRequest::single(Break {
            recipe: Recipe::resolve(&[], None, &["seed=2"]).unwrap(),
            ..Break::default()
        })
    };
    let broken = break_scene(scene, &request, &Context::quiet()).unwrap();
    let notes = &broken.report.input.repairs;
    assert!(
        notes.iter().any(|n| n.contains("shared 1 edge")),
        "{notes:?}"
    );
    // The lower piece is open at the ground.
    let upper = broken.scene.nodes.iter().find(|n| n.name.contains("upper"));
    let upper = upper.unwrap().mesh.check();
    assert!(upper.is_solid(), "{upper}");
}
