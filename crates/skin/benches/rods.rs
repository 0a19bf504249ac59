//! How long the skin of 100 rods of 30 vertices takes: to be made, and to be put where the rods are in a frame.
//!
//! `cargo bench -p greenstick-skin --bench rods`

use glam::DAffine3;
use greenstick_fibre::Loads;
use greenstick_fibre::State;
use greenstick_fibre::placement::{PlacementOptions, RodCount, WoodMaterial, fill_stem};
use greenstick_fibre::store::Frame;
use greenstick_fibre::topology::break_up;
use greenstick_geometry::{Context, Film, Joint};
use greenstick_skin::rods::{
    FractureState, Materials, RodSkinOptions, Wood, frame_poses, rod_skin,
};
use greenstick_skin::texture::SectionSquare;
use greenstick_wood::moisture::Fallback;
use greenstick_wood::noise::unit;
use greenstick_wood::primitive;
use greenstick_wood::species::Species;
use greenstick_wood::stem::{StemOptions, find_stem};
use std::collections::BTreeMap;
use std::hint::black_box;
use std::time::Instant;

fn median(times: usize, mut work: impl FnMut()) -> f64 {
    let mut taken: Vec<f64> = (0..times)
        .map(|_| {
            let start = Instant::now();
            work();
            start.elapsed().as_secs_f64() * 1e3
        })
        .collect();
    taken.sort_by(f64::total_cmp);
    taken[times / 2]
}

fn main() {
    let oak = Species::find("white oak").expect("the table has it");
    let material =
        WoodMaterial::from_species(oak, 12.0, Fallback::Refuse).expect("oak is known dry");
    println!("rods vertices broken_rods fibres triangles made_ms points_ms points_and_normals_ms");
    for (rods, part) in [(100, 0.0), (100, 0.02), (400, 0.02)] {
        let stem = find_stem(
            &[primitive::cylinder(0.005, 0.15, 48)],
            &"0.5".parse().expect("a fraction"),
            &StemOptions::default(),
            &Context::quiet(),
        )
        .expect("a cylinder is a stem")
        .stem;
        let options = PlacementOptions {
            rods: RodCount::Number(rods),
            ..PlacementOptions::default()
        };
        let placed = fill_stem(&stem, &material, &options, &Context::quiet()).expect("rods fit");
        let wood = Wood {
            stem: &stem,
            stem_to_rods: DAffine3::IDENTITY,
            bundle: &placed.bundle,
            along: &placed.along,
            cells: &placed.cells,
            outline: &placed.outline,
            bark: None,
            pull_out: material.tension / (4.0 * material.shear),
        };
        let mut bundle = placed.bundle.clone();
        let mut state = State::at_rest(&bundle);
        let chosen = |what: u64, n: usize, part: f64| -> Vec<u32> {
            let chosen = |i: &u32| unit(what, i64::from(*i), 0, 0) < part;
            (0..n as u32).filter(chosen).collect()
        };
        let bonds = chosen(1, bundle.bonds.len(), 5.0 * part);
        let splits = chosen(2, bundle.vertices(), part);
        break_up(
            &mut bundle,
            &mut state,
            &mut Loads::default(),
            &bonds,
            &splits,
        );
        let frame = Frame::capture(&bundle, &state, &[]);
        let state =
            FractureState::from_frame(&wood, &frame, &BTreeMap::new()).expect("it is its own");
        let square = SectionSquare {
            middle: glam::DVec2::ZERO,
            side: 0.01,
        };
        let materials = Materials {
            inner: 0,
            bark: 1,
            bark_mesh_offset: 2,
            square,
            zone: &|_| 0,
        };
        for fibres in [1, 4] {
            let options = RodSkinOptions {
                fibres,
                ..RodSkinOptions::default()
            };
            let make = || rod_skin(&wood, &state, &materials, &options).expect("it has a skin");
            let made = median(5, || drop(black_box(make())));
            let skin = make();
            let joint = |&rest| Joint {
                name: String::new(),
                rest,
            };
            let film = Film {
                joints: skin.joints.rest.iter().map(joint).collect(),
                pieces: skin.pieces,
                frames_per_second: 30.0,
                ..Film::default()
            };
            let (mut maps, mut out) = (Vec::new(), Vec::new());
            let mut frame_of = |normals: bool| {
                median(21, || {
                    film.joint_maps(&frame_poses(&skin.joints, &frame), &mut maps);
                    for piece in 0..film.pieces.len() {
                        film.deform_positions(piece, &maps, &mut out);
                        black_box(&out);
                        if normals {
                            film.deform_normals(piece, &maps, &mut out);
                            black_box(&out);
                        }
                    }
                })
            };
            let (points, both) = (frame_of(false), frame_of(true));
            let triangles: usize = film.pieces.iter().map(|p| p.mesh.triangles.len()).sum();
            let vertices = placed.bundle.vertices();
            let broken = state.broken_rods();
            println!(
                "{rods} {vertices} {broken} {fibres} {triangles} {made:.1} {points:.2} {both:.2}"
            );
        }
    }
}
