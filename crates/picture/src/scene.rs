//! The items gathered in one hierarchy, and the light that comes back along a ray.

use crate::bvh::{Bvh, Ray};
use crate::light::{FLOOR_RADIANCE, Light, Studio, luminance};
use crate::sampling::{Sampler, cone_direction, cosine_direction};
use crate::shader::{Appearance, Hit};
use crate::{Item, MAXIMUM_TRIANGLES, PictureError};
use glam::{DVec3, Vec3};
use std::f64::consts::PI;

/// The items, ready to be met by rays.
pub(crate) struct Scene<'a> {
    items: &'a [Item<'a>],
    /// Number of the first triangle of each item.
    starts: Vec<u32>,
    bvh: Bvh,
    /// Middle and radius (m) of the ball about the bounding box.
    pub middle: DVec3,
    pub radius: f64,
}

/// Every vertex in the world, checked to be finite and to exist where named.
pub(crate) fn world_points(items: &[Item]) -> Result<Vec<DVec3>, PictureError> {
    let triangles: usize = items.iter().map(|i| i.mesh.triangles.len()).sum();
    if triangles == 0 {
        return Err(PictureError::Empty { items: items.len() });
    }
    if triangles > MAXIMUM_TRIANGLES {
        return Err(PictureError::Triangles { triangles });
    }
    let mut points = Vec::with_capacity(items.iter().map(|i| i.mesh.positions.len()).sum());
    for (number, item) in items.iter().enumerate() {
        for (vertex, p) in item.mesh.positions.iter().enumerate() {
            let position = item.transform.transform_point3(*p);
            // Distances are squared in f32 later on: beyond this they would overflow.
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

/// What came back along a camera ray; the last three guide the smoothing.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Seen {
    pub light: DVec3,
    pub color: DVec3,
    pub normal: DVec3,
    /// Distance, m; infinite for the background.
    pub distance: f64,
    /// Whether an item was met, not the floor or the background.
    pub item: bool,
    /// Samples behind a mean of many; 1 for one.
    pub samples: u32,
}

/// The look of the last surface that a pixel's samples met: the next sample takes it over where it meets nearly the
/// same place, since detail finer than the pixel is averaged anyway.
pub(crate) type Remembered = Option<(usize, DVec3, DVec3, Appearance)>;

/// Of this many samples only one asks the shader.
const SHADE_EVERY: u32 = 3;

/// Colour of the second surface is asked at this multiple of the first one's footprint: detail there is averaged.
const INDIRECT_FOOTPRINT: f64 = 16.0;
/// Share of the dome that a surface met by an indirect ray is taken to see; its own occlusion is not traced.
const INDIRECT_OPENNESS: f64 = 0.6;
/// Reflectance of bark and wood seen face on (index of refraction 1.5).
const FACE_ON: f64 = 0.04;
/// A single sample is not brighter than this: a highlight met by chance would stay a white pixel.
const BRIGHTEST: f64 = 4.0;
/// Smoother highlights than this are noise at few samples.
const LEAST_ROUGHNESS: f64 = 0.3;

impl<'a> Scene<'a> {
    /// Gathers the items; `points` as [`world_points`] gives them.
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
            let near = |v: u32| (local[v as usize] - middle).as_vec3();
            corners.extend(item.mesh.triangles.iter().map(|t| t.map(near)));
            offset += local.len();
        }
        Scene {
            items,
            starts,
            bvh: Bvh::build(&corners),
            middle,
            radius,
        }
    }

    fn ray(&self, origin: DVec3, direction: DVec3) -> Ray {
        let origin: Vec3 = (origin - self.middle).as_vec3();
        Ray {
            origin,
            direction: direction.as_vec3(),
            reach: f32::INFINITY,
        }
    }

    /// A ray that leaves a surface: lifted off by what f32 coordinates may be wrong.
    fn leaving(&self, from: DVec3, normal: DVec3, direction: DVec3) -> Ray {
        self.ray(from + normal * (self.radius * 2e-6), direction)
    }

    /// The nearest hit and its distance; `footprint` of the hit is `pixel` × distance + `base`.
    fn meet(
        &self,
        ray: &Ray,
        direction: DVec3,
        pixel: f64,
        base: f64,
    ) -> Option<(usize, Hit<'a>, f64)> {
        let meeting = self.bvh.nearest(ray)?;
        let item = self.starts.partition_point(|&s| s <= meeting.triangle) - 1;
        let triangle = (meeting.triangle - self.starts[item]) as usize;
        let weights = meeting.weights.map(f64::from);
        let mut hit = Hit::new(&self.items[item], triangle, weights, -direction);
        let distance = f64::from(meeting.distance);
        hit.footprint = pixel * distance + base;
        Some((item, hit, distance))
    }

    /// Light that comes back to `origin` from a unit `direction`. `background` is what is seen where nothing is met;
    /// `pixel` the size of a pixel one metre ahead, m; `light` the number of the light to sample and its weight.
    pub fn see(
        &self,
        studio: &Studio,
        (origin, direction): (DVec3, DVec3),
        (pixel, background): (f64, DVec3),
        sampler: &Sampler,
        light: (usize, f64),
        remembered: &mut Remembered,
    ) -> Seen {
        let open = Seen {
            light: background,
            color: background,
            normal: -direction,
            distance: f64::INFINITY,
            item: false,
            samples: 1,
        };
        // From far away f32 would be too coarse: start at the ball about the scene.
        let ahead = ((self.middle - origin).dot(direction) - self.radius * 1.01).max(0.0);
        let ray = self.ray(origin + direction * ahead, direction);
        let met = self.meet(&ray, direction, pixel, pixel * ahead);
        let Some((item, hit, distance)) = met else {
            return self
                .see_floor(studio, (origin, direction), sampler, light)
                .map_or(open, |(shade, distance)| Seen {
                    light: background * shade,
                    color: background,
                    normal: studio.up,
                    distance,
                    item: false,
                    samples: 1,
                });
        };
        let look = match remembered {
            Some((of, place, side, look))
                if !sampler.index.is_multiple_of(SHADE_EVERY)
                    && *of == item
                    && place.distance(hit.position) < hit.footprint
                    && side.dot(hit.geometric_normal) > 0.985 =>
            {
                *look
            }
            _ => tamed(self.items[item].shader.shade(&hit), &hit),
        };
        *remembered = Some((item, hit.position, hit.geometric_normal, look));
        let surface = Surface {
            look: &look,
            position: hit.position,
            side: hit.geometric_normal,
            to: -direction,
        };
        let mut sum =
            self.direct(studio, &surface, &studio.lights[light.0], sampler.square(2)) * light.1;
        let out = cosine_direction(look.normal, sampler.square(3));
        if out.dot(hit.geometric_normal) > 0.0 {
            let incoming = self.indirect(studio, &surface, out, hit.footprint, sampler, light);
            // The density cosine / π cancels the cosine.
            sum += surface.scatter(out) * incoming * PI;
        }
        Seen {
            light: sum.min(DVec3::splat(BRIGHTEST)),
            color: DVec3::from_array(look.color),
            normal: look.normal,
            distance: distance + ahead,
            item: true,
            samples: 1,
        }
    }

    /// Light from one of the lights, reflected.
    fn direct(&self, studio: &Studio, surface: &Surface, light: &Light, square: [f64; 2]) -> DVec3 {
        let out = cone_direction(light.direction, light.cosine, square);
        let cosine = out.dot(surface.look.normal);
        if cosine <= 0.0 || out.dot(surface.side) <= 0.0 || !self.open(studio, surface, out) {
            return DVec3::ZERO;
        }
        surface.scatter(out) * light.irradiance * cosine
    }

    fn open(&self, studio: &Studio, surface: &Surface, out: DVec3) -> bool {
        // The lights stand above the horizon, so the floor hides none of them.
        debug_assert!(studio.floor.is_none() || out.dot(studio.up) > 0.0);
        !self
            .bvh
            .blocks(&self.leaving(surface.position, surface.side, out))
    }

    /// Radiance that reaches the surface from the unit direction `out`, by way of the sky or another surface.
    fn indirect(
        &self,
        studio: &Studio,
        surface: &Surface,
        out: DVec3,
        footprint: f64,
        sampler: &Sampler,
        light: (usize, f64),
    ) -> DVec3 {
        let ray = self.leaving(surface.position, surface.side, out);
        let Some((item, hit, _)) = self.meet(&ray, out, 0.0, footprint * INDIRECT_FOOTPRINT) else {
            let below = studio.floor.is_some() && out.dot(studio.up) < 0.0;
            return if below {
                DVec3::splat(FLOOR_RADIANCE)
            } else {
                studio.sky(out)
            };
        };
        let look = tamed(self.items[item].shader.shade(&hit), &hit);
        let color = DVec3::from_array(look.color);
        let second = Surface {
            look: &look,
            position: hit.position,
            side: hit.geometric_normal,
            to: -out,
        };
        let direct = self.direct(studio, &second, &studio.lights[light.0], sampler.square(4));
        direct * light.1 + color * studio.sky(look.normal) * INDIRECT_OPENNESS
    }

    /// How much the floor is shaded (1: not at all) and its distance; `None` where the floor is not seen.
    fn see_floor(
        &self,
        studio: &Studio,
        (origin, direction): (DVec3, DVec3),
        sampler: &Sampler,
        light: (usize, f64),
    ) -> Option<(f64, f64)> {
        let floor = studio.floor.as_ref()?;
        let fall = direction.dot(studio.up);
        let distance = (floor.level - origin.dot(studio.up)) / fall;
        if fall >= 0.0 || !distance.is_finite() {
            return None;
        }
        let position = origin + direction * distance;
        let away = (position.distance(floor.middle) / floor.radius - 1.0) * 0.4;
        if away >= 1.0 {
            return None;
        }
        let free = |out: DVec3| !self.bvh.blocks(&self.leaving(position, studio.up, out));
        let lamp = &studio.lights[light.0];
        let toward_lamp = cone_direction(lamp.direction, lamp.cosine, sampler.square(2));
        let out = cosine_direction(studio.up, sampler.square(3));
        let mut light_there = 0.0;
        if free(toward_lamp) {
            let cosine = toward_lamp.dot(studio.up).max(0.0);
            light_there += luminance(lamp.irradiance) * cosine * light.1;
        }
        // What hides the sky is itself not quite black.
        let hidden = if free(out) { 1.0 } else { 0.1 };
        light_there += luminance(studio.sky(out)) * PI * hidden;
        let keep = away.max(0.0);
        let keep = keep * keep * (3.0 - 2.0 * keep);
        let shade = light_there / studio.open_floor();
        Some((shade + (1.0 - shade) * keep, distance))
    }
}

