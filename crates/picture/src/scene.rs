//! The scene: all items in one hierarchy, and what rays meet in it.

use crate::bvh::{Bvh, Intersection, Ray};
use crate::camera::{Camera, Sphere};
use crate::error::{MAX_TRIANGLES, PictureError};
use crate::item::Item;
use crate::light::Studio;
use crate::shader::Hit;
use crate::surface::{Met, Place, Seen, single, valid_appearance};
use glam::{DVec3, Vec3};
use std::sync::atomic::{AtomicU64, Ordering};

/// The items in a hierarchy.
pub(crate) struct Scene<'a> {
    items: &'a [Item<'a>],
    /// Number of the first triangle of each item.
    starts: Vec<u32>,
    bvh: Bvh,
    /// Sphere around the bounding box.
    pub bounds: Sphere,
    /// Whether a surface has holes that rays go through.
    has_holes: bool,
    /// The colour of each triangle at its middle, packed, or 0 where nobody has asked for it yet.
    colors: Vec<AtomicU64>,
}

/// Returns the vertices of all items in world coordinates. Coordinates and indices must be valid.
pub(crate) fn world_points(items: &[Item]) -> Result<Vec<DVec3>, PictureError> {
    let triangles: usize = items.iter().map(|i| i.mesh.triangles.len()).sum();
    if triangles == 0 {
        return Err(PictureError::Empty { items: items.len() });
    }
    if triangles > MAX_TRIANGLES {
        return Err(PictureError::Triangles { triangles });
    }
    let mut points = Vec::with_capacity(items.iter().map(|i| i.mesh.positions.len()).sum());
    for (number, item) in items.iter().enumerate() {
        for (vertex, p) in item.mesh.positions.iter().enumerate() {
            let position = item.transform.transform_point3(*p);
            // Distances are squared in f32, which would overflow beyond this limit.
            if !position.is_finite() || position.abs().max_element() > 1e15 {
                return Err(PictureError::Position {
                    item: number,
                    vertex,
                    position,
                });
            }
            points.push(position);
        }
        let vertices = item.mesh.positions.len();
        for (triangle, corners) in item.mesh.triangles.iter().enumerate() {
            if let Some(&vertex) = corners.iter().find(|&&v| v as usize >= vertices) {
                return Err(PictureError::Vertex {
                    item: number,
                    triangle,
                    vertex,
                    vertices,
                });
            }
        }
    }
    Ok(points)
}

/// A surface that indirect light comes from.
pub(crate) struct Bounce {
    pub position: Vec3,
    /// Unit normal on the side that the ray met.
    pub normal: Vec3,
    pub color: Vec3,
}

/// Smallest cosine of the angle between normals at which rays of a pixel share an appearance.
const MIN_SHARED_COSINE: f32 = 0.985;
/// Offset of rays that leave a surface, relative to the radius of the scene: the error of f32 coordinates.
const RELATIVE_RAY_OFFSET: f32 = 2e-6;
/// Footprint on surfaces that indirect rays meet, relative to that on the first surface: finer detail is averaged. Triangles that
/// are not larger have one colour there.
const INDIRECT_FOOTPRINT_SCALE: f32 = 16.0;
/// Most triangles whose colours are kept: 128 MiB.
const MAX_KEPT_COLORS: usize = 1 << 24;
/// Most holes that a ray goes through.
const MAX_LAYERS: usize = 256;
/// How far from the scene shadows on the floor fade, per radius of the scene.
const SHADOW_FADE: f64 = 0.4;

