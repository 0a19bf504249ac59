//! What is around a stem: bark, planed wood around a dowel, weathered wood around a pole, and no bark in the bore of a tube.

use crate::support::scene;
use glam::DVec3;
use greenstick::geometry::{
    Context, Image, ImageSource, Material, Mesh, Scene, Texture, TextureReference,
};
use greenstick::wood::colour::RgbImage;
use greenstick::wood::primitive;
use greenstick::wood::stem::StemKind;
use greenstick::{BreakRequest, BreakSession, Broken};

fn broken(scene: &Scene, kind: Option<StemKind>) -> (Broken, bool) {
    let mut request = BreakRequest {
        texture_width: 32,
        ..BreakRequest::default()
    };
    request.stem.kind = kind;
    let mut session = BreakSession::new(scene.clone());
    let broken = session.broken(&request, &Context::quiet()).unwrap();
    let stages = session.stages(&request, &Context::quiet()).unwrap();
    let has_bark = stages.layout.bundles.bundles.iter().any(|b| b.bark);
    (broken, has_bark)
}

/// Names of the materials that triangles of the pieces have.
fn materials(broken: &Broken) -> Vec<&str> {
    let used = |m: u32| (broken.scene.nodes.iter()).any(|n| n.mesh.materials.contains(&m));
    let all = (0..).zip(&broken.scene.materials);
    let used = all.filter(|&(m, _)| used(m)).map(|(_, m)| &*m.name);
    used.collect()
}

#[test]
fn a_dowel_and_a_pole_have_no_bark() {
    let rod = primitive::cylinder(0.01, 0.4, 48);
    let rod = scene(rod, 1.0);
    for (kind, outside, barked) in [
        (Some(StemKind::Round), "bark", true),
        (Some(StemKind::Dowel), "planed_wood", false),
        (Some(StemKind::Pole), "weathered_wood", false),
    ] {
        let (broken, has_bark) = broken(&rod, kind);
        assert_eq!(has_bark, barked, "{kind:?}");
        assert_eq!(materials(&broken), [outside, "inner_wood", "sawn_wood"]);
        let report = &broken.report;
        assert_eq!(report.place.kind, kind.map_or("round", StemKind::word));
        let parts: f64 = report.pieces.iter().map(|p| p.volume_m3.unwrap()).sum();
        assert!((parts / report.input.volume_m3.unwrap() - 1.0).abs() < 1e-6);
        for node in broken.scene.nodes.iter().filter(|n| !n.is_detail) {
            assert_eq!(node.mesh.check().self_intersections.unwrap().crossing, 0);
        }
        // The pith of a dowel lies beside it, that of a pole within.
        let pith = glam::DVec2::from(report.place.pith_m).length();
        assert_eq!(pith > 0.01, kind == Some(StemKind::Dowel), "{pith}");
    }
}

#[test]
fn a_material_that_says_nothing_gives_way_to_bark_and_others_stay() {
    let plain = Material {
        name: "tree".to_owned(),
        base_color: [0.8, 0.8, 0.8, 1.0],
        ..Material::default()
    };
    let brown = Material {
        base_color: [0.4, 0.3, 0.2, 1.0],
        ..plain.clone()
    };
    let two = vec![plain.clone(), plain.clone()];
    for (materials_in, outside) in [
        (vec![plain], "bark"),
        (vec![brown], "tree"),
        // Names of several tell parts apart.
        (two, "tree"),
    ] {
        let mut rod = primitive::branch(&primitive::BranchOptions::default());
        rod.materials = vec![0; rod.triangles.len()];
        let mut input = scene(rod, 1.0);
        input.materials = materials_in;
        let (broken, _) = broken(&input, Some(StemKind::Round));
        let notes = broken.report.input.repairs.iter();
        let told = notes.filter(|n| n.contains("material \"tree\"")).count();
        assert_eq!(told, usize::from(outside == "bark"));
        assert_eq!(materials(&broken)[0], outside);
    }
}

