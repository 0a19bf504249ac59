//! What faces of broken wood are made of, by statistics of their heights.

use glam::DVec2;
use greenstick_fracture::heights::{
    BreakSite, CellFailure, FailureMode, HeightCache, HeightField, HeightSource, Heights, heights,
};
use greenstick_fracture::layout::{FibreBundles, LayoutOptions, fibrous};
use greenstick_fracture::parameters::{BreakParameters, SurfaceStyle};
use greenstick_fracture::recipe::Recipe;
use greenstick_fracture::surface::NONE;
use greenstick_geometry::{Context, Mesh};
use greenstick_wood::primitive;
use greenstick_wood::stem::{Stem, StemLocation, StemOptions, find_stem};
use std::sync::Arc;

fn stem(mesh: Mesh) -> Stem {
    let middle = StemLocation::Fraction(0.5);
    let options = StemOptions {
        slope_of_grain: 0.0,
        ..StemOptions::default()
    };
    let found = find_stem(&[mesh], &middle, &options, &Context::quiet());
    found.unwrap().stem
}

/// The bundles of a stem's section and the heights of its face.
fn face(stem: &Stem, options: &LayoutOptions, p: &BreakParameters) -> (FibreBundles, Heights) {
    from_source(stem, options, p, &HeightSource::Procedural)
}

fn from_source(
    stem: &Stem,
    options: &LayoutOptions,
    p: &BreakParameters,
    source: &HeightSource,
) -> (FibreBundles, Heights) {
    let bundles = fibrous(&stem.rings, options);
    let site = BreakSite {
        radius: stem.radius,
        place: stem.location,
        usable: stem.usable,
        pith: stem.rings.pith(),
        wedge: None,
        relief: 1.0,
    };
    let made = heights(&bundles, p, &site, source, &mut HeightCache::default());
    (bundles, made)
}

/// A face of a preset on a stem 4 cm thick.
fn round_face(preset: &str, seed: u64) -> (Stem, FibreBundles, Heights) {
    round_face_up_to(preset, seed, 1.0)
}

/// [`round_face`] in a layout that reaches up to a ring coordinate.
fn round_face_up_to(preset: &str, seed: u64, reach: f64) -> (Stem, FibreBundles, Heights) {
    let p = BreakParameters {
        seed,
        ..Recipe::resolve(&[preset], None, &[]).unwrap().face
    };
    round_face_of(&p, reach)
}

/// A face of parameters in a layout that reaches up to a ring coordinate, on a stem 4 cm thick.
fn round_face_of(p: &BreakParameters, reach: f64) -> (Stem, FibreBundles, Heights) {
    let stem = stem(primitive::cylinder(0.02, 0.6, 64));
    let options = LayoutOptions {
        rings: p.rings as usize,
        sectors: p.sectors as usize,
        reach: (0.0, reach),
        radius: 1.1 * reach * stem.radius,
        arc: None,
        bark: Some(0.94),
        bark_below: Vec::new(),
        ring_edges: (1..=8).map(|i| 0.125 * f64::from(i)).collect(),
        seed: p.seed,
    };
    let (bundles, heights) = face(&stem, &options, p);
    (stem, bundles, heights)
}

/// Heights (in radii) of the walls between bundles of wood, each with its length: those at the middles of the edges.
fn walls(radius: f64, bundles: &FibreBundles, heights: &Heights) -> Vec<(f64, f64)> {
    let layout = &bundles.layout;
    let cell = |facet: u32| layout.cells[facet as usize];
    let between = layout.edges.iter().filter_map(|edge| {
        let [a, b] = edge.facets;
        let is_wall = a.0 != NONE && b.0 != NONE && cell(a.0) != cell(b.0);
        let is_wood = is_wall
            && [a, b]
                .iter()
                .all(|f| !bundles.bundles[cell(f.0) as usize].bark);
        is_wood.then(|| {
            let [left, right] = [a, b].map(|(f, k)| heights.surface.side_heights(f, k));
            let [from, to] = edge.nodes.map(|n| layout.nodes[n as usize]);
            let step = 0.5 * (left[0] + left[1] - right[0] - right[1]).abs();
            (step / radius, from.distance(to))
        })
    });
    between.collect()
}