/// A place of a surface seen from the unit direction `to`.
struct Surface<'a> {
    look: &'a Appearance,
    position: DVec3,
    /// Geometric normal on the viewer's side.
    side: DVec3,
    to: DVec3,
}

impl Surface<'_> {
    /// The reflectance (1/sr) towards the unit direction `out`: Lambert under a GGX coat (Walter and others 2007,
    /// with the height-correlated masking of Heitz 2014).
    fn scatter(&self, out: DVec3) -> DVec3 {
        let n = self.look.normal;
        let half = (out + self.to).normalize_or(n);
        let (nl, nv) = (n.dot(out).max(1e-4), n.dot(self.to).max(0.05));
        let (nh, vh) = (n.dot(half).max(0.0), self.to.dot(half).clamp(0.0, 1.0));
        let a = self.look.roughness * self.look.roughness;
        let a = a * a;
        let d = nh * nh * (a - 1.0) + 1.0;
        let masked = nl * (nv * nv * (1.0 - a) + a).sqrt() + nv * (nl * nl * (1.0 - a) + a).sqrt();
        let f = 1.0 - vh;
        let fresnel = FACE_ON + (1.0 - FACE_ON) * f * f * f * f * f;
        let coat = a / (PI * d * d) * 0.5 / masked * fresnel;
        DVec3::from_array(self.look.color) * ((1.0 - fresnel) / PI) + DVec3::splat(coat)
    }
}

