//! Rods and bonds in stems: areas, distances, sums of stiffness.

use super::fill::{PlacedRods, fill_stem};
use super::material::WoodMaterial;
use super::options::{Arrangement, EdgeLengths, PlacementError, PlacementOptions, RodCount};
use super::points::poisson_disk;
use super::voronoi::{is_inside, voronoi_cells};
use crate::energy::energies;
use crate::state::State;
use glam::DVec2;
use greenstick_geometry::{Context, Mesh};
use greenstick_wood::moisture::Fallback;
use greenstick_wood::primitive::{BranchOptions, board, branch, cylinder};
use greenstick_wood::species::Species;
use greenstick_wood::stem::{Stem, StemOptions, find_stem};
use std::f64::consts::{PI, TAU};

fn stem(mesh: Mesh) -> Stem {
    find_stem(
        &[mesh],
        &"0.5".parse().unwrap(),
        &StemOptions::default(),
        &Context::quiet(),
    )
    .unwrap()
    .stem
}

fn oak() -> WoodMaterial {
    let oak = Species::find("white oak").unwrap();
    WoodMaterial::from_species(oak, 12.0, Fallback::Refuse).unwrap()
}

fn circle(radius: f64) -> Vec<DVec2> {
    (0..256)
        .map(|k| TAU * f64::from(k) / 256.0)
        .map(|a| DVec2::new(a.cos(), a.sin()) * radius)
        .collect()
}

#[test]
fn poisson_disks_respect_their_distance_and_leave_no_hole() {
    let outline = circle(1.0);
    let sample = |seed: u64| poisson_disk(&outline, 0.1, seed, &Context::quiet()).unwrap();
    let points = sample(3);
    for (i, p) in points.iter().enumerate() {
        assert!(points[..i].iter().all(|q| q.distance(*p) >= 0.1));
    }
    // Hardly any position is farther than the distance from all points.
    let holes = (0..4000)
        .map(|k| {
            let (r, a) = (
                (f64::from(k) / 4000.0).sqrt() * 0.98,
                2.399963 * f64::from(k),
            );
            DVec2::new(a.cos(), a.sin()) * r
        })
        .filter(|p| points.iter().all(|q| q.distance(*p) > 0.1))
        .count();
    assert!(holes < 200, "{holes} of 4000");
    assert_eq!(points, sample(3));
    assert_ne!(points, sample(4));
}

#[test]
fn cells_fill_the_outline_and_facets_are_mutual() {
    let outline = circle(1.0);
    let area = 128.0 * (TAU / 256.0).sin();
    for points in [
        poisson_disk(&outline, 0.15, 1, &Context::quiet()).unwrap(),
        vec![DVec2::new(0.2, 0.1)],
    ] {
        let found = voronoi_cells(&outline, &points);
        let sum: f64 = found.iter().map(|c| c.area).sum();
        assert!((sum / area - 1.0).abs() < 1e-12, "{sum}");
        for (i, c) in found.iter().enumerate() {
            for facet in &c.facets {
                let mut others = found[facet.neighbour as usize].facets.iter();
                let back = others.find(|f| f.neighbour as usize == i);
                let same = back.is_some_and(|f| (f.width - facet.width).abs() < 1e-9);
                assert!(facet.width < 1e-9 || same);
            }
        }
        // Brute force: the cell that contains a position is that of the nearest point.
        for k in 0..500 {
            let p = DVec2::new(
                (f64::from(k) * 0.618) % 1.4 - 0.7,
                (f64::from(k) * 0.324) % 1.4 - 0.7,
            );
            let nearest = (0..points.len())
                .min_by(|&a, &b| points[a].distance(p).total_cmp(&points[b].distance(p)));
            let contains = (0..points.len()).find(|&i| is_inside(&found[i].corners, p));
            assert_eq!(contains, nearest);
        }
    }
}

/// Checks the stiffness of a cross-section with these area and second moments of area.
fn check_sums(placed: &PlacedRods, wood: &WoodMaterial, area: f64, second: [f64; 2]) {
    let b = &placed.bundle;
    let stretch: f64 = (0..b.rods()).map(|r| b.stretch[b.rod(r).start]).sum();
    assert!(
        (stretch / (wood.longitudinal * area) - 1.0).abs() < 2e-3,
        "{stretch}"
    );
    let whole: f64 = placed.cells.iter().map(|c| c.area).sum();
    let centre = placed
        .cells
        .iter()
        .fold(DVec2::ZERO, |s, c| s + c.centroid * (c.area / whole));
    for (axis, exact) in second.into_iter().enumerate() {
        let inertia: f64 = placed
            .cells
            .iter()
            .map(|c| c.area * (c.centroid - centre)[axis].powi(2) + c.area * c.area / (4.0 * PI))
            .sum();
        assert!(
            (inertia / exact - 1.0).abs() < 0.01,
            "axis {axis}: {inertia} {}",
            exact
        );
    }
}

