//! Heights of the break surface: Yang 2019 §3 on every bundle or node, and the relief of torn fibres.
//!
//! All heights are ratios to the stem's radius until they are placed along the axis at the end.

use crate::layout::{Bundle, Bundles, wrap};
use crate::parameters::{BreakParameters, Sector, ZoneParameters};
use crate::slabs::Slabs;
use crate::surface::{NONE, Surface};
use glam::DVec2;
use greenstick_wood::noise;
use greenstick_wood::tissue::Zone;

/// Seeds of independent random numbers.
mod purpose {
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
    /// Height between the 5th and the 95th hundredth of the corners, m: the relief of the face before limiting.
    pub relief_range: f64,
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
struct Maker<'a> {
    p: &'a BreakParameters,
    setting: &'a Setting,
    slabs: Slabs,
    tension: DVec2,
    tilt: DVec2,
    noise_radius: f64,
    high: Sector,
    low: Sector,
    ductile: Sector,
}

/// Heights of the published smooth surface: one per node, shared by all facets there.
pub fn smooth(bundles: &Bundles, p: &BreakParameters, setting: &Setting) -> Heights {
    let maker = Maker::new(p, setting);
    let pith = bundles.layout.nodes.first().copied().unwrap_or_default();
    let rings = f64::from(p.rings);
    let proportions = p.proportions();
    let heights: Vec<f64> = bundles
        .layout
        .nodes
        .iter()
        .zip(bundles.addresses.iter().zip(&bundles.directions))
        .enumerate()
        .map(|(n, (&at, (&(rho, phi), &direction)))| {
            // Beyond the bark the heights of the outermost ring run on.
            let rho = rho.min(1.0);
            let zone = proportions.zone_at(rho, 0.5 / rings);
            let unit = direction * rho;
            let across = (at - pith) / setting.radius;
            let key = if rho >= 1.0 {
                (1 << 40) + (wrap(phi) * 1e6) as i64
            } else {
                n as i64
            };
            maker.published(across, unit, rho, phi, zone, key) + maker.thorn(rho, phi, zone, key)
        })
        .collect();
    let corners = bundles
        .layout
        .facets
        .iter()
        .map(|f| f.map(|n| heights[n as usize]))
        .collect();
    finish(bundles, corners, setting, Vec::new())
}

/// Heights of the fibrous surface: one level per bundle, torn at its border, with a tip.
pub fn fibrous(bundles: &Bundles, p: &BreakParameters, setting: &Setting) -> Heights {
    let maker = Maker::new(p, setting);
    let pith = bundles
        .bundles
        .first()
        .map_or(DVec2::ZERO, |_| bundles.layout.nodes[0]);
    let levels: Vec<Level> = bundles
        .bundles
        .iter()
        .enumerate()
        .map(|(i, b)| maker.level(i, b, bundles, pith))
        .collect();
    let thorns = levels
        .iter()
        .enumerate()
        .filter(|(_, l)| l.thorn > 0.0)
        .map(|(i, l)| Thorn {
            bundle: i as u32,
            length: l.thorn * setting.radius,
        })
        .collect();
    // Facets of a bundle follow each other, so the last height made at a node is most often the one asked for.
    let mut last = vec![(NONE, 0.0); bundles.layout.nodes.len()];
    let corners = bundles
        .layout
        .facets
        .iter()
        .zip(&bundles.layout.cells)
        .map(|(facet, &cell)| {
            let level = &levels[cell as usize];
            let tip = bundles.tips[cell as usize];
            facet.map(|n| {
                if n == tip && tip != NONE {
                    return level.tip;
                }
                let known = &mut last[n as usize];
                if known.0 != cell {
                    *known = (cell, maker.border(level, cell, n, bundles, pith));
                }
                known.1
            })
        })
        .collect();
    finish(bundles, corners, setting, thorns)
}

fn unit(rho: f64, phi: f64) -> DVec2 {
    let (sin, cos) = libm::sincos(phi);
    DVec2::new(cos, sin) * rho
}

/// Height of one fibre bundle.
struct Level {
    /// At its border, on the mean.
    base: f64,
    /// At its tip.
    tip: f64,
    /// Height of its thorn, 0 for none.
    thorn: f64,
    /// How ragged its border is.
    fibre: f64,
    middle: DVec2,
    slant: DVec2,
}

impl<'a> Maker<'a> {
    fn new(p: &'a BreakParameters, setting: &'a Setting) -> Self {
        let direction = |degrees: f64| unit(1.0, degrees.to_radians());
        // A plane along the grain has no height over the section; what is past the stem is limited later.
        let steepness = libm::tan(p.inclination.min(89.5).to_radians());
        Maker {
            p,
            setting,
            slabs: Slabs::new(p.slab_count as usize, p.seed),
            tension: direction(p.ductile.direction),
            tilt: direction(p.inclination_direction) * steepness,
            noise_radius: p.noise_diameter(2.0 * setting.radius) / 2.0,
            high: p.high.sector(),
            low: p.low.sector(),
            ductile: p.ductile.sector(),
        }
    }

