//! The appearance of a stem at a point of a surface: the address of the point, and the directions of the relief there.

use super::bark::BarkPoint;
use super::saw::saw_mark;
use super::stem::StemAppearance;
use super::surface::WoodSurface;
use super::wood::WoodPoint;
use crate::rings::StemAddress;
use crate::stem::Stem;
use glam::{DVec2, DVec3};

/// Cosine of the angle to the grain within which a face of the skin is a sawn end.
const SAWN_COSINE: f64 = 0.9;
/// Distance from an end up to which wood inside that lies straight across the grain was sawn, radii, and its cosine.
const CUT_END_RADII: f64 = 0.15;
const CUT_END_COSINE: f64 = 0.9995;
/// Cosine of the angle to the direction away from the pith beyond which the skin is that of a bore: the sides of furrows in
/// bark turn away from that direction by no more than a right angle.
const BORE_COSINE: f64 = -0.5;
/// Distance from the pith up to which it may be, radii: folds in thick bark lie farther out.
const BORE_RADII: f64 = 0.85;
/// Brightness of weathered wood over that of fresh, and its tint.
const WEATHERED_LIGHT: f64 = 0.62;
const WEATHERED_TINT: [f64; 3] = [1.0, 0.985, 0.95];

/// What is left of the relief of torn wood after planing.
const PLANED_RELIEF: f64 = 0.25;
/// How much less saturated a fresh tear is than planed wood, how much lighter, and its least roughness.
const TORN_PALENESS: f64 = 0.16;
const TORN_LIGHT: f64 = 1.0;
const TORN_ROUGHNESS: f64 = 0.82;
/// The same of fibres that broke across, over end grain that was sawn.
const BRUSH_PALENESS: f64 = 0.12;
const BRUSH_LIGHT: f64 = 0.2;

/// A point of the surface of a stem, in the world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfacePoint {
    /// Position, m.
    pub position: DVec3,
    /// Unit normal for shading.
    pub normal: DVec3,
    /// Unit normal of the triangle.
    pub geometric_normal: DVec3,
    /// Grain coordinates, m; `None` off the limb.
    pub grain: Option<DVec3>,
    /// Whether the wood has moved since it grew, so that the stem's frames do not give directions.
    pub moved: bool,
    /// Gradients of the grain coordinates along the surface, of wood that has moved.
    pub grain_gradients: Option<[DVec3; 3]>,
    /// Size of detail that is averaged, m.
    pub footprint: f64,
}

/// The appearance at a point of a surface, with directions in the world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OrientedSurface {
    /// The appearance.
    pub surface: WoodSurface,
    /// Directions of x and y of the section and of the grain.
    pub directions: [DVec3; 3],
}

impl OrientedSurface {
    /// Returns the gradient of the micro relief in the world, m per m.
    pub fn relief_gradient(&self) -> DVec3 {
        let ([x, y, along], slope) = (self.directions, self.surface.slope);
        x * slope.x + y * slope.y + along * slope.z
    }
}

impl StemAppearance {
    /// Returns the wood inside at a point with grain coordinates `grain`, m.
    pub fn wood_at(&self, stem: &Stem, grain: DVec3, point: &SurfacePoint) -> OrientedSurface {
        let (shown, end_grain) = self.wood_and_cut(stem, grain, point);
        // An end that was sawn off for its cracks shows the wood inside.
        let margin = CUT_END_RADII * stem.radius;
        let at_end = grain.z < margin || grain.z > stem.length - margin;
        match at_end && end_grain > CUT_END_COSINE {
            true => self.with_saw_marks(shown, (stem, grain), point.footprint),
            false => OrientedSurface {
                surface: torn_across(shown.surface, end_grain),
                ..shown
            },
        }
    }

