//! Layouts of fibrous faces over sections that wood has: no facet folds over, and together they cover the section.

use greenstick_fracture::layout::{LayoutOptions, fibrous};
use greenstick_fracture::surface::NONE;
use greenstick_geometry::Context;
use greenstick_wood::primitive::{self, BranchOptions};
use greenstick_wood::stem::{StemLocation, StemOptions, find_stem};

/// Fluted stems whose last annual ring is as thin as a tenth of the others.
#[test]
fn no_facet_folds_over_beside_a_thin_ring() {
    for seed in 0..6 {
        let branch = BranchOptions {
            relief: 0.5 + 0.1 * seed as f64,
            around: 36,
            seed,
            ..BranchOptions::default()
        };
        let middle = StemLocation::Fraction(0.5);
        let found = find_stem(
            &[primitive::branch(&branch)],
            &middle,
            &StemOptions::default(),
            &Context::quiet(),
        );
        let stem = found.unwrap().stem;
        let mut fewest = usize::MAX;
        for last in [0.5, 0.05, 0.005] {
            let bark = 0.94;
            let options = LayoutOptions {
                rings: 50,
                sectors: 160,
                reach: (0.0, 1.0),
                radius: 1.2 * stem.radius,
                arc: None,
                bark: Some(bark),
                bark_below: Vec::new(),
                ring_edges: (1..10)
                    .map(|i| 0.1 * f64::from(i))
                    .chain([bark - 0.05 * last, 1.0])
                    .collect(),
                seed,
            };
            let made = fibrous(&stem.rings, &options);
            let nodes = |f: [u32; 3]| f.map(|n| made.layout.nodes[n as usize]);
            let areas = made.layout.facets.iter().map(|&f| {
                let [a, b, c] = nodes(f);
                (b - a).perp_dot(c - a) / 2.0
            });
            let least = areas.clone().fold(f64::INFINITY, f64::min);
            assert!(least > 0.0, "seed {seed}, last ring {last}: {least} m²");
            // What none of them overlaps is what their border encloses.
            let layout = &made.layout;
            let border = layout.edges.iter().flat_map(|e| match e.facets {
                [inside, (NONE, _)] | [(NONE, _), inside] => Some(inside),
                _ => None,
            });
            let border = border.map(|(facet, side)| {
                let corners = nodes(layout.facets[facet as usize]);
                let k = usize::from(side);
                corners[k].perp_dot(corners[(k + 1) % 3]) / 2.0
            });
            let border: f64 = border.sum();
            let sum: f64 = areas.sum();
            assert!((sum / border - 1.0).abs() < 1e-9, "{sum} {border}");
            fewest = fewest.min(layout.facets.len());
            // Only the thin band gets finer.
            assert!(layout.facets.len() < 2 * fewest, "{}", layout.facets.len());
        }
    }
}
