//! The ends of bundles where wood broke short or was crushed: they lean together in groups, some groups were pulled out of the other
//! piece as stubs, and others left pits.

use super::{TornRelief, heavy};
use crate::height_model::purpose;
use glam::DVec2;
use greenstick_wood::noise;

/// How many patches with rough ends follow each other over a radius, and how rough ends are between them where wood broke short
/// and where it was crushed.
const PATCHES: f64 = 3.6;
const LEAST_ROUGH: f64 = 0.12;
const LEAST_CRUSHED: f64 = 0.28;
/// Height of the folds of crushed wood, radii, that short ends there are as high as. They differ less than folds do: a bundle is as wide
/// under low folds as under high ones.
const CRUSHED_HEIGHT: f64 = 0.029;
/// How rough the ends of brittle wood are over its steps: they are fine grains of its plates.
const BRITTLE_SHARDS: f64 = 0.05;
/// Slopes of the ends of a group and of a bundle, height per radius, over the height of the relief of short ends.
const GROUP_LEAN: f64 = 9.0;
const OWN_LEAN: f64 = 5.5;
/// Shares of the groups that stand out and that are sunk, how far at least and at most, and by how much their bundles differ,
/// over the same.
const STUBS: f64 = 0.1;
const PITS: f64 = 0.1;
const STUB_HEIGHT: (f64, f64) = (0.5, 2.0);
const STUB_BUNDLES: f64 = 0.45;
/// Height of the outlines of bundles' ends, over the same.
const POINTS: f64 = 0.9;

/// The short end of a bundle; heights are radii.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Shard {
    /// How far it stands out.
    pub height: f64,
    /// Slope, height per radius.
    pub slant: DVec2,
    /// Height of the outline of its end.
    pub blade: f64,
}

impl TornRelief<'_> {
    /// Returns the short end of a bundle with a number, of a part of a sliver, where this much of the wood is torn rather than
    /// crushed. `middle` is its middle, m, and `width` its width along the ring, radii: over its width it leans by no more than the
    /// height of the relief.
    pub(super) fn shard(
        &self,
        (key, part): (i64, i64),
        (middle, width): (DVec2, f64),
        torn: f64,
    ) -> Shard {
        let p = self.model.p;
        let crushed = (p.compression_height * CRUSHED_HEIGHT).sqrt();
        let relief = torn * self.brittle * BRITTLE_SHARDS * p.step_height + (1.0 - torn) * crushed;
        if relief <= 0.0 {
            return Shard::default();
        }
        let at = (middle - self.ends.pith) / self.model.site.radius;
        let patch = noise::gradient_2d(self.model.seed(purpose::SHARD), at * PATCHES);
        let least = LEAST_CRUSHED + (LEAST_ROUGH - LEAST_CRUSHED) * torn;
        let rough = least + (1.0 - least) * noise::smoothstep(-0.05, 0.3, patch);
        let relief = relief * rough;
        let own = |k: i64| 2.0 * self.random(purpose::SHARD, key, k) - 1.0;
        let group = |k: i64| 2.0 * self.random(purpose::SHARD, part, 100 + k) - 1.0;
        let slant =
            DVec2::new(group(0), group(1)) * GROUP_LEAN + DVec2::new(own(0), own(1)) * OWN_LEAN;
        let kind = 0.5 + 0.5 * group(2);
        let (least, most) = STUB_HEIGHT;
        let stands = least + (most - least) * group(3).abs() + STUB_BUNDLES * own(2);
        let height = if kind < STUBS {
            stands
        } else if kind > 1.0 - PITS {
            -stands
        } else {
            0.0
        };
        let wide = width.max(1.0 / f64::from(p.rings));
        Shard {
            height: relief * height,
            slant: (slant * relief).clamp_length_max(relief / wide),
            blade: relief * POINTS * heavy(0.5 + 0.5 * own(3)),
        }
    }
}
