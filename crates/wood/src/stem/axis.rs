//! The centreline of a stem: a smooth curve with a frame that does not twist (parallel transport, Bishop 1975).

use glam::DVec3;

/// A point of an [`Axis`] and the directions along and across the stem there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frame {
    /// Point on the curve, m.
    pub origin: DVec3,
    /// First direction across the stem (unit); angles are counted from it.
    pub x: DVec3,
    /// Second direction across the stem (unit), `tangent × x`.
    pub y: DVec3,
    /// Along the stem (unit).
    pub tangent: DVec3,
}

/// A smooth curve through given points, with transported frames. Its parameter is the length along the points, m.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    points: Vec<DVec3>,
    /// Length along the points, starting at 0.
    lengths: Vec<f64>,
    /// Derivative by length at each point.
    slopes: Vec<DVec3>,
    /// Transported first direction at each point.
    across: Vec<DVec3>,
}

impl Axis {
    /// The curve through `points` (m). Consecutive points that coincide are taken once; `None` for fewer than two
    /// distinct, finite points. The first direction across is the one nearest to `across`, where given.
    ///
    /// ```
    /// use glam::DVec3;
    /// use greenstick_wood::stem::Axis;
    ///
    /// let axis = Axis::new(&[DVec3::ZERO, DVec3::Y, DVec3::Y * 3.0], None).expect("three distinct points");
    /// assert_eq!(axis.length(), 3.0);
    /// assert_eq!(axis.frame(2.0).tangent, DVec3::Y);
    /// assert!((axis.length_at(DVec3::new(0.5, 2.5, 0.0)) - 2.5).abs() < 1e-12);
    /// ```
    pub fn new(points: &[DVec3], across: Option<DVec3>) -> Option<Self> {
        let mut distinct: Vec<DVec3> = Vec::with_capacity(points.len());
        for &p in points {
            if !p.is_finite() {
                return None;
            }
            if distinct.last() != Some(&p) {
                distinct.push(p);
            }
        }
        if distinct.len() < 2 {
            return None;
        }
        let mut lengths = vec![0.0];
        for pair in distinct.windows(2) {
            lengths.push(lengths[lengths.len() - 1] + pair[0].distance(pair[1]));
        }
        let last = distinct.len() - 1;
        let chord = |i: usize| (distinct[i + 1] - distinct[i]) / (lengths[i + 1] - lengths[i]);
        let slopes: Vec<DVec3> = (0..=last)
            .map(|i| match i {
                0 => chord(0),
                _ if i == last => chord(last - 1),
                // Weighted by the opposite interval: the derivative of the parabola through three points.
                _ => {
                    let (before, after) =
                        (lengths[i] - lengths[i - 1], lengths[i + 1] - lengths[i]);
                    (chord(i - 1) * after + chord(i) * before) / (before + after)
                }
            })
            .map(|d| d.try_normalize().unwrap_or(DVec3::Z))
            .collect();
        let mut direction = across.map_or(DVec3::ZERO, |d| d.reject_from_normalized(slopes[0]));
        direction = direction
            .try_normalize()
            .unwrap_or_else(|| slopes[0].any_orthonormal_vector());
        let mut frames = vec![direction];
        for pair in slopes.windows(2) {
            direction = glam::DQuat::from_rotation_arc(pair[0], pair[1]) * direction;
            direction = direction.reject_from_normalized(pair[1]).normalize();
            frames.push(direction);
        }
        Some(Axis {
            points: distinct,
            lengths,
            slopes,
            across: frames,
        })
    }

    /// Length of the curve, m.
    pub fn length(&self) -> f64 {
        self.lengths[self.lengths.len() - 1]
    }

    /// The points the curve was made from.
    pub fn points(&self) -> &[DVec3] {
        &self.points
    }

    /// Length (m) of the curve at each of its points.
    pub fn lengths(&self) -> &[f64] {
        &self.lengths
    }

    /// Index of the interval that contains `s`.
    fn interval(&self, s: f64) -> usize {
        self.lengths
            .partition_point(|&l| l <= s)
            .clamp(1, self.lengths.len() - 1)
            - 1
    }

