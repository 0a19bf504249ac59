//! Heights of the break surface: Yang 2019 §3 on every bundle or node, and the relief of torn fibres.
//!
//! All heights are ratios to the stem's radius until they are placed along the axis at the end.

use crate::ends::Ends;
pub use crate::field::{HeightField, HeightFieldError};
use crate::layout::{Bundles, wrap};
pub use crate::limit::Wedge;
use crate::limit::place;
use crate::parameters::{BreakParameters, Sector, SurfaceStyle as Kind, ZoneParameters};
use crate::surface::{Layout, Surface};
use crate::torn::{Level, Torn};
use glam::DVec2;
use greenstick_wood::noise;
use greenstick_wood::tissue::{Proportions, Zone};
use std::sync::Arc;

/// Seeds of independent random numbers.
pub(crate) mod purpose {
    pub const PERLIN: u64 = 0x9e11;
    pub const WHITE: u64 = 0x3417e;
    pub const THORN: u64 = 0x7402;
    pub const ZONE_THORN: u64 = 0x7403;
    pub const LENGTH: u64 = 0x1e46;
    pub const SHAFT: u64 = 0x54af;
    pub const SLIVER: u64 = 0x511f;
    pub const GROUP: u64 = 0x6409;
    pub const FIBRE: u64 = 0xf1b3;
    pub const STEP: u64 = 0x57e9;
    pub const BARK: u64 = 0xba4c;
    pub const SHELF: u64 = 0x54e1;
    pub const WANDER: u64 = 0x3a4d;
}

/// The stem that heights are made for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Setting {
    /// Radius of the stem at the break, m.
    pub radius: f64,
    /// Length along the axis of the break, m.
    pub place: f64,
    /// Lengths along the axis that the surface must keep within, m.
    pub usable: (f64, f64),
    /// Pith of the section, m from the axis; it may lie outside of it.
    pub pith: DVec2,
    /// The wedge that the face keeps within, where a piece is to hang on.
    pub wedge: Option<Wedge>,
    /// Factor on the relief (not on inclination, layers or thorns of given length) that a species calls for.
    pub relief: f64,
}

/// A surface with what had to be done to fit it into the stem.
#[derive(Debug, Clone)]
pub struct Heights {
    /// The surface.
    pub surface: Surface,
    /// How many facet corners would have left the stem.
    pub limited: usize,
    /// Lowest and highest height before limiting, m from the place of the break.
    pub wanted: (f64, f64),
    /// Lowest and highest height as it is, m from the place of the break.
    pub range: (f64, f64),
    /// Thorns on the face.
    pub thorns: Vec<Thorn>,
}

/// A bundle that stands out as a thorn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Thorn {
    /// Its bundle.
    pub bundle: u32,
    /// Height over the bundle's own, m.
    pub length: f64,
}

/// Everything a height is worked out from.
pub(crate) struct Maker<'a> {
    pub p: &'a BreakParameters,
    pub setting: &'a Setting,
    /// Unit direction of the tension side.
    pub tension: DVec2,
    /// Slope of the face.
    pub tilt: DVec2,
    noise_radius: f64,
    high: Sector,
    low: Sector,
    ductile: Sector,
}

/// Intermediate results that the next heights over the same layout reuse where nothing that they depend on has changed.
/// Heights are the same with a fresh cache.
#[derive(Debug, Clone, Default)]
pub struct HeightCache {
    /// Noise at the nodes of a smooth surface.
    noise: Option<Arc<NodeNoise>>,
    /// Torn ends of the bundles of a fibrous surface.
    pub(crate) ends: Option<Arc<Ends>>,
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
    bundles: &Bundles,
    p: &BreakParameters,
    setting: &Setting,
    source: &HeightSource,
    cache: &mut HeightCache,
) -> Heights {
    match (source, p.surface) {
        (HeightSource::Procedural, Kind::Smooth) => smooth(bundles, p, setting, cache),
        (HeightSource::Procedural, Kind::Fibrous) => fibrous(bundles, p, setting, cache),
        (HeightSource::Field(field), Kind::Smooth) => smooth_of_field(bundles, field, setting),
        (HeightSource::Field(field), Kind::Fibrous) => {
            fibrous_of_field(bundles, field, p, setting, cache)
        }
    }
}

/// Heights of a smooth surface through a field.
fn smooth_of_field(bundles: &Bundles, field: &HeightField, setting: &Setting) -> Heights {
    let at = |&(rho, phi): &(f64, f64)| field.at(rho, phi) / setting.radius;
    let heights = bundles.addresses.iter().map(at).collect();
    let nodes = bundles.layout.nodes.iter().copied();
    place(bundles, heights, nodes, &bundles.layout.facets, setting)
}

