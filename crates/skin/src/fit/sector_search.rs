//! The sector of the section (Yang 2019, Eqs. 2 to 7) that divides it best: a search over direction, angle and rings.

use super::statistics::Weighted;
use greenstick_fracture::parameters::Sector;

/// Step of the search in direction and angle, degrees.
const STEP_DEGREES: u32 = 10;
/// Steps of the search over the part of the rings.
const RING_STEPS: u32 = 10;
/// Scores that differ by less than this part are equal, summed in another order.
const EQUAL_SCORES: f64 = 1e-9;

/// A point of the section.
#[derive(Debug, Clone, Copy)]
pub(super) struct SectionAddress {
    /// Angle about the pith, degrees.
    pub angle: f64,
    /// Ring coordinate.
    pub ring: f64,
}

/// What lies in a sector.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct SectorContents {
    /// Number of points.
    pub count: usize,
    /// Sum of their weights.
    pub weight: f64,
    /// Sum of weight times value.
    pub sum: f64,
}

impl SectorContents {
    /// The contents of `sector`: those of the points that lie in it, each with its value.
    pub fn of(sector: &Sector, points: &[SectionAddress], values: &[Weighted]) -> SectorContents {
        let mut contents = SectorContents::default();
        for (point, v) in points.iter().zip(values) {
            if sector.contains(point.angle, point.ring) {
                contents.count += 1;
                contents.weight += v.weight;
                contents.sum += v.weight * v.value;
            }
        }
        contents
    }
}

/// Returns the sector with the highest `score` above zero. Of sectors that score alike, because they hold the same
/// points, it returns the one in the middle.
pub(super) fn best_sector(
    points: &[SectionAddress],
    values: &[Weighted],
    score: impl Fn(&SectorContents) -> f64,
) -> Option<Sector> {
    let score = |sector: &Sector| score(&SectorContents::of(sector, points, values));
    let mut best = 0.0;
    let mut equals: Vec<Sector> = Vec::new();
    for rings in 1..=RING_STEPS {
        for angle in 1..=360 / STEP_DEGREES {
            for direction in 0..360 / STEP_DEGREES {
                let sector = Sector {
                    direction: f64::from(direction * STEP_DEGREES),
                    angle: f64::from(angle * STEP_DEGREES),
                    rings: f64::from(rings) / f64::from(RING_STEPS),
                };
                let found = score(&sector);
                if found > best * (1.0 + EQUAL_SCORES) {
                    best = found;
                    equals.clear();
                }
                if found > 0.0 && found >= best * (1.0 - EQUAL_SCORES) {
                    equals.push(sector);
                }
            }
        }
    }
    let middle = mean_sector(&equals);
    if score(&middle) >= best * (1.0 - EQUAL_SCORES) && !equals.is_empty() {
        return Some(middle);
    }
    let distance = |sector: &Sector| {
        let turn = (sector.direction - middle.direction + 180.0).rem_euclid(360.0) - 180.0;
        let (angle, rings) = (sector.angle - middle.angle, sector.rings - middle.rings);
        turn.abs() + angle.abs() + 360.0 * rings.abs()
    };
    equals
        .into_iter()
        .min_by(|a, b| distance(a).total_cmp(&distance(b)))
}

/// The mean of sectors; direction 0 where they point all around.
fn mean_sector(sectors: &[Sector]) -> Sector {
    let count = sectors.len() as f64;
    let (mut x, mut y, mut angle, mut rings) = (0.0, 0.0, 0.0, 0.0);
    for sector in sectors {
        let (sin, cos) = libm::sincos(sector.direction.to_radians());
        (x, y) = (x + cos, y + sin);
        (angle, rings) = (angle + sector.angle, rings + sector.rings);
    }
    let all_around = libm::hypot(x, y) < EQUAL_SCORES * count.max(1.0);
    Sector {
        direction: if all_around {
            0.0
        } else {
            libm::atan2(y, x).to_degrees().rem_euclid(360.0)
        },
        angle: angle / count,
        rings: rings / count,
    }
}