#[test]
fn a_filled_cylinder_and_board_have_the_stiffness_and_mass_of_the_cross_section() {
    let wood = oak();
    for arrangement in [Arrangement::PoissonDisk, Arrangement::Anatomy] {
        let options = PlacementOptions {
            arrangement,
            rods: RodCount::Number(150),
            ..PlacementOptions::default()
        };
        let (radius, length) = (0.02, 0.4);
        let round = stem(cylinder(radius, length, 96));
        let placed = fill_stem(&round, &wood, &options, &Context::quiet()).unwrap();
        assert_eq!(placed.bundle.rods(), 150);
        assert!(!placed.bundle.twisting);
        let area = 48.0 * (TAU / 96.0).sin() * radius * radius;
        let quarter = PI * radius.powi(4) / 4.0 * (area / (PI * radius * radius)).powi(2);
        check_sums(&placed, &wood, area, [quarter; 2]);
        let reach = round.usable.1 - round.usable.0;
        let mass = wood.density * area * reach;
        assert!((placed.bundle.total_mass() / mass - 1.0).abs() < 2e-3);
        // Facets times distances cover the cross-section twice, each shared by two vertices' bonds: S sums to ½ G V, but for
        // the outline.
        let shear: f64 = placed.bundle.bonds.shear.iter().sum();
        let mean = 0.5 * (wood.shear_radial + wood.shear_tangential);
        let ratio = shear / (mean * area * reach);
        assert!((0.75..1.05).contains(&ratio), "{ratio}");
        let (width, height) = (0.05, 0.03);
        let plank = stem(board(0.4, width, height));
        let placed = fill_stem(&plank, &wood, &options, &Context::quiet()).unwrap();
        assert_eq!(placed.bundle.rods(), 150);
        let (i, j) = (width * height.powi(3) / 12.0, height * width.powi(3) / 12.0);
        let wide = placed.outline.iter().fold(0.0f64, |a, p| a.max(p.x.abs())) > 0.02;
        check_sums(
            &placed,
            &wood,
            width * height,
            if wide { [j, i] } else { [i, j] },
        );
    }
}

#[test]
fn a_curved_tapering_branch_is_filled_at_rest() {
    let curved = stem(branch(&BranchOptions::default()));
    let options = PlacementOptions {
        rods: RodCount::Spacing(6e-3),
        weibull: 8.0,
        ..PlacementOptions::default()
    };
    let placed = fill_stem(&curved, &oak(), &options, &Context::quiet()).unwrap();
    let b = &placed.bundle;
    assert!(b.twisting && b.rods() > 15);
    let state = State::at_rest(b);
    let energies = energies(b, &state);
    // The energy of a strain of 1e-9.
    let scale: f64 = b
        .stretch
        .iter()
        .zip(&b.rest_length)
        .map(|(k, l)| k * l)
        .sum();
    assert!(energies.potential() < 1e-18 * scale, "{energies:?}");
    let edges = (0..b.vertices())
        .filter(|&j| b.is_edge(j))
        .map(|j| b.rest_length[j]);
    assert!(
        edges.clone().fold(f64::INFINITY, f64::min) > 3.5e-3 && edges.fold(0.0, f64::max) < 6.8e-3
    );
    let mean = b.tension_limit.iter().sum::<f64>() / b.vertices() as f64;
    assert!((mean / (oak().tension / oak().longitudinal) - 1.0).abs() < 0.02);
    // By brute force: bonds go to the nearest point of the other rod.
    for bond in b.bonds.iter().step_by(17) {
        let x = b.rest.get(bond.vertex as usize);
        let best = b
            .rod(b.rod_of(bond.edge as usize))
            .filter(|&j| b.is_edge(j))
            .map(|j| {
                let (p, q) = (b.rest.get(j), b.rest.get(j + 1));
                let t = ((x - p).dot(q - p) / (q - p).length_squared()).clamp(0.0, 1.0);
                x.distance(p.lerp(q, t))
            })
            .fold(f64::INFINITY, f64::min);
        assert!((bond.distance - best).abs() < 1e-12);
    }
}

#[test]
fn bad_requests_are_refused() {
    let round = stem(cylinder(0.02, 0.4, 64));
    for (rods, [least, greatest]) in [
        (RodCount::Number(0), [4e-3, 6e-3]),
        (RodCount::Spacing(f64::NAN), [4e-3, 6e-3]),
        (RodCount::Spacing(1e-9), [4e-3, 6e-3]),
        (RodCount::Number(10), [6e-3, 4e-3]),
        (RodCount::Number(10), [0.0, 4e-3]),
        (RodCount::Number(10), [4.0, 6.0]),
    ] {
        let edges = EdgeLengths { least, greatest };
        let options = PlacementOptions {
            rods,
            edges,
            ..PlacementOptions::default()
        };
        let placed = fill_stem(&round, &oak(), &options, &Context::quiet());
        assert!(
            matches!(placed, Err(PlacementError::Value { .. })),
            "{rods:?} {edges:?}"
        );
    }
}
