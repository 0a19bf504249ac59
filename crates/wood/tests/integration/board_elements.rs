//! Finite elements of boards whose shape is known: they fill it, none is turned over, and they pass the patch test.

use glam::{DMat3, DQuat, DVec3};
use greenstick_geometry::{Context, Mesh};
use greenstick_wood::anatomy::{Anatomy, AnatomyOptions, ElasticWood, StemElements};
use greenstick_wood::appearance::WoodAppearance;
use greenstick_wood::primitive::board;
use greenstick_wood::species::Species;
use greenstick_wood::stem::{FoundStem, StemKind, StemOptions, find_stem};
use std::collections::BTreeMap;

const SIZE: [f64; 3] = [0.6, 0.12, 0.03];

/// Corners of a hexahedron in its own coordinates, in the order of its nodes.
const CORNERS: [[f64; 3]; 8] = [
    [-1.0, -1.0, -1.0],
    [1.0, -1.0, -1.0],
    [1.0, 1.0, -1.0],
    [-1.0, 1.0, -1.0],
    [-1.0, -1.0, 1.0],
    [1.0, -1.0, 1.0],
    [1.0, 1.0, 1.0],
    [-1.0, 1.0, 1.0],
];

/// Its faces.
const FACES: [[usize; 4]; 6] = [
    [0, 1, 2, 3],
    [4, 5, 6, 7],
    [0, 1, 5, 4],
    [1, 2, 6, 5],
    [2, 3, 7, 6],
    [3, 0, 4, 7],
];

/// A turned copy, off the origin.
fn turned(mut mesh: Mesh) -> Mesh {
    let turn = DQuat::from_scaled_axis(DVec3::new(0.7, -0.4, 1.1));
    for p in &mut mesh.positions {
        *p = turn * *p + DVec3::new(2.0, -1.0, 0.5);
    }
    mesh.attributes.clear();
    mesh
}

/// A board along z with a hole of `hole` (length and width) through its thickness y, in the middle.
fn with_hole(hole: [f64; 2]) -> Mesh {
    let [length, width, thickness] = SIZE;
    let mut mesh = Mesh::default();
    for y in [-0.5, 0.5] {
        for [l, w] in [[length, width], hole] {
            for (x, z) in [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)] {
                let p = DVec3::new(x * w, y * thickness, z * l);
                mesh.positions.push(p);
            }
        }
    }
    let mut quad = |a: u32, b: u32, c: u32, d: u32| {
        mesh.triangles.extend([[a, b, c], [a, c, d]]);
    };
    for k in 0..4 {
        let l = (k + 1) % 4;
        quad(k, l, 4 + l, 4 + k);
        quad(8 + l, 8 + k, 12 + k, 12 + l);
        quad(k, 8 + k, 8 + l, l);
        quad(4 + l, 12 + l, 12 + k, 4 + k);
    }
    mesh
}

/// A board whose grain is straight.
fn find(mesh: &Mesh) -> FoundStem {
    find_sloped(mesh, 0.0)
}

fn find_sloped(mesh: &Mesh, slope_of_grain: f64) -> FoundStem {
    let meshes = std::slice::from_ref(mesh);
    let options = StemOptions {
        slope_of_grain,
        ..StemOptions::default()
    };
    let found = find_stem(meshes, &"0.3".parse().unwrap(), &options, &Context::quiet()).unwrap();
    assert_eq!(found.stem.kind, StemKind::Board);
    found
}

fn divided(mesh: &Mesh, edge: Option<f64>) -> StemElements {
    divide(&find(mesh), mesh, edge)
}

fn divide(found: &FoundStem, mesh: &Mesh, edge: Option<f64>) -> StemElements {
    let options = AnatomyOptions {
        resolution: 64,
        ..AnatomyOptions::default()
    };
    let (wood, quiet) = (WoodAppearance::softwood(), Context::quiet());
    let anatomy = Anatomy::new(found, mesh, &options, wood, &quiet).unwrap();
    StemElements::new(&anatomy, edge, &quiet).unwrap()
}

/// The derivatives of positions by an element's own coordinates, and of shape functions, at a point of it.
fn jacobian(p: &[DVec3; 8], at: [f64; 3]) -> (DMat3, [DVec3; 8]) {
    let slopes = CORNERS.map(|c| {
        let factor = [0, 1, 2].map(|k| 0.5 * (1.0 + c[k] * at[k]));
        DVec3::new(
            0.5 * c[0] * factor[1] * factor[2],
            0.5 * c[1] * factor[0] * factor[2],
            0.5 * c[2] * factor[0] * factor[1],
        )
    });
    let column = |k: usize| (0..8).map(|n| p[n] * slopes[n][k]).sum::<DVec3>();
    (DMat3::from_cols(column(0), column(1), column(2)), slopes)
}

