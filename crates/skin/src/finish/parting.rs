//! Moving the pieces of a break apart, as one would pull them: along the grain while their splinters lie between each other,
//! then straight on, until neither lies in the other.

use crate::report::BreakNote;
use crate::stages::BreakStages;
use glam::{DAffine3, DMat3, DQuat, DVec2, DVec3};
use greenstick_geometry::overlap::ParallelRays;
use greenstick_geometry::{Aabb, Mesh};
use std::f64::consts::TAU;

/// Lengths at which the grain is sampled, and points in the section at each beside its middle.
const LENGTHS: usize = 33;
const AROUND: usize = 6;
/// How far from the middle these lie, radii.
const AROUND_RADII: f64 = 0.7;
/// Step over which the direction of the grain is taken, radii.
const GRAIN_STEP: f64 = 1e-3;
/// Distance of the rays by which it is seen whether the pieces lie in each other, radii.
const RAY_SPACING: f64 = 0.03;
/// First step by which a way that is too short is lengthened, factor from step to step, and how near the shortest way is found,
/// radii.
const FIRST_STEP: f64 = 0.25;
const STEP_GROWTH: f64 = 1.5;
const WAY_TOLERANCE: f64 = 0.05;
/// How far beyond the length of the face a way is looked for, radii. What still touches there touches elsewhere than at the face.
const FARTHEST: f64 = 4.0;

/// A rigid motion at a steady rate: how fast a point moves and how fast all turns about it, per metre of way.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Twist {
    centre: DVec3,
    velocity: DVec3,
    /// Axis times angle, rad/m.
    turn: DVec3,
}

impl Twist {
    /// Returns the motion that moves these points most nearly in their directions, by least squares. It does not turn points on a
    /// line about that line.
    fn along(points: &[(DVec3, DVec3)]) -> Twist {
        let count = points.len().max(1) as f64;
        let centre = points.iter().map(|p| p.0).sum::<DVec3>() / count;
        let velocity = points.iter().map(|p| p.1).sum::<DVec3>() / count;
        let (mut inertia, mut moment, mut spread) = (DMat3::ZERO, DVec3::ZERO, 0.0);
        for &(point, direction) in points {
            let r = point - centre;
            let outer = DMat3::from_cols(r * r.x, r * r.y, r * r.z);
            inertia += DMat3::from_diagonal(DVec3::splat(r.length_squared())) - outer;
            moment += r.cross(direction);
            spread += r.length_squared();
        }
        let axis = velocity.normalize_or_zero();
        inertia += DMat3::from_cols(axis * axis.x, axis * axis.y, axis * axis.z) * (1e-9 * spread);
        let turn = if spread > 0.0 {
            inertia.inverse() * moment
        } else {
            DVec3::ZERO
        };
        Twist {
            centre,
            velocity,
            turn,
        }
    }

    /// Returns where the motion takes everything over a way (m): the exponential of the twist (Murray, Li and Sastry 1994, *A
    /// Mathematical Introduction to Robotic Manipulation*, Eq. 2.36).
    fn after(&self, way: f64) -> DAffine3 {
        let turn = self.turn * way;
        let angle = turn.length();
        let rotation = DQuat::from_scaled_axis(turn);
        let straight = self.velocity * way;
        let moved = if angle < 1e-9 {
            straight
        } else {
            let axis = turn / angle;
            let across = axis.cross(straight);
            let (sin, cos) = libm::sincos(angle);
            straight + across * ((1.0 - cos) / angle) + axis.cross(across) * (1.0 - sin / angle)
        };
        DAffine3::from_translation(self.centre + moved)
            * DAffine3::from_quat(rotation)
            * DAffine3::from_translation(-self.centre)
    }
}

/// How far the pieces of a break are to be moved apart.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Separation {
    /// The way, m.
    pub way: f64,
    /// Whether they are moved farther where they would lie in each other.
    pub until_clear: bool,
}

