//! What of a stem a texture of its inner wood covers, and the texture coordinates of its points.

use glam::{DVec2, DVec3};
use greenstick_wood::stem::{GrainSpace, Stem};

/// The square of a section that a texture covers, and the side grain beside it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SectionSquare {
    /// Its middle, grain (x, y), m.
    pub middle: DVec2,
    /// Its side, m.
    pub side: f64,
    /// Width and thickness of what the section holds, m.
    pub size: DVec2,
    /// Ring coordinates between which the side grain lies.
    pub rho: (f64, f64),
    /// Width of a ring coordinate of 1 in the side grain, m.
    pub radius: f64,
}

/// How fast side grain drifts across the texture along a ring, per rad, so that tangential faces are not one flat colour.
const RING_DRIFT: f64 = 0.25;
/// How far it drifts at most, as a part of the ring coordinate: farther, and wood under the bark would show bark.
const MAX_DRIFT: f64 = 0.025;
/// Ring coordinate up to which the side grain is baked: that of the outside, with what drifts beyond it.
const OUTER_RHO: f64 = 1.05;

impl SectionSquare {
    /// Metres along the grain for each metre of v.
    pub const STRETCH: f64 = 2.0;

    /// The square of this side about a round section.
    pub const fn round(middle: DVec2, side: f64) -> Self {
        SectionSquare {
            middle,
            side,
            size: DVec2::new(side, side),
            rho: (0.0, OUTER_RHO),
            radius: 0.5 * side,
        }
    }

    /// The same with side grain from the ring coordinate `least` on, whose rings have the mean radius `radius` at 1.
    #[must_use]
    pub fn with_rings(self, least: f64, radius: f64) -> Self {
        SectionSquare {
            rho: (least.clamp(0.0, 0.99), OUTER_RHO),
            radius,
            ..self
        }
    }

    /// Width of all that the texture covers, m.
    pub fn extent(&self) -> f64 {
        self.side + self.radius * (self.rho.1 - self.rho.0)
    }

    /// Length along the grain after which the side grain repeats, m.
    pub fn period(&self) -> f64 {
        Self::STRETCH * self.side
    }

    /// By what texture coordinates are multiplied to get from metres to parts of the image.
    pub fn scale(&self) -> [f32; 2] {
        [(1.0 / self.extent()) as f32, (1.0 / self.side) as f32]
    }

    /// Length of the perimeter of what the section holds, m.
    pub fn perimeter(&self) -> f64 {
        2.0 * (self.size.x + self.size.y)
    }

    /// The point on the perimeter at `u` m, and the direction in which u rises: the sides towards −y, +y, −x and +x, one
    /// after the other, each along its rising coordinate.
    pub(super) fn on_perimeter(&self, u: f64) -> (DVec2, DVec2) {
        let (
            low,
            DVec2 {
                x: width,
                y: height,
            },
        ) = (self.middle - 0.5 * self.size, self.size);
        let (x, y) = (DVec2::X, DVec2::Y);
        match u {
            u if u < width => (low + x * u, x),
            u if u < 2.0 * width => (low + x * (u - width) + y * height, x),
            u if u < 2.0 * width + height => (low + y * (u - 2.0 * width), y),
            u => (low + x * width + y * (u - 2.0 * width - height), y),
        }
    }

    /// Returns how far along the perimeter, as [`SectionSquare::on_perimeter`] counts it (m), a place of the section lies on a face
    /// with this outward normal.
    fn along_perimeter(&self, place: DVec2, normal: DVec2) -> f64 {
        let p = place - (self.middle - 0.5 * self.size);
        let DVec2 {
            x: width,
            y: height,
        } = self.size;
        match normal {
            n if n.y.abs() >= n.x.abs() && n.y < 0.0 => p.x.clamp(0.0, width),
            n if n.y.abs() >= n.x.abs() => width + p.x.clamp(0.0, width),
            n if n.x < 0.0 => 2.0 * width + p.y.clamp(0.0, height),
            _ => 2.0 * width + height + p.y.clamp(0.0, height),
        }
    }

    /// Texture coordinates (m) of end grain at a point of the section.
    pub fn end_grain(&self, across: DVec2) -> DVec2 {
        across - self.middle + 0.5 * self.side
    }

    /// Texture coordinates (m) of side grain at ring coordinate `rho` and length `s` (m), at an angle of `turned` (rad) from
    /// the middle of its face.
    pub fn side_grain(&self, rho: f64, turned: f64, s: f64) -> DVec2 {
        let drift = (RING_DRIFT * turned).clamp(-MAX_DRIFT, MAX_DRIFT);
        let across = (rho * (1.0 + drift) - self.rho.0).max(0.0);
        DVec2::new(self.side + self.radius * across, s / Self::STRETCH)
    }
}

/// The planed faces of sawn wood, side by side on a texture whose rows lie along the grain.
#[derive(Debug, Clone, Copy)]
pub struct PlanedFaces<'a> {
    /// What the section holds.
    pub square: SectionSquare,
    /// Length along the stem that the texture covers, and after which it repeats, m.
    pub length: f64,
    grain: Option<&'a GrainSpace>,
}

impl<'a> PlanedFaces<'a> {
    /// Faces that look the same all along: the texture covers as much of the length as of the perimeter.
    pub fn straight_grained(square: SectionSquare) -> Self {
        PlanedFaces {
            square,
            length: square.perimeter(),
            grain: None,
        }
    }

    /// Faces of a stem. Where its grain slopes, they differ all along, and the texture covers the whole stem.
    pub fn of_stem(stem: &'a Stem, square: SectionSquare) -> Self {
        let straight = PlanedFaces::straight_grained(square);
        if !stem.grain.is_sloped() {
            return straight;
        }
        PlanedFaces {
            length: stem.length,
            grain: Some(&stem.grain),
            ..straight
        }
    }

    /// Returns the coordinates, in parts of the texture, of a point of grain space (m) on a face with this outward normal.
    pub fn coordinates(&self, grain: DVec3, normal: DVec2) -> DVec2 {
        let across = grain.truncate();
        let place = self.grain.map_or(across, |g| g.to_section(across, grain.z));
        let along = self.square.along_perimeter(place, normal);
        DVec2::new(along / self.square.perimeter(), grain.z / self.length)
    }

    /// Returns the place in grain space (x, y) of a place in the section at length `s` (m) that the texture shows.
    pub(super) fn fibre_at(&self, place: DVec2, s: f64) -> DVec2 {
        self.grain.map_or(place, |g| g.from_section(place, s))
    }
}
