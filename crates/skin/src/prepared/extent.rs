//! How far the skin of a limb reaches about its pith.

use crate::texture::SectionSquare;
use glam::{DVec2, DVec3};
use greenstick_fracture::layout::wrap_angle;
use greenstick_wood::stem::FoundStem;
use greenstick_wood::tissue::{MAX_BARK_START, MIN_BARK_START};
use std::f64::consts::{PI, TAU};

/// How far the skin of the limb reaches about the pith.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SectionExtent {
    /// Ring coordinates between which all of it lies.
    pub reach: (f64, f64),
    /// Greatest distance from the pith, m.
    pub radius: f64,
    /// Ring coordinate at which the bark begins.
    pub bark: f64,
    /// Ring coordinate below which it begins at the latest, in sectors of equal width from the angle −π on: where the skin dips, as in a
    /// deep furrow.
    pub bark_below: [f64; DIP_SECTORS],
    /// Angles (rad) between which it lies, where the pith is outside of the section.
    pub arc: Option<(f64, f64)>,
}

/// Length of stem on either side of the break, in radii, whose skin tells how deep the bark's furrows are.
const FURROW_REACH: f64 = 1.5;
/// Length of stem on either side of the break, in radii, whose dips wood stays below: about what splinters reach.
const DIP_REACH: f64 = 3.0;
/// Sectors in which dips of the skin are known.
const DIP_SECTORS: usize = 96;
/// Ring coordinate by which bark begins below a dip, and farthest below where it begins elsewhere.
const BELOW_DIPS: f64 = 0.012;
const DEEPEST_DIP: f64 = 0.06;
/// Ring coordinate by which bark may begin farther out for each radian away from a dip.
const RISE: f64 = 0.3;
/// Part of the skin that lies in furrows.
const FURROW_SHARE: usize = 10;
/// Ring coordinate by which wood begins below the furrows.
const BELOW_FURROWS: f64 = 0.02;
/// An arc of a board is widened by this part, so that the skin lies within it.
const ARC_MARGIN: f64 = 0.03;
/// Arc (rad) from which on the pith counts as inside a board.
const SURROUNDED: f64 = 3.0;
/// The square is wider than the skin by this factor.
const SQUARE_MARGIN: f64 = 1.02;

/// What is gathered of the skin, point by point.
struct Gathered {
    /// Least and greatest ring coordinate.
    rho: (f64, f64),
    radius: f64,
    /// Ring coordinates near the break.
    near: Vec<f64>,
    /// The least of them in each sector.
    dips: [f64; DIP_SECTORS],
    /// Least and greatest angle about the pith, from the direction of the sections' centroids, rad.
    angle: (f64, f64),
}

impl SectionExtent {
    /// The extent of the limb of a stem, whose triangles have the corners `corners` with grain coordinates `grain`.
    pub fn new(found: &FoundStem, corners: &[[u32; 3]], grain: &[DVec3]) -> Self {
        let stem = &found.stem;
        let pith = stem.rings.pith();
        let board = stem.kind.is_sawn();
        let forward = stem
            .sections
            .iter()
            .fold(DVec2::ZERO, |sum, s| sum + s.centroid)
            - pith;
        let mut skin = Gathered {
            rho: (f64::INFINITY, 0.0),
            radius: 0.0,
            near: Vec::new(),
            dips: [f64::INFINITY; DIP_SECTORS],
            angle: (f64::INFINITY, f64::NEG_INFINITY),
        };
        let mut visited = vec![false; grain.len()];
        for &t in &found.limb {
            let points = corners[t as usize];
            let c = points.map(|p| grain[p as usize]);
            for k in 0..3 {
                let point = c[k].truncate();
                if board {
                    // The wood nearest to the pith may lie in the middle of an edge.
                    let (a, b) = (point, c[(k + 1) % 3].truncate());
                    let t = (pith - a).dot(b - a) / (b - a).length_squared().max(1e-300);
                    let rho = stem.rings.address(a.lerp(b, t.clamp(0.0, 1.0))).0;
                    skin.rho.0 = skin.rho.0.min(rho);
                }
                if std::mem::replace(&mut visited[points[k] as usize], true) {
                    continue;
                }
                let (rho, phi) = stem.rings.address(point);
                skin.rho.1 = skin.rho.1.max(rho);
                skin.radius = skin.radius.max(point.distance(pith));
                let far = (c[k].z - stem.location).abs() / stem.radius;
                if far < FURROW_REACH {
                    skin.near.push(rho);
                }
                if far < DIP_REACH {
                    let place = (wrap_angle(phi) + PI) / TAU * DIP_SECTORS as f64;
                    let dip = &mut skin.dips[(place as usize).min(DIP_SECTORS - 1)];
                    *dip = dip.min(rho);
                }
                let off = point - pith;
                let angle = libm::atan2(forward.perp_dot(off), forward.dot(off));
                skin.angle = (skin.angle.0.min(angle), skin.angle.1.max(angle));
            }
        }
        let (low, high) = skin.angle;
        if board && high - low < SURROUNDED {
            skin.board(libm::atan2(forward.y, forward.x))
        } else {
            skin.round()
        }
    }
}

impl Gathered {
    /// The extent of a board whose pith lies outside of it; `forward` is the angle (rad) of its middle.
    fn board(&self, forward: f64) -> SectionExtent {
        let (low, high) = self.angle;
        let margin = ARC_MARGIN * (high - low);
        SectionExtent {
            reach: (0.98 * self.rho.0, 1.02 * self.rho.1),
            radius: self.radius,
            bark: 1.0,
            bark_below: [1.0; DIP_SECTORS],
            arc: Some((forward + low - margin, forward + high + margin)),
        }
    }

    /// The extent of wood about its pith.
    fn round(mut self) -> SectionExtent {
        self.near.sort_by(f64::total_cmp);
        let furrow = self.near.get(self.near.len() / FURROW_SHARE).copied();
        let bark = furrow.unwrap_or(MAX_BARK_START) - BELOW_FURROWS;
        let bark = bark.clamp(MIN_BARK_START, MAX_BARK_START);
        // What lies between two sectors belongs to both. From a dip the bark rises gradually to both sides, so that bundles stay in order.
        let below = |i: usize| {
            let rising = |k: usize| {
                let away = k.min(DIP_SECTORS - k).saturating_sub(1);
                self.dips[(i + k) % DIP_SECTORS] + RISE * TAU * away as f64 / DIP_SECTORS as f64
            };
            let least = (0..DIP_SECTORS).map(rising).fold(f64::INFINITY, f64::min);
            (least - BELOW_DIPS).clamp(bark - DEEPEST_DIP, 1.0)
        };
        let bark_below = std::array::from_fn(below);
        SectionExtent {
            reach: (0.0, self.rho.1.max(1.0)),
            radius: self.radius,
            bark,
            bark_below,
            arc: None,
        }
    }
}

/// The square about the limb's skin, whose ring coordinates begin at `least`.
pub(super) fn square_about(
    found: &FoundStem,
    least: f64,
    corners: &[[u32; 3]],
    grain: &[DVec3],
) -> SectionSquare {
    let points = found.limb.iter().flat_map(|&t| corners[t as usize]);
    let (low, high) = points
        .map(|p| grain[p as usize].truncate())
        .fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), p| {
            (low.min(p), high.max(p))
        });
    let size = high - low;
    SectionSquare {
        size,
        ..SectionSquare::round((low + high) / 2.0, size.max_element() * SQUARE_MARGIN)
    }
    .with_rings(least, found.stem.rings.mean_radius(1.0))
}
