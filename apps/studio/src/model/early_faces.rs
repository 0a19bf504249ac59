//! The broken faces of both pieces, as they are drawn before the pieces are finished.

use super::meshes::{Vertex, normal_map};
use glam::{DAffine3, DMat3, DVec3, Mat3, Vec3};
use greenstick::session::BreakStages;
use greenstick::skin::broken::FaceAddress;
use rayon::iter::{
    IndexedParallelIterator, IntoParallelIterator, IntoParallelRefMutIterator, ParallelExtend,
    ParallelIterator,
};

/// A piece as it stands in the scene.
#[derive(Debug, Clone, Copy)]
pub(super) struct Standing {
    pub number: f32,
    pub transform: DAffine3,
}

/// From the coordinates of the mesh that is cut to a piece's place in the scene.
#[derive(Debug, Clone, Copy)]
pub(super) struct Moved {
    transform: DAffine3,
    normals: Mat3,
    /// Whether nothing is turned or scaled.
    is_shift: bool,
    number: f32,
}

impl Moved {
    pub fn new(piece: Standing, middle: DVec3) -> Self {
        let mut transform = piece.transform;
        transform.translation -= middle;
        Moved {
            transform,
            normals: normal_map(&transform).as_mat3(),
            is_shift: transform.matrix3 == DMat3::IDENTITY,
            number: piece.number,
        }
    }

    /// Moves a vertex at `position`.
    #[inline]
    pub fn place(&self, position: DVec3, mut vertex: Vertex) -> Vertex {
        let world = if self.is_shift {
            position + self.transform.translation
        } else {
            let normal = self.normals * Vec3::from_array(vertex.normal);
            vertex.normal = normal.normalize_or_zero().to_array();
            self.transform.transform_point3(position)
        };
        vertex.position = world.as_vec3().to_array();
        vertex.zone_piece[1] = self.number;
        vertex
    }
}

/// The broken faces of both pieces.
pub(super) struct Faces<'a> {
    pub stages: &'a BreakStages,
    /// Where the pieces stand, the lower one first.
    pub moved: [Moved; 2],
    /// The number of the first vertex.
    pub first: u32,
}

impl Faces<'_> {
    /// Adds the vertices, those of the lower piece first.
    pub fn add_vertices(&self, addresses: &[FaceAddress], vertices: &mut Vec<Vertex>) {
        let cut = &self.stages.cut.face;
        let (face, points) = (&cut.face, cut.cut.points);
        let count = face.ids.len();
        vertices.par_extend((0..2 * count).into_par_iter().map(|n| {
            let (upper, i) = (n >= count, n % count);
            let sign = if upper { -1.0 } else { 1.0 };
            let position = face.places[face.ids[i] as usize - points];
            let mut vertex = Vertex {
                position: [0.0; 3],
                normal: face.normals[i].map(|n| sign * n),
                uv: face.coordinates[i],
                grain: [0.0; 4],
                zone_piece: [f32::from(addresses[i].zone.code()), 0.0],
            };
            vertex.set_grain(Vec3::from_array(addresses[i].grain));
            self.moved[usize::from(upper)].place(position, vertex)
        }));
    }

    /// Adds the corners of the triangles, those of the lower piece first.
    pub fn add_corners(&self, corners: &mut Vec<u32>) {
        let face = &self.stages.cut.face.face;
        for (half, moved) in self.moved.iter().enumerate() {
            let first = self.first + (half * face.ids.len()) as u32;
            let mirrored = moved.transform.matrix3.determinant() < 0.0;
            let turned = (half == 1) != mirrored;
            let start = corners.len();
            corners.resize(start + 3 * face.triangles.len(), 0);
            let made = corners[start..].as_chunks_mut::<3>().0.par_iter_mut();
            made.zip(&face.triangles).for_each(|(corners, t)| {
                let [a, b, c] = t.map(|v| v + first);
                *corners = if turned { [a, c, b] } else { [a, b, c] };
            });
        }
    }
}
