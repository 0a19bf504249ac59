//! The published grid of rings and sectors.

use super::bundles::{FibreBundle, FibreBundles, LayoutOptions};
use super::nodes::{NodeBuilder, RAY_OFFSET, directions};
use crate::surface::SectionLayout;
use greenstick_wood::rings::RingField;
use std::f64::consts::TAU;
use std::sync::Arc;

/// The published grid: a fan about the pith, then rings of quadrangles, each parted in two.
pub fn smooth(field: &RingField, options: &LayoutOptions) -> FibreBundles {
    let (rings, sectors) = (options.rings, options.sectors);
    let mut maker = NodeBuilder {
        field,
        nodes: Vec::new(),
        addresses: Vec::new(),
    };
    let inner = options.reach.0.max(0.0);
    let around = options.arc.is_none();
    let (start, step) = match options.arc {
        None => (RAY_OFFSET, TAU / sectors as f64),
        Some((a, b)) => (a, (b - a) / sectors as f64),
    };
    let columns = if around { sectors } else { sectors + 1 };
    // One ring more than asked lies beyond the bark, at the heights of the last.
    let rho = |i: usize| inner + (1.0 - inner) * i as f64 / rings as f64;
    let (mut facets, mut cells, mut bundles) = (Vec::new(), Vec::new(), Vec::new());
    let first = usize::from(around);
    if around {
        maker.node(0.0, 0.0);
    }
    for i in first..=rings + 1 {
        for j in 0..columns {
            let phi = start + step * j as f64;
            if i > rings {
                maker.beyond(options, phi, step);
            } else {
                maker.node(rho(i), phi);
            }
        }
    }
    let id =
        |i: usize, j: usize| (usize::from(around) + (i - first) * columns + j % columns) as u32;
    for i in 0..=rings {
        for j in 0..sectors {
            let cell = bundles.len() as u32;
            let ring = i.min(rings - 1);
            bundles.push(FibreBundle {
                ring: ring as u32,
                sector: j as u32,
                rho: (rho(ring) + rho(ring + 1)) / 2.0,
                phi: start + step * (j as f64 + 0.5),
                half_width: step / 2.0,
                bark: false,
            });
            if i == 0 && around {
                facets.push([0, id(1, j), id(1, j + 1)]);
                cells.push(cell);
            } else {
                let [a, b, c, d] = [id(i, j), id(i + 1, j), id(i + 1, j + 1), id(i, j + 1)];
                facets.extend([[a, b, c], [a, c, d]]);
                cells.extend([cell; 2]);
            }
        }
    }
    let tips = vec![crate::surface::NONE; bundles.len()];
    let layout = SectionLayout::new(maker.nodes, facets, cells);
    FibreBundles {
        layout: Arc::new(layout),
        bundles,
        directions: directions(&maker.addresses),
        addresses: maker.addresses,
        tips,
        skin: None,
    }
}
