//! The camera of the viewport: it turns about a point, as Blender's does.

use glam::camera::rh::proj::directx::{orthographic, perspective};
use glam::camera::rh::view::look_at_mat4;
use glam::{Mat4, Vec2, Vec3};

/// A camera that turns about a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// What it turns about.
    pub target: Vec3,
    /// Distance from it, m.
    pub distance: f32,
    /// Turn about the vertical, rad.
    pub yaw: f32,
    /// How steeply it looks down, rad.
    pub pitch: f32,
    /// Whether there is no perspective.
    pub parallel: bool,
    /// Whether z is up and not y.
    pub z_up: bool,
}

/// Half of the vertical angle of view (40° in all): close to that of a 50 mm lens.
const HALF_ANGLE: f32 = 0.349;
/// Radians for each point that the mouse moves: half a turn across a window of 800 points.
const TURN_PER_POINT: f32 = 0.0065;
/// Steepest view: straight down, but for the last bit, at which left and right would swap.
const MAX_PITCH: f32 = 1.5706;
/// How much of a direction is horizontal where something lies more than it stands.
const LYING: f32 = 0.5;
/// Angle at which something that lies is looked at first, rad: nearly from its side, so that its faces show.
const ASIDE: f32 = 1.1;
/// Room around what is framed.
const MARGIN: f32 = 1.12;

impl Default for Camera {
    fn default() -> Self {
        Camera {
            target: Vec3::ZERO,
            distance: 1.0,
            yaw: 0.7,
            pitch: 0.45,
            parallel: false,
            z_up: false,
        }
    }
}

/// A view along an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AxisView {
    /// From the front: +z, or −y where z is up.
    Front,
    /// From +x.
    Right,
    /// From above.
    Top,
}

impl Camera {
    /// Unit direction from the target to the eye.
    pub fn backward(&self) -> Vec3 {
        let (sp, cp) = self.pitch.sin_cos();
        let (sy, cy) = self.yaw.sin_cos();
        self.world(Vec3::new(sy * cp, sp, cy * cp))
    }

    /// A direction whose second coordinate is the vertical, in the world.
    fn world(&self, v: Vec3) -> Vec3 {
        if self.z_up {
            Vec3::new(v.x, -v.z, v.y)
        } else {
            v
        }
    }

    /// Unit direction upwards in the world.
    pub fn vertical(&self) -> Vec3 {
        self.world(Vec3::Y)
    }

    /// Looks from aside at something that lies along this unit direction.
    pub fn look_from_aside(&mut self, along: Vec3) {
        let along = if self.z_up {
            Vec3::new(along.x, along.z, -along.y)
        } else {
            along
        };
        let flat = Vec3::new(along.x, 0.0, along.z);
        if flat.length() > LYING {
            self.yaw = flat.x.atan2(flat.z) + ASIDE;
            self.pitch = 0.35;
        }
    }

    /// Unit direction to the right.
    pub fn right(&self) -> Vec3 {
        let (sy, cy) = self.yaw.sin_cos();
        self.world(Vec3::new(cy, 0.0, -sy))
    }

    /// Unit direction upwards in the picture.
    pub fn up(&self) -> Vec3 {
        self.backward().cross(self.right())
    }

    /// Where it is.
    pub fn eye(&self) -> Vec3 {
        self.target + self.backward() * self.distance
    }

    /// World to clip coordinates for a picture of this ratio of width to height, in a scene of this radius about 0.
    pub fn projection(&self, aspect: f32, scene_radius: f32) -> Mat4 {
        let view = look_at_mat4(self.eye(), self.target, self.up());
        let reach = self.eye().length() + scene_radius;
        if self.parallel {
            let h = self.distance * HALF_ANGLE.tan();
            let far = reach.max(self.distance) * 2.0;
            return orthographic(-h * aspect, h * aspect, -h, h, -far, far) * view;
        }
        let near = (self.eye().length() - scene_radius)
            .max(self.distance * 0.01)
            .max(reach * 1e-4);
        perspective(2.0 * HALF_ANGLE, aspect, near * 0.9, reach * 1.1) * view
    }

    /// Where a point stands in the picture, −1 to 1 across and up; none behind the eye.
    pub fn seen_at(&self, point: Vec3, aspect: f32) -> Option<Vec2> {
        let from_eye = point - self.eye();
        let depth = if self.parallel {
            self.distance
        } else {
            -from_eye.dot(self.backward())
        };
        let half = depth * HALF_ANGLE.tan();
        (half > 0.0).then(|| {
            let across = from_eye.dot(self.right()) / (half * aspect);
            Vec2::new(across, from_eye.dot(self.up()) / half)
        })
    }

    /// Size of a pixel at a distance of 1 in a picture of this height.
    pub fn pixel(&self, height: f32) -> f32 {
        2.0 * HALF_ANGLE.tan() / height.max(1.0)
    }

    /// Turns by a movement of the mouse, points.
    pub fn orbit(&mut self, by: Vec2) {
        self.yaw -= by.x * TURN_PER_POINT;
        self.pitch = (self.pitch + by.y * TURN_PER_POINT).clamp(-MAX_PITCH, MAX_PITCH);
    }

    /// Shifts by a movement of the mouse in a viewport of this height, points: what is under it stays under it.
    pub fn pan(&mut self, by: Vec2, height: f32) {
        let scale = self.distance * self.pixel(height);
        self.target += (self.right() * -by.x + self.up() * by.y) * scale;
    }

