//! The scene: all items in one hierarchy, and the radiance along rays.

use crate::bvh::{Bvh, Ray};
use crate::camera::Sphere;
use crate::error::{MAX_TRIANGLES, PictureError};
use crate::item::Item;
use crate::light::{FLOOR_RADIANCE, Light, Studio, luminance};
use crate::sampling::{Sampler, cone_direction, cosine_direction};
use crate::shader::{Appearance, Hit};
use crate::surface::{Surface, valid_appearance};
use glam::{DVec3, Vec3};
use std::f64::consts::PI;

/// The items in a hierarchy.
pub(crate) struct Scene<'a> {
    items: &'a [Item<'a>],
    /// Number of the first triangle of each item.
    starts: Vec<u32>,
    bvh: Bvh,
    /// Sphere around the bounding box.
    pub bounds: Sphere,
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

/// The result for a camera ray, or the mean of several.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Sample {
    pub radiance: DVec3,
    /// Colour of the surface.
    pub color: DVec3,
    pub normal: DVec3,
    /// Distance, m; infinite for the background.
    pub distance: f64,
    /// Whether the ray hit an item, not the floor or the background.
    pub is_item: bool,
    /// Number of rays.
    pub samples: u32,
}

/// A camera ray.
#[derive(Clone, Copy)]
pub(crate) struct CameraRay {
    pub origin: DVec3,
    /// Unit direction.
    pub direction: DVec3,
    /// Size of a pixel at a distance of one metre, m.
    pub pixel_size: f64,
    /// Radiance of the background in this direction.
    pub background: DVec3,
}

/// The light that a sample uses.
#[derive(Clone, Copy)]
pub(crate) struct LightChoice {
    /// Index of the light.
    pub light: usize,
    /// Reciprocal of the probability of this choice.
    pub weight: f64,
}

/// The last surface that the samples of a pixel hit. The next sample reuses its appearance if it hits nearly the same
/// point, because detail finer than a pixel is averaged anyway.
#[derive(Clone, Copy)]
pub(crate) struct LastSurface {
    item: usize,
    position: DVec3,
    normal: DVec3,
    appearance: Appearance,
}

/// Every sample with an index divisible by this evaluates the shader.
const SHADING_INTERVAL: u32 = 3;
/// Smallest cosine of the angle between normals at which samples share an appearance.
const MIN_SHARED_COSINE: f64 = 0.985;
/// Offset of rays that leave a surface, relative to the radius of the scene: the error of f32 coordinates.
const RELATIVE_RAY_OFFSET: f64 = 2e-6;