    fn seed(&self, purpose: u64) -> u64 {
        self.p.seed ^ purpose << 20
    }

    /// Inclination, layers, Perlin and white noise: Eqs. 1 to 5. `across` is in radii, `unit` in ring coordinates.
    fn published(
        &self,
        across: DVec2,
        unit: DVec2,
        rho: f64,
        phi: f64,
        zone: Zone,
        key: i64,
    ) -> f64 {
        let degrees = phi.to_degrees();
        let mut height = across.dot(self.tilt);
        if self.high.contains(degrees, rho) {
            height += self.p.high.height;
        }
        if self.low.contains(degrees, rho) {
            height += self.p.low.height;
        }
        height + self.noise(unit, self.p.zone(zone), key)
    }

    fn noise(&self, unit: DVec2, zone: &ZoneParameters, key: i64) -> f64 {
        let (mut amplitude, mut frequency) = (zone.perlin_amplitude, zone.perlin_frequency);
        let mut height = 0.0;
        if amplitude > 0.0 {
            for octave in 0..zone.perlin_octaves {
                let at = unit * (self.noise_radius * frequency);
                let n = noise::plane(self.seed(purpose::PERLIN) + u64::from(octave), at);
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

    /// Length of the thorn at a place, 0 for none: Eq. 8 with P the probability of a thorn.
    fn thorn(&self, rho: f64, phi: f64, zone: Zone, key: i64) -> f64 {
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
        let draw = |purpose: u64, length: f64, probability: f64| {
            let meets = noise::unit(self.seed(purpose), key, 0, 0) < probability;
            if meets {
                length * noise::unit(self.seed(purpose::LENGTH), key, purpose as i64, 0)
            } else {
                0.0
            }
        };
        draw(purpose::THORN, length, probability).max(draw(
            purpose::ZONE_THORN,
            tissue.thorn_length,
            tissue.thorn_probability,
        ))
    }

    /// How far a place is from the edge of the compression shelf, in radii: below 0 on the shelf.
    fn off_shelf(&self, unit: DVec2) -> f64 {
        let ragged = 0.16 * noise::plane(self.seed(purpose::SHELF), unit * 3.0);
        unit.dot(self.tension) + 1.0 - 2.0 * self.p.compression_shelf + ragged
    }

    fn level(&self, index: usize, bundle: &Bundle, bundles: &Bundles, pith: DVec2) -> Level {
        let p = self.p;
        let key = index as i64;
        let rho = bundle.rho.min(1.0);
        let unit = unit(rho, bundle.phi);
        let bark = if bundle.bark { 1.0 } else { 0.0 };
        let zone = p.proportions().zone_at(rho, bark);
        let middle = match bundles.tips[index] {
            NONE => unit * self.setting.radius + pith,
            tip => bundles.layout.nodes[tip as usize],
        };
        let across = (middle - pith) / self.setting.radius;
        let published = self.published(across, unit, rho, bundle.phi, zone, key);
        let relief = self.setting.relief;
        let shelf = self.off_shelf(unit);
        // Torn wood stands free within a tenth of a radius of the shelf's edge.
        let torn = if p.compression_shelf > 0.0 {
            noise::smoothstep(-0.05, 0.1, shelf)
        } else {
            1.0
        };
        let slab = self.slabs.at(rho, bundle.phi);
        let random = |purpose: u64, a: i64, b: i64| noise::unit(self.seed(purpose), a, b, 0);
        if bundle.bark {
            let edge = self.bark_edge(bundle.phi);
            let wood = p.slab_height * relief * torn * self.slabs.at(0.97, bundle.phi).height;
            let base = published + wood + p.bark_offset + p.bark_height * edge;
            return Level {
                base,
                tip: base,
                thorn: 0.0,
                fibre: 0.3 * p.bark_height,
                middle,
                slant: DVec2::ZERO,
            };
        }
        // Slivers: a few bundles side by side share one height; short ones are common, long ones rare.
        let group = random(
            purpose::GROUP,
            i64::from(bundle.ring / 3),
            i64::from(bundle.sector / 2),
        );
        let own = random(purpose::SLIVER, key, 0);
        let rare = |x: f64| x * x * x * x;
        let sliver = 1.1 * (rare(group) - 0.2) + 1.3 * (rare(own) - 0.2);
        // Both halves keep their splinters: every other slab tears downwards.
        let sliver = if slab.height > 0.0 { sliver } else { -sliver };
        let along_ring = bundle.phi * 0.8;
        let step = noise::line(
            self.seed(purpose::STEP) + u64::from(bundle.ring),
            along_ring,
        );
        let torn_height = relief
            * (p.slab_height * slab.height + p.sliver_height * sliver * slab.splinters)
            + p.step_height * step;
        let crushed = p.compression_height * (random(purpose::SHELF, key, 1) - 0.5);
        let mut base = published + torn * torn_height + (1.0 - torn) * crushed;
        base -= self.split(shelf, key);
        let thorn = self.thorn(rho, bundle.phi, zone, key);
        let fibre = relief * p.fibre_height * (0.25 + 0.75 * torn);
        let slant = slab.slant * (torn * relief * p.slab_height);
        base += slant.dot(unit);
        let tip = if thorn > 0.0 {
            base + thorn
        } else {
            // A blade that runs out to a point, on the piece that keeps this slab's splinters.
            let length = random(purpose::FIBRE, key, 1);
            let blade = relief * torn * p.sliver_height * (0.06 + 1.1 * length * length * length);
            base + fibre * (2.0 * own - 0.5) + if slab.height > 0.0 { blade } else { -blade }
        };
        Level {
            base,
            tip,
            thorn,
            fibre,
            middle,
            slant: slant + self.tilt,
        }
    }

    /// Edge of the bark around the stem: wide flaps with narrow teeth between furrows, about −1 to 1.
    fn bark_edge(&self, phi: f64) -> f64 {
        let seed = self.seed(purpose::BARK);
        // The angle on a circle, so that the edge closes.
        let on = |scale: f64| unit(scale, phi);
        0.7 * noise::plane(seed, on(1.3))
            + 0.5 * noise::plane(seed + 1, on(4.0))
            + 0.3 * noise::plane(seed + 2, on(12.0))
    }

    /// Depth of the split between the tension and the compression side.
    fn split(&self, shelf: f64, key: i64) -> f64 {
        const WIDTH: f64 = 0.05;
        let near = 1.0 - (shelf - 0.02).abs() / WIDTH;
        if self.p.split <= 0.0 || near <= 0.0 || self.p.compression_shelf <= 0.0 {
            return 0.0;
        }
        self.p.split * near * (0.4 + 0.6 * noise::unit(self.seed(purpose::SHELF), key, 7, 0))
    }

    /// Height at a corner of a bundle's border.
    fn border(&self, level: &Level, cell: u32, node: u32, bundles: &Bundles, pith: DVec2) -> f64 {
        let key =
            |purpose: u64| noise::unit(self.seed(purpose), i64::from(cell), i64::from(node), 3);
        let at = bundles.layout.nodes[node as usize];
        let (_, phi) = bundles.addresses[node as usize];
        let slope = level.slant.dot(at - level.middle) / self.setting.radius;
        if bundles.bundles[cell as usize].bark {
            // Nodes beyond the bark repeat the heights of those below them, so that the edge runs straight outwards.
            let unit = bundles.directions[node as usize];
            let edge = self.p.bark_height
                * (self.bark_edge(phi) - self.bark_edge(bundles.bundles[cell as usize].phi));
            let lean = (unit * self.setting.radius - (level.middle - pith)).dot(self.tilt)
                / self.setting.radius;
            return level.base + edge + lean;
        }
        if level.thorn > 0.0 {
            let shaft = self.p.thorn_shaft * (0.85 + 0.3 * key(purpose::SHAFT));
            return level.base + level.thorn * shaft.clamp(0.5, 0.8) + slope;
        }
        level.base + slope + level.fibre * (key(purpose::FIBRE) - 0.5)
    }
}

/// Share of the free length within which heights are left alone.
const FREE: f64 = 0.75;
/// Share of the free length that limited heights never pass.
const MOST: f64 = 0.97;

/// Places heights (in radii) along the axis and bends those that would leave the stem back into it, keeping their order.
fn finish(
    bundles: &Bundles,
    mut corners: Vec<[f64; 3]>,
    setting: &Setting,
    thorns: Vec<Thorn>,
) -> Heights {
    let (below, above) = (
        setting.place - setting.usable.0,
        setting.usable.1 - setting.place,
    );
    let (mut wanted, mut range) = (
        [f64::INFINITY, f64::NEG_INFINITY],
        [f64::INFINITY, f64::NEG_INFINITY],
    );
    let mut limited = 0;
    let mut sorted: Vec<f64> = corners.iter().flatten().copied().collect();
    let at = |part: f64| (part * (sorted.len().max(1) - 1) as f64) as usize;
    let (low, high) = (at(0.05), at(0.95));
    let mut hundredth = |i: usize| {
        sorted.select_nth_unstable_by(i, f64::total_cmp);
        sorted[i] * setting.radius
    };
    let relief_range = if corners.is_empty() {
        0.0
    } else {
        hundredth(high) - hundredth(low)
    };
    for height in corners.iter_mut().flatten() {
        let h = *height * setting.radius;
        wanted = [wanted[0].min(h), wanted[1].max(h)];
        let most = if h < 0.0 { below } else { above };
        let over = h.abs() - FREE * most;
        let h = if over > 0.0 {
            limited += 1;
            let room = (MOST - FREE) * most;
            (FREE * most + room * over / (over + room)).copysign(h)
        } else {
            h
        };
        range = [range[0].min(h), range[1].max(h)];
        *height = setting.place + h;
    }
    Heights {
        surface: Surface {
            layout: bundles.layout.clone(),
            heights: corners,
        },
        limited,
        wanted: (wanted[0], wanted[1]),
        range: (range[0], range[1]),
        relief_range,
        thorns,
    }
}
