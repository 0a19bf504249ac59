//! Heights of the break surface: Yang 2019 §3 on every bundle or node, and the relief of torn fibres.
//!
//! All heights are ratios to the stem's radius until they are placed along the axis at the end.

use crate::ends::TornEnds;
use crate::even::even_out;
pub use crate::field::{CellFailure, FailureMode, HeightField, HeightFieldError, grid_middle};
pub use crate::height_model::{BreakSite, Heights, Thorn};
use crate::height_model::{HeightModel, NoiseSamplers, purpose};
use crate::layout::{FibreBundles, InnerEdge, wrap_angle};
use crate::limit::place_heights;
use crate::parameters::{BreakParameters, SurfaceStyle as Kind, ZoneParameters};
use crate::plates::brittleness;
pub use crate::slabs::SectionSpan;
use crate::surface::SectionLayout;
use crate::thorns::add_thorns;
use crate::torn::{BundleHeight, TornRelief, bundle_noise, node_noise};
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
    /// Noise at those bundles.
    bundle_noise: Option<Arc<BundleNoise>>,
}

/// Where the heights of a break come from.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum HeightSource {
    /// The procedural model: Yang 2019 §3, and the relief of torn fibres.
    #[default]
    Procedural,
    /// Heights that were measured, simulated or painted. Where the field says how the wood failed, the procedural model adds
    /// all that is finer than the grid: slivers, fibres and strips of bark. Otherwise it adds only the fur of fine fibres. A field
    /// that is [added](HeightField::added) raises and lowers the face of the procedural model.
    Field(Arc<HeightField>),
}

impl HeightSource {
    /// Whether it decides how far the wood splinters, so that a species must not do so again.
    pub fn decides_relief(&self) -> bool {
        matches!(self, HeightSource::Field(field) if field.has_failures() && !field.is_added())
    }
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
        (HeightSource::Procedural, Kind::Smooth) => smooth(bundles, p, site, None, cache),
        (HeightSource::Procedural, Kind::Fibrous) => fibrous(bundles, p, site, None, cache),
        (HeightSource::Field(field), Kind::Smooth) if field.is_added() => {
            smooth(bundles, p, site, Some(field), cache)
        }
        (HeightSource::Field(field), Kind::Smooth) => smooth_of_field(bundles, field, site),
        (HeightSource::Field(field), Kind::Fibrous) => {
            fibrous(bundles, p, site, Some(field), cache)
        }
    }
}

/// Heights of a smooth surface through a field.
fn smooth_of_field(bundles: &FibreBundles, field: &HeightField, site: &BreakSite) -> Heights {
    let at = |&(rho, phi): &(f64, f64)| field.at(rho, phi) / site.radius;
    let heights = bundles.addresses.iter().map(at).collect();
    let nodes = bundles.layout.nodes.iter().copied();
    place_heights(bundles, heights, nodes, &bundles.layout.facets, site, false)
}

/// Heights of the published smooth surface: one per node, shared by all facets there but those of thorns. `added` is over them.
fn smooth(
    bundles: &FibreBundles,
    p: &BreakParameters,
    site: &BreakSite,
    added: Option<&HeightField>,
    cache: &mut HeightCache,
) -> Heights {
    let model = HeightModel::new(p, site);
    let mut base = smooth_nodes(bundles, &model, cache);
    if let Some(added) = added {
        for (height, &(rho, phi)) in base.iter_mut().zip(&bundles.addresses) {
            *height += added.at(rho, phi) / site.radius;
        }
    }
    let face = add_thorns(bundles, &model, base);
    let nodes = &bundles.layout.nodes;
    let on_thorns = face.nodes.iter().map(|&n| nodes[n as usize]);
    let at = nodes.iter().copied().chain(on_thorns);
    let mut placed = place_heights(bundles, face.heights, at, &face.corners, site, true);
    placed.thorns = face.thorns;
    placed
}

