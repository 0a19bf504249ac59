//! The look of a stem's wood as the shader takes it: numbers, the ring field of its section, and the years.

use super::wire;
use bytemuck::{Pod, Zeroable};
use glam::{DVec2, Vec2};
use greenstick::session::BrokenWood;
use greenstick::wood::appearance::BarkAppearance;
use greenstick::wood::noise::unit;
use greenstick::wood::rings::StemAddress;
use serde::{Deserialize, Serialize};

/// Texels along each side of the ring field: at 256 the rings of a section lie within a hundredth of a ring width of where they are.
const FIELD_SIDE: usize = 256;
/// Texels of the years, and texels for one ring coordinate; bark reaches beyond 1.
const YEARS: usize = 2048;
const YEARS_PER_COORDINATE: f64 = 1638.4;

/// What a stem's wood looks like, in the layout of the shader's `Wood`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, Default)]
pub struct WoodNumbers {
    sapwood: [f32; 4],
    latewood: [f32; 4],
    heartwood: [f32; 4],
    pith: [f32; 4],
    phloem: [f32; 4],
    cork: [f32; 4],
    ridge: [f32; 4],
    furrow: [f32; 4],
    edges: [f32; 4],
    rings: [f32; 4],
    vessels: [f32; 4],
    square: [f32; 4],
    bark: [f32; 4],
    seed: [u32; 4],
    middle: [f32; 4],
}

/// The wood inside one break.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct WoodLook {
    /// The numbers.
    #[serde(with = "wire::one")]
    pub numbers: WoodNumbers,
    /// Side of the ring field, texels.
    pub field_side: u32,
    /// Four numbers for each texel: the ring coordinate and, where rings follow no coordinate, the ring, the place in it and its
    /// width.
    #[serde(with = "wire::plain")]
    pub field: Vec<[f32; 4]>,
    /// For each step of the ring coordinate the ring there, its inner and outer edge, and the strength of its latewood.
    #[serde(with = "wire::plain")]
    pub years: Vec<[f32; 4]>,
}

fn color(c: [f64; 3]) -> [f32; 4] {
    [c[0] as f32, c[1] as f32, c[2] as f32, 1.0]
}

/// 64 bits of a seed as 32.
fn folded(seed: u64) -> u32 {
    (seed ^ (seed >> 32)) as u32
}

impl Default for WoodLook {
    /// The wood of a stem of which nothing is known: its bark shows that of a branch.
    fn default() -> Self {
        let bark = BarkAppearance::default();
        WoodLook {
            numbers: WoodNumbers {
                ridge: color(bark.ridge_color),
                furrow: color(bark.furrow_color),
                edges: [1.0; 4],
                rings: [1.0, 0.0, 0.5, 0.0],
                vessels: [0.0, 0.0, 1.0, bark.lenticels as f32],
                square: [-1.0, -1.0, 2.0, 1.0],
                bark: [bark.furrow_width as f32, bark.furrow_depth as f32, 0.0, 0.0],
                ..WoodNumbers::default()
            },
            field_side: 1,
            field: vec![[0.5, 0.0, 0.0, 1.0]],
            years: years(&[], 0),
        }
    }
}

impl WoodLook {
    /// The wood of a break.
    pub fn new(wood: &BrokenWood) -> Self {
        let (stem, look) = (&wood.stem, &wood.appearance);
        let (w, bark) = (&look.wood, &look.bark);
        let pith = stem.rings.pith();
        let reach = stem.rings.extent().max(1e-6);
        let side = 2.0 * reach;
        let edges = look.rings.edges();
        let mut field = Vec::with_capacity(FIELD_SIDE * FIELD_SIDE);
        for y in 0..FIELD_SIDE {
            for x in 0..FIELD_SIDE {
                let at = |i: usize| -reach + side * (i as f64 + 0.5) / FIELD_SIDE as f64;
                let across = DVec2::new(at(x), at(y));
                let (rho, angle) = stem.rings.address(across + pith);
                let mut texel = [rho as f32, 0.0, 0.0, 1.0];
                if edges.is_empty() {
                    let address = StemAddress {
                        rho,
                        angle,
                        across,
                        along: stem.location,
                    };
                    if let Some(ring) = look.rings.ring_at(&address) {
                        texel[1] = ring.ring as f32;
                        texel[2] = ring.fraction as f32;
                        texel[3] = ring.width as f32;
                    }
                }
                field.push(texel);
            }
        }
        let flag = |on: bool| f32::from(u8::from(on));
        WoodLook {
            numbers: WoodNumbers {
                sapwood: color(w.sapwood_color),
                latewood: color(w.latewood_color),
                heartwood: color(w.heartwood_color),
                pith: color(w.pith_color),
                phloem: color(w.phloem_color),
                cork: color(w.cork_color),
                ridge: color(bark.ridge_color),
                furrow: color(bark.furrow_color),
                edges: [w.radius, w.pith, w.heartwood, w.phloem].map(|x| x as f32),
                rings: [
                    w.drawn_inner_bark_end() as f32,
                    w.latewood_contrast as f32,
                    w.latewood_width as f32,
                    flag(w.ring_porous),
                ],
                vessels: [
                    w.vessel_diameter,
                    w.ray_contrast,
                    w.ray_height,
                    bark.lenticels,
                ]
                .map(|x| x as f32),
                square: [-reach, -reach, side, FIELD_SIDE as f64].map(|x| x as f32),
                bark: [
                    bark.furrow_width as f32,
                    bark.furrow_depth as f32,
                    flag(!stem.kind.has_bark()),
                    flag(edges.is_empty()),
                ],
                seed: [folded(w.seed), folded(bark.seed), 0, 0],
                middle: [pith.x as f32, pith.y as f32, 0.0, 0.0],
            },
            field_side: FIELD_SIDE as u32,
            field,
            years: years(edges, w.seed),
        }
    }
}