/// Footprint on surfaces hit by indirect rays, relative to that on the first surface: finer detail is averaged.
const INDIRECT_FOOTPRINT_SCALE: f64 = 16.0;
/// Fraction of the sky that is assumed to be visible from surfaces hit by indirect rays; their occlusion is not traced.
const INDIRECT_OPENNESS: f64 = 0.6;
/// Largest radiance of a sample: rare highlights would remain as white pixels.
const MAX_RADIANCE: f64 = 4.0;

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
        Scene {
            items,
            starts,
            bvh: Bvh::new(&corners),
            bounds: Sphere {
                centre: middle,
                radius,
            },
        }
    }

    /// A ray in the coordinates of the hierarchy.
    fn ray(&self, origin: DVec3, direction: DVec3) -> Ray {
        let origin: Vec3 = (origin - self.bounds.centre).as_vec3();
        Ray {
            origin,
            direction: direction.as_vec3(),
            max_distance: f32::INFINITY,
        }
    }

    /// A ray that leaves a surface.
    fn leaving(&self, from: DVec3, normal: DVec3, direction: DVec3) -> Ray {
        self.ray(
            from + normal * (self.bounds.radius * RELATIVE_RAY_OFFSET),
            direction,
        )
    }

    /// Finds the nearest intersection. Returns the item, the intersection and its distance; the footprint is
    /// `pixel_size` × distance + `base`.
    fn intersect(
        &self,
        ray: &Ray,
        direction: DVec3,
        pixel_size: f64,
        base: f64,
    ) -> Option<(usize, Hit<'a>, f64)> {
        let found = self.bvh.nearest(ray)?;
        let item = self.starts.partition_point(|&s| s <= found.triangle) - 1;
        let triangle = (found.triangle - self.starts[item]) as usize;
        let weights = found.weights.map(f64::from);
        let mut hit = Hit::new(
            self.items[item].mesh,
            &self.items[item].transform,
            triangle,
            weights,
            -direction,
        );
        let distance = f64::from(found.distance);
        hit.footprint = pixel_size * distance + base;
        Some((item, hit, distance))
    }

    /// Computes the radiance along a camera ray.
    pub fn sample(
        &self,
        studio: &Studio,
        camera_ray: &CameraRay,
        sampler: &Sampler,
        light: LightChoice,
        last: &mut Option<LastSurface>,
    ) -> Sample {
        let CameraRay {
            origin,
            direction,
            pixel_size,
            background,
        } = *camera_ray;
        // f32 is too coarse far from the scene: the ray starts at the bounding sphere.
        let to_centre = (self.bounds.centre - origin).dot(direction);
        let ahead = (to_centre - self.bounds.radius * 1.01).max(0.0);
        let ray = self.ray(origin + direction * ahead, direction);
        let found = self.intersect(&ray, direction, pixel_size, pixel_size * ahead);
        let Some((item, hit, distance)) = found else {
            return self
                .sample_floor(studio, camera_ray, sampler, light)
                .unwrap_or(Sample {
                    radiance: background,
                    color: background,
                    normal: -direction,
                    distance: f64::INFINITY,
                    is_item: false,
                    samples: 1,
                });
        };
        let appearance = match last {
            Some(last)
                if !sampler.index.is_multiple_of(SHADING_INTERVAL)
                    && last.item == item
                    && last.position.distance(hit.position) < hit.footprint
                    && last.normal.dot(hit.geometric_normal) > MIN_SHARED_COSINE =>
            {
                last.appearance
            }
            _ => valid_appearance(self.items[item].shader.shade(&hit), &hit),
        };
        *last = Some(LastSurface {
            item,
            position: hit.position,
            normal: hit.geometric_normal,
            appearance,
        });
        let surface = Surface {
            appearance: &appearance,
            position: hit.position,
            geometric_normal: hit.geometric_normal,
            to_viewer: -direction,
        };
        let lamp = &studio.lights[light.light];
        let mut sum = self.direct(&surface, lamp, sampler.square(2), studio) * light.weight;
        let out = cosine_direction(appearance.normal, sampler.square(3));
        if out.dot(hit.geometric_normal) > 0.0 {
            let incoming = self.indirect(studio, &surface, out, hit.footprint, sampler, light);
            // The density cosine / π cancels the cosine.
            sum += surface.scatter(out) * incoming * PI;
        }
        Sample {
            radiance: sum.min(DVec3::splat(MAX_RADIANCE)),
            color: DVec3::from_array(appearance.color),
            normal: appearance.normal,
            distance: distance + ahead,
            is_item: true,
            samples: 1,
        }
    }

    /// Radiance from one of the lights that a surface reflects.
    fn direct(&self, surface: &Surface, light: &Light, square: [f64; 2], studio: &Studio) -> DVec3 {
        let out = cone_direction(light.direction, light.cosine, square);
        let cosine = out.dot(surface.appearance.normal);
        let is_behind = cosine <= 0.0 || out.dot(surface.geometric_normal) <= 0.0;
        if is_behind || !self.reaches_light(studio, surface, out) {
            return DVec3::ZERO;
        }
        surface.scatter(out) * light.irradiance * cosine
    }

    /// Whether nothing lies between a surface and a light.
    fn reaches_light(&self, studio: &Studio, surface: &Surface, out: DVec3) -> bool {
        // The lights are above the horizon, so that the floor never hides them.
        debug_assert!(studio.floor.is_none() || out.dot(studio.up) > 0.0);
        !self
            .bvh
            .is_blocked(&self.leaving(surface.position, surface.geometric_normal, out))
    }

    /// Radiance that reaches a surface from the unit direction `out`, from the sky, the floor or another surface.
    fn indirect(
        &self,
        studio: &Studio,
        surface: &Surface,
        out: DVec3,
        footprint: f64,
        sampler: &Sampler,
        light: LightChoice,
    ) -> DVec3 {
        let ray = self.leaving(surface.position, surface.geometric_normal, out);
        let base = footprint * INDIRECT_FOOTPRINT_SCALE;
        let Some((item, hit, _)) = self.intersect(&ray, out, 0.0, base) else {
            let is_floor = studio.floor.is_some() && out.dot(studio.up) < 0.0;
            return if is_floor {
                DVec3::splat(FLOOR_RADIANCE)
            } else {
                studio.sky(out)
            };
        };
        let appearance = valid_appearance(self.items[item].shader.shade(&hit), &hit);
        let color = DVec3::from_array(appearance.color);
        let second = Surface {
            appearance: &appearance,
            position: hit.position,
            geometric_normal: hit.geometric_normal,
            to_viewer: -out,
        };
        let lamp = &studio.lights[light.light];
        let direct = self.direct(&second, lamp, sampler.square(4), studio);
        direct * light.weight + color * studio.sky(appearance.normal) * INDIRECT_OPENNESS
    }

    /// The sample of the floor, where shadows darken the background; `None` if the floor is not visible.
    fn sample_floor(
        &self,
        studio: &Studio,
        ray: &CameraRay,
        sampler: &Sampler,
        light: LightChoice,
    ) -> Option<Sample> {
        let floor = studio.floor.as_ref()?;
        let fall = ray.direction.dot(studio.up);
        let distance = (floor.level - ray.origin.dot(studio.up)) / fall;
        if fall >= 0.0 || !distance.is_finite() {
            return None;
        }
        let position = ray.origin + ray.direction * distance;
        let away = (position.distance(floor.bounds.centre) / floor.bounds.radius - 1.0) * 0.4;
        if away >= 1.0 {
            return None;
        }
        let is_free = |out: DVec3| !self.bvh.is_blocked(&self.leaving(position, studio.up, out));
        let lamp = &studio.lights[light.light];
        let to_lamp = cone_direction(lamp.direction, lamp.cosine, sampler.square(2));
        let out = cosine_direction(studio.up, sampler.square(3));
        let mut irradiance = 0.0;
        if is_free(to_lamp) {
            let cosine = to_lamp.dot(studio.up).max(0.0);
            irradiance += luminance(lamp.irradiance) * cosine * light.weight;
        }
        // Surfaces that hide the sky are not entirely black.
        let visibility = if is_free(out) { 1.0 } else { 0.1 };
        irradiance += luminance(studio.sky(out)) * PI * visibility;
        let fade = away.max(0.0);
        let fade = fade * fade * (3.0 - 2.0 * fade);
        let shade = irradiance / studio.unshadowed_floor();
        Some(Sample {
            radiance: ray.background * (shade + (1.0 - shade) * fade),
            color: ray.background,
            normal: studio.up,
            distance,
            is_item: false,
            samples: 1,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shader::PlainShader;
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
        let dark = Light {
            direction: DVec3::Z,
            cosine: 0.9,
            irradiance: DVec3::ZERO,
        };
        let white = DVec3::ONE;
        Studio {
            up: DVec3::Z,
            lights: vec![dark],
            sky: [white; 2],
            floor: None,
            background: [white; 2],
        }
    }

    /// The mean luminance of samples along one ray.
    fn mean_light(scene: &Scene, studio: &Studio, from: DVec3, to: DVec3, samples: u32) -> f64 {
        let sum: f64 = (0..samples)
            .map(|index| {
                let sampler = Sampler {
                    pixel: 7,
                    index,
                    digits: 32 - samples.leading_zeros(),
                };
                let ray = CameraRay {
                    origin: from,
                    direction: (to - from).normalize(),
                    pixel_size: 1e-4,
                    background: DVec3::ONE,
                };
                let light = LightChoice {
                    light: 0,
                    weight: 1.0,
                };
                let sample = scene.sample(studio, &ray, &sampler, light, &mut None);
                luminance(sample.radiance)
            })
            .sum();
        sum / f64::from(samples)
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
            let light = mean_light(
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
            mean_light(
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
            let light = mean_light(&scene, &sky_only(), from, at, 4096) / open;
            let square = x * x + 1.5 * 1.5;
            let expected = 1.0 - 1.5 / square.sqrt() / square;
            assert!(
                (light - expected).abs() < 0.02,
                "{light} at {x}, expected {expected}"
            );
        }
    }
}