/// The share of walls by length whose height lies below a number of radii.
fn lower_share(walls: &[(f64, f64)], than: f64) -> f64 {
    let all: f64 = walls.iter().map(|w| w.1).sum();
    let low: f64 = walls.iter().filter(|w| w.0 < than).map(|w| w.1).sum();
    low / all
}

#[test]
fn brash_wood_breaks_in_plates_that_bundles_share_and_tough_wood_in_splinters() {
    for seed in 1..4 {
        let (stem, bundles, brash) = round_face("brash", seed);
        let walls_of = |heights: &Heights| walls(stem.radius, &bundles, heights);
        let plates = walls_of(&brash);
        // Bundles end together, but for the sheer edges of plates and of short slivers.
        let (level, edges) = (
            lower_share(&plates, 0.006),
            1.0 - lower_share(&plates, 0.03),
        );
        assert!(level > 0.3, "seed {seed}: {level}");
        assert!((0.05..0.25).contains(&edges), "seed {seed}: {edges}");
        // Nearly flat, but not a saw cut: the inclination alone is 0.2 radii.
        let relief = (brash.wanted.1 - brash.wanted.0) / stem.radius;
        assert!((0.3..0.8).contains(&relief), "seed {seed}: {relief}");
        let (stem, bundles, torn) = round_face("splintering-tension", seed);
        let torn = lower_share(&walls(stem.radius, &bundles, &torn), 0.006);
        assert!(torn < 0.3, "seed {seed}: {torn}");
    }
}

/// Crushed wood is no noisy floor: groups of bundles stand out of it as stubs, and about as many left pits.
#[test]
fn stubs_stand_out_of_crushed_wood_beside_pits() {
    for seed in 1..4 {
        let (stem, bundles, heights) = round_face("compression-first", seed);
        let layout = &bundles.layout;
        let mut cells = vec![(0.0, 0.0); bundles.bundles.len()];
        for (f, facet) in layout.facets.iter().enumerate() {
            let [a, b, c] = facet.map(|n| layout.nodes[n as usize]);
            let area = (b - a).perp_dot(c - a);
            let cell = &mut cells[layout.cells[f] as usize];
            *cell = (
                cell.0 + area * heights.surface.heights[f].iter().sum::<f64>() / 3.0,
                cell.1 + area,
            );
        }
        let height = |cell: usize| cells[cell].0 / cells[cell].1 / stem.radius;
        // Tension is along x: the crushed side is opposite.
        let is_crushed = |cell: usize| {
            let b = &bundles.bundles[cell];
            !b.bark && b.rho < 0.85 && b.rho * b.phi.cos() < -0.3 && cells[cell].1 > 0.0
        };
        let mut around = vec![Vec::new(); cells.len()];
        for edge in &layout.edges {
            let [a, b] = edge.facets;
            if a.0 != NONE && b.0 != NONE {
                let [a, b] = [a.0, b.0].map(|f| layout.cells[f as usize] as usize);
                if a != b && is_crushed(a) && is_crushed(b) {
                    around[a].push(height(b));
                    around[b].push(height(a));
                }
            }
        }
        let (mut crushed, mut out, mut sunk) = (0.0, 0.0, 0.0);
        for (cell, around) in around.iter_mut().enumerate().filter(|c| c.1.len() > 2) {
            around.sort_unstable_by(f64::total_cmp);
            let off = height(cell) - around[around.len() / 2];
            crushed += 1.0;
            out += f64::from(off > 0.06);
            sunk += f64::from(off < -0.06);
        }
        let (out, sunk) = (out / crushed, sunk / crushed);
        println!("seed {seed}: {crushed} {out} {sunk}");
        assert!((0.02..0.2).contains(&out), "seed {seed}: {out}");
        assert!((0.02..0.2).contains(&sunk), "seed {seed}: {sunk}");
    }
}