/// A step from 0 to 1 between two edges, as shaders have it.
fn smoothstep(low: f32, high: f32, x: f32) -> f32 {
    let t = ((x - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

impl WoodLook {
    /// Ring coordinate of a place of the section (grain coordinates, m), and its angle about the pith, rad.
    pub fn address(&self, across: Vec2) -> (f32, f32) {
        let from_pith = across - self.pith();
        (self.rho(from_pith), from_pith.y.atan2(from_pith.x))
    }

    /// Where the pith is, grain coordinates, m.
    fn pith(&self) -> Vec2 {
        Vec2::new(self.numbers.middle[0], self.numbers.middle[1])
    }

    /// Ring coordinate of a place counted from the pith, m.
    fn rho(&self, from_pith: Vec2) -> f32 {
        let square = self.numbers.square;
        let last = self.field_side.max(1) as usize - 1;
        let n = self.field_side as f32;
        let t = (from_pith - Vec2::new(square[0], square[1])) / square[2] * n - 0.5;
        let low = t.floor();
        let f = t - low;
        let texel = |dx: i64, dy: i64| {
            let at = |x: f32, d: i64| (x as i64 + d).clamp(0, last as i64) as usize;
            self.field[at(low.y, dy) * (last + 1) + at(low.x, dx)][0]
        };
        let row = |dy| texel(0, dy) + (texel(1, dy) - texel(0, dy)) * f.x;
        row(0) + (row(1) - row(0)) * f.y
    }

    /// The place of the section (grain coordinates, m) with a ring coordinate at an angle: the inverse of [`WoodLook::address`].
    pub fn point(&self, rho: f32, angle: f32) -> Vec2 {
        let direction = Vec2::from_angle(angle);
        let (mut low, mut high) = (0.0, 0.5 * self.numbers.square[2]);
        for _ in 0..24 {
            let middle = 0.5 * (low + high);
            if self.rho(direction * middle) < rho {
                low = middle;
            } else {
                high = middle;
            }
        }
        self.pith() + direction * (0.5 * (low + high))
    }

    /// Ring coordinates at which tissues begin that follow no ring: the ends of the pith, of the wood and of the inner bark.
    pub fn tissue_edges(&self) -> [f32; 3] {
        let n = &self.numbers;
        [n.edges[1], n.edges[3], n.rings[0]]
    }

    /// Radius of the stem, m.
    pub fn stem_radius(&self) -> f32 {
        self.numbers.edges[0]
    }

    /// Part of a ring's width before its latewood.
    pub fn earlywood(&self) -> f32 {
        1.0 - self.numbers.rings[2].clamp(0.02, 1.0)
    }

    /// Linear colour of a sawn section at a ring coordinate, at a place (0 to 1) in its ring: that of the viewport without streaks,
    /// rays and vessels.
    pub fn end_grain(&self, rho: f32, fraction: f32) -> [f32; 3] {
        let n = &self.numbers;
        let [pith, phloem, cork] = self.tissue_edges();
        let start = self.earlywood();
        let rise = ((fraction - start) / (1.0 - start)).max(0.0);
        let late = rise * rise * n.rings[1] * 0.8;
        let heart = if n.edges[2] > 0.0 {
            1.0 - smoothstep(n.edges[2] - 0.035, n.edges[2] + 0.025, rho)
        } else {
            0.0
        };
        let tissue = match rho {
            r if r > cork => Some(n.cork),
            r if r > phloem => Some(n.phloem),
            r if r < pith => Some(n.pith),
            _ => None,
        };
        std::array::from_fn(|c| {
            if let Some(colour) = tissue {
                return colour[c] * 0.85;
            }
            let wood = n.sapwood[c] + (n.heartwood[c] - n.sapwood[c]) * heart;
            let darker = 1.0 + (n.latewood[c] / n.sapwood[c].max(1e-3) - 1.0) * late;
            wood * darker * (1.0 - 0.30 * (1.0 - 0.25 * late))
        })
    }
}

/// The years by ring coordinate; one ring where there are no edges.
fn years(edges: &[f64], seed: u64) -> Vec<[f32; 4]> {
    let all = [1.0];
    let edges = if edges.is_empty() { &all[..] } else { edges };
    (0..YEARS)
        .map(|i| {
            let rho = (i as f64 + 0.5) / YEARS_PER_COORDINATE;
            let ring = edges.partition_point(|&e| e < rho).min(edges.len() - 1);
            let inner = if ring == 0 { 0.0 } else { edges[ring - 1] };
            let strength = unit(seed, ring as i64, 2, 0);
            [
                ring as f32 + 1.0,
                inner as f32,
                edges[ring] as f32,
                strength as f32,
            ]
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn years_hold_the_edges_of_rings() {
        let found = years(&[0.25, 0.5, 1.0], 1);
        let at = |rho: f64| found[(rho * YEARS_PER_COORDINATE) as usize];
        assert_eq!(at(0.3)[..3], [2.0, 0.25, 0.5]);
        assert_eq!(at(0.1)[..3], [1.0, 0.0, 0.25]);
        assert_eq!(at(1.2)[..3], [3.0, 0.5, 1.0]);
        assert_eq!(years(&[], 1)[5][..3], [1.0, 0.0, 1.0]);
    }
}