/// Nodal forces under a stress that is the same everywhere.
fn nodal_forces(stem: &StemElements, stress: DMat3) -> Vec<DVec3> {
    let gauss = [-1.0 / 3f64.sqrt(), 1.0 / 3f64.sqrt()];
    let mut forces = vec![DVec3::ZERO; stem.nodes.len()];
    for element in &stem.elements {
        let p = element.corners.map(|c| stem.nodes[c as usize]);
        for at in CORNERS.map(|c| c.map(|x| gauss[usize::from(x > 0.0)])) {
            let (j, slopes) = jacobian(&p, at);
            let (inverse, weight) = (j.inverse().transpose(), j.determinant());
            for (corner, slope) in element.corners.iter().zip(slopes) {
                forces[*corner as usize] += stress * (inverse * slope) * weight;
            }
        }
    }
    forces
}

/// Whether each node lies within, not on a face that one element has alone.
fn inner_nodes(stem: &StemElements) -> Vec<bool> {
    let mut faces: BTreeMap<[u32; 4], u32> = BTreeMap::new();
    for element in &stem.elements {
        for face in FACES {
            let mut key = face.map(|k| element.corners[k]);
            key.sort_unstable();
            *faces.entry(key).or_default() += 1;
        }
    }
    assert!(faces.values().all(|count| *count <= 2));
    let mut inner = vec![true; stem.nodes.len()];
    for (face, _) in faces.iter().filter(|(_, count)| **count == 1) {
        face.iter().for_each(|&n| inner[n as usize] = false);
    }
    inner
}

/// No element is turned over; axes are right-handed; a stress that is the same everywhere is in balance at all inner nodes, and
/// does the work of the whole volume.
fn check(stem: &StemElements) {
    for element in &stem.elements {
        let p = element.corners.map(|c| stem.nodes[c as usize]);
        for corner in CORNERS {
            let (j, _) = jacobian(&p, corner);
            let size = j.x_axis.length() * j.y_axis.length() * j.z_axis.length();
            let share = j.determinant() / size;
            assert!(share > 0.1, "{share} {p:?}");
        }
        let [l, r, t] = element.axes;
        assert!(l.cross(r).dot(t) > 0.999_999 && (t.length() - 1.0).abs() < 1e-9);
    }
    let (a, b, c) = (
        DVec3::new(3.0, 1.0, -0.5),
        DVec3::new(1.0, -2.0, 0.7),
        DVec3::new(-0.5, 0.7, 1.5),
    );
    let stress = DMat3::from_cols(a, b, c);
    let forces = nodal_forces(stem, stress);
    let inner = inner_nodes(stem);
    assert!(inner.iter().any(|i| *i));
    let largest = forces.iter().map(|f| f.length()).fold(0.0, f64::max);
    for (force, _) in forces.iter().zip(&inner).filter(|(_, inner)| **inner) {
        assert!(force.length() < 1e-9 * largest, "{force} of {largest}");
    }
    let strain = DMat3::from_diagonal(DVec3::new(1.0, 0.5, -2.0));
    let work: f64 = (forces.iter().zip(&stem.nodes))
        .map(|(f, x)| f.dot(strain * *x))
        .sum();
    let expected =
        (stress.x_axis.x + 0.5 * stress.y_axis.y - 2.0 * stress.z_axis.z) * stem.volume(|_| true);
    assert!((work / expected - 1.0).abs() < 1e-9, "{work} {expected}");
}