/// Mean heights (radii) of the wood of a face in strips across the direction in which layers and inclination rise.
fn strips((stem, bundles, heights): &(Stem, FibreBundles, Heights)) -> [f64; 9] {
    let layout = &bundles.layout;
    let pith = stem.rings.pith();
    let mut strips = [(0.0, 0.0); 9];
    for (f, facet) in layout.facets.iter().enumerate() {
        let corners = facet.map(|n| (layout.nodes[n as usize] - pith) / stem.radius);
        let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
        if bundles.bundles[layout.cells[f] as usize].bark || middle.length() > 0.9 {
            continue;
        }
        let area = (corners[1] - corners[0]).perp_dot(corners[2] - corners[0]);
        let height = heights.surface.heights[f].iter().sum::<f64>() / 3.0;
        let strip = &mut strips[((middle.x + 0.9) / 0.2).clamp(0.0, 8.0) as usize];
        *strip = (strip.0 + area * height / stem.radius, strip.1 + area);
    }
    strips.map(|(sum, area)| sum / area)
}

/// The height of a high layer at its border: it runs out over a way that grows with it, and is no cliff.
#[test]
fn a_high_layer_runs_out_on_the_slant() {
    let layer = ["high.height=5", "high.angle=180", "high.rings=1", "seed=1"];
    let recipe = Recipe::resolve(&["simple-tension"], None, &layer).unwrap();
    let means = strips(&round_face_of(&recipe.face, 1.0));
    let whole = means[8] - means[0];
    assert!(whole > 2.0, "{means:?}");
    // The steepest fifth of a radius takes no more than a third of the height.
    let steepest = means.windows(2).map(|m| m[1] - m[0]).fold(0.0, f64::max);
    assert!(steepest < 0.35 * whole, "{means:?}");
}

/// Sheared wood parts on one long slope.
#[test]
fn a_shear_face_is_one_long_slope() {
    const SEEDS: u64 = 3;
    let mut steep = 0.0;
    for seed in 1..=SEEDS {
        let means = strips(&round_face("shear", seed));
        let whole = means[8] - means[0];
        assert!(whole > 4.0, "seed {seed}: {means:?}");
        let steepest = means.windows(2).map(|m| m[1] - m[0]).fold(0.0, f64::max);
        steep += steepest / whole / SEEDS as f64;
    }
    // An even slope has an eighth of its height in each strip, and one seed's slabs and slivers on that; a step between two beams more.
    assert!(steep < 0.22, "{steep}");
}

/// The parts of a board's width.
const PARTS: usize = 90;

/// The mean heights (m) of the bundles in the middle of a board's thickness, by the part of the width, which lies along `along`.
fn profile(
    bundles: &FibreBundles,
    heights: &Heights,
    along: DVec2,
    (width, thickness): (f64, f64),
) -> [f64; PARTS] {
    let mut parts = [(0.0, 0.0); PARTS];
    let layout = &bundles.layout;
    for (facet, (cell, heights)) in layout
        .cells
        .iter()
        .zip(&heights.surface.heights)
        .enumerate()
    {
        let tip = bundles.tips[*cell as usize];
        let counts = tip != NONE && layout.facets[facet].contains(&tip);
        let Some(at) = counts.then(|| layout.nodes[tip as usize]) else {
            continue;
        };
        let place = at.dot(along) / width + 0.5;
        if at.dot(along.perp()).abs() < 0.2 * thickness && (0.0..1.0).contains(&place) {
            let part = &mut parts[(place * PARTS as f64) as usize];
            *part = (part.0 + heights.iter().sum::<f64>(), part.1 + 3.0);
        }
    }
    parts.map(|(sum, count)| sum / count)
}