impl<'a> Scene<'a> {
    /// Builds the hierarchy of items, given their [`world_points`].
    pub fn new(items: &'a [Item<'a>], points: &[DVec3]) -> Scene<'a> {
        let first = points[0];
        let (low, high) = points
            .iter()
            .fold((first, first), |(l, h), &p| (l.min(p), h.max(p)));
        let middle = (low + high) * 0.5;
        let radius = ((high - low).length() * 0.5).max(f64::MIN_POSITIVE);
        let mut starts = Vec::with_capacity(items.len());
        let mut corners = Vec::with_capacity(items.iter().map(|i| i.mesh.triangles.len()).sum());
        let mut offset = 0;
        for item in items {
            starts.push(corners.len() as u32);
            let local = &points[offset..offset + item.mesh.positions.len()];
            let relative = |v: u32| (local[v as usize] - middle).as_vec3();
            corners.extend(item.mesh.triangles.iter().map(|t| t.map(relative)));
            offset += local.len();
        }
        let kept = if corners.len() <= MAX_KEPT_COLORS {
            corners.len()
        } else {
            0
        };
        Scene {
            items,
            starts,
            bvh: Bvh::new(&corners),
            bounds: Sphere {
                centre: middle,
                radius,
            },
            has_holes: items.iter().any(|item| item.shader.has_holes()),
            colors: (0..kept).map(|_| AtomicU64::new(0)).collect(),
        }
    }

    /// The item and the triangle of its mesh with a number in the hierarchy.
    fn item_of(&self, number: u32) -> (usize, usize) {
        let item = self.starts.partition_point(|&s| s <= number) - 1;
        (item, (number - self.starts[item]) as usize)
    }

    /// The hit of a ray in a direction on a triangle of an item.
    fn hit(&self, item: usize, triangle: usize, weights: [f32; 3], direction: DVec3) -> Hit<'a> {
        let Item {
            mesh, transform, ..
        } = &self.items[item];
        Hit::new(
            mesh,
            transform,
            triangle,
            weights.map(f64::from),
            -direction,
        )
    }

    /// A ray that leaves a surface.
    fn leaving(&self, from: Vec3, normal: Vec3, direction: Vec3) -> Ray {
        Ray {
            origin: from + normal * (self.bounds.radius as f32 * RELATIVE_RAY_OFFSET),
            direction,
            max_distance: f32::INFINITY,
        }
    }

    /// Whether anything hides what lies in the direction `out` from a surface.
    pub fn is_hidden(&self, from: Vec3, normal: Vec3, out: Vec3) -> bool {
        let ray = self.leaving(from, normal, out);
        if self.has_holes {
            self.nearest(ray).is_some()
        } else {
            self.bvh.is_blocked(&ray)
        }
    }

    /// The nearest intersection that is no hole.
    fn nearest(&self, mut ray: Ray) -> Option<Intersection> {
        let mut found = self.bvh.nearest(&ray)?;
        if !self.has_holes {
            return Some(found);
        }
        let start = ray.origin;
        let length = ray.direction.length();
        for _ in 0..MAX_LAYERS {
            let (item, triangle) = self.item_of(found.triangle);
            let direction = ray.direction.as_dvec3();
            let hit = self.hit(item, triangle, found.weights, direction);
            if !self.items[item].shader.is_hole(&hit) {
                break;
            }
            let step = self.bounds.radius as f32 * RELATIVE_RAY_OFFSET / length;
            ray.origin += ray.direction * (found.distance + step);
            found = self.bvh.nearest(&ray)?;
        }
        found.distance += (ray.origin - start).dot(ray.direction) / (length * length);
        Some(found)
    }

    /// The distance through the body behind a surface in a unit direction, where it is less than `most`, m.
    pub fn thickness(&self, from: Vec3, behind: Vec3, out: Vec3, most: f32) -> Option<f32> {
        let mut ray = self.leaving(from, behind, out);
        ray.max_distance = most;
        Some(self.bvh.nearest(&ray)?.distance)
    }

    /// What a ray from a surface meets; `footprint` is the size of a pixel on it.
    pub fn bounce(&self, from: Vec3, normal: Vec3, out: Vec3, footprint: f32) -> Option<Bounce> {
        let found = self.nearest(self.leaving(from, normal, out))?;
        let [a, b, c] = found.corners;
        let facing = (b - a).cross(c - a).normalize_or(-out);
        let facing = if facing.dot(out) > 0.0 {
            -facing
        } else {
            facing
        };
        let [u, v, w] = found.weights;
        let size = (b - a).length().max((c - a).length());
        let coarse = footprint * INDIRECT_FOOTPRINT_SCALE;
        let color = if size <= coarse {
            self.color_of(found.triangle, size, facing)
        } else {
            self.color_at(found.triangle, found.weights, coarse, facing)
        };
        Some(Bounce {
            position: a * u + b * v + c * w,
            normal: facing,
            color,
        })
    }

    /// The colour of a small triangle of a `size` at its middle.
    fn color_of(&self, number: u32, size: f32, facing: Vec3) -> Vec3 {
        let Some(kept) = self.colors.get(number as usize) else {
            return self.color_at(number, [1.0 / 3.0; 3], size, facing);
        };
        // Whoever comes first writes the same bits, so that no order needs to be kept.
        match kept.load(Ordering::Relaxed) {
            0 => {
                let packed = pack(self.color_at(number, [1.0 / 3.0; 3], size, facing));
                kept.store(packed, Ordering::Relaxed);
                unpack(packed)
            }
            packed => unpack(packed),
        }
    }

    /// The colour of a triangle at a point, where detail finer than `footprint` is averaged.
    fn color_at(&self, number: u32, weights: [f32; 3], footprint: f32, facing: Vec3) -> Vec3 {
        let (item, triangle) = self.item_of(number);
        let mut hit = self.hit(item, triangle, weights, -facing.as_dvec3());
        hit.footprint = f64::from(footprint);
        single(valid_appearance(self.items[item].shader.shade(&hit), &hit).color)
    }

    /// What a camera ray through a point of the picture sees, in coordinates from −1 to 1. Where that is nearly the same place as one of
    /// `known`, its appearance is that one's, because detail finer than a pixel is averaged anyway. A ground that is shown has no colour yet.
    pub fn look(&self, studio: &Studio, camera: &Camera, [u, v]: [f64; 2], known: &[Seen]) -> Seen {
        let direction = camera.direction(u, v);
        // f32 is too coarse far from the scene: the ray starts at the bounding sphere.
        let to_centre = (self.bounds.centre - camera.origin).dot(direction);
        let ahead = (to_centre - self.bounds.radius * 1.01).max(0.0);
        let start = camera.origin + direction * ahead - self.bounds.centre;
        let found = self.nearest(Ray {
            origin: start.as_vec3(),
            direction: direction.as_vec3(),
            max_distance: f32::INFINITY,
        });
        // What lies below the floor is hidden.
        let floor = (studio.floor.as_ref())
            .and_then(|floor| floor.distance(camera.origin, direction, studio.up));
        let found = found.filter(|f| floor.is_none_or(|d| f64::from(f.distance) + ahead <= d));
        let Some(found) = found else {
            return self.beyond_items(studio, camera, direction, [u, v]);
        };
        let (item, triangle) = self.item_of(found.triangle);
        let mut hit = self.hit(item, triangle, found.weights, direction);
        hit.footprint = camera.pixel_size * (f64::from(found.distance) + ahead);
        let place = Place {
            met: Met::Item(item as u32),
            position: (hit.position - self.bounds.centre).as_vec3(),
            normal: hit.normal.as_vec3(),
            geometric_normal: hit.geometric_normal.as_vec3(),
            footprint: hit.footprint as f32,
            is_fibrous: false,
        };
        let distance = |seen: &&Seen| seen.place.position.distance_squared(place.position);
        let is_near = |seen: &&Seen| {
            seen.place.met == place.met
                && distance(seen) < place.footprint * place.footprint
                && seen.place.geometric_normal.dot(place.geometric_normal) > MIN_SHARED_COSINE
        };
        let shared =
            (known.iter().filter(is_near)).min_by(|a, b| distance(a).total_cmp(&distance(b)));
        if let Some(seen) = shared {
            let is_fibrous = seen.place.is_fibrous;
            return Seen {
                place: Place {
                    is_fibrous,
                    ..place
                },
                ..*seen
            };
        }
        let appearance = valid_appearance(self.items[item].shader.shade(&hit), &hit);
        Seen {
            place: Place {
                is_fibrous: appearance.fibre != DVec3::ZERO,
                ..place
            },
            fibre: appearance.fibre.as_vec3(),
            color: single(appearance.color),
            roughness: appearance.roughness as f32,
            normal: appearance.normal.as_vec3(),
            to_viewer: -direction.as_vec3(),
            shadows: 0.0,
        }
    }

    /// What a camera ray sees that meets no item: the floor near the scene, or the background.
    fn beyond_items(
        &self,
        studio: &Studio,
        camera: &Camera,
        direction: DVec3,
        [u, v]: [f64; 2],
    ) -> Seen {
        let to_viewer = -direction.as_vec3();
        let background = Seen {
            place: Place {
                met: Met::Background,
                position: Vec3::ZERO,
                normal: to_viewer,
                geometric_normal: to_viewer,
                footprint: 0.0,
                is_fibrous: false,
            },
            fibre: Vec3::ZERO,
            color: studio.background(u, v),
            roughness: 1.0,
            normal: to_viewer,
            to_viewer,
            shadows: 0.0,
        };
        let Some(floor) = &studio.floor else {
            return background;
        };
        let Some(distance) = floor.distance(camera.origin, direction, studio.up) else {
            return background;
        };
        let position = camera.origin + direction * distance - self.bounds.centre;
        let away = (position.length() / self.bounds.radius - 1.0) * SHADOW_FADE;
        if away >= 1.0 && floor.ground.is_none() {
            return background;
        }
        let fade = away.clamp(0.0, 1.0) as f32;
        let color = match &floor.ground {
            Some(_) => Vec3::ZERO,
            None => background.color,
        };
        Seen {
            color,
            place: Place {
                met: if away < 1.0 {
                    Met::Floor
                } else {
                    Met::FarGround
                },
                position: position.as_vec3(),
                normal: studio.up,
                geometric_normal: studio.up,
                footprint: (camera.pixel_size * distance) as f32,
                is_fibrous: false,
            },
            normal: studio.up,
            shadows: 1.0 - fade * fade * (3.0 - 2.0 * fade),
            ..background
        }
    }
}