    /// Returns the wood inside at a point, and |normal · grain|.
    fn wood_and_cut(
        &self,
        stem: &Stem,
        grain: DVec3,
        point: &SurfacePoint,
    ) -> (OrientedSurface, f64) {
        let (ring, angle) = self.address(stem, grain);
        let normal = point.geometric_normal;
        let (directions, end_grain, facing) = match point.grain_gradients {
            // A length along the grain that does not change along a face means that the face lies across it.
            Some(rise) => {
                // They lie in the face: their vector products give the normal in the directions of the grain.
                let [x, y, along] = rise;
                let facing = DVec2::new(normal.dot(y.cross(along)), normal.dot(along.cross(x)));
                let end_grain = (1.0 - along.length_squared()).max(0.0).sqrt();
                (rise, end_grain, facing)
            }
            None => {
                let frame = stem.grain.axis().frame(grain.z);
                (
                    [frame.x, frame.y, frame.tangent],
                    normal.dot(frame.tangent).abs(),
                    DVec2::new(normal.dot(frame.x), normal.dot(frame.y)),
                )
            }
        };
        let wood = WoodPoint {
            address: StemAddress {
                rho: ring,
                angle,
                across: grain.truncate() - stem.rings.pith(),
                along: grain.z,
            },
            end_grain,
            facing,
        };
        let shown = OrientedSurface {
            surface: (self.wood).surface_at(&*self.rings, &wood, point.footprint),
            directions,
        };
        (shown, end_grain)
    }

    /// Returns wood that was sawn: across the grain the saw left its marks, along it the wood is planed.
    fn sawn_at(&self, stem: &Stem, grain: DVec3, point: &SurfacePoint) -> OrientedSurface {
        let (shown, end_grain) = self.wood_and_cut(stem, grain, point);
        match end_grain > SAWN_COSINE {
            true => self.with_saw_marks(shown, (stem, grain), point.footprint),
            false => OrientedSurface {
                surface: planed(shown.surface),
                ..shown
            },
        }
    }

    /// Adds the marks of the saw at a point of an end.
    fn with_saw_marks(
        &self,
        mut shown: OrientedSurface,
        (stem, grain): (&Stem, DVec3),
        footprint: f64,
    ) -> OrientedSurface {
        // The two ends of a stem were not cut by one stroke.
        let end = u64::from(grain.z > stem.location);
        let mark = saw_mark(self.wood.seed ^ end << 8, grain.truncate(), footprint);
        let surface = &mut shown.surface;
        surface.color = surface.color.map(|c| (c * mark.brightness).min(1.0));
        surface.height += mark.height;
        surface.slope += mark.slope.extend(0.0);
        shown
    }

    /// Returns the skin at a point: bark, or the wood inside on sawn wood, on the ends of a stem and in its bore; weathered
    /// wood on a pole.
    pub fn skin_at(&self, stem: &Stem, point: &SurfacePoint) -> OrientedSurface {
        match point.grain {
            Some(grain) if is_sawn(stem, grain, point) => self.sawn_at(stem, grain, point),
            Some(grain) if !stem.kind.has_bark() => {
                let mut shown = self.wood_at(stem, grain, point);
                shown.surface.color = weathered(shown.surface.color);
                shown
            }
            _ => self.bark_at(stem, point),
        }
    }

    fn bark_at(&self, stem: &Stem, point: &SurfacePoint) -> OrientedSurface {
        let (bark, directions) = match point.grain {
            Some(grain) => {
                let across: DVec2 = grain.truncate() - stem.rings.pith();
                let bark = BarkPoint {
                    angle: libm::atan2(across.y, across.x),
                    along: grain.z,
                    radius: across.length(),
                };
                let directions = point.grain_gradients.unwrap_or_else(|| {
                    let frame = stem.grain.axis().frame(grain.z);
                    [frame.x, frame.y, frame.tangent]
                });
                (bark, directions)
            }
            None => {
                // Off the limb the axes of the world are as good as any.
                let bark = BarkPoint {
                    angle: libm::atan2(point.normal.z, point.normal.x),
                    along: point.position.y,
                    radius: stem.radius,
                };
                (bark, [DVec3::X, DVec3::Z, DVec3::Y])
            }
        };
        OrientedSurface {
            surface: self.bark.surface_at(&bark, point.footprint),
            directions,
        }
    }
}