/// Heights of fibre bundles that end at a field, with ragged ends.
fn fibrous_of_field(
    bundles: &Bundles,
    field: &HeightField,
    p: &BreakParameters,
    setting: &Setting,
    cache: &mut HeightCache,
) -> Heights {
    let maker = Maker::new(p, setting);
    let torn = Torn::new(&maker, bundles, &mut Walks::new(&maker), cache);
    let levels: Vec<Level> = (0..bundles.bundles.len())
        .map(|i| torn.level_of_field(field, i))
        .collect();
    let rims = torn.ends.rims.iter();
    let heights = rims
        .map(|rim| torn.at(&levels[rim.cell as usize], rim))
        .collect();
    let nodes = &bundles.layout.nodes;
    let at = torn.ends.rims.iter().map(|r| nodes[r.node as usize]);
    place(bundles, heights, at, &torn.ends.corners, setting)
}

/// Heights of the published smooth surface: one per node, shared by all facets there.
fn smooth(
    bundles: &Bundles,
    p: &BreakParameters,
    setting: &Setting,
    cache: &mut HeightCache,
) -> Heights {
    let heights = smooth_nodes(bundles, &Maker::new(p, setting), cache);
    let at = bundles.layout.nodes.iter().copied();
    place(bundles, heights, at, &bundles.layout.facets, setting)
}

/// Heights of the fibrous surface: the end of each bundle, torn.
fn fibrous(
    bundles: &Bundles,
    p: &BreakParameters,
    setting: &Setting,
    cache: &mut HeightCache,
) -> Heights {
    let (heights, ends, thorns) = fibrous_rims(bundles, &Maker::new(p, setting), cache);
    let nodes = &bundles.layout.nodes;
    let at = ends.rims.iter().map(|r| nodes[r.node as usize]);
    let mut placed = place(bundles, heights, at, &ends.corners, setting);
    placed.thorns = thorns;
    placed
}