/// A closed tube along +y from the origin, m.
fn tube(outer: f64, inner: f64, length: f64) -> Mesh {
    const AROUND: u32 = 48;
    const ROWS: u32 = 20;
    let mut mesh = Mesh::default();
    for radius in [outer, inner] {
        for row in 0..=ROWS {
            for k in 0..AROUND {
                let (sin, cos) =
                    libm::sincos(std::f64::consts::TAU * f64::from(k) / f64::from(AROUND));
                let y = length * f64::from(row) / f64::from(ROWS);
                (mesh.positions).push(DVec3::new(radius * cos, y, radius * sin));
            }
        }
    }
    let at = |wall: u32, row: u32, k: u32| (wall * (ROWS + 1) + row) * AROUND + k % AROUND;
    let mut quad = |a: u32, b: u32, c: u32, d: u32| mesh.triangles.extend([[a, b, c], [a, c, d]]);
    for k in 0..AROUND {
        for row in 0..ROWS {
            let [a, b] = [0, 1].map(|wall| {
                [
                    at(wall, row, k),
                    at(wall, row + 1, k),
                    at(wall, row + 1, k + 1),
                    at(wall, row, k + 1),
                ]
            });
            quad(a[0], a[1], a[2], a[3]);
            quad(b[3], b[2], b[1], b[0]);
        }
        quad(at(0, 0, k), at(0, 0, k + 1), at(1, 0, k + 1), at(1, 0, k));
        quad(
            at(1, ROWS, k),
            at(1, ROWS, k + 1),
            at(0, ROWS, k + 1),
            at(0, ROWS, k),
        );
    }
    mesh
}

#[test]
fn there_is_no_bark_in_the_bore_of_a_tube() {
    let tube = scene(tube(0.05, 0.03, 0.6), 1.0);
    let (broken, _) = broken(&tube, Some(StemKind::Round));
    let (mut in_bore, mut outside) = (0, 0);
    for node in &broken.scene.nodes {
        for (t, &material) in node.mesh.materials.iter().enumerate() {
            let name = &*broken.scene.materials[material as usize].name;
            let corners = node.mesh.corners(t);
            let off = corners.map(|p| p.x.hypot(p.z));
            if off.iter().all(|r| (r - 0.03).abs() < 5e-4) && name != "inner_wood" {
                assert_eq!(name, "sawn_wood");
                in_bore += 1;
            }
            outside += usize::from(off.iter().all(|r| *r > 0.049) && name == "bark");
        }
    }
    assert!(in_bore > 100 && outside > 100, "{in_bore} {outside}");
}

#[test]
fn plain_rods_are_dowels_or_poles_and_what_grew_has_bark() {
    let plain = |radius: f64, length: f64| primitive::cylinder(radius, length, 48);
    // Moved point by point: a bend, a taper, and a surface that is out of round.
    let moved = |move_to: &dyn Fn(DVec3) -> DVec3| {
        let mut rod = primitive::cylinder_of(0.01, 0.4, 48, 40);
        rod.positions.iter_mut().for_each(|p| *p = move_to(*p));
        rod
    };
    let bent = moved(&|p| p + DVec3::X * (0.02 * (p.y / 0.4 * 3.0).sin()));
    let tapered = moved(&|p| DVec3::new(p.x * (1.0 - 0.4 * p.y), p.y, p.z * (1.0 - 0.4 * p.y)));
    let uneven = moved(&|p| DVec3::new(p.x * 1.05, p.y, p.z));
    for (rod, kind) in [
        (plain(0.01, 0.4), StemKind::Dowel),
        (plain(0.06, 2.0), StemKind::Pole),
        (plain(0.06, 0.3), StemKind::Round),
        (bent, StemKind::Round),
        (tapered, StemKind::Round),
        (uneven, StemKind::Round),
    ] {
        let (broken, has_bark) = broken(&scene(rod, 1.0), None);
        assert_eq!(broken.report.place.kind, kind.word());
        assert_eq!(has_bark, kind == StemKind::Round);
        let noted = broken.report.to_string().contains("taken for a");
        assert_eq!(noted, kind != StemKind::Round);
    }
    // A texture could show bark.
    let mut painted = scene(plain(0.01, 0.4), 1.0);
    painted.nodes[0].mesh_mut().materials = vec![0; painted.nodes[0].mesh.triangles.len()];
    painted.materials = vec![Material {
        base_color_texture: Some(TextureReference {
            texture: 0,
            coordinates: 0,
            transform: None,
            strength: 1.0,
        }),
        ..Material::default()
    }];
    painted.textures = vec![Texture {
        image: Some(0),
        alternatives: Vec::new(),
        sampler: [None; 4],
    }];
    let white = RgbImage {
        width: 1,
        height: 1,
        rgb: vec![255; 3],
    };
    painted.images = vec![Image {
        name: "white".into(),
        mime_type: "image/png".into(),
        source: ImageSource::Bytes(white.png()),
    }];
    assert_eq!(broken(&painted, None).0.report.place.kind, "round");
}