    /// Point and derivative at `s`; the curve goes straight on beyond its ends.
    fn point_and_slope(&self, s: f64) -> (DVec3, DVec3) {
        if s <= 0.0 {
            return (self.points[0] + self.slopes[0] * s, self.slopes[0]);
        }
        if s >= self.length() {
            let last = self.points.len() - 1;
            return (
                self.points[last] + self.slopes[last] * (s - self.length()),
                self.slopes[last],
            );
        }
        let i = self.interval(s);
        let h = self.lengths[i + 1] - self.lengths[i];
        let t = (s - self.lengths[i]) / h;
        let (a, b) = (self.points[i], self.points[i + 1]);
        let (m, n) = (self.slopes[i] * h, self.slopes[i + 1] * h);
        // Cubic Hermite interpolation, written about `a` so that straight stems stay exactly straight.
        let d = b - a;
        let point = a + m * t + (d * 3.0 - m * 2.0 - n) * (t * t) + (m + n - d * 2.0) * (t * t * t);
        let slope =
            (m + (d * 3.0 - m * 2.0 - n) * (2.0 * t) + (m + n - d * 2.0) * (3.0 * t * t)) / h;
        (point, slope)
    }

    /// Point and directions at length `s` (m), which may lie beyond the ends.
    pub fn frame(&self, s: f64) -> Frame {
        let (origin, slope) = self.point_and_slope(s);
        let tangent = slope.try_normalize().unwrap_or(DVec3::Z);
        let i = self.interval(s);
        let t = ((s - self.lengths[i]) / (self.lengths[i + 1] - self.lengths[i])).clamp(0.0, 1.0);
        let x = self.across[i]
            .lerp(self.across[i + 1], t)
            .reject_from_normalized(tangent);
        let x = x
            .try_normalize()
            .unwrap_or_else(|| tangent.any_orthonormal_vector());
        Frame {
            origin,
            x,
            y: tangent.cross(x),
            tangent,
        }
    }

    /// The length (m) whose section plane contains `world`; of several, the one near the closest of the curve's points.
    pub fn length_at(&self, world: DVec3) -> f64 {
        let nearest = (0..self.points.len())
            .min_by(|&a, &b| {
                self.points[a]
                    .distance_squared(world)
                    .total_cmp(&self.points[b].distance_squared(world))
            })
            .unwrap_or(0);
        self.length_near(world, self.lengths[nearest])
    }

    /// [`Axis::length_at`], by Newton's iteration from `guess` (m).
    pub fn length_near(&self, world: DVec3, guess: f64) -> f64 {
        let miss = |s: f64| {
            let (point, slope) = self.point_and_slope(s);
            (world - point).dot(slope.normalize_or_zero())
        };
        let mut s = guess;
        let mut value = miss(s);
        for _ in 0..50 {
            if value == 0.0 {
                break;
            }
            // The plane turns slowly along a stem, so that the miss falls by nearly one per metre; a secant corrects that.
            let next = s + value;
            let next_value = miss(next);
            let slope = (next_value - value) / (next - s);
            let better = if slope < -0.1 {
                s - value / slope
            } else {
                next
            };
            let better_value = miss(better);
            let done = (better - s).abs() <= 1e-15 * (1.0 + s.abs());
            (s, value) = (better, better_value);
            if done {
                break;
            }
        }
        s
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_orthonormal_and_lengths_invert() {
        let points: Vec<DVec3> = (0..30)
            .map(|i| i as f64 * 0.05)
            .map(|a| DVec3::new(a.cos(), a.sin(), 0.3 * a))
            .collect();
        let axis = Axis::new(&points, None).unwrap();
        for k in 0..100 {
            let s = axis.length() * (k as f64 / 99.0 * 1.2 - 0.1);
            let f = axis.frame(s);
            assert!(f.x.dot(f.tangent).abs() < 1e-14 && (f.y.length() - 1.0).abs() < 1e-14);
            let p = f.origin + f.x * 0.05 - f.y * 0.08;
            assert!((axis.length_at(p) - s).abs() < 1e-12);
        }
    }

    #[test]
    fn a_straight_axis_is_exactly_straight() {
        let points: Vec<DVec3> = (0..9)
            .map(|i| DVec3::new(0.0, 0.0, i as f64 * 0.125))
            .collect();
        let axis = Axis::new(&points, Some(DVec3::X)).unwrap();
        let f = axis.frame(0.3);
        assert_eq!((f.x, f.y, f.tangent), (DVec3::X, DVec3::Y, DVec3::Z));
        assert!((f.origin - DVec3::new(0.0, 0.0, 0.3)).length() < 1e-15);
    }

    #[test]
    fn too_few_points_are_refused() {
        assert!(Axis::new(&[DVec3::ZERO, DVec3::ZERO], None).is_none());
        assert!(Axis::new(&[DVec3::ZERO, DVec3::splat(f64::NAN)], None).is_none());
    }
}