/// The face of a board 68 cm wide and 2.5 cm thick along the middle of its thickness: how its height changes over the width.
#[test]
fn boards_break_in_wedges_and_not_in_blocks() {
    let (width, thickness) = (0.68, 0.025);
    let stem = stem(primitive::board(1.0, width, thickness));
    let pith = stem.rings.pith();
    let address = |x: f64, y: f64| stem.rings.address(DVec2::new(x, y));
    // The wide side lies along the axis across which the pith is not.
    let along = if pith.x.abs() > pith.y.abs() {
        DVec2::Y
    } else {
        DVec2::X
    };
    let corners = [-0.5, 0.0, 0.5]
        .map(|s| [-0.5, 0.5].map(|t| along * s * width + along.perp() * t * thickness));
    let at = corners.iter().flatten().map(|c| address(c.x, c.y));
    let (low, high) = at.clone().fold((f64::INFINITY, 0.0f64), |(l, h), a| {
        (l.min(a.0), h.max(a.0))
    });
    let (left, right) = at.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, r), a| {
        (l.min(a.1), r.max(a.1))
    });
    const SEEDS: u64 = 3;
    let (mut steep, mut jumps) = (0.0, 0.0);
    for seed in 1..=SEEDS {
        let p = BreakParameters {
            seed,
            compression_shelf: 0.0,
            ..BreakParameters::default()
        }
        .at_size(2.0 * stem.radius);
        let options = LayoutOptions {
            rings: p.rings as usize,
            sectors: 16 * p.sectors as usize / 10,
            reach: (0.98 * low, 1.02 * high),
            radius: 1.1 * (pith.length() + width),
            arc: Some((left - 0.03, right + 0.03)),
            bark: None,
            bark_below: Vec::new(),
            ring_edges: Vec::new(),
            seed,
        };
        let (bundles, heights) = face(&stem, &options, &p);
        let means = profile(&bundles, &heights, along, (width, thickness));
        let step = |m: &[f64]| (m[1] - m[0]).abs() / stem.radius;
        let mut changes: Vec<f64> = means.windows(2).map(step).collect();
        changes.sort_by(f64::total_cmp);
        let sum: f64 = changes.iter().sum();
        let top: f64 = changes[changes.len() * 9 / 10..].iter().sum();
        steep += changes[changes.len() * 9 / 10] / SEEDS as f64;
        jumps += top / sum / SEEDS as f64;
    }
    // Blocks rise in a few sheer steps, and have little between them.
    assert!(steep < 0.39 && jumps < 0.31, "{steep} {jumps}");
}

/// A field of 4 × 12 cells with a hill on one side of the pith, which splinters far.
fn hill() -> HeightField {
    let near = |cell: usize| (3..8).contains(&(cell % 12)) && cell >= 12;
    let heights = (0..48).map(|i| if near(i) { 0.006 } else { 0.0 });
    let failures = (0..48).map(|i| CellFailure {
        mode: FailureMode::Torn,
        splintering: if near(i) { 1.8 } else { 1.0 },
    });
    let field = HeightField::new(4, 12, heights.collect()).unwrap();
    field.with_failures(failures.collect()).unwrap().added()
}

#[test]
fn an_added_field_is_over_whatever_face_the_parameters_shape() {
    let stem = stem(primitive::cylinder(0.02, 3.0, 64));
    let none = HeightField::new(4, 12, vec![0.0; 48]).unwrap();
    let whole = CellFailure {
        mode: FailureMode::Torn,
        splintering: 1.0,
    };
    let none = none.with_failures(vec![whole; 48]).unwrap().added();
    let faces = [
        "",
        "inclination=25,inclination_direction=70",
        "high.angle=90,high.rings=0.6,high.height=0.5",
    ];
    for (preset, surface) in [
        ("green-stick", SurfaceStyle::Fibrous),
        ("brash", SurfaceStyle::Smooth),
    ] {
        let made = |settings: &str, field: Option<&HeightField>| {
            let settings: Vec<&str> = settings.split(',').filter(|s| !s.is_empty()).collect();
            let p = BreakParameters {
                surface,
                // Whether wood was crushed is a matter of the parameters and of the field together.
                compression_shelf: 0.0,
                ..Recipe::resolve(&[preset], None, &settings).unwrap().face
            };
            let options = LayoutOptions {
                rings: 24,
                sectors: 60,
                reach: (0.0, 1.0),
                radius: 1.1 * stem.radius,
                arc: None,
                bark: Some(0.94),
                bark_below: Vec::new(),
                ring_edges: (1..=8).map(|i| 0.125 * f64::from(i)).collect(),
                seed: p.seed,
            };
            let source = field.map_or(HeightSource::Procedural, |f| {
                HeightSource::Field(Arc::new(f.clone()))
            });
            from_source(&stem, &options, &p, &source).1
        };
        let mut first = None;
        for settings in faces {
            let plain = made(settings, None);
            let same = made(settings, Some(&none));
            assert_eq!(plain.surface.heights, same.surface.heights);
            assert_eq!((plain.scales, plain.moved), ((1.0, 1.0), 0.0));
            let hilly = made(settings, Some(&hill()));
            assert_eq!(hilly.scales, (1.0, 1.0));
            // What the field adds does not depend on the plane or the layers under it.
            let corners = |h: &Heights| h.surface.heights.concat();
            let by: Vec<f64> = (corners(&hilly).iter().zip(corners(&plain)))
                .map(|(a, b)| a - b)
                .collect();
            let most = by.iter().copied().fold(f64::MIN, f64::max);
            assert!(most > 0.0059, "{most}");
            let first = first.get_or_insert_with(|| by.clone());
            let off = by.iter().zip(&*first).map(|(a, b)| (a - b).abs());
            let off = off.fold(0.0, f64::max);
            assert!(
                off < 1e-9,
                "{preset} {settings}: {off} {:?} {:?} {}",
                hilly.wanted,
                plain.wanted,
                hilly.limited
            );
        }
    }
}

