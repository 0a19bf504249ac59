//! The mesh that is cut, as pieces are made of it.

use glam::DVec3;
use greenstick_geometry::{Mesh, Unions};
use greenstick_wood::stem::LayeredGrain;
use std::collections::{BTreeMap, BTreeSet};

/// The mesh that was cut.
#[derive(Clone, Copy)]
pub struct Source<'a> {
    /// The mesh, in its node's coordinates.
    pub mesh: &'a Mesh,
    /// Point number of each vertex.
    pub points: &'a [u32],
    /// A vertex of each point.
    pub vertices: &'a [u32],
    /// Grain coordinates of each point, NaN off the limb.
    pub grain: &'a [DVec3],
    /// Grain coordinates to the node's.
    pub chart: &'a LayeredGrain,
    /// Triangles of the mesh that pieces have whole again where the break does not meet them; `None` where they keep the parts.
    pub splits: Option<&'a SplitTriangles>,
}

/// Triangles of a mesh that were split, and their parts, which stand in place of each and behind all that there were.
#[derive(Debug, Clone, Default)]
pub struct SplitTriangles {
    /// Number of triangles before.
    triangles: usize,
    /// Number of vertices before.
    vertices: usize,
    /// The corners that split triangles had.
    whole: BTreeMap<u32, [u32; 3]>,
    /// For each triangle that was added the one that it is a part of.
    origins: Vec<u32>,
}

impl SplitTriangles {
    /// Returns the splits of a mesh before any.
    pub(crate) fn of_unsplit(mesh: &Mesh) -> Self {
        SplitTriangles {
            triangles: mesh.triangles.len(),
            vertices: mesh.positions.len(),
            ..SplitTriangles::default()
        }
    }

    /// Returns these splits of a mesh whose triangles had been split before.
    pub(crate) fn after(self, before: &SplitTriangles) -> Self {
        let mut whole = before.whole.clone();
        for (&triangle, &corners) in &self.whole {
            if (triangle as usize) < before.triangles {
                whole.entry(triangle).or_insert(corners);
            }
        }
        let further = self.origins.iter().map(|&t| before.origin(t));
        SplitTriangles {
            whole,
            origins: before.origins.iter().copied().chain(further).collect(),
            triangles: before.triangles,
            vertices: before.vertices,
        }
    }

    /// Takes down the corners of a triangle that is about to be split.
    pub(crate) fn note(&mut self, triangle: u32, corners: [u32; 3]) {
        if (triangle as usize) < self.triangles {
            self.whole.entry(triangle).or_insert(corners);
        }
    }

    /// Takes down that the next triangle that is added is a part of this one, itself a part or not.
    pub(crate) fn add(&mut self, triangle: u32) {
        self.origins.push(self.origin(triangle));
    }

    fn origin(&self, triangle: u32) -> u32 {
        let added = (triangle as usize).checked_sub(self.triangles);
        added.map_or(triangle, |i| self.origins[i])
    }

    /// Returns which triangles of `mesh` stand for a whole one again, by its corners: of each that is split the first part has
    /// the corners of all, the others have none. Those that share an edge that was split are put together only if all of them
    /// `may` be, so that edges fit.
    pub(crate) fn put_together(
        &self,
        mesh: &Mesh,
        may: impl Fn(u32) -> bool,
    ) -> BTreeMap<u32, Option<[u32; 3]>> {
        let parts = || {
            let first = self.whole.keys().copied();
            first.chain((self.triangles..self.triangles + self.origins.len()).map(|t| t as u32))
        };
        let (points, count) = mesh.points();
        let mut joined = Unions::new(self.triangles);
        let mut at_point = vec![u32::MAX; count];
        for part in parts() {
            let origin = self.origin(part);
            let corners = mesh.triangles[part as usize].iter();
            for &v in corners.filter(|&&v| v as usize >= self.vertices) {
                let known = &mut at_point[points[v as usize] as usize];
                if *known == u32::MAX {
                    *known = origin;
                } else {
                    joined.join(*known, origin);
                }
            }
        }
        let stays: BTreeSet<u32> = parts()
            .filter(|&part| !may(part))
            .map(|part| joined.root(self.origin(part)))
            .collect();
        let mut together = BTreeMap::new();
        for part in parts() {
            let origin = self.origin(part);
            if !stays.contains(&joined.root(origin)) {
                let whole = self.whole.get(&origin).filter(|_| part == origin);
                together.insert(part, whole.copied());
            }
        }
        together
    }
}
