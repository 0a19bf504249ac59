//! The broken face of a piece, as fuzz sees it: triangles with the directions of the grain.

use glam::{DMat3, DVec2, DVec3, Vec3};
use greenstick_geometry::Mesh;

/// Least square of the slope of the length along a face that is side grain.
pub(super) const SIDE_GRAIN: f64 = 0.6;

/// The values at the corners of a triangle, and the directions of the grain there.
pub(super) struct Frame {
    pub corners: [DVec3; 3],
    /// Grain coordinates of the corners, m.
    pub grain: [DVec3; 3],
    /// Unit directions in the piece: beside the grain in the face, out of the face, along the grain.
    pub directions: [DVec3; 3],
    /// The first two in the section.
    pub across: [DVec2; 2],
    /// How far the face leans: the way in the section, m, of a unit of the piece's coordinates along the last direction.
    pub lean: DVec2,
    /// Square of the slope of the length along the triangle: 1 where it lies along the grain.
    pub steepness: f64,
    /// Whether the triangle lies across the grain, and the last direction points to its free side.
    pub is_end: bool,
    /// Tissue.
    pub zone: usize,
    /// Sector.
    pub sector: f32,
}

/// A piece with the attributes of a broken face.
pub(super) struct TornFace<'a> {
    piece: &'a Mesh,
    grain: &'a [[f32; 3]],
    zones: &'a [f32],
    sectors: &'a [f32],
}

impl<'a> TornFace<'a> {
    /// The face of a piece; none where it lacks one of these attributes.
    pub fn of(piece: &'a Mesh) -> Option<Self> {
        let values = |name: &str, width: usize| {
            let attribute = piece.attributes.get(name).filter(|a| a.width == width);
            attribute.map(|a| a.data.as_slice())
        };
        Some(TornFace {
            piece,
            grain: values("_GRAIN", 3)?.as_chunks().0,
            zones: values("_ZONE", 1)?,
            sectors: values("_SECTOR", 1)?,
        })
    }

    /// Grain coordinates of the corners of a triangle, m.
    pub fn grain(&self, t: usize) -> [DVec3; 3] {
        let at = |v: u32| Vec3::from_array(self.grain[v as usize]).as_dvec3();
        self.piece.triangles[t].map(at)
    }

    /// Tissue of a triangle.
    pub fn zone(&self, t: usize) -> usize {
        self.zone_of(self.piece.triangles[t][0])
    }

    /// Tissue of a vertex.
    pub fn zone_of(&self, vertex: u32) -> usize {
        self.zones[vertex as usize] as usize
    }

    /// The frame of a triangle; none where it has no area.
    pub fn frame(&self, t: usize) -> Option<Frame> {
        let (corners, grain) = (self.piece.corners(t), self.grain(t));
        let (e, f) = (corners[1] - corners[0], corners[2] - corners[0]);
        let normal = e.cross(f);
        let square = normal.length_squared();
        let (ge, gf) = (grain[1] - grain[0], grain[2] - grain[0]);
        let across = ge.cross(gf).truncate();
        let (rise, steepness) = slope([e, f], [ge, gf])?;
        let [of_e, of_f] = dual_basis([e, f]);
        let out = across.normalize();
        let along = rise.normalize_or_zero();
        let lean = ge * along.dot(of_e) + gf * along.dot(of_f);
        let normal = normal / square.sqrt();
        Some(Frame {
            corners,
            grain,
            directions: [normal.cross(along), normal, along],
            across: [-out.perp(), out],
            lean: lean.truncate(),
            steepness,
            is_end: false,
            zone: self.zone(t),
            sector: self.sectors[self.piece.triangles[t][0] as usize],
        })
    }
}

impl TornFace<'_> {
    /// The frame of a triangle across the grain: what stands on it points `forward` along the grain (1 or −1) and leans to a side of
    /// the section; none where it has no area.
    pub fn end_frame(&self, t: usize, side: DVec2, forward: f64) -> Option<Frame> {
        let (corners, grain) = (self.piece.corners(t), self.grain(t));
        let edges = |c: [DVec3; 3]| {
            let (e, f) = (c[1] - c[0], c[2] - c[0]);
            let normal = e.cross(f);
            let out = normal.try_normalize()? * normal.length().sqrt();
            Some(DMat3::from_cols(e, f, out))
        };
        // Pieces are as large in grain space, but for a factor.
        let to_piece = edges(corners)? * edges(grain)?.inverse();
        let along = (to_piece * DVec3::new(0.0, 0.0, forward)).try_normalize()?;
        let out = to_piece * side.extend(0.0);
        let out = (out - along * out.dot(along)).try_normalize()?;
        Some(Frame {
            corners,
            grain,
            directions: [along.cross(out), out, along],
            across: [side.perp() * forward, side],
            lean: DVec2::ZERO,
            steepness: 0.0,
            is_end: true,
            zone: self.zone(t),
            sector: self.sectors[self.piece.triangles[t][0] as usize],
        })
    }
}

/// Returns the dual basis of two edges of a triangle in its plane: the products with it of a way along the triangle are the parts of both
/// edges that make it up.
pub(super) fn dual_basis([e, f]: [DVec3; 2]) -> [DVec3; 2] {
    let normal = e.cross(f);
    let square = normal.length_squared();
    [f.cross(normal) / square, normal.cross(e) / square]
}

/// Returns the gradient of the length in the piece, and the square of its slope along the face, by two edges of a triangle and the
/// same edges in grain coordinates; none where it has no area.
pub(super) fn slope([e, f]: [DVec3; 2], [ge, gf]: [DVec3; 2]) -> Option<(DVec3, f64)> {
    let normal = e.cross(f);
    let square = normal.length_squared();
    if square <= 0.0 || ge.cross(gf).truncate() == DVec2::ZERO {
        return None;
    }
    let [of_e, of_f] = dual_basis([e, f]);
    let rise = of_e * ge.z + of_f * gf.z;
    let scale = |grain: DVec3, edge: DVec3| grain.length_squared() / edge.length_squared();
    Some((rise, rise.length_squared() / scale(ge, e).max(scale(gf, f))))
}
