//! Leaves and twigs that lie on a forest floor: curled, so that they stand out of the layers of flat ones below them and shade each
//! other.

use super::noise::{unit, value};
use crate::camera::Camera;
use crate::item::Item;
use crate::plain::PlainShader;
use glam::{DAffine3, DVec2, DVec3, Vec2, Vec3};
use greenstick_geometry::{Attribute, Mesh};
use std::f64::consts::{PI, TAU};

/// Distance between places of leaves, m, and the share of them that have one.
const SPACING: f64 = 0.052;
const SHARE: f32 = 0.5;
/// How uneven they lie: features of the noise, in distances between places, and how much it takes from the share at most.
const PATCHES: f32 = 5.0;
const THINNED: f32 = 0.45;
/// Most places along each side of what the picture shows; on more ground they lie farther apart.
const MOST_PLACES: f64 = 72.0;
/// How far beyond what is shown leaves lie, as a part of its extent.
const MARGIN: f64 = 0.45;
/// Half lengths, m, and half widths in half lengths: least, and what the largest has more.
const LENGTHS: (f64, f64) = (0.020, 0.034);
const WIDTHS: (f64, f64) = (0.28, 0.30);
/// How far the edges of leaves are rolled up, and their tips, in half widths and half lengths; some are rolled down.
const EDGE_ROLLS: (f64, f64) = (-0.25, 1.15);
const TIP_ROLLS: (f64, f64) = (-0.10, 0.40);
/// How far the edge waves, in half widths, and leaves are twisted over their length, rad.
const WAVE: f64 = 0.16;
const TWIST: f64 = 0.8;
/// How far leaves are tilted, m per m, and how much higher than the ground they lie at most, m.
const TILT: f64 = 0.30;
const LIFT: f64 = 4e-3;
/// Sections along a leaf, and places across it, in half widths: the midrib is narrow.
const ALONG: u32 = 16;
const ACROSS: [f64; 8] = [-1.0, -0.68, -0.34, -0.05, 0.05, 0.34, 0.68, 1.0];
/// How much lighter midribs are, and darker edges.
const MIDRIB: f64 = 1.35;
const EDGE: f64 = 0.82;
/// Linear reflectance of leaves, from fresh to rotten.
const COLORS: [Vec3; 5] = [
    Vec3::new(0.300, 0.205, 0.095),
    Vec3::new(0.255, 0.150, 0.070),
    Vec3::new(0.190, 0.105, 0.052),
    Vec3::new(0.140, 0.090, 0.056),
    Vec3::new(0.245, 0.180, 0.115),
];

/// Shares of leaves with lobes, of narrow ones, and of twigs.
const LOBED: f32 = 0.3;
const NARROW: f32 = 0.2;
const TWIGS: f32 = 0.07;
/// Lobes along a leaf, how deep they are cut, in half widths, and how much narrower narrow leaves are.
const LOBES: f64 = 3.5;
const LOBE_DEPTH: f64 = 0.34;
const NARROWER: f64 = 0.45;
/// Half lengths and half thicknesses of twigs, m: least, and what the largest has more; how far they are bent, in half lengths, and
/// their linear reflectance.
const TWIG_LENGTHS: (f64, f64) = (0.035, 0.13);
const TWIG_RADII: (f64, f64) = (1.2e-3, 2.8e-3);
const TWIG_BEND: f64 = 0.16;
const TWIG_COLOR: Vec3 = Vec3::new(0.125, 0.100, 0.078);

/// In the hash.
const SEED: u32 = 0x1ea7;

/// What lies on the ground.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Shape {
    /// A leaf that is widest before its middle and drawn out at the tip.
    Ovate,
    /// The same with lobes, as of an oak.
    Lobed,
    /// A thin round stem.
    Twig,
}

/// Leaves that lie on the ground, as items of a scene.
pub(crate) struct FallenLeaves {
    mesh: Mesh,
    shader: PlainShader,
}

/// A leaf or twig on the ground.
struct Leaf {
    shape: Shape,
    /// Its middle, m from that of the picture, and its direction.
    middle: DVec2,
    direction: DVec2,
    /// Half its length and half its width, m.
    long: f64,
    wide: f64,
    rolls: [f64; 2],
    tilt: DVec2,
    twist: f64,
    phase: f64,
    lift: f64,
    color: Vec3,
}

