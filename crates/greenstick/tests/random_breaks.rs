//! Random parameters over the whole of their ranges: pieces are always closed and add up.

use greenstick::fracture::parameters::BreakParameters;
use greenstick::geometry::{Context, Mesh, Node, Scene};
use greenstick::wood::{noise, primitive, stem};

fn scene(mesh: Mesh) -> Scene {
    let node = Node {
        name: "stem".into(),
        transform: glam::DAffine3::IDENTITY,
        mesh,
        parent: None,
    };
    Scene {
        nodes: vec![node],
        ..Scene::default()
    }
}

#[test]
fn a_default_break_of_the_built_in_branch_is_sound() {
    let mesh = primitive::branch(&Default::default());
    let volume = mesh.volume();
    let t = std::time::Instant::now();
    let prepared = greenstick::prepare(
        scene(mesh),
        &stem::Place::Fraction(0.5),
        &Default::default(),
        0.0,
        &Context::quiet(),
    )
    .unwrap();
    eprintln!(
        "prepare {:?} radius {} usable {:?} place {} limb {} parted {} reach {:?} bark {}",
        t.elapsed(),
        prepared.found.stem.radius,
        prepared.found.stem.usable,
        prepared.found.stem.place,
        prepared.found.limb.len(),
        prepared.parted,
        prepared.reach,
        prepared.bark
    );
    for seed in 0..6 {
        for surface in ["fibrous", "smooth"] {
            let mut p = BreakParameters {
                seed,
                ..Default::default()
            };
            use greenstick::fracture::parameters::Parameters;
            p.set_text("surface", surface).unwrap();
            let t = std::time::Instant::now();
            let model = prepared.model(&p, 1.0, 1).unwrap();
            let time = t.elapsed();
            {
                let l = &model.bundles.layout;
                let bad: Vec<_> = l
                    .facets
                    .iter()
                    .enumerate()
                    .filter(|(_, f)| {
                        let [a, b, c] = f.map(|n| l.nodes[n as usize]);
                        (b - a).perp_dot(c - a) <= 0.0
                    })
                    .map(|(i, f)| {
                        (
                            i,
                            model.bundles.bundles[l.cells[i] as usize].ring,
                            f.map(|n| model.bundles.addresses[n as usize]),
                        )
                    })
                    .collect();
                eprintln!(
                    "bad facets {} of {} {:?}",
                    bad.len(),
                    l.facets.len(),
                    &bad[..bad.len().min(4)]
                );
            }
            let mut sum = 0.0;
            for (name, piece) in [("lower", &model.lower), ("upper", &model.upper)] {
                let report = piece.check();
                eprintln!(
                    "{seed} {surface} {name} {time:?} {} triangles\n{report}",
                    piece.triangles.len()
                );
                sum += piece.volume();
            }
            assert!((sum / volume - 1.0).abs() < 1e-9, "{sum} {volume}");
            let _ = noise::unit(1, 2, 3, 4);
        }
    }
}