/// Bits of a component of a packed colour.
const COLOR_BITS: u32 = 21;

/// A colour, components 0 to 1, as bits that are not all 0.
fn pack(color: Vec3) -> u64 {
    let most = (1u64 << COLOR_BITS) - 1;
    let [r, g, b] = color.to_array().map(|c| (c * most as f32) as u64 & most);
    1 << 63 | r << (2 * COLOR_BITS) | g << COLOR_BITS | b
}

fn unpack(packed: u64) -> Vec3 {
    let most = (1u64 << COLOR_BITS) - 1;
    let part = |n: u32| (packed >> (n * COLOR_BITS) & most) as f32 / most as f32;
    Vec3::new(part(2), part(1), part(0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::light::{Lamp, luminance};
    use crate::plain::PlainShader;
    use crate::sampling::Sampler;
    use glam::DAffine3;
    use greenstick_geometry::Mesh;

    /// A sphere: an octahedron subdivided `steps` times.
    fn sphere(centre: DVec3, radius: f64, steps: usize) -> Mesh {
        let mut faces = Vec::new();
        for i in 0..8 {
            let x = 1.0 - 2.0 * (i & 1) as f64;
            let y = 1.0 - (i & 2) as f64;
            let z = 1.0 - (i & 4) as f64 / 2.0;
            faces.push([DVec3::X * x, DVec3::Y * y, DVec3::Z * z]);
        }
        for _ in 0..steps {
            faces = faces
                .iter()
                .flat_map(|&[a, b, c]| {
                    let [d, e, f] = [a + b, b + c, c + a].map(DVec3::normalize);
                    [[a, d, f], [d, b, e], [f, e, c], [d, e, f]]
                })
                .collect();
        }
        let positions: Vec<DVec3> = faces
            .iter()
            .flatten()
            .map(|&p| centre + p * radius)
            .collect();
        let triangles = (0..faces.len() as u32)
            .map(|i| [3 * i, 3 * i + 1, 3 * i + 2])
            .collect();
        Mesh {
            positions,
            triangles,
            ..Mesh::default()
        }
    }

    /// A shader of one grey without highlights.
    fn matt(grey: f64) -> PlainShader {
        let mut shader = PlainShader::uniform([grey; 3]);
        shader.default.roughness = 1.0;
        shader
    }

    /// A white sky and no lights.
    fn sky_only() -> Studio {
        let dark = || Lamp::new(DVec3::Z, 0.9, Vec3::ZERO);
        Studio {
            up: Vec3::Z,
            lamps: [dark(), dark()],
            sky: [Vec3::ONE; 2],
            floor_radiance: Vec3::ZERO,
            floor: None,
            background: [Vec3::ONE; 2],
        }
    }

    /// The luminance of what a camera at `from` sees at `to`, in light of so many rays.
    fn seen_light(scene: &Scene, studio: &Studio, from: DVec3, to: DVec3, rays: u32) -> f64 {
        let forward = (to - from).normalize();
        let right = forward.any_orthonormal_vector();
        let camera = Camera {
            origin: from,
            right,
            up: right.cross(forward),
            forward,
            tangents: [1e-3; 2],
            pixel_size: 1e-4,
        };
        let seen = scene.look(studio, &camera, [0.0, 0.0], &[]);
        let light = scene.light_at(studio, &seen.place, &Sampler::new([7, 9], rays), rays);
        f64::from(luminance(seen.radiance(studio, &light)))
    }

    #[test]
    fn a_white_sphere_in_a_white_sky_reflects_all_light() {
        let mesh = sphere(DVec3::ZERO, 1.0, 5);
        let shader = matt(1.0);
        let items = [Item {
            mesh: &mesh,
            transform: DAffine3::IDENTITY,
            shader: &shader,
        }];
        let scene = Scene::new(&items, &world_points(&items).unwrap());
        for x in [0.0, 0.3, 0.7] {
            let light = seen_light(
                &scene,
                &sky_only(),
                DVec3::new(x, 0.0, 9.0),
                DVec3::new(x, 0.0, 0.0),
                1024,
            );
            assert!(
                (light - 1.0).abs() < 0.03,
                "{light} of the light is reflected at {x}"
            );
        }
    }

    #[test]
    fn a_black_sphere_hides_its_configuration_factor() {
        // Seen from a small horizontal plate, a sphere above the horizon hides the fraction cos θ (R/d)² (Howell, Catalog of
        // Configuration Factors, B-20).
        let plate = Mesh {
            positions: [[-9.0, -9.0], [9.0, -9.0], [9.0, 9.0], [-9.0, 9.0]]
                .map(|[x, y]| DVec3::new(x, y, 0.0))
                .to_vec(),
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..Mesh::default()
        };
        let above = sphere(DVec3::new(0.0, 0.0, 1.5), 1.0, 6);
        let (grey, black) = (matt(0.5), matt(0.0));
        let items = [
            Item {
                mesh: &plate,
                transform: DAffine3::IDENTITY,
                shader: &grey,
            },
            Item {
                mesh: &above,
                transform: DAffine3::IDENTITY,
                shader: &black,
            },
        ];
        let scene = Scene::new(&items, &world_points(&items).unwrap());
        let open = {
            let far = DVec3::new(-8.5, -8.5, 0.0);
            seen_light(
                &scene,
                &sky_only(),
                far + DVec3::new(-0.5, 0.0, 2.0),
                far,
                4096,
            )
        };
        for x in [0.0, 1.0, 2.0, 3.0] {
            let at = DVec3::new(x, 0.0, 0.0);
            let from = at + DVec3::new(0.9, 0.0, 0.6);
            let light = seen_light(&scene, &sky_only(), from, at, 4096) / open;
            let square = x * x + 1.5 * 1.5;
            let expected = 1.0 - 1.5 / square.sqrt() / square;
            assert!(
                (light - expected).abs() < 0.02,
                "{light} at {x}, expected {expected}"
            );
        }
    }
}