impl FallenLeaves {
    /// The leaves about what a camera shows, on the ground through the lowest of the `points`, m.
    pub fn about(points: &[DVec3], camera: &Camera, up: DVec3) -> FallenLeaves {
        let right = camera.right;
        let away = up.cross(right);
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for point in points {
            let at = DVec3::new(point.dot(right), point.dot(away), point.dot(up));
            (low, high) = (low.min(at), high.max(at));
        }
        let middle = 0.5 * (low + high).truncate();
        let reach = (0.5 + MARGIN) * (high - low).truncate().max_element();
        let spacing = SPACING.max(2.0 * reach / MOST_PLACES);
        let mut leaves = Leaves {
            directions: [right, away, up],
            origin: right * middle.x + away * middle.y + up * low.z,
            mesh: Mesh::default(),
            normals: Vec::new(),
            colors: Vec::new(),
        };
        let last = (reach / spacing) as i32;
        for i in -last..=last {
            for j in -last..=last {
                if let Some(leaf) = Leaf::at([i, j], spacing) {
                    leaves.add(&leaf);
                }
            }
        }
        FallenLeaves {
            mesh: leaves.finish(),
            shader: PlainShader::uniform([1.0; 3]),
        }
    }

    /// Returns the items of a scene and the leaves.
    pub fn beside<'a>(&'a self, items: &[Item<'a>]) -> Vec<Item<'a>> {
        let own = Item {
            mesh: &self.mesh,
            transform: DAffine3::IDENTITY,
            shader: &self.shader,
        };
        [items, &[own]].concat()
    }
}

impl Leaf {
    /// The leaf of a place of the ground, if there is one.
    fn at([i, j]: [i32; 2], spacing: f64) -> Option<Leaf> {
        let draw = |k: u32| unit(SEED ^ k << 24, i, j);
        let place = Vec2::new(i as f32, j as f32) / PATCHES;
        let thinned = THINNED * (0.5 - 0.5 * value(SEED ^ 0xbed, place));
        if draw(0) > SHARE * (1.0 - thinned) {
            return None;
        }
        let random = |k: u32| f64::from(draw(k));
        let within = |(least, more): (f64, f64), part: f64| least + more * part;
        let between = |(low, high): (f64, f64), part: f64| low + (high - low) * part;
        let (sin, cos) = libm::sincos(TAU * random(3));
        let long = within(LENGTHS, random(4) * random(5).sqrt());
        let kind = (draw(6) * COLORS.len() as f32) as usize;
        let wide = long * within(WIDTHS, random(7));
        let of_shape = draw(16);
        let (shape, long, wide) = match of_shape {
            s if s < TWIGS => (
                Shape::Twig,
                within(TWIG_LENGTHS, random(4) * random(5)),
                within(TWIG_RADII, random(7) * random(7)),
            ),
            s if s < TWIGS + LOBED => (Shape::Lobed, 1.15 * long, wide),
            s if s < TWIGS + LOBED + NARROW => (Shape::Ovate, long, NARROWER * wide),
            _ => (Shape::Ovate, long, wide),
        };
        let base = match shape {
            Shape::Twig => TWIG_COLOR,
            _ => COLORS[kind.min(COLORS.len() - 1)],
        };
        Some(Leaf {
            shape,
            middle: DVec2::new(f64::from(i) + random(1), f64::from(j) + random(2)) * spacing,
            direction: DVec2::new(cos, sin),
            long,
            wide,
            rolls: [
                between(EDGE_ROLLS, random(8)),
                between(TIP_ROLLS, random(9)),
            ],
            tilt: DVec2::new(random(10) - 0.5, random(11) - 0.5) * (2.0 * TILT),
            twist: TWIST * (random(12) - 0.5),
            phase: TAU * random(13),
            lift: LIFT * random(14),
            color: base * (0.7 + 0.6 * draw(15)),
        })
    }

