//! The handle that tilts a break: the highest point of the break's plane on a cylinder around the stem.

use glam::Vec3;

/// Radius of the cylinder on which the handle moves, in radii of the stem.
const REACH: f32 = 1.3;
/// The steepest plane that the handle reaches, degrees: beyond it the tip is far from the break.
const MAX_INCLINATION: f64 = 80.0;
/// Corners of the plane's outline.
const CORNERS: usize = 64;

/// Where a handle acts: a point of the stem's axis, and unit directions there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TiltHandle {
    /// The point of the axis.
    pub place: Vec3,
    /// The direction from which angles are counted, and the one square to it, both across the stem.
    pub across: [Vec3; 2],
    /// The direction of the stem.
    pub along: Vec3,
    /// Radius of the stem there, m.
    pub radius: f32,
}

/// How a plane is tilted, degrees.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tilt {
    /// The angle between the plane and the section of the stem.
    pub inclination: f64,
    /// The angle of its highest point around the stem.
    pub direction: f64,
}

impl TiltHandle {
    fn at(&self, angle: f64, tilt: Tilt) -> Vec3 {
        let reach = REACH * self.radius;
        let (sin, cos) = (angle.sin() as f32, angle.cos() as f32);
        let inclination = tilt.inclination.min(MAX_INCLINATION).to_radians();
        let from_high = angle - tilt.direction.to_radians();
        let height = (inclination.tan() * from_high.cos()) as f32;
        self.place + (self.across[0] * cos + self.across[1] * sin + self.along * height) * reach
    }

    /// The highest point of a plane, where the handle is.
    pub fn tip(&self, tilt: Tilt) -> Vec3 {
        self.at(tilt.direction.to_radians(), tilt)
    }

    /// The outline of a plane on the cylinder, closed.
    pub fn outline(&self, tilt: Tilt) -> Vec<Vec3> {
        let turn = std::f64::consts::TAU / CORNERS as f64;
        (0..=CORNERS)
            .map(|k| self.at(k as f64 * turn, tilt))
            .collect()
    }

    /// The plane whose highest point lies where a ray (origin and unit direction) meets the cylinder, on the side of the point
    /// that it had, or comes nearest to its axis. None for a ray along the axis.
    pub fn dragged(&self, origin: Vec3, direction: Vec3, had: Tilt) -> Option<Tilt> {
        let reach = REACH * self.radius;
        let axis = (self.place, self.along);
        let point = on_cylinder(axis, (origin, direction), self.tip(had))? - self.place;
        let [x, y] = self.across.map(|a| f64::from(point.dot(a)));
        let height = f64::from(point.dot(self.along) / reach);
        Some(Tilt {
            inclination: height.max(0.0).atan().to_degrees().min(MAX_INCLINATION),
            direction: y.atan2(x).to_degrees().rem_euclid(360.0),
        })
    }
}

/// Where a ray (origin and unit direction) meets the cylinder about an axis (a point and a unit direction) that goes through `had`, on
/// the side of that point, or where it comes nearest to the axis. None for a ray along the axis.
pub fn on_cylinder(
    (place, along): (Vec3, Vec3),
    (origin, direction): (Vec3, Vec3),
    had: Vec3,
) -> Option<Vec3> {
    let flat = |v: Vec3| v - along * v.dot(along);
    let (from, towards) = (flat(origin - place), flat(direction));
    let speed = towards.length_squared();
    if speed < 1e-8 {
        return None;
    }
    let nearest = -from.dot(towards) / speed;
    let gap = (from + towards * nearest).length_squared();
    let had = flat(had - place);
    let half = ((had.length_squared() - gap).max(0.0) / speed).sqrt();
    let sides = [-half, half].map(|s| origin + direction * (nearest + s));
    let off = |point: Vec3| flat(point - place).distance_squared(had);
    Some(if off(sides[0]) <= off(sides[1]) {
        sides[0]
    } else {
        sides[1]
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const HANDLE: TiltHandle = TiltHandle {
        place: Vec3::new(0.1, 0.2, 0.3),
        across: [Vec3::Z, Vec3::X],
        along: Vec3::Y,
        radius: 0.02,
    };

    #[test]
    fn a_ray_through_the_tip_gives_the_tilt_back() {
        for (inclination, direction) in [(0.0, 10.0), (35.0, 350.0), (72.0, 60.0)] {
            let tilt = Tilt {
                inclination,
                direction,
            };
            let tip = HANDLE.tip(tilt);
            // From where the tip is on the near side, and from behind.
            let away = (tip - HANDLE.place).normalize() + Vec3::new(0.1, 0.2, 0.05);
            let had = Tilt {
                inclination: 5.0,
                direction: direction + 20.0,
            };
            for eye in [tip + away, tip - away] {
                let towards = (tip - eye).normalize();
                let found = HANDLE.dragged(eye, towards, had).unwrap();
                assert!((found.inclination - inclination).abs() < 0.01, "{found:?}");
                assert!((found.direction - direction).abs() < 0.01, "{found:?}");
            }
        }
    }

    #[test]
    fn below_the_section_and_beside_the_stem_there_is_a_plane_too() {
        let eye = HANDLE.place + Vec3::new(0.0, -1.0, 5.0);
        let below = HANDLE.place + Vec3::new(0.0, -0.5, 0.0);
        let level = Tilt {
            inclination: 0.0,
            direction: 0.0,
        };
        let dragged = |point: Vec3| HANDLE.dragged(eye, (point - eye).normalize(), level);
        let found = dragged(below).unwrap();
        assert_eq!(found.inclination, 0.0);
        let beside = HANDLE.place + Vec3::new(0.4, 0.1, 0.0);
        let found = dragged(beside).unwrap();
        assert!((found.direction - 90.0).abs() < 10.0, "{found:?}");
        assert!(HANDLE.dragged(eye, Vec3::Y, level).is_none());
    }
}