/// Slopes outwards of the torn bark of a face, between its inner edge and the nodes beyond the skin, in a layout that reaches up to a ring
/// coordinate.
fn bark_slopes(preset: &str, seed: u64, reach: f64) -> Vec<f64> {
    let (stem, bundles, heights) = round_face_up_to(preset, seed, reach);
    let layout = &bundles.layout;
    let from_pith = |n: u32| layout.nodes[n as usize].distance(stem.rings.pith());
    let mut slopes = Vec::new();
    for (f, facet) in layout.facets.iter().enumerate() {
        if !bundles.bundles[layout.cells[f] as usize].bark {
            continue;
        }
        if facet
            .iter()
            .all(|&n| bundles.addresses[n as usize].0 >= 1.0)
        {
            continue;
        }
        // The side that runs most nearly outwards.
        let sides = [(0, 1), (1, 2), (2, 0)];
        let rise = |&(i, j): &(usize, usize)| from_pith(facet[j]) - from_pith(facet[i]);
        let steepest = sides
            .into_iter()
            .max_by(|a, b| rise(a).abs().total_cmp(&rise(b).abs()))
            .unwrap();
        let [from, to] = [steepest.0, steepest.1].map(|k| heights.surface.heights[f][k]);
        slopes.push((to - from) / rise(&steepest));
    }
    slopes
}

/// Torn bark shows its thickness: it breaks on the slant, on one piece as often as on the other, and hardly so where it broke with
/// brittle wood.
#[test]
fn bark_breaks_on_the_slant_outwards() {
    let (mut steep, mut brash_steep) = (Vec::new(), Vec::new());
    for seed in 1..6 {
        steep.extend(bark_slopes("simple-tension", seed, 1.0));
        brash_steep.extend(bark_slopes("brash", seed, 1.0));
    }
    let share = |slopes: &[f64], of: fn(f64) -> bool| {
        slopes.iter().filter(|&&s| of(s)).count() as f64 / slopes.len() as f64
    };
    // The thickness of bark is seen from the side where it is not level.
    let (seen, out) = (share(&steep, |s| s.abs() > 0.7), share(&steep, |s| s > 0.0));
    assert!(seen > 0.6, "{seen}");
    assert!((0.3..0.7).contains(&out), "{out}");
    let brash = share(&brash_steep, |s| s.abs() > 0.7);
    assert!(brash < 0.5 * seen, "{brash}");
}

/// So it does where the stem flares below the break, so that the layout reaches far beyond the bark of the section: there the slant was
/// spread over all of that, which left level blocks. No facet there is folded, and all of them together cover what they did.
#[test]
fn bark_breaks_on_the_slant_where_the_stem_flares() {
    let share = |reach: f64| {
        let slopes = (1..6).flat_map(|seed| bark_slopes("simple-tension", seed, reach));
        let slopes: Vec<f64> = slopes.collect();
        slopes.iter().filter(|s| s.abs() > 0.7).count() as f64 / slopes.len() as f64
    };
    let (round, flared) = (share(1.0), share(1.75));
    assert!(flared > 0.85 * round, "{flared} {round}");
    let (_, bundles, _) = round_face_up_to("simple-tension", 1, 1.75);
    let layout = &bundles.layout;
    let area = |facet: &[u32; 3]| {
        let [a, b, c] = facet.map(|n| layout.nodes[n as usize]);
        0.5 * (b - a).perp_dot(c - a)
    };
    let areas: Vec<f64> = layout.facets.iter().map(area).collect();
    assert!(areas.iter().all(|&a| a > 0.0));
    let outline = layout.edges.iter().filter_map(|edge| {
        let [left, right] = edge.facets.map(|f| f.0 == NONE);
        let [a, b] = edge.nodes.map(|n| layout.nodes[n as usize]);
        (left != right).then(|| 0.5 * if right { a.perp_dot(b) } else { b.perp_dot(a) })
    });
    let (sum, outline) = (areas.iter().sum::<f64>(), outline.sum::<f64>());
    assert!((sum / outline - 1.0).abs() < 1e-9, "{sum} {outline}");
}