    /// The place of a point along (−1 to 1) and across the leaf (likewise): along and beside its direction, and its height, m.
    fn place(&self, along: f64, across: f64) -> DVec3 {
        let t = 0.5 + 0.5 * along;
        if self.shape == Shape::Twig {
            let (sin, cos) = libm::sincos(PI * across);
            let radius = self.wide * (1.0 - 0.6 * t);
            let bent = TWIG_BEND * self.long * (1.0 - along * along);
            let kinked = 0.2 * bent * libm::sin(5.0 * along + self.phase);
            let beside = bent * self.twist / TWIST + kinked;
            return DVec3::new(along * self.long, beside + radius * sin, radius * cos);
        }
        // Widest before its middle, drawn out at the tip.
        let lobes = match self.shape {
            Shape::Lobed => {
                let wave = libm::cos(TAU * (LOBES * t * (1.2 - 0.2 * t) + 0.5));
                1.0 - LOBE_DEPTH * (0.5 - 0.5 * wave) * (1.0 - t * t * t)
            }
            Shape::Ovate | Shape::Twig => 1.0,
        };
        let half = self.wide * (2.6 * t.sqrt() * (1.0 - t)).max(0.0) * lobes;
        let beside = across * half;
        let wave = WAVE * across * libm::sin(3.5 * PI * along + self.phase);
        let rolled = self.rolls[0] * across * across + wave;
        let bent = self.rolls[1] * along * along * self.long;
        let turned = libm::sin(self.twist * along) * beside;
        let tilted = self.tilt.x * along * self.long + self.tilt.y * beside;
        DVec3::new(
            along * self.long,
            beside,
            rolled * half + bent + turned + tilted,
        )
    }
}

/// Leaves as they are added to a mesh.
struct Leaves {
    /// To the right, away from the camera, and upwards.
    directions: [DVec3; 3],
    /// The point of the ground that leaves are placed about, m.
    origin: DVec3,
    mesh: Mesh,
    normals: Vec<f32>,
    colors: Vec<f32>,
}

impl Leaves {
    fn add(&mut self, leaf: &Leaf) {
        let first = self.mesh.positions.len() as u32;
        let along = |k: u32| 2.0 * f64::from(k) / f64::from(ALONG) - 1.0;
        let places: Vec<(f64, f64)> = (0..=ALONG)
            .flat_map(|k| ACROSS.map(|across| (along(k), across)))
            .collect();
        let heights = places.iter().map(|&(a, b)| leaf.place(a, b).z);
        let lowest = heights.fold(f64::INFINITY, f64::min);
        let [right, away, up] = self.directions;
        let world = |v: DVec3| {
            let flat = leaf.direction * v.x + leaf.direction.perp() * v.y;
            right * flat.x + away * flat.y + up * v.z
        };
        let middle = right * leaf.middle.x + away * leaf.middle.y + up * (leaf.lift - lowest);
        for &(a, b) in &places {
            let here = leaf.place(a, b);
            (self.mesh.positions).push(self.origin + middle + world(here));
            let step = 1e-3;
            // Near its ends a leaf has no width: the normal is that beside them.
            let inner = a.clamp(-0.95, 0.95);
            let slope = |da: f64, db: f64| leaf.place(inner + da, b + db) - leaf.place(inner, b);
            let normal = slope(step, 0.0).cross(slope(0.0, step));
            let normal = world(normal).normalize_or(up);
            self.normals.extend(normal.as_vec3().to_array());
            let tone = match b.abs() {
                _ if leaf.shape == Shape::Twig => 1.0,
                rib if rib < 0.1 => MIDRIB,
                edge if edge > 0.9 => EDGE,
                _ => 1.0,
            };
            let color = (leaf.color * tone as f32).min(Vec3::ONE);
            self.colors.extend(color.extend(1.0).to_array());
        }
        let row = ACROSS.len() as u32;
        for k in 0..ALONG {
            for c in 0..row - 1 {
                let at = first + k * row + c;
                let corners = [at, at + row, at + row + 1, at + 1];
                let [a, b, c, d] = corners;
                self.mesh.triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
    }

    fn finish(self) -> Mesh {
        let mut mesh = self.mesh;
        for (name, width, data) in [("NORMAL", 3, self.normals), ("COLOR_0", 4, self.colors)] {
            mesh.attributes
                .insert(name.to_owned(), Attribute { width, data });
        }
        mesh
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::View;

    #[test]
    fn leaves_lie_on_the_ground_about_what_is_shown() {
        let points = [DVec3::new(-0.4, 0.1, -0.3), DVec3::new(0.5, 0.6, 0.4)];
        let camera = Camera::new(&points, View::Automatic, None, DVec3::Y, [90, 70]).unwrap();
        let leaves = FallenLeaves::about(&points, &camera, DVec3::Y);
        let mesh = &leaves.mesh;
        let single = (ALONG + 1) as usize * ACROSS.len();
        let count = mesh.positions.len() / single;
        assert!(count > 100, "{count}");
        for leaf in mesh.positions.chunks(single) {
            let lowest = leaf.iter().map(|p| p.y).fold(f64::INFINITY, f64::min);
            assert!((0.1..=0.1 + LIFT + 1e-9).contains(&lowest), "{lowest}");
            let highest = leaf.iter().map(|p| p.y).fold(0.0, f64::max);
            assert!(highest < 0.2, "{highest}");
        }
        let far = |p: &DVec3| (p.x - 0.05).abs().max((p.z - 0.05).abs());
        let reach = mesh.positions.iter().map(far).fold(0.0, f64::max);
        assert!(reach > 0.6 && reach < 1.4, "{reach}");
        // However much ground is seen, their number stays within bounds.
        let wide = points.map(|p| p * 1000.0);
        let many = FallenLeaves::about(&wide, &camera, DVec3::Y).mesh;
        assert!(many.positions.len() / single < 3200);
    }
}
