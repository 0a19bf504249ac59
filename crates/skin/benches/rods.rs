//! How long the skin of 100 rods of 30 vertices takes: to be made, and to be put where the rods are in a frame.
//!
//! `cargo bench -p greenstick-skin --bench rods`

use glam::DAffine3;
use greenstick_fibre::Loads;
use greenstick_fibre::State;
use greenstick_fibre::placement::{
    PlacedRods, PlacementOptions, RodCount, WoodMaterial, fill_stem,
};
use greenstick_fibre::store::Frame;
use greenstick_fibre::topology::break_up;
use greenstick_geometry::{Context, Film, Joint};
use greenstick_skin::rods::{
    FractureState, Joints, Materials, RodSkinOptions, Wood, frame_poses, rod_skin,
};
use greenstick_skin::texture::SectionSquare;
use greenstick_wood::moisture::Fallback;
use greenstick_wood::noise::unit;
use greenstick_wood::primitive;
use greenstick_wood::species::Species;
use greenstick_wood::stem::{Stem, StemLocation, StemOptions, find_stem};
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

/// A cylinder filled with rods.
struct FilledCylinder {
    stem: Stem,
    placed: PlacedRods,
    pull_out: f64,
}

impl FilledCylinder {
    fn new(rods: u32) -> Self {
        let oak = Species::find("white oak").expect("the table has it");
        let material =
            WoodMaterial::from_species(oak, 12.0, Fallback::Refuse).expect("oak is known dry");
        let stem = find_stem(
            &[primitive::cylinder(0.005, 0.15, 48)],
            &StemLocation::Fraction(0.5),
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
        FilledCylinder {
            stem,
            placed,
            pull_out: material.tension / (4.0 * material.shear),
        }
    }

    fn wood(&self) -> Wood<'_> {
        Wood {
            stem: &self.stem,
            stem_to_rods: DAffine3::IDENTITY,
            bundle: &self.placed.bundle,
            along: &self.placed.along,
            cells: &self.placed.cells,
            outline: &self.placed.outline,
            bark: None,
            pull_out: self.pull_out,
        }
    }

    /// A frame in which this fraction of the vertices are broken, and five times that of the bonds.
    fn broken_frame(&self, fraction: f64) -> Frame {
        let mut bundle = self.placed.bundle.clone();
        let mut state = State::at_rest(&bundle);
        let choose = |purpose: u64, count: usize, fraction: f64| -> Vec<u32> {
            let chosen = |i: &u32| unit(purpose, i64::from(*i), 0, 0) < fraction;
            (0..count as u32).filter(chosen).collect()
        };
        let bonds = choose(1, bundle.bonds.len(), 5.0 * fraction);
        let splits = choose(2, bundle.vertices(), fraction);
        let mut loads = Loads::default();
        break_up(&mut bundle, &mut state, &mut loads, &bonds, &splits);
        Frame::capture(&bundle, &state, &[])
    }
}

/// Median time of deforming a film's pieces to a frame, ms.
fn deform_time(film: &Film, joints: &Joints, frame: &Frame, with_normals: bool) -> f64 {
    let (mut maps, mut out) = (Vec::new(), Vec::new());
    median(21, || {
        film.joint_maps(&frame_poses(joints, frame), &mut maps);
        for piece in 0..film.pieces.len() {
            film.deform_positions(piece, &maps, &mut out);
            black_box(&out);
            if with_normals {
                film.deform_normals(piece, &maps, &mut out);
                black_box(&out);
            }
        }
    })
}

fn measure(rods: u32, broken_fraction: f64) {
    let filled = FilledCylinder::new(rods);
    let wood = filled.wood();
    let frame = filled.broken_frame(broken_fraction);
    let state = FractureState::from_frame(&wood, &frame, &BTreeMap::new()).expect("it is its own");
    let square = SectionSquare::round(glam::DVec2::ZERO, 0.01);
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
        let [points, both] = [false, true].map(|n| deform_time(&film, &skin.joints, &frame, n));
        let triangles: usize = film.pieces.iter().map(|p| p.mesh.triangles.len()).sum();
        let (vertices, broken) = (filled.placed.bundle.vertices(), state.broken_rods());
        println!("{rods} {vertices} {broken} {fibres} {triangles} {made:.1} {points:.2} {both:.2}");
    }
}

fn main() {
    println!("rods vertices broken_rods fibres triangles made_ms points_ms points_and_normals_ms");
    for (rods, broken_fraction) in [(100, 0.0), (100, 0.02), (400, 0.02)] {
        measure(rods, broken_fraction);
    }
}