/// The ends of the bundles of wood: their middles and heights, both in radii.
fn ends_of((stem, bundles, heights): &(Stem, FibreBundles, Heights)) -> Vec<(DVec2, f64)> {
    let layout = &bundles.layout;
    let mut ends: Vec<(DVec2, f64)> = Vec::new();
    for (facet, heights) in layout.facets.iter().zip(&heights.surface.heights) {
        // The tip of a bundle is the last corner of the first of its facets that has it.
        let [_, _, tip] = *facet;
        let middle = layout.nodes[tip as usize] / stem.radius;
        let new = ends.last().is_none_or(|last| last.0 != middle);
        if new && bundles.tips.contains(&tip) && middle.length() < 0.85 {
            ends.push((middle, heights[2] / stem.radius));
        }
    }
    assert!(ends.len() > 1000, "{}", ends.len());
    ends
}

/// The mean difference of the heights of ends whose distance lies in a range, all in radii.
fn mean_difference(ends: &[(DVec2, f64)], (from, to): (f64, f64)) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for (i, (p, h)) in ends.iter().enumerate() {
        for (q, k) in &ends[..i] {
            if (from..to).contains(&p.distance(*q)) {
                sum += (h - k).abs();
                count += 1.0;
            }
        }
    }
    sum / count
}

/// Brittle wood parts along rings and rays into clumps: bundles beside each other end at about one height, those farther off at others.
#[test]
fn brittle_wood_ends_in_clumps() {
    for seed in 1..4 {
        let ends = ends_of(&round_face("brash", seed));
        // The inclination of the face adds 0.03 at the distance of clumps.
        let beside = mean_difference(&ends, (0.0, 0.04));
        let clumps_off = mean_difference(&ends, (0.25, 0.35));
        println!("seed {seed}: {beside} {clumps_off}");
        assert!(clumps_off > 0.05, "seed {seed}: {clumps_off}");
        assert!(
            beside < 0.6 * clumps_off,
            "seed {seed}: {beside} {clumps_off}"
        );
    }
}

/// A brash face is one of few plates, each nearly plane: ends an eighth of a radius apart are mostly of one plate, and differ by a small
/// part of what those across the face do.
#[test]
fn brittle_wood_breaks_in_few_large_plates() {
    for seed in 1..4 {
        let ends = ends_of(&round_face("brash", seed));
        let near = mean_difference(&ends, (0.1, 0.15));
        let across = mean_difference(&ends, (0.9, 1.1));
        println!("seed {seed}: {near} {across}");
        assert!(near < 0.55 * across, "seed {seed}: {near} {across}");
        // It is nearly flat all the same.
        assert!(across < 0.25, "seed {seed}: {across}");
    }
}

/// Where bending hardly crushed the wood, on the side opposite to the tension, it tore short: in tufts that differ by more than crumbs
/// would, and less than the splinters beside them.
#[test]
fn a_narrow_compression_side_tears_short() {
    for preset in ["simple-tension", "splintering-tension"] {
        for seed in 1..4 {
            let ends = ends_of(&round_face(preset, seed));
            // Tension is along x.
            let spread = |from: f64, to: f64| {
                let part = ends.iter().filter(|e| (from..to).contains(&e.0.x));
                let mut heights: Vec<f64> = part.map(|e| e.1).collect();
                heights.sort_unstable_by(f64::total_cmp);
                heights[heights.len() * 9 / 10] - heights[heights.len() / 10]
            };
            let (compressed, torn) = (spread(-0.85, -0.6), spread(0.1, 0.85));
            println!("{preset} {seed}: {compressed} {torn}");
            assert!(compressed > 0.15, "{preset} {seed}: {compressed}");
            assert!(compressed < torn, "{preset} {seed}: {compressed} {torn}");
        }
    }
}