/// A shader's answer made safe: finite, in range, the normal of unit length and on the viewer's side.
fn tamed(look: Appearance, hit: &Hit) -> Appearance {
    let color = look.color.map(|c| {
        if c.is_finite() {
            c.clamp(0.0, 1.0)
        } else {
            0.0
        }
    });
    let rough = if look.roughness.is_finite() {
        look.roughness
    } else {
        1.0
    };
    let mut normal = look.normal.try_normalize().unwrap_or(hit.normal);
    // A bump must not turn the surface's face into its own shadow altogether.
    let lift = normal.dot(hit.geometric_normal);
    if lift < 0.1 {
        normal = (normal + hit.geometric_normal * (0.1 - lift)).normalize_or(hit.geometric_normal);
    }
    Appearance {
        color,
        roughness: rough.clamp(LEAST_ROUGHNESS, 1.0),
        normal,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::PlainShader;
    use glam::DAffine3;
    use greenstick_geometry::Mesh;

    /// A ball of the given radius about a place: an octahedron divided `steps` times.
    fn ball(centre: DVec3, radius: f64, steps: usize) -> Mesh {
        let mut faces = Vec::new();
        for (x, y, z) in (0..8).map(|i| {
            (
                1.0 - 2.0 * (i & 1) as f64,
                1.0 - (i & 2) as f64,
                1.0 - (i & 4) as f64 / 2.0,
            )
        }) {
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

    fn dome_only() -> Studio {
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

    fn mean_light(scene: &Scene, studio: &Studio, from: DVec3, to: DVec3, samples: u32) -> f64 {
        let sum: f64 = (0..samples)
            .map(|index| {
                let sampler = Sampler {
                    pixel: 7,
                    index,
                    digits: 32 - samples.leading_zeros(),
                };
                let ray = (from, (to - from).normalize());
                luminance(
                    scene
                        .see(
                            studio,
                            ray,
                            (1e-4, DVec3::ONE),
                            &sampler,
                            (0, 1.0),
                            &mut None,
                        )
                        .light,
                )
            })
            .sum();
        sum / f64::from(samples)
    }

    #[test]
    fn a_white_ball_in_a_white_dome_gives_back_all_light() {
        let mesh = ball(DVec3::ZERO, 1.0, 5);
        let shader = PlainShader {
            roughness: 1.0,
            ..PlainShader::uniform([1.0; 3])
        };
        let items = [Item {
            mesh: &mesh,
            transform: DAffine3::IDENTITY,
            shader: &shader,
        }];
        let scene = Scene::new(&items, &world_points(&items).unwrap());
        for x in [0.0, 0.3, 0.7] {
            let light = mean_light(
                &scene,
                &dome_only(),
                DVec3::new(x, 0.0, 9.0),
                DVec3::new(x, 0.0, 0.0),
                1024,
            );
            assert!(
                (light - 1.0).abs() < 0.03,
                "{light} of the light came back at {x}"
            );
        }
    }

    #[test]
    fn a_black_ball_above_a_plane_hides_the_form_factor_of_a_sphere() {
        // A small horizontal plate under a ball: the hidden part is cos θ (R/d)² while the ball is above the plate's
        // horizon (Howell, Catalog of Configuration Factors, B-20).
        let plate = Mesh {
            positions: [(-9.0, -9.0), (9.0, -9.0), (9.0, 9.0), (-9.0, 9.0)]
                .map(|(x, y)| DVec3::new(x, y, 0.0))
                .to_vec(),
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..Mesh::default()
        };
        let sphere = ball(DVec3::new(0.0, 0.0, 1.5), 1.0, 6);
        let grey = PlainShader {
            roughness: 1.0,
            ..PlainShader::uniform([0.5; 3])
        };
        let black = PlainShader {
            roughness: 1.0,
            ..PlainShader::uniform([0.0; 3])
        };
        let items = [
            Item {
                mesh: &plate,
                transform: DAffine3::IDENTITY,
                shader: &grey,
            },
            Item {
                mesh: &sphere,
                transform: DAffine3::IDENTITY,
                shader: &black,
            },
        ];
        let scene = Scene::new(&items, &world_points(&items).unwrap());
        let open = {
            let far = DVec3::new(-8.5, -8.5, 0.0);
            mean_light(
                &scene,
                &dome_only(),
                far + DVec3::new(-0.5, 0.0, 2.0),
                far,
                4096,
            )
        };
        for x in [0.0, 1.0, 2.0, 3.0] {
            let at = DVec3::new(x, 0.0, 0.0);
            let from = at + DVec3::new(0.9, 0.0, 0.6);
            let light = mean_light(&scene, &dome_only(), from, at, 4096) / open;
            let square = x * x + 1.5 * 1.5;
            let expected = 1.0 - 1.5 / square.sqrt() / square;
            assert!(
                (light - expected).abs() < 0.02,
                "{light} at {x}, expected {expected}"
            );
        }
    }
}
