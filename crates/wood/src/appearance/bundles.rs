//! Bundles of fibres: wood splits between them, so that a face along the grain is a row of long, narrow facets with sharp edges. Each
//! is a body in space, bounded by surfaces that wander along the grain and run together, where it ends in a point.

use super::mix::{mix_scalar, visible_detail};
use super::wood::WoodAppearance;
use crate::noise::{hash, smoothstep};
use crate::rings::periodic_cells;
use glam::{DVec2, DVec3};

/// Bundles of one size.
struct BundleSize {
    /// Mean width and depth, m.
    width: f64,
    /// Length after which a boundary has wandered by up to its width, in widths.
    stretch: f64,
    /// Share of the brightness.
    share: f64,
    /// Largest tilt of a facet, m per m.
    tilt: f64,
}

const fn bundle(width: f64, stretch: f64, share: f64, tilt: f64) -> BundleSize {
    BundleSize {
        width,
        stretch,
        share,
        tilt,
    }
}

/// Slivers, bundles and strands.
const SIZES: [BundleSize; 3] = [
    bundle(1.1e-3, 64.0, 0.17, 0.26),
    bundle(0.42e-3, 70.0, 0.25, 0.30),
    bundle(0.15e-3, 100.0, 0.21, 0.24),
];
/// Radius of a stem, m, up to which slivers have that width, and how much wider those of thick stems are at most.
const FINE_RADIUS: f64 = 0.04;
const COARSEST: f64 = 8.0;
/// How far a boundary lies from its mean place at most, in widths: nearly half, so that some bundles vanish and others are wide.
const WANDER: f64 = 0.47;
/// Part of a bundle's width that has to be seen for its relief to show.
const RELIEF_DETAIL: f64 = 0.5;
/// How far the ridge of a bundle lies from its middle at most, in its width.
const RIDGE_ASIDE: f64 = 0.42;
/// Sizes of bundles that gape: the gaps of finer ones are below what an eye sees.
const OPEN_SIZES: usize = 2;
/// Share of boundaries that gape in places, how wide the dark line is, in widths, and how dark.
const OPEN_SHARE: f64 = 0.40;
const OPEN_WIDTH: f64 = 0.10;
const OPEN_DARKNESS: f64 = 0.50;
/// Sines of the angle between a boundary and a surface between which its dark line begins to show.
const LYING: (f64, f64) = (0.3, 0.6);
/// Shares of slivers and bundles in the tone that tissues take.
const TONES: [f64; 2] = [0.75, 0.65];
/// Direction of the lattice in the section: no face of a stem or a board is likely to lie along it.
const TURN: DVec2 = DVec2::new(0.825_335_614_909_678_3, 0.564_642_473_395_035_4);

// Purpose in the hash.
const BUNDLE: u64 = 0xb0;

/// What the bundles at a point look like.
#[derive(Default)]
pub(super) struct Bundles {
    /// Change of brightness, mean about 0.
    pub shade: f64,
    /// How much of a dark gap between bundles there is, 0 to 1.
    pub gap: f64,
    /// The tone of the slivers, −1 to 1: what is done sliver by sliver takes it.
    pub tone: f64,
    /// Relief, m.
    pub height: f64,
    /// Its slope.
    pub slope: DVec3,
}

/// Numbers that change along the grain, drawn at places one length apart.
struct Along {
    seed: u64,
    z: f64,
    period: i64,
}

impl Along {
    /// A smooth number from −1 to 1 for the item `(i, j)` of the section.
    fn value(&self, i: i64, j: i64) -> f64 {
        // Neighbours must not turn at one height.
        let start = 0.618_033_988_749_895 * i as f64 + 0.754_877_666_246_693 * j as f64;
        let z = self.z + (start - start.floor());
        let level = z.floor();
        let f = z - level;
        let at = |k: i64| {
            let k = match self.period {
                0 => k,
                period => k.rem_euclid(period),
            };
            (hash(self.seed, i, j, k) >> 40) as f64 * (2.0 / 16_777_215.0) - 1.0
        };
        let [a, b] = [at(level as i64), at(level as i64 + 1)];
        mix_scalar(a, b, f * f * (3.0 - 2.0 * f))
    }
}

/// One interval of a row with boundaries that wander.
struct Interval {
    number: i64,
    low: f64,
    high: f64,
    /// The boundary that is nearer, by its number.
    nearer: i64,
}

/// Finds the interval of a row `j` that holds `t`.
fn interval(along: &Along, t: f64, j: i64) -> Interval {
    let boundary = |k: i64| k as f64 + WANDER * along.value(k, j);
    let cell = t.floor() as i64;
    let (mut number, mut low, mut high) = (cell, boundary(cell), boundary(cell + 1));
    if t < low {
        (number, high, low) = (cell - 1, low, boundary(cell - 1));
    } else if t >= high {
        (number, low, high) = (cell + 1, high, boundary(cell + 2));
    }
    let nearer = number + i64::from(high - t < t - low);
    Interval {
        number,
        low,
        high,
        nearer,
    }
}

