//! Heights of the break surface: Yang 2019 §3 on every bundle or node, and the relief of torn fibres.
//!
//! All heights are ratios to the stem's radius until they are placed along the axis at the end.

use crate::ends::TornEnds;
pub use crate::field::{HeightField, HeightFieldError};
pub use crate::height_model::{BreakSite, Heights, Thorn};
use crate::height_model::{HeightModel, NoiseSamplers};
use crate::layout::{FibreBundles, wrap_angle};
use crate::limit::place_heights;
use crate::parameters::{BreakParameters, SurfaceStyle as Kind, ZoneParameters};
use crate::surface::SectionLayout;
use crate::torn::{BundleHeight, TornRelief};
pub use crate::wedge::Wedge;
use glam::DVec2;
use greenstick_wood::tissue::{Proportions, Zone};
use std::sync::Arc;

/// Intermediate results that the next heights over the same layout reuse where nothing that they depend on has changed.
/// Heights are the same with a fresh cache.
#[derive(Debug, Clone, Default)]
pub struct HeightCache {
    /// Noise at the nodes of a smooth surface.
    noise: Option<Arc<NodeNoise>>,
    /// Torn ends of the bundles of a fibrous surface.
    ends: Option<Arc<TornEnds>>,
}

/// Where the heights of a break come from.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum HeightSource {
    /// The procedural model: Yang 2019 §3, and the relief of torn fibres.
    #[default]
    Procedural,
    /// Heights that were measured, simulated or painted. The procedural model adds only the fur of fine fibres.
    Field(Arc<HeightField>),
}

/// Heights of a break, made with what `source` and the style of the parameters ask for.
pub fn heights(
    bundles: &FibreBundles,
    p: &BreakParameters,
    site: &BreakSite,
    source: &HeightSource,
    cache: &mut HeightCache,
) -> Heights {
    match (source, p.surface) {
        (HeightSource::Procedural, Kind::Smooth) => smooth(bundles, p, site, cache),
        (HeightSource::Procedural, Kind::Fibrous) => fibrous(bundles, p, site, cache),
        (HeightSource::Field(field), Kind::Smooth) => smooth_of_field(bundles, field, site),
        (HeightSource::Field(field), Kind::Fibrous) => {
            fibrous_of_field(bundles, field, p, site, cache)
        }
    }
}

/// Heights of a smooth surface through a field.
fn smooth_of_field(bundles: &FibreBundles, field: &HeightField, site: &BreakSite) -> Heights {
    let at = |&(rho, phi): &(f64, f64)| field.at(rho, phi) / site.radius;
    let heights = bundles.addresses.iter().map(at).collect();
    let nodes = bundles.layout.nodes.iter().copied();
    place_heights(bundles, heights, nodes, &bundles.layout.facets, site)
}

/// Heights of fibre bundles that end at a field, with ragged ends.
fn fibrous_of_field(
    bundles: &FibreBundles,
    field: &HeightField,
    p: &BreakParameters,
    site: &BreakSite,
    cache: &mut HeightCache,
) -> Heights {
    let maker = HeightModel::new(p, site);
    let torn = TornRelief::new(
        &maker,
        bundles,
        &mut NoiseSamplers::new(&maker),
        &mut cache.ends,
    );
    let levels: Vec<BundleHeight> = (0..bundles.bundles.len())
        .map(|i| torn.field_height(field, i))
        .collect();
    let rims = torn.ends.nodes.iter();
    let heights = rims
        .map(|rim| torn.node_height(&levels[rim.cell as usize], rim))
        .collect();
    let nodes = &bundles.layout.nodes;
    let at = torn.ends.nodes.iter().map(|r| nodes[r.node as usize]);
    place_heights(bundles, heights, at, &torn.ends.corners, site)
}