impl Separation {
    /// A way (m) and whether pieces are moved farther where they would lie in each other.
    pub fn new(way: f64, until_clear: bool) -> Self {
        Separation { way, until_clear }
    }
}

/// The way of the upper piece.
pub(super) struct Parting<'a> {
    stages: &'a BreakStages,
    /// Along the grain, over the length of the face.
    along: Twist,
    /// Length of the face, m.
    length: f64,
    /// Direction of the stem at the upper end of the face.
    onward: DVec3,
}

/// How far pieces are moved apart.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Parted {
    /// The way, m.
    pub way: f64,
    /// What is to be said of it.
    pub note: Option<BreakNote>,
}

impl<'a> Parting<'a> {
    pub fn new(stages: &'a BreakStages) -> Self {
        let prepared = stages.stem.stem();
        let (stem, layers) = (&prepared.found.stem, &prepared.layers);
        let (low, high) = stages.heights.heights.range;
        let (low, high) = (stem.location + low, stem.location + high);
        let step = GRAIN_STEP * stem.radius;
        let mut points = Vec::with_capacity(LENGTHS * (AROUND + 1));
        for i in 0..LENGTHS {
            let s = low + (high - low) * i as f64 / (LENGTHS - 1) as f64;
            let around = (0..AROUND).map(|k| {
                let (sin, cos) = libm::sincos(TAU * k as f64 / AROUND as f64);
                DVec2::new(cos, sin) * (AROUND_RADII * stem.radius)
            });
            for across in around.chain([DVec2::ZERO]) {
                let at = |s: f64| layers.to_world(across.extend(s));
                let direction = (at(s + step) - at(s - step)).normalize_or_zero();
                points.push((at(s), direction));
            }
        }
        Parting {
            stages,
            along: Twist::along(&points),
            length: high - low,
            onward: stem.grain.axis().frame(high).tangent,
        }
    }

    /// Returns the motion of the upper piece over a way (m): along the grain until the face is clear, then straight.
    pub fn after(&self, way: f64) -> DAffine3 {
        let within = way.min(self.length);
        let along = self.along.after(within);
        let onward = along.transform_vector3(self.onward);
        DAffine3::from_translation(onward * (way - within)) * along
    }

    /// Returns the way of a break: that which is requested or, if they are to be clear, the shortest beyond it on which the pieces do
    /// not lie in each other. A piece that hangs on stays where it is.
    pub fn way(&self, asked: Separation, pieces: [&Mesh; 2]) -> Parted {
        let Separation {
            way: asked,
            until_clear,
        } = asked;
        if self.stages.stem.face.hang > 0.0 {
            return Parted {
                way: 0.0,
                note: (asked > 0.0).then_some(BreakNote::HangsOn { requested_m: asked }),
            };
        }
        if !until_clear || asked == 0.0 {
            return Parted {
                way: asked,
                note: None,
            };
        }
        let shared = self.shared(pieces);
        let at_first = shared(asked);
        if at_first == 0.0 {
            return Parted {
                way: asked,
                note: None,
            };
        }
        match self.clear_beyond(asked, |way| shared(way) == 0.0) {
            Some(way) => Parted {
                way,
                note: Some(BreakNote::PartedFarther {
                    way_m: way,
                    requested_m: asked,
                }),
            },
            None => Parted {
                way: asked,
                note: Some(BreakNote::PartsOverlap {
                    shared_m3: at_first,
                }),
            },
        }
    }

    /// Returns the shortest way on which the pieces are clear of each other, beyond one (m) on which they are not; `None` where none is
    /// long enough.
    fn clear_beyond(&self, mut touching: f64, is_clear: impl Fn(f64) -> bool) -> Option<f64> {
        let radius = self.stages.stem.stem().found.stem.radius;
        let farthest = self.length + FARTHEST * radius;
        let mut step = FIRST_STEP * radius;
        let mut clear = loop {
            if touching >= farthest {
                return None;
            }
            let way = (touching + step).min(farthest);
            if is_clear(way) {
                break way;
            }
            (touching, step) = (way, step * STEP_GROWTH);
        };
        while clear - touching > WAY_TOLERANCE * radius {
            let way = 0.5 * (touching + clear);
            if is_clear(way) {
                clear = way;
            } else {
                touching = way;
            }
        }
        Some(clear)
    }

