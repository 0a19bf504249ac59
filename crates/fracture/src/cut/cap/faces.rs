//! Triangles of the broken face, as they are filled.

use super::super::parts::CapFace;

/// Triangles of a broken face.
#[derive(Default)]
pub(in super::super) struct Faces {
    pub triangles: Vec<[u32; 3]>,
    /// What each triangle belongs to.
    pub faces: Vec<CapFace>,
    /// First triangle of every wall.
    pub walls: Vec<u32>,
}

impl Faces {
    pub fn with_capacity(count: usize) -> Self {
        Faces {
            triangles: Vec::with_capacity(count),
            faces: Vec::with_capacity(count),
            walls: Vec::new(),
        }
    }

    pub fn push(&mut self, triangle: [u32; 3], face: CapFace) {
        self.triangles.push(triangle);
        self.faces.push(face);
    }

    pub fn append(&mut self, others: &[Faces]) {
        let count = others.iter().map(|o| o.triangles.len()).sum();
        self.triangles.reserve_exact(count);
        self.faces.reserve_exact(count);
        for other in others {
            let first = self.triangles.len() as u32;
            self.triangles.extend_from_slice(&other.triangles);
            self.faces.extend_from_slice(&other.faces);
            self.walls
                .extend(other.walls.iter().map(|wall| first + wall));
        }
    }
}