/// Heights of the published smooth surface: one per node, shared by all facets there.
fn smooth(
    bundles: &FibreBundles,
    p: &BreakParameters,
    site: &BreakSite,
    cache: &mut HeightCache,
) -> Heights {
    let (heights, thorns) = smooth_nodes(bundles, &HeightModel::new(p, site), cache);
    let at = bundles.layout.nodes.iter().copied();
    let mut placed = place_heights(bundles, heights, at, &bundles.layout.facets, site);
    placed.thorns = thorns;
    placed
}

/// Heights of the fibrous surface: the end of each bundle, torn.
fn fibrous(
    bundles: &FibreBundles,
    p: &BreakParameters,
    site: &BreakSite,
    cache: &mut HeightCache,
) -> Heights {
    let (heights, ends, thorns) = fibrous_rims(bundles, &HeightModel::new(p, site), cache);
    let nodes = &bundles.layout.nodes;
    let at = ends.nodes.iter().map(|r| nodes[r.node as usize]);
    let mut placed = place_heights(bundles, heights, at, &ends.corners, site);
    placed.thorns = thorns;
    placed
}

/// Height between the 5th and the 95th hundredth of the corners, m: the relief of a face before limiting.
pub fn relief_range(
    bundles: &FibreBundles,
    p: &BreakParameters,
    site: &BreakSite,
    cache: &mut HeightCache,
) -> f64 {
    let maker = HeightModel::new(p, site);
    let mut heights: Vec<f64> = if p.surface == Kind::Smooth {
        let (heights, _) = smooth_nodes(bundles, &maker, cache);
        let corners = bundles.layout.facets.iter().flatten();
        corners.map(|&n| heights[n as usize]).collect()
    } else {
        let (heights, ends, _) = fibrous_rims(bundles, &maker, cache);
        let corners = ends.corners.iter().flatten();
        corners.map(|&r| heights[r as usize]).collect()
    };
    if heights.is_empty() {
        return 0.0;
    }
    let mut hundredth = |part: f64| {
        let i = (part * (heights.len() - 1) as f64) as usize;
        *heights.select_nth_unstable_by(i, f64::total_cmp).1
    };
    let low = hundredth(0.05);
    (hundredth(0.95) - low) * site.radius
}

/// The height of every node of the published surface, in radii, and the thorns, each of which stands on a node.
fn smooth_nodes(
    bundles: &FibreBundles,
    maker: &HeightModel,
    cache: &mut HeightCache,
) -> (Vec<f64>, Vec<Thorn>) {
    let (p, site) = (maker.p, maker.site);
    let pith = bundles.layout.nodes.first().copied().unwrap_or_default();
    let rings = f64::from(p.rings);
    let proportions = p.proportions();
    // Beyond the bark the heights of the outermost ring run on.
    let key = |n: usize, (rho, phi): (f64, f64)| {
        if rho >= 1.0 {
            (1 << 40) + (wrap_angle(phi) * 1e6) as i64
        } else {
            n as i64
        }
    };
    let relief = NodeNoise::cached(bundles, maker, cache, |n, (rho, phi), direction, walks| {
        let rho = rho.min(1.0);
        let zone = proportions.zone_at(rho, 0.5 / rings);
        let key = key(n, (rho, phi));
        let noise = maker.noise(walks, direction * rho, p.zone(zone), key);
        (noise, zone)
    });
    let mut thorns = Vec::new();
    let nodes = bundles.layout.nodes.iter();
    let heights = nodes
        .zip(bundles.addresses.iter().zip(&relief.nodes))
        .enumerate()
        .map(|(n, (&at, (&(rho, phi), &(noise, zone))))| {
            let rho = rho.min(1.0);
            let across = (at - pith) / site.radius;
            let thorn = |purpose, length, probability| {
                if probability <= 0.0 {
                    0.0
                } else {
                    maker.drawn_thorn(key(n, (rho, phi)), purpose, length, probability)
                }
            };
            let thorn = maker.thorn(rho, phi, zone, thorn);
            // Beyond the bark the surface runs on, but no thorn stands there.
            if thorn > 0.0 && bundles.addresses[n].0 <= 1.0 {
                thorns.push((n as u32, thorn * site.radius));
            }
            maker.stepped(across, rho, phi) + noise * site.relief + thorn
        })
        .collect();
    (heights, thorns_of_nodes(bundles, &thorns))
}

