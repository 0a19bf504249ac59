mod common;
use common::*;
use greenstick_fibre::loads::Loads;
use greenstick_fibre::state::State;
use greenstick_fibre::store::Frame;
use greenstick_fibre::topology::break_up;
use greenstick_skin::rods::*;
use greenstick_wood::noise::unit;
use greenstick_wood::primitive::{self, BranchOptions};
use std::collections::BTreeMap;
#[test]
fn debug() {
    let seed: u64 = std::env::var("SEED").map_or(3, |s| s.parse().unwrap());
    let splinters: f64 = std::env::var("SPL").map_or(1.0, |s| s.parse().unwrap());
    let fibres: u32 = std::env::var("FIB").map_or(1, |s| s.parse().unwrap());
    let rp: f64 = std::env::var("RP").map_or(0.0, |s| s.parse().unwrap());
    let bp: f64 = std::env::var("BP").map_or(0.9, |s| s.parse().unwrap());
    let grown = if std::env::var("CYL").is_ok() {
        grown(primitive::cylinder(0.02, 0.3, 64), 30)
    } else {
        grown(primitive::branch(&BranchOptions::default()), 30)
    };
    let wood = wood(&grown);
    let mut bundle = grown.placed.bundle.clone();
    let mut state = State::at_rest(&bundle);
    let chosen = |what: u64, n: usize, part: f64| -> Vec<u32> {
        (0..n as u32)
            .filter(|i: &u32| unit(seed ^ what, i64::from(*i), 0, 0) < part)
            .collect()
    };
    let bonds = chosen(0xb0, bundle.bonds.len(), bp);
    let splits = chosen(0x0d, bundle.vertices(), rp);
    break_up(
        &mut bundle,
        &mut state,
        &mut Loads::default(),
        &bonds,
        &splits,
    );
    let frame = Frame::of(&bundle, &state, &[]);
    let parting = Parting::of(&wood, &frame, &BTreeMap::new()).unwrap();
    let options = RodSkinOptions {
        seed,
        fibres,
        splinters,
        ..RodSkinOptions::default()
    };
    let made = rod_skin(&wood, &parting, &MATERIALS, &options).unwrap();
    let mut total = 0;
    for piece in &made.pieces {
        let r = piece.mesh.check();
        let Some(s) = &r.self_intersections else {
            continue;
        };
        total += s.crossing;
        if s.crossing == 0 {
            continue;
        }
        if std::env::var("SHOW").is_err() {
            continue;
        }
        println!("{} crossing {}", piece.name, s.crossing);
        let g = &piece.mesh.attributes["_GRAIN"];
        for p in s.crossing_places.iter().take(3) {
            println!("at {p:?}");
            for (t, tri) in piece.mesh.triangles.iter().enumerate() {
                let c = piece.mesh.corners(t);
                let inside = (0..3).all(|k| {
                    let lo = c.iter().map(|c| c[k]).fold(f64::INFINITY, f64::min);
                    let hi = c.iter().map(|c| c[k]).fold(f64::NEG_INFINITY, f64::max);
                    p[k] >= lo - 3e-6 && p[k] <= hi + 3e-6
                });
                let n = (c[1] - c[0]).cross(c[2] - c[0]).normalize_or_zero();
                let off = (glam::DVec3::from_array(*p) - c[0]).dot(n).abs();
                if inside && off < 3e-6 {
                    println!(
                        "  t{t} {:?} n {:.2?} off {off:.1e}",
                        tri.map(|v| {
                            let a = g.at(v as usize);
                            [a[0] * 1e3, a[1] * 1e3, a[2] * 1e3]
                        }),
                        n.to_array()
                    );
                }
            }
        }
    }
    println!("TOTAL {total} pieces {}", made.pieces.len());
}