#[test]
fn hexahedra_fill_a_board_to_its_corners() {
    let [length, width, thickness] = SIZE;
    let mesh = turned(board(length, width, thickness));
    let stem = divided(&mesh, Some(0.25 * thickness));
    check(&stem);
    // Twice as long as wide.
    assert_eq!(stem.elements.len(), 40 * 16 * 4);
    assert_eq!(stem.end_nodes, [17 * 5; 2]);
    let volume = stem.volume(|_| true);
    assert!((volume / (length * width * thickness) - 1.0).abs() < 1e-6);
    let found = find(&mesh);
    let axis = found.stem.grain.axis();
    let along = (axis.frame(length).origin - axis.frame(0.0).origin).normalize();
    assert!(
        stem.elements
            .iter()
            .all(|e| e.axes[0].dot(along) > 0.999_999)
    );
    // Rings are arcs about the pith: farther from it is a later ring.
    let pith = axis.frame(0.0);
    let centre = found.stem.rings.pith();
    let centre = pith.origin + pith.x * centre.x + pith.y * centre.y;
    for element in &stem.elements {
        let place = element
            .corners
            .iter()
            .map(|&c| stem.nodes[c as usize])
            .sum::<DVec3>()
            / 8.0;
        let outwards = (place - centre).reject_from_normalized(along);
        assert!(
            element.axes[1].dot(outwards.normalize()) > 0.999,
            "{element:?}"
        );
    }
}

#[test]
fn elements_have_the_direction_of_sloping_grain() {
    let [length, width, thickness] = SIZE;
    let mesh = turned(board(length, width, thickness));
    let found = find_sloped(&mesh, 0.05);
    let stem = divide(&found, &mesh, Some(0.25 * thickness));
    let grain = &found.stem.grain;
    let along = grain.axis().frame(0.5 * length).tangent;
    let mut most: f64 = 0.0;
    for element in &stem.elements {
        let corners = element.corners.iter().map(|&c| stem.nodes[c as usize]);
        let place = grain.to_grain(corners.sum::<DVec3>() / 8.0);
        let fibre = |s: f64| grain.to_world(place.truncate().extend(s));
        let direction = (fibre(place.z + 1e-4) - fibre(place.z - 1e-4)).normalize();
        let off = element.axes[0].angle_between(direction);
        assert!(off < 2e-3, "{off}");
        most = most.max(element.axes[0].angle_between(along));
    }
    assert!(most > 0.03, "{most}");
}

#[test]
fn hexahedra_follow_the_taper_of_a_board() {
    let [length, width, thickness] = SIZE;
    let mut mesh = board(length, width, thickness);
    for p in &mut mesh.positions {
        let share = p.z / length + 0.5;
        (p.x, p.y) = (p.x * (1.0 - 0.3 * share), p.y * (1.0 - 0.1 * share));
    }
    let stem = divided(&turned(mesh), None);
    check(&stem);
    // The mean of (1 - 0.3 s)(1 - 0.1 s).
    let expected = length * width * thickness * (1.0 - 0.2 + 0.01);
    let volume = stem.volume(|_| true);
    assert!(
        (volume / expected - 1.0).abs() < 2e-3,
        "{volume} {expected}"
    );
}

#[test]
fn a_hole_through_a_board_has_no_elements() {
    let [length, width, thickness] = SIZE;
    for hole in [[0.1, 0.04], [0.123, 0.037]] {
        let mesh = turned(with_hole(hole));
        let solid = length * width * thickness;
        let expected = solid - hole[0] * hole[1] * thickness;
        for edge in [None, Some(0.004)] {
            let stem = divided(&mesh, edge);
            check(&stem);
            // Its ends are off by half of an element's length each; its sides, along the board, are where they are.
            let edge = edge.unwrap_or(0.25 * thickness);
            let bound = 2.0 * edge * hole[1] * thickness + 1e-3 * expected;
            let volume = stem.volume(|_| true);
            println!("{hole:?}: {volume} m³, in truth {expected}");
            assert!((volume - expected).abs() < bound, "{volume} {expected}");
            assert!(volume < solid - 0.5 * hole[0] * hole[1] * thickness);
        }
    }
}

#[test]
fn a_board_is_written_as_a_solid_of_sapwood() {
    let mesh = turned(board(SIZE[0], SIZE[1], SIZE[2]));
    let stem = divided(&mesh, Some(0.015));
    let wood = ElasticWood::new(Species::find("white oak").unwrap(), Some(12.0)).unwrap();
    let model = stem.solid_model(&wood.unwrap(), DVec3::ZERO);
    assert_eq!(model.nodes, stem.nodes);
    let names: Vec<&str> = model.parts.iter().map(|p| &*p.name).collect();
    assert_eq!(names, ["SAPWOOD"]);
    assert_eq!(model.parts[0].elements.len(), stem.elements.len());
    let sets: Vec<usize> = model.node_sets.iter().map(|s| s.nodes.len()).collect();
    assert_eq!(sets, [9 * 3, 9 * 3]);
}