/// The thorns on nodes, (node, length in m), ascending: each belongs to a bundle at its node.
fn thorns_of_nodes(bundles: &FibreBundles, thorns: &[(u32, f64)]) -> Vec<Thorn> {
    if thorns.is_empty() {
        return Vec::new();
    }
    let layout = &bundles.layout;
    let mut bundle_of = vec![0; layout.nodes.len()];
    for (facet, &cell) in layout.facets.iter().zip(&layout.cells) {
        facet.iter().for_each(|&n| bundle_of[n as usize] = cell);
    }
    let thorn = |&(node, length): &(u32, f64)| Thorn {
        bundle: bundle_of[node as usize],
        length,
    };
    thorns.iter().map(thorn).collect()
}

/// What the noise of nodes is made from beside the layout.
#[derive(Debug, Clone, PartialEq)]
struct NoiseKey {
    seed: u64,
    radius: f64,
    rings: u32,
    proportions: Proportions,
    zones: [ZoneParameters; 5],
}

/// Noise at the nodes of a layout and the tissue they lie in; both stay the same while the shape of the face changes.
#[derive(Debug)]
pub(crate) struct NodeNoise {
    layout: Arc<SectionLayout>,
    key: NoiseKey,
    nodes: Vec<(f64, Zone)>,
}

impl NodeNoise {
    /// The cached noise, or that which `make` returns for each node's number, address and direction.
    fn cached(
        bundles: &FibreBundles,
        maker: &HeightModel,
        cache: &mut HeightCache,
        make: impl Fn(usize, (f64, f64), DVec2, &mut NoiseSamplers) -> (f64, Zone),
    ) -> Arc<NodeNoise> {
        let p = maker.p;
        let key = NoiseKey {
            seed: p.seed,
            radius: maker.noise_radius,
            rings: p.rings,
            proportions: p.proportions(),
            zones: [&p.pith, &p.heartwood, &p.sapwood, &p.phloem, &p.bark].map(Clone::clone),
        };
        if let Some(last) = &cache.noise
            && last.key == key
            && Arc::ptr_eq(&last.layout, &bundles.layout)
        {
            return last.clone();
        }
        let mut walks = NoiseSamplers::new(maker);
        let nodes = bundles.addresses.iter().zip(&bundles.directions);
        let made = Arc::new(NodeNoise {
            layout: bundles.layout.clone(),
            key,
            nodes: nodes
                .enumerate()
                .map(|(n, (&address, &direction))| make(n, address, direction, &mut walks))
                .collect(),
        });
        cache.noise = Some(made.clone());
        made
    }
}

/// The height of every node of every bundle of the torn surface, in radii, the ends they are of, and the thorns.
fn fibrous_rims(
    bundles: &FibreBundles,
    maker: &HeightModel,
    cache: &mut HeightCache,
) -> (Vec<f64>, Arc<TornEnds>, Vec<Thorn>) {
    let mut walks = NoiseSamplers::new(maker);
    let torn = TornRelief::new(maker, bundles, &mut walks, &mut cache.ends);
    let levels: Vec<BundleHeight> = (0..bundles.bundles.len())
        .map(|i| torn.bundle_height(&mut walks, i))
        .collect();
    let thorns = levels
        .iter()
        .enumerate()
        .filter(|(_, l)| l.thorn > 0.0)
        .map(|(i, l)| Thorn {
            bundle: i as u32,
            length: l.thorn * maker.site.radius,
        })
        .collect();
    let rims = torn.ends.nodes.iter();
    let heights = rims
        .map(|rim| torn.node_height(&levels[rim.cell as usize], rim))
        .collect();
    (heights, torn.ends, thorns)
}