/// Heights of the fibrous surface: the end of each bundle, torn, at a field or with one added where there is one.
fn fibrous(
    bundles: &FibreBundles,
    p: &BreakParameters,
    site: &BreakSite,
    field: Option<&HeightField>,
    cache: &mut HeightCache,
) -> Heights {
    let model = HeightModel::new(p, site);
    let (heights, ends, thorns) = fibrous_rims(bundles, &model, field, cache);
    let nodes = &bundles.layout.nodes;
    let at = ends.nodes.iter().map(|r| nodes[r.node as usize]);
    let is_drawn = field.is_none_or(HeightField::is_added);
    let mut placed = place_heights(bundles, heights, at, &ends.corners, site, is_drawn);
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
        let base = smooth_nodes(bundles, &maker, cache);
        let face = add_thorns(bundles, &maker, base);
        let corners = face.corners.iter().flatten();
        corners.map(|&n| face.heights[n as usize]).collect()
    } else {
        let (heights, ends, _) = fibrous_rims(bundles, &maker, None, cache);
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

/// The height of every node of the published surface without its thorns, in radii.
///
/// Where a node would lie beyond the skin, it has the height of the bark in its direction. A face that is one height in
/// each direction where it meets the skin leaves no holes in the bark, however high and dense the noise of the wood is.
fn smooth_nodes(bundles: &FibreBundles, maker: &HeightModel, cache: &mut HeightCache) -> Vec<f64> {
    let site = maker.site;
    let pith = bundles.layout.nodes.first().copied().unwrap_or_default();
    let noise = NodeNoise::cached(bundles, maker, cache);
    let half_width = bundles.bundles.first().map_or(0.0, |b| b.half_width);
    let nodes = bundles.layout.nodes.iter();
    nodes
        .zip(bundles.addresses.iter().zip(&noise.nodes))
        .map(|(&at, (&(rho, phi), noise))| {
            let across = (at - pith) / site.radius;
            let level = maker.stepped(across, rho.min(1.0), phi);
            let own = level + noise.own * site.relief;
            match (&bundles.skin, noise.bark) {
                // Layers that end below the bark stay as they are.
                (Some(skin), Some(bark)) if level == maker.stepped(across, 1.0, phi) => {
                    let bark = level + bark * site.relief;
                    let from = site.place + own.min(bark) * site.radius;
                    let to = site.place + own.max(bark) * site.radius;
                    let edge = InnerEdge {
                        rho,
                        phi,
                        half_width,
                    };
                    if skin.covers_between(&edge, from, to) {
                        own
                    } else {
                        bark
                    }
                }
                _ => own,
            }
        })
        .collect()
}

/// What noise is made from beside the layout.
#[derive(Debug, Clone, PartialEq)]
struct NoiseKey {
    seed: u64,
    radius: f64,
    rings: u32,
    proportions: Proportions,
    zones: [ZoneParameters; 5],
}

impl NoiseKey {
    fn new(maker: &HeightModel) -> Self {
        let p = maker.p;
        NoiseKey {
            seed: p.seed,
            radius: maker.noise_radius,
            rings: p.rings,
            proportions: p.proportions(),
            zones: [&p.pith, &p.heartwood, &p.sapwood, &p.phloem, &p.bark].map(Clone::clone),
        }
    }
}

/// The noise of a node.
#[derive(Debug, Clone, Copy)]
struct NoiseAtNode {
    /// That of the node's tissue.
    own: f64,
    /// That of the bark in its direction, where the skin may lie below the node.
    bark: Option<f64>,
}

/// Noise at the nodes of a layout, which stays the same while the shape of the face changes.
#[derive(Debug)]
pub(crate) struct NodeNoise {
    layout: Arc<SectionLayout>,
    key: NoiseKey,
    nodes: Vec<NoiseAtNode>,
}

impl NodeNoise {
    /// Returns the noise that is cached, or makes it.
    fn cached(
        bundles: &FibreBundles,
        maker: &HeightModel,
        cache: &mut HeightCache,
    ) -> Arc<NodeNoise> {
        let key = NoiseKey::new(maker);
        if let Some(last) = &cache.noise
            && last.key == key
            && Arc::ptr_eq(&last.layout, &bundles.layout)
        {
            return last.clone();
        }
        let made = Arc::new(NodeNoise {
            layout: bundles.layout.clone(),
            key,
            nodes: NodeNoise::make(bundles, maker),
        });
        cache.noise = Some(made.clone());
        made
    }

    fn make(bundles: &FibreBundles, maker: &HeightModel) -> Vec<NoiseAtNode> {
        let p = maker.p;
        let (rings, proportions) = (f64::from(p.rings), p.proportions());
        let mut samplers = NoiseSamplers::new(maker);
        let mut noise = |zone: Zone, unit: DVec2, key: i64| {
            maker.noise_about_mean(&mut samplers, unit, p.zone(zone), key)
        };
        // From the bark on the heights of the outermost ring run on.
        let bark_key = |phi: f64| (1 << 40) + (wrap_angle(phi) * 1e6) as i64;
        let skin = bundles.skin.as_ref().map_or(1.0, |skin| skin.least());
        let nodes = bundles.addresses.iter().zip(&bundles.directions);
        nodes
            .enumerate()
            .map(|(n, (&(rho, phi), &direction))| NoiseAtNode {
                own: if rho >= 1.0 {
                    noise(Zone::Bark, direction, bark_key(phi))
                } else {
                    let zone = proportions.zone_at(rho, 0.5 / rings);
                    noise(zone, direction * rho, n as i64)
                },
                bark: (rho < 1.0 && rho > skin - 0.01)
                    .then(|| noise(Zone::Bark, direction, bark_key(phi))),
            })
            .collect()
    }
}

/// Noise at the bundles of a layout, which stays the same while the shape of the face changes.
#[derive(Debug)]
struct BundleNoise {
    layout: Arc<SectionLayout>,
    key: NoiseKey,
    bundles: Vec<f64>,
    /// The part of the noise that is continuous across bundles, at every node.
    nodes: Vec<f64>,
}

impl BundleNoise {
    /// Returns the noise that is cached, or makes it.
    fn cached(
        bundles: &FibreBundles,
        maker: &HeightModel,
        noises: &mut NoiseSamplers,
        cache: &mut Option<Arc<BundleNoise>>,
    ) -> Arc<BundleNoise> {
        let key = NoiseKey::new(maker);
        if let Some(last) = cache
            && last.key == key
            && Arc::ptr_eq(&last.layout, &bundles.layout)
        {
            return last.clone();
        }
        let numbered = bundles.bundles.iter().enumerate();
        let made = Arc::new(BundleNoise {
            layout: bundles.layout.clone(),
            key,
            bundles: numbered
                .map(|(i, bundle)| bundle_noise(maker, noises, i, bundle))
                .collect(),
            nodes: (bundles.addresses.iter().zip(&bundles.directions))
                .map(|(&(rho, _), &direction)| node_noise(maker, noises, direction * rho.min(1.0)))
                .collect(),
        });
        *cache = Some(made.clone());
        made
    }
}

/// The height of every node of every bundle of the torn surface, in radii, the ends they are of, and the thorns.
fn fibrous_rims(
    bundles: &FibreBundles,
    maker: &HeightModel,
    field: Option<&HeightField>,
    cache: &mut HeightCache,
) -> (Vec<f64>, Arc<TornEnds>, Vec<Thorn>) {
    let mut walks = NoiseSamplers::new(maker);
    let torn = TornRelief::new(maker, bundles, field, &mut walks, &mut cache.ends);
    let noise = BundleNoise::cached(bundles, maker, &mut walks, &mut cache.bundle_noise);
    let levels: Vec<BundleHeight> = (noise.bundles.iter().enumerate())
        .map(|(i, &noise)| torn.bundle_height(&mut walks, i, noise))
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
    let mut heights: Vec<f64> = rims
        .map(|rim| torn.node_height(&levels[rim.cell as usize], rim, &noise.nodes))
        .collect();
    let brittle = brittleness(maker.p);
    if brittle > 0.0 {
        let at =
            |node: u32| (bundles.layout.nodes[node as usize] - torn.ends.pith) / maker.site.radius;
        let seed = maker.seed(purpose::PLATE);
        even_out(
            &mut heights,
            &torn.ends.nodes,
            (&bundles.bundles, &at),
            brittle,
            seed,
        );
    }
    (heights, torn.ends, thorns)
}