/// Returns wood as it is on a fresh tear: lighter and less saturated than planed, because loose fibres scatter the light, and matt.
pub fn torn(surface: WoodSurface) -> WoodSurface {
    let light = luminance(surface.color);
    let paler = |c: f64| (c + TORN_PALENESS * (light - c)) * TORN_LIGHT;
    WoodSurface {
        color: surface.color.map(|c| paler(c).min(1.0)),
        roughness: surface.roughness.max(TORN_ROUGHNESS),
        ..surface
    }
}

/// Returns wood as it is on a fresh tear that lies across the grain by |normal · grain|: fibres that broke at many heights
/// stand there as a pale brush, whose sides shine, where a saw leaves open cells.
pub fn torn_across(surface: WoodSurface, end_grain: f64) -> WoodSurface {
    let end = end_grain.clamp(0.0, 1.0);
    let light = luminance(surface.color);
    let paler = |c: f64| (c + BRUSH_PALENESS * end * (light - c)) * (1.0 + BRUSH_LIGHT * end);
    torn(WoodSurface {
        color: surface.color.map(paler),
        ..surface
    })
}

/// Returns wood as a plane leaves it, which takes off most of the relief.
pub fn planed(surface: WoodSurface) -> WoodSurface {
    WoodSurface {
        height: surface.height * PLANED_RELIEF,
        slope: surface.slope * PLANED_RELIEF,
        ..surface
    }
}

/// Rec. 709.
fn luminance([r, g, b]: [f64; 3]) -> f64 {
    0.2126 * r + 0.7152 * g + 0.0722 * b
}

/// Returns whether the skin at a point is sawn wood.
fn is_sawn(stem: &Stem, grain: DVec3, point: &SurfacePoint) -> bool {
    let end = || match point.grain_gradients {
        // Along a face that lies across the grain the length along the grain does not change, wherever it has moved.
        Some([_, _, rise]) => rise.length_squared() < 1.0 - SAWN_COSINE * SAWN_COSINE,
        None => {
            let along = stem.grain.axis().frame(grain.z).tangent;
            !point.moved && point.geometric_normal.dot(along).abs() > SAWN_COSINE
        }
    };
    stem.kind.is_sawn() || end() || in_bore(stem, grain, point)
}

/// Returns whether the skin at a point is that of a bore.
fn in_bore(stem: &Stem, grain: DVec3, point: &SurfacePoint) -> bool {
    let outward = point.geometric_normal;
    let normal = match point.grain_gradients {
        // The gradients lie in the surface: they map two directions along it.
        Some(gradients) => {
            let (first, second) = outward.any_orthonormal_pair();
            let mapped = [first, second]
                .map(|along| DVec3::from_array(gradients.map(|gradient| gradient.dot(along))));
            mapped[0].cross(mapped[1])
        }
        None if point.moved => return false,
        None => {
            let frame = stem.grain.axis().frame(grain.z);
            DVec3::from_array([frame.x, frame.y, frame.tangent].map(|d| d.dot(outward)))
        }
    };
    faces_pith(stem, grain, normal)
}

/// Returns whether a face of the skin at a point of the grain lies deep in a stem and faces the pith, as in the bore of a tube;
/// `normal` is in the directions of the grain, of any length.
pub fn faces_pith(stem: &Stem, grain: DVec3, normal: DVec3) -> bool {
    let across = grain.truncate() - stem.rings.pith();
    // Beyond a fork the crotches of limbs face the axis too.
    let ((low, high), ends) = (stem.usable, stem.ends);
    let is_on_stem = (ends.0 || grain.z >= low) && (ends.1 || grain.z <= high);
    is_on_stem
        && across.length() < BORE_RADII * stem.radius
        && across.dot(normal.truncate()) < BORE_COSINE * across.length() * normal.length()
}

/// Returns the colour of wood that has weathered for years: light and rain take what is not cellulose, and leave it silver grey,
/// with the figure of the wood (Hoadley, *Understanding Wood*, on weathering).
pub fn weathered(color: [f64; 3]) -> [f64; 3] {
    let light = luminance(color);
    WEATHERED_TINT.map(|tint| (WEATHERED_LIGHT * light * tint).min(1.0))
}