    /// The volume (m³) that the pieces share at the face, by the way of the upper one.
    fn shared<'m>(&'m self, [lower, upper]: [&'m Mesh; 2]) -> impl Fn(f64) -> f64 + 'm {
        let prepared = self.stages.stem.stem();
        let stem = &prepared.found.stem;
        let frame = stem.grain.axis().frame(stem.location);
        let rays = ParallelRays {
            axes: [frame.x, frame.y, frame.tangent],
            spacing: RAY_SPACING * stem.radius,
        };
        let transform = *prepared.transform();
        let material = self.stages.stem.inner_material;
        let face = move |mesh: &Mesh, transform: &DAffine3| -> Aabb {
            let triangles = (0..mesh.triangles.len()).filter(|&t| mesh.material(t) == material);
            rays.bounds(
                triangles.flat_map(|t| mesh.corners(t).map(|p| transform.transform_point3(p))),
            )
        };
        let below = face(lower, &transform);
        move |way| {
            let moved = self.after(way) * transform;
            let region = below.intersection(&face(upper, &moved));
            rays.shared_volume([(lower, &transform), (upper, &moved)], &region)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_4;

    fn arc(radius: f64, upto: f64) -> Vec<(DVec3, DVec3)> {
        let point = |i: i32| {
            let (sin, cos) = libm::sincos(upto * f64::from(i) / 20.0);
            (
                DVec3::new(cos, 0.0, sin) * radius,
                DVec3::new(-sin, 0.0, cos),
            )
        };
        (0..=20).map(point).collect()
    }

    #[test]
    fn wood_that_is_bent_to_an_arc_slides_along_it() {
        let points = arc(0.7, FRAC_PI_4);
        let moved = Twist::along(&points).after(0.3);
        for (point, _) in points {
            let to = moved.transform_point3(point);
            assert!((to.length() - 0.7).abs() < 1e-9, "{to}");
            assert!((to.angle_between(point) * 0.7 - 0.3).abs() < 1e-9);
        }
    }

    #[test]
    fn straight_wood_is_pulled_straight() {
        let points: Vec<(DVec3, DVec3)> = (0..9)
            .map(|i| (DVec3::new(0.1, 0.2, f64::from(i)), DVec3::Z))
            .collect();
        let moved = Twist::along(&points).after(0.3);
        assert!(moved.abs_diff_eq(DAffine3::from_translation(DVec3::Z * 0.3), 1e-15));
        let one = Twist::along(&points[..1]).after(0.3);
        assert!(one.abs_diff_eq(DAffine3::from_translation(DVec3::Z * 0.3), 1e-15));
    }

    #[test]
    fn wood_with_spiral_grain_is_screwed_out() {
        // Radians per metre.
        const TURN: f64 = 7.0;
        let at = |angle: f64, s: f64| {
            let (sin, cos) = libm::sincos(angle + TURN * s);
            DVec3::new(0.02 * cos, 0.02 * sin, s)
        };
        let points: Vec<(DVec3, DVec3)> = (0..60)
            .map(|i| {
                let (angle, s) = (f64::from(i % 6) * TAU / 6.0, f64::from(i / 6) * 0.01);
                let point = at(angle, s);
                (point, DVec3::new(-TURN * point.y, TURN * point.x, 1.0))
            })
            .collect();
        let moved = Twist::along(&points).after(0.05);
        for angle in [0.3, 2.0] {
            let to = moved.transform_point3(at(angle, 0.01));
            assert!(to.distance(at(angle, 0.06)) < 1e-9, "{to}");
        }
    }
}
