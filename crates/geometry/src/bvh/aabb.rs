//! Axis-aligned boxes.

use glam::DVec3;

/// An axis-aligned box that includes its faces.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Aabb {
    /// Smallest coordinates.
    pub low: DVec3,
    /// Largest coordinates.
    pub high: DVec3,
}

impl Aabb {
    /// The box without points; its union with any box is that box.
    pub const EMPTY: Aabb = Aabb {
        low: DVec3::INFINITY,
        high: DVec3::NEG_INFINITY,
    };

    /// The smallest box around `points`.
    pub fn around(points: &[DVec3]) -> Self {
        points.iter().fold(Aabb::EMPTY, |b, &p| Aabb {
            low: b.low.min(p),
            high: b.high.max(p),
        })
    }

    /// The smallest box around both boxes.
    pub fn join(&self, other: &Aabb) -> Self {
        Aabb {
            low: self.low.min(other.low),
            high: self.high.max(other.high),
        }
    }

    /// The intersection of both boxes. Where they do not meet, `low` exceeds `high` in some coordinate.
    pub fn intersection(&self, other: &Aabb) -> Self {
        Aabb {
            low: self.low.max(other.low),
            high: self.high.min(other.high),
        }
    }

    /// The box with its faces moved outwards by `margin`.
    pub fn grown(&self, margin: f64) -> Self {
        Aabb {
            low: self.low - margin,
            high: self.high + margin,
        }
    }

    /// Whether the boxes share a point.
    #[inline]
    pub fn overlaps(&self, other: &Aabb) -> bool {
        // `&` instead of `&&`: one branch instead of six.
        (self.low.x <= other.high.x)
            & (other.low.x <= self.high.x)
            & (self.low.y <= other.high.y)
            & (other.low.y <= self.high.y)
            & (self.low.z <= other.high.z)
            & (other.low.z <= self.high.z)
    }

    /// Centre of the box.
    pub fn centre(&self) -> DVec3 {
        (self.low + self.high) * 0.5
    }

    /// Half the lengths of the box's edges.
    pub fn half_size(&self) -> DVec3 {
        (self.high - self.low) * 0.5
    }

    /// Half the area of the box's surface.
    pub(super) fn half_area(&self) -> f64 {
        let d = self.high - self.low;
        d.x * d.y + d.y * d.z + d.z * d.x
    }

    /// Squared distance of `point` from the box, 0 inside.
    #[inline]
    pub fn distance_squared(&self, point: DVec3) -> f64 {
        (self.low - point)
            .max(point - self.high)
            .max(DVec3::ZERO)
            .length_squared()
    }

    /// Returns where the ray from `origin` enters the box, in lengths of the direction whose reciprocal is `inverse`;
    /// `None` if it misses the box or enters it beyond `limit`.
    #[inline]
    pub(super) fn ray_entry(&self, origin: DVec3, inverse: DVec3, limit: f64) -> Option<f64> {
        let a = (self.low - origin) * inverse;
        let b = (self.high - origin) * inverse;
        let (mut enter, mut leave) = (0.0f64, limit);
        for k in 0..3 {
            // 0 × ∞, for a ray in the plane of a face, is NaN: `f64::min` and `max` then return the other operand.
            enter = enter.max(a[k].min(b[k]));
            leave = leave.min(a[k].max(b[k]));
        }
        // The factor makes up for the rounding of the six products (Ize 2013, Robust BVH Ray Traversal).
        (enter <= leave * (1.0 + 4.0 * f64::EPSILON)).then_some(enter)
    }
}
