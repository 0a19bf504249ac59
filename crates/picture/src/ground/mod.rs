//! What a scene stands on, where a picture shows more of it than shadows: a worn workbench, a floor of concrete, or a forest floor.
//! They are patterns of the place in true size, so that they tell the eye how large the wood is.

mod bench;
mod concrete;
mod leaves;
mod litter;
mod look;
mod noise;
mod scratches;

use crate::camera::Camera;
use glam::{DVec2, DVec3, Vec3};
use greenstick_schema::choices;
pub(crate) use leaves::FallenLeaves;
use look::GroundSurface;

choices! {
    /// What a scene stands on.
    pub enum Ground {
        /// An even backdrop that shows only shadows.
        Plain = "plain",
        /// The planks of a worn workbench.
        Bench = "bench",
        /// A floor of worn concrete.
        Concrete = "concrete",
        /// Soil under fallen leaves.
        Litter = "litter",
    }
}

/// Extent of what a picture shows from which on it stands outdoors, m: more than that is carried into no workshop.
const OUTDOORS_EXTENT: f64 = 1.5;

impl Ground {
    /// The ground that suits a picture of these points: the floor of a workshop for what can be carried into one, fallen leaves for what is larger.
    ///
    /// ```
    /// use glam::DVec3;
    /// use greenstick_picture::Ground;
    ///
    /// assert_eq!(Ground::under(&[DVec3::ZERO, DVec3::X * 0.1]), Ground::Concrete);
    /// assert_eq!(Ground::under(&[DVec3::ZERO, DVec3::X * 3.0]), Ground::Litter);
    /// ```
    pub fn under(points: &[DVec3]) -> Ground {
        let first = points.first().copied().unwrap_or(DVec3::ZERO);
        let corners = points
            .iter()
            .fold((first, first), |(low, high), &p| (low.min(p), high.max(p)));
        match corners.0.distance(corners.1) < OUTDOORS_EXTENT {
            true => Ground::Concrete,
            false => Ground::Litter,
        }
    }
}

/// A ground as a picture shows it.
pub(crate) struct ShownGround {
    kind: Ground,
    /// Horizontal unit directions of the pattern.
    axes: [DVec3; 2],
    /// A point of the world at the origin of the pattern.
    origin: DVec3,
    /// Size of a pixel at a distance of one metre, m.
    pixel_size: f64,
}

/// Angle between planks and the rows of a picture, rad: parallel to the frame they look placed.
const TURN: f64 = -0.62;
/// Smallest share of a footprint that a view along the ground may stretch it from: farther away only the mean is left.
const LEAST_FALL: f64 = 0.1;

impl ShownGround {
    /// A ground under a scene with its middle at `origin`, laid out for a camera; none for the plain one.
    pub fn new(kind: Ground, camera: &Camera, up: DVec3, origin: DVec3) -> Option<ShownGround> {
        let (sin, cos) = libm::sincos(TURN);
        let away = up.cross(camera.right);
        (kind != Ground::Plain).then_some(ShownGround {
            kind,
            axes: [
                camera.right * cos + away * sin,
                away * cos - camera.right * sin,
            ],
            origin,
            pixel_size: camera.pixel_size,
        })
    }

    /// The colour, and the upward normal tilted by the relief, where a ray that falls by `fall` per unit of length meets the ground at
    /// a distance, m. Detail finer than `blur` pixels is averaged.
    pub fn at(
        &self,
        position: DVec3,
        up: DVec3,
        (distance, fall): (f64, f64),
        blur: f64,
    ) -> (Vec3, Vec3) {
        let off = position - self.origin;
        let place = DVec2::new(off.dot(self.axes[0]), off.dot(self.axes[1])).as_vec2();
        let footprint = blur * self.pixel_size * distance / fall.abs().max(LEAST_FALL).sqrt();
        let GroundSurface { color, slope } = match self.kind {
            Ground::Litter => litter::litter(place, footprint as f32),
            Ground::Concrete => concrete::concrete(place, footprint as f32),
            Ground::Bench | Ground::Plain => bench::bench(place, footprint as f32),
        };
        let [x, y] = self.axes.map(|axis| axis.as_vec3());
        let normal = up.as_vec3() - x * slope.x - y * slope.y;
        (color, normal.normalize())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec2;

    /// Mean and standard deviation of the luminance of a ground over a square of 2 m.
    fn statistics(look: fn(Vec2, f32) -> GroundSurface, footprint: f32) -> (f32, f32) {
        let n = 300;
        let values: Vec<f32> = (0..n * n)
            .map(|i| {
                let place = Vec2::new((i % n) as f32, (i / n) as f32) * (2.0 / n as f32);
                look(place, footprint).color.element_sum() / 3.0
            })
            .collect();
        let mean = values.iter().sum::<f32>() / values.len() as f32;
        let squares: f32 = values.iter().map(|v| (v - mean) * (v - mean)).sum();
        (mean, (squares / values.len() as f32).sqrt())
    }

    #[test]
    fn grounds_keep_their_brightness_and_lose_their_detail_from_afar() {
        for (name, look) in [
            ("bench", bench::bench as fn(Vec2, f32) -> GroundSurface),
            ("concrete", concrete::concrete),
            ("litter", litter::litter),
        ] {
            let (near, rough) = statistics(look, 1e-5);
            let (far, smooth) = statistics(look, 1.0);
            assert!((near / far - 1.0).abs() < 0.1, "{name}: {near}, {far}");
            assert!(rough > 0.15 * near, "{name}: {rough} of {near}");
            assert!(smooth < 0.02 * far, "{name}: {smooth} of {far}");
        }
    }

    #[test]
    fn colours_are_reflectances_everywhere() {
        for look in [
            bench::bench as fn(Vec2, f32) -> GroundSurface,
            concrete::concrete,
            litter::litter,
        ] {
            for i in 0..20_000 {
                let t = i as f32;
                let place = Vec2::new((t * 0.0137).sin(), (t * 0.0071).cos()) * 40.0;
                let surface = look(place, 1e-4);
                assert!(surface.color.min_element() > 0.0 && surface.color.max_element() < 0.9);
                assert!(surface.slope.length() < 2.0, "{:?}", surface.slope);
            }
        }
    }
}
