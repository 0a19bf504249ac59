//! A coin that lies on the floor beside the scene: a euro, whose size everyone knows.

use crate::camera::Camera;
use crate::item::Item;
use crate::plain::PlainShader;
use glam::{DAffine3, DMat3, DVec3};
use greenstick_geometry::Mesh;

/// Radius of the coin, of its inner part, and its thickness, m (Council Regulation (EU) No 729/2014).
const RADIUS: f64 = 11.625e-3;
const INNER_RADIUS: f64 = 8.3e-3;
const THICKNESS: f64 = 2.33e-3;
/// Height and width of its rim, m.
const RIM: (f64, f64) = (0.16e-3, 0.7e-3);
/// Corners around.
const SIDES: u32 = 128;
/// Linear colours of the outer and the inner part.
const OUTER: [f64; 3] = [0.50, 0.36, 0.15];
const INNER: [f64; 3] = [0.46, 0.45, 0.42];
/// Distance from the scene, in radii of the coin.
const DISTANCE: f64 = 1.5;

/// The coin.
pub(crate) struct Coin {
    /// Its outer and its inner part.
    pub parts: [Mesh; 2],
    /// Their shaders.
    pub shaders: [PlainShader; 2],
    /// From its middle on the floor to the world, m.
    pub transform: DAffine3,
}

impl Coin {
    /// A coin in front of what a camera shows, on the floor below the lowest of the `points`, m.
    pub fn before(points: &[DVec3], camera: &Camera, up: DVec3) -> Coin {
        let right = camera.right;
        let toward = right.cross(up);
        let range = |direction: DVec3| {
            let along = points.iter().map(|p| p.dot(direction));
            along.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| {
                (low.min(v), high.max(v))
            })
        };
        let ((left, far), (_, front)) = (range(right), range(toward));
        let at =
            right * (0.5 * (left + far)) + toward * (front + DISTANCE * RADIUS) + up * range(up).0;
        Coin {
            parts: [outer(), inner()],
            shaders: [OUTER, INNER].map(PlainShader::uniform),
            transform: DAffine3 {
                matrix3: DMat3::from_cols(right, up, toward),
                translation: at,
            },
        }
    }

    /// Returns the items of a scene and those of the coin.
    pub fn beside<'a>(&'a self, items: &[Item<'a>]) -> Vec<Item<'a>> {
        let parts = self.parts.iter().zip(&self.shaders);
        let own = parts.map(|(mesh, shader)| Item {
            mesh,
            transform: self.transform,
            shader,
        });
        items.iter().copied().chain(own).collect()
    }

    /// Points about it, m.
    pub fn corners(&self) -> [DVec3; 4] {
        [DVec3::X, DVec3::NEG_X, DVec3::Z, DVec3::NEG_Z]
            .map(|d| self.transform.transform_point3(d * RADIUS))
    }
}

/// A surface of revolution about y through points (radius, height), m, outwards to the left of their order.
fn revolved(profile: &[[f64; 2]]) -> Mesh {
    let mut mesh = Mesh::default();
    for pair in profile.windows(2) {
        // Rings of their own for each pair: edges are sharp.
        let first = mesh.positions.len() as u32;
        for [radius, height] in pair {
            for k in 0..SIDES {
                let turn = std::f64::consts::TAU * f64::from(k) / f64::from(SIDES);
                let (sin, cos) = libm::sincos(turn);
                (mesh.positions).push(DVec3::new(radius * cos, *height, radius * sin));
            }
        }
        for k in 0..SIDES {
            let next = (k + 1) % SIDES;
            let [a, b] = [first + k, first + next];
            let [c, d] = [a + SIDES, b + SIDES];
            mesh.triangles.extend([[a, c, b], [b, c, d]]);
        }
    }
    mesh
}

fn outer() -> Mesh {
    let (high, wide) = RIM;
    let top = THICKNESS - high;
    revolved(&[
        [RADIUS, 0.0],
        [RADIUS, THICKNESS],
        [RADIUS - wide, THICKNESS],
        [RADIUS - 1.5 * wide, top],
        [INNER_RADIUS, top],
    ])
}

fn inner() -> Mesh {
    let top = THICKNESS - RIM.0;
    revolved(&[
        [INNER_RADIUS, top],
        [INNER_RADIUS - 0.1e-3, top - 0.08e-3],
        [0.0, top - 0.08e-3],
    ])
}
