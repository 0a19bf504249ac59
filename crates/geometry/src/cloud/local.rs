//! A cloud in coordinates about its own corner, which do not depend on where the cloud lies.
//!
//! Scanners write coordinates in whole steps, of a millimetre say, so that many distances in a cloud are exactly equal. Which of
//! two equal ones counts as the smaller is decided by rounding, and far from the origin coordinates round differently. Local
//! coordinates are therefore whole multiples of a step that is far above the rounding and far below what a scanner resolves. The
//! step is decimal, as a scanner's are: its coordinates lie in the middle of what is rounded to one multiple, and never between
//! two.

use super::PointCloud;
use glam::DVec3;

/// Steps in the extent of a cloud, at least: about those of single precision.
const STEPS: f64 = (1u64 << 24) as f64;

/// The largest power of ten that is a whole number in double precision.
const MOST_STEPS_PER_METRE: f64 = 1e22;

/// Where a cloud's local coordinates begin, and the step of which they are multiples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LocalFrame {
    /// The least coordinates of the cloud, m.
    pub origin: DVec3,
    /// Steps in a metre: a power of ten; 0 where coordinates are not rounded.
    steps_per_metre: f64,
}

/// Returns the least power of ten, from 1 to [`MOST_STEPS_PER_METRE`], that is not below a number.
fn power_of_ten_above(value: f64) -> f64 {
    let mut power = 1.0;
    while power < value && power < MOST_STEPS_PER_METRE {
        power *= 10.0;
    }
    power
}

impl LocalFrame {
    /// Returns the frame of points; of those that are finite.
    pub fn new(points: &[DVec3]) -> Self {
        let finite = || points.iter().filter(|p| p.is_finite());
        let low = finite().fold(DVec3::INFINITY, |a, p| a.min(*p));
        let high = finite().fold(DVec3::NEG_INFINITY, |a, p| a.max(*p));
        let extent = (high - low).max_element();
        if !(extent > 0.0 && extent.is_finite()) {
            return LocalFrame {
                origin: DVec3::ZERO,
                steps_per_metre: 0.0,
            };
        }
        LocalFrame {
            origin: low,
            steps_per_metre: power_of_ten_above(STEPS / extent),
        }
    }

    /// Returns the local coordinates of a point.
    pub fn to_local(&self, point: DVec3) -> DVec3 {
        let local = point - self.origin;
        if self.steps_per_metre > 0.0 {
            (local * self.steps_per_metre).round() / self.steps_per_metre
        } else {
            local
        }
    }

    /// Returns a cloud in local coordinates.
    pub fn cloud(&self, cloud: &PointCloud) -> PointCloud {
        PointCloud {
            points: cloud.points.iter().map(|p| self.to_local(*p)).collect(),
            normals: cloud.normals.clone(),
            colours: cloud.colours.clone(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shifted_cloud_has_the_same_local_coordinates() {
        // Steps of 1 mm, as scanners write them; decimal fractions are no binary ones.
        let points: Vec<DVec3> = (0..2000u32)
            .map(|i| DVec3::new(f64::from(i % 37), f64::from(i * 7 % 101), f64::from(i)) * 0.001)
            .collect();
        let shift = DVec3::new(5e5, 5.4e6, 300.0);
        let shifted: Vec<DVec3> = points.iter().map(|p| *p + shift).collect();
        let local = |points: &[DVec3]| -> Vec<DVec3> {
            let frame = LocalFrame::new(points);
            points.iter().map(|p| frame.to_local(*p)).collect()
        };
        let own = local(&points);
        assert_eq!(own, local(&shifted));
        for (a, b) in own.iter().zip(&points) {
            assert!(a.distance(*b) < 2e-7, "{a} {b}");
        }
    }

    #[test]
    fn points_at_one_place_stay_there() {
        let frame = LocalFrame::new(&[DVec3::ONE; 3]);
        assert_eq!(frame.to_local(DVec3::ONE), DVec3::ONE);
        let none = LocalFrame::new(&[DVec3::NAN]);
        assert_eq!(none.to_local(DVec3::X), DVec3::X);
    }
}