/// Height between the 5th and the 95th hundredth of the corners, m: the relief of a face before limiting.
pub fn relief_range(
    bundles: &Bundles,
    p: &BreakParameters,
    setting: &Setting,
    cache: &mut HeightCache,
) -> f64 {
    let maker = Maker::new(p, setting);
    let mut heights: Vec<f64> = if p.surface == Kind::Smooth {
        let heights = smooth_nodes(bundles, &maker, cache);
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
    (hundredth(0.95) - low) * setting.radius
}

/// The height of every node of the published surface, in radii.
fn smooth_nodes(bundles: &Bundles, maker: &Maker, cache: &mut HeightCache) -> Vec<f64> {
    let (p, setting) = (maker.p, maker.setting);
    let pith = bundles.layout.nodes.first().copied().unwrap_or_default();
    let rings = f64::from(p.rings);
    let proportions = p.proportions();
    // Beyond the bark the heights of the outermost ring run on.
    let key = |n: usize, (rho, phi): (f64, f64)| {
        if rho >= 1.0 {
            (1 << 40) + (wrap(phi) * 1e6) as i64
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
    let nodes = bundles.layout.nodes.iter();
    nodes
        .zip(bundles.addresses.iter().zip(&relief.nodes))
        .enumerate()
        .map(|(n, (&at, (&(rho, phi), &(noise, zone))))| {
            let rho = rho.min(1.0);
            let across = (at - pith) / setting.radius;
            let thorn = |purpose, length, probability| {
                if probability <= 0.0 {
                    0.0
                } else {
                    maker.drawn_thorn(key(n, (rho, phi)), purpose, length, probability)
                }
            };
            maker.stepped(across, rho, phi) + noise + maker.thorn(rho, phi, zone, thorn)
        })
        .collect()
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
    layout: Arc<Layout>,
    key: NoiseKey,
    nodes: Vec<(f64, Zone)>,
}

impl NodeNoise {
    /// The cached noise, or that which `make` returns for each node's number, address and direction.
    fn cached(
        bundles: &Bundles,
        maker: &Maker,
        cache: &mut HeightCache,
        make: impl Fn(usize, (f64, f64), DVec2, &mut Walks) -> (f64, Zone),
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
        let mut walks = Walks::new(maker);
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
    bundles: &Bundles,
    maker: &Maker,
    cache: &mut HeightCache,
) -> (Vec<f64>, Arc<Ends>, Vec<Thorn>) {
    let mut walks = Walks::new(maker);
    let torn = Torn::new(maker, bundles, &mut walks, cache);
    let levels: Vec<Level> = (0..bundles.bundles.len())
        .map(|i| torn.level(&mut walks, i))
        .collect();
    let thorns = levels
        .iter()
        .enumerate()
        .filter(|(_, l)| l.thorn > 0.0)
        .map(|(i, l)| Thorn {
            bundle: i as u32,
            length: l.thorn * maker.setting.radius,
        })
        .collect();
    let rims = torn.ends.rims.iter();
    let heights = rims
        .map(|rim| torn.at(&levels[rim.cell as usize], rim))
        .collect();
    (heights, torn.ends, thorns)
}

/// Noise of a surface at one place after another.
pub(crate) struct Walks {
    /// Perlin noise, by octave.
    octaves: Vec<noise::GradientNoise2d>,
    /// What rays wander by.
    pub wander: noise::GradientNoise2d,
    /// How ragged the edge of the compression shelf is.
    pub shelf: noise::GradientNoise2d,
}

impl Walks {
    pub fn new(maker: &Maker) -> Self {
        let p = maker.p;
        let zones = [&p.pith, &p.heartwood, &p.sapwood, &p.phloem, &p.bark];
        let most = zones.iter().map(|z| z.perlin_octaves).max().unwrap_or(0);
        let seed = maker.seed(purpose::PERLIN);
        Walks {
            octaves: (0..most)
                .map(|octave| noise::GradientNoise2d::new(seed + u64::from(octave)))
                .collect(),
            wander: noise::GradientNoise2d::new(maker.seed(purpose::WANDER)),
            shelf: noise::GradientNoise2d::new(maker.seed(purpose::SHELF)),
        }
    }
}

pub(crate) fn unit(rho: f64, phi: f64) -> DVec2 {
    let (sin, cos) = libm::sincos(phi);
    DVec2::new(cos, sin) * rho
}

impl<'a> Maker<'a> {
    fn new(p: &'a BreakParameters, setting: &'a Setting) -> Self {
        let direction = |degrees: f64| unit(1.0, degrees.to_radians());
        // A plane along the grain has no height over the section; what is past the stem is limited later.
        let steepness = libm::tan(p.inclination.min(89.5).to_radians());
        Maker {
            p,
            setting,
            tension: direction(p.ductile.direction),
            tilt: direction(p.inclination_direction) * steepness,
            noise_radius: p.noise_diameter(2.0 * setting.radius) / 2.0,
            high: p.high.sector(),
            low: p.low.sector(),
            ductile: p.ductile.sector(),
        }
    }

    pub fn seed(&self, purpose: u64) -> u64 {
        self.p.seed ^ purpose << 20
    }

    /// Inclination, layers, Perlin and white noise: Eqs. 1 to 5. `across` is in radii, `unit` in ring coordinates.
    pub fn published(
        &self,
        walks: &mut Walks,
        (across, unit): (DVec2, DVec2),
        (rho, phi): (f64, f64),
        zone: Zone,
        key: i64,
    ) -> f64 {
        self.stepped(across, rho, phi) + self.noise(walks, unit, self.p.zone(zone), key)
    }

    /// The same without noise.
    pub fn stepped(&self, across: DVec2, rho: f64, phi: f64) -> f64 {
        across.dot(self.tilt) + self.layers(rho, phi)
    }

    fn layers(&self, rho: f64, phi: f64) -> f64 {
        let degrees = phi.to_degrees();
        let mut height = 0.0;
        if self.high.contains(degrees, rho) {
            height += self.p.high.height;
        }
        if self.low.contains(degrees, rho) {
            height += self.p.low.height;
        }
        height
    }

    pub fn noise(&self, walks: &mut Walks, unit: DVec2, zone: &ZoneParameters, key: i64) -> f64 {
        let (mut amplitude, mut frequency) = (zone.perlin_amplitude, zone.perlin_frequency);
        let mut height = 0.0;
        if amplitude > 0.0 {
            for octave in walks.octaves.iter_mut().take(zone.perlin_octaves as usize) {
                let n = octave.at(unit * (self.noise_radius * frequency));
                height += amplitude * (0.5 + 0.5 * n).clamp(0.0, 1.0);
                (amplitude, frequency) = (amplitude / 2.0, frequency * 2.0);
            }
        }
        let mut white = zone.white_noise_amplitude;
        if white > 0.0 {
            for octave in 0..zone.white_noise_octaves {
                height += white * noise::unit(self.seed(purpose::WHITE), key, i64::from(octave), 0);
                white /= 2.0;
            }
        }
        height
    }

    /// Length of the thorn at a place, 0 for none: Eq. 8 with P the probability of a thorn. `draw` is given what for, the greatest length and
    /// the probability.
    pub fn thorn(
        &self,
        rho: f64,
        phi: f64,
        zone: Zone,
        draw: impl Fn(u64, f64, f64) -> f64,
    ) -> f64 {
        let (length, probability) = if self.ductile.contains(phi.to_degrees(), rho) {
            (
                self.p.ductile.thorn_length,
                self.p.ductile.thorn_probability,
            )
        } else {
            (
                self.p.brittle.thorn_length,
                self.p.brittle.thorn_probability,
            )
        };
        let tissue = self.p.zone(zone);
        draw(purpose::THORN, length, probability).max(draw(
            purpose::ZONE_THORN,
            tissue.thorn_length,
            tissue.thorn_probability,
        ))
    }

    fn drawn_thorn(&self, key: i64, purpose: u64, length: f64, probability: f64) -> f64 {
        if noise::unit(self.seed(purpose), key, 0, 0) < probability {
            length * noise::unit(self.seed(purpose::LENGTH), key, purpose as i64, 0)
        } else {
            0.0
        }
    }
}