    /// Moves what it looks at to the depth of a point; what is seen stays as it is. Where all is parallel, depths do not matter.
    pub fn look_at_depth_of(&mut self, point: Vec3) {
        let eye = self.eye();
        let depth = (eye - point).dot(self.backward());
        if !self.parallel && depth > 0.0 {
            self.target = eye - self.backward() * depth;
            self.distance = depth;
        }
    }

    /// Goes nearer (factor below 1) or farther, towards what is at `at` (−1 to 1 across and up).
    pub fn zoom(&mut self, factor: f32, at: Vec2, aspect: f32) {
        let before = self.distance;
        self.distance = (self.distance * factor).clamp(1e-4, 1e5);
        let moved = (before - self.distance) * HALF_ANGLE.tan();
        self.target += (self.right() * at.x * aspect + self.up() * at.y) * moved;
    }

    /// Shows a sphere.
    pub fn frame(&mut self, centre: Vec3, radius: f32, aspect: f32) {
        self.target = centre;
        let narrow = aspect.clamp(0.2, 1.0);
        self.distance = MARGIN * radius.max(1e-5) / (HALF_ANGLE.sin() * narrow);
    }

    /// Shows what is so high (m) from the upper to the lower edge of the picture, or as wide where the picture is narrow.
    pub fn frame_height(&mut self, centre: Vec3, height: f32, aspect: f32) {
        self.target = centre;
        let narrow = aspect.clamp(0.2, 1.0);
        self.distance = 0.5 * height.max(1e-5) / (HALF_ANGLE.tan() * narrow);
    }

    /// Looks along an axis, or against it.
    pub fn look(&mut self, view: AxisView, opposite: bool) {
        use std::f32::consts::{FRAC_PI_2, PI};
        (self.yaw, self.pitch) = match view {
            AxisView::Front => (0.0, 0.0),
            AxisView::Right => (FRAC_PI_2, 0.0),
            AxisView::Top => (0.0, MAX_PITCH),
        };
        if opposite {
            match view {
                AxisView::Top => self.pitch = -MAX_PITCH,
                _ => self.yaw += PI,
            }
        }
    }

    /// The ray through a point of the picture (−1 to 1 across and up): origin and unit direction.
    pub fn ray(&self, at: Vec2, aspect: f32) -> (Vec3, Vec3) {
        let t = HALF_ANGLE.tan();
        let aside = self.right() * at.x * aspect * t + self.up() * at.y * t;
        if self.parallel {
            let from = self.target + aside * self.distance;
            return (from + self.backward() * 1e3, -self.backward());
        }
        (self.eye(), (aside - self.backward()).normalize())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ray_goes_through_what_is_drawn_there() {
        let camera = Camera {
            target: Vec3::new(0.3, -0.2, 0.5),
            distance: 2.0,
            ..Camera::default()
        };
        let turned = Camera {
            z_up: true,
            ..camera
        };
        assert!((turned.up().z - camera.up().y).abs() < 1e-6 && turned.vertical() == Vec3::Z);
        let matrix = camera.projection(1.6, 3.0);
        for at in [Vec2::ZERO, Vec2::new(0.7, -0.4), Vec2::new(-0.9, 0.8)] {
            let (origin, direction) = camera.ray(at, 1.6);
            let clip = matrix.project_point3(origin + direction * 1.7);
            assert!((clip.truncate() - at).length() < 1e-4, "{clip} {at}");
            assert!((0.0..1.0).contains(&clip.z));
            let seen = camera.seen_at(origin + direction * 1.7, 1.6).unwrap();
            assert!((seen - at).length() < 1e-4, "{seen} {at}");
        }
    }

    #[test]
    fn what_is_under_the_pointer_stays_there() {
        let mut camera = Camera::default();
        let at = Vec2::new(0.5, 0.25);
        let (origin, direction) = camera.ray(at, 1.5);
        let backward = camera.backward();
        let t = (camera.target - origin).dot(backward) / direction.dot(backward);
        let point = origin + direction * t;
        camera.zoom(0.5, at, 1.5);
        let clip = camera.projection(1.5, 1.0).project_point3(point);
        assert!((clip.truncate() - at).length() < 1e-3, "{clip}");
    }

    #[test]
    fn a_framed_height_fills_the_picture() {
        let mut camera = Camera::default();
        for (aspect, edge) in [(1.5, Vec2::Y), (0.5, Vec2::X)] {
            camera.frame_height(Vec3::ONE, 0.6, aspect);
            let across = if edge == Vec2::X {
                camera.right()
            } else {
                camera.up()
            };
            let seen = camera.seen_at(Vec3::ONE + across * 0.3, aspect).unwrap();
            assert!((seen - edge).length() < 1e-5, "{seen}");
        }
    }

    #[test]
    fn a_framed_sphere_fits() {
        let mut camera = Camera::default();
        camera.frame(Vec3::ONE, 0.4, 1.3);
        let matrix = camera.projection(1.3, 2.5);
        for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
            for sign in [-0.4, 0.4] {
                let clip = matrix.project_point3(Vec3::ONE + axis * sign);
                assert!(clip.x.abs() < 1.0 && clip.y.abs() < 1.0, "{clip}");
            }
        }
    }
}