impl Interval {
    /// The height and the slope at `t` of a roof over it, whose ridge lies aside by a number from −1 to 1.
    fn roof(&self, t: f64, aside: f64) -> (f64, f64) {
        let ridge = 0.5 + RIDGE_ASIDE * aside;
        let (rise, fall) = (2.0 * (1.0 - ridge), 2.0 * ridge);
        let [up, down] = [rise * (t - self.low), fall * (self.high - t)];
        match up < down {
            true => (up, rise),
            false => (down, -fall),
        }
    }
}

impl WoodAppearance {
    /// Factor on the width of slivers: those that a thick stem tears into are as much wider.
    fn coarseness(&self) -> f64 {
        match self.pith > 0.0 {
            true => (self.radius / FINE_RADIUS).clamp(1.0, COARSEST),
            // Sawn wood is planed, and the pith may be far off.
            false => 1.0,
        }
    }

    /// Returns the bundles at a place of a surface with the normal `facing` in the section.
    pub(super) fn bundles(&self, place: DVec3, facing: DVec2, footprint: f64) -> Bundles {
        let flat = TURN.rotate(place.truncate());
        let facing = facing.try_normalize().map(|f| TURN.rotate(f));
        let mut sum = Bundles::default();
        let mut slope = DVec2::ZERO;
        for (n, size) in SIZES.iter().enumerate() {
            let width = match n {
                0 => size.width * self.coarseness(),
                _ => size.width,
            };
            let visible = visible_detail(1.25 * width, footprint);
            if visible == 0.0 {
                break;
            }
            let (length, period) = periodic_cells(width * size.stretch, self.period);
            let at = |purpose: u64| Along {
                seed: self.seed ^ BUNDLE ^ ((n as u64) << 8) ^ (purpose << 16),
                z: place.z / length,
                period,
            };
            let (rows, columns, tones) = (at(0), at(1), at(2));
            let [x, y] = (flat / width).to_array();
            let row = interval(&rows, y, i64::MIN / 2);
            let column = interval(&columns, x, row.number);
            let soft = 0.5 * footprint / width;
            let tone_of = |i: i64, j: i64| tones.value(i, j);
            let own = tone_of(column.number, row.number);
            // Across a boundary a pixel sees both sides.
            let beside = if column.nearer == column.number {
                -1
            } else {
                1
            };
            let off = (x - column.low).min(column.high - x);
            let tone = if off < soft {
                let other = tone_of(column.number + beside, row.number);
                mix_scalar(own, other, 0.5 * (1.0 - off / soft))
            } else {
                own
            };
            sum.shade += tone * size.share * visible;
            // Each bundle is a low roof in both directions, so that the relief goes on from one to the next.
            let (over_x, rise_x) = column.roof(x, own);
            let (over_y, rise_y) = row.roof(y, own);
            // Slopes of one pixel would glitter.
            let tilt = 4.0 * size.tilt * visible_detail(RELIEF_DETAIL * width, footprint);
            sum.height += tilt * over_x * over_y * width;
            slope += DVec2::new(rise_x * over_y, over_x * rise_y) * tilt;
            if n < OPEN_SIZES {
                let own = opening((&tones, &column, row.number), off, soft, facing);
                sum.gap = sum.gap.max(own * visible);
            }
            if let Some(share) = TONES.get(n) {
                sum.tone += share * tone * visible;
            }
        }
        // Back from the lattice.
        sum.slope = DVec2::new(TURN.x, -TURN.y).rotate(slope).extend(0.0);
        sum
    }
}

/// How dark the gap at the nearer boundary of an interval is, at a distance `off` from it, in widths.
fn opening(
    (tones, column, row): (&Along, &Interval, i64),
    off: f64,
    soft: f64,
    facing: Option<DVec2>,
) -> f64 {
    let wide = (0.5 * OPEN_WIDTH).max(soft);
    if off > wide {
        return 0.0;
    }
    let open = tones.value(column.nearer, row ^ 0x5_5555);
    let gape = smoothstep(1.0 - 2.0 * OPEN_SHARE, 1.0, open);
    // What lies in a gap would be a dark patch.
    let crossing = facing.map_or(1.0, |f| smoothstep(LYING.0, LYING.1, f.y.abs()));
    (1.0 - off / wide) * gape * crossing * OPEN_DARKNESS * (0.5 * OPEN_WIDTH / wide).sqrt()
}
