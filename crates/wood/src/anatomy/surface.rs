//! The surface reconstructed from particles (Forests 2023, Fig. 12): a ring's particles in all layers joined to a side, and
//! the particles of all rings within it, in the first and the last layer, to two ends.

use super::particles::Particle;
use super::sectors::SectorLayout;
use glam::DVec3;
use greenstick_geometry::Mesh;
use greenstick_geometry::mesh::Attribute;
use std::f64::consts::{PI, TAU};

/// What the colours of a surface distinguish.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum SurfaceColouring {
    /// Annual rings (Fig. 12a).
    #[default]
    Ring,
    /// Sectors (Fig. 12b).
    Sector,
}

/// The closed surface over the particles of `ring` (1 to the layout's number). `layers` are those of a round stem, each
/// with its particles by ring and sector; inner rings may lack some. `piths` are the pith in the first and the last layer,
/// m. `None` where there are fewer than two layers or three sectors, or `ring` is not whole in a layer.
pub(super) fn reconstruct_surface(
    layers: &[&[Particle]],
    layout: &SectorLayout,
    ring: u16,
    piths: [DVec3; 2],
    colouring: SurfaceColouring,
) -> Option<Mesh> {
    let outer = usize::from(ring).checked_sub(1)?;
    let sectors = *layout.sectors.get(outer)? as usize;
    let is_whole = |layer: &&[Particle]| particles_of_ring(layer, outer).len() == sectors;
    let ([first, .., last], true) = (layers, sectors >= 3 && layers.iter().all(is_whole)) else {
        return None;
    };
    let mut builder = SurfaceBuilder {
        mesh: Mesh::default(),
        data: Vec::new(),
        colouring,
    };
    let rows: Vec<Vec<u32>> = layers
        .iter()
        .map(|layer| builder.vertices(particles_of_ring(layer, outer)))
        .collect();
    for pair in rows.windows(2) {
        for j in 0..sectors {
            let next = (j + 1) % sectors;
            let (a, b, c, d) = (pair[0][j], pair[0][next], pair[1][next], pair[1][j]);
            builder.mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    builder.end(first, outer, &rows[0], piths[0], Facing::Base);
    builder.end(last, outer, &rows[rows.len() - 1], piths[1], Facing::Top);
    Some(builder.finish())
}

/// The particles of a ring, counted from 0, in a layer.
fn particles_of_ring(layer: &[Particle], ring: usize) -> &[Particle] {
    let start = layer.partition_point(|p| usize::from(p.ring) <= ring);
    let end = layer.partition_point(|p| usize::from(p.ring) <= ring + 1);
    &layer[start..end]
}

/// Angles (rad) of the particles of a ring, rising from about 0.
fn angles(particles: &[Particle]) -> Vec<f64> {
    let mut angles: Vec<f64> = particles.iter().map(|p| p.angle).collect();
    // The first may lie a little before angle 0.
    if let Some(first) = angles.first_mut().filter(|a| **a > PI) {
        *first -= TAU;
    }
    angles
}

/// Which way an end of the surface faces.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Facing {
    Base,
    Top,
}

/// A closed line of vertices about the pith, with their rising angles (rad).
struct ClosedLine {
    vertices: Vec<u32>,
    angles: Vec<f64>,
}

impl ClosedLine {
    /// The angle of point `i`, which may go round more than once.
    fn angle(&self, i: usize) -> f64 {
        let count = self.vertices.len();
        self.angles[i % count] + TAU * (i / count) as f64
    }
}

struct SurfaceBuilder {
    mesh: Mesh,
    /// Ring, sector, layer of each vertex.
    data: Vec<[f32; 3]>,
    colouring: SurfaceColouring,
}

impl SurfaceBuilder {
    fn vertex(&mut self, p: &Particle) -> u32 {
        self.mesh.positions.push(p.position);
        self.data
            .push([p.ring.into(), p.sector as f32, p.layer as f32]);
        self.mesh.positions.len() as u32 - 1
    }

    fn vertices(&mut self, particles: &[Particle]) -> Vec<u32> {
        particles.iter().map(|p| self.vertex(p)).collect()
    }

    /// Covers an end, from the vertices of its outermost ring (counted from 0) to the pith.
    fn end(
        &mut self,
        layer: &[Particle],
        outermost: usize,
        vertices: &[u32],
        pith: DVec3,
        facing: Facing,
    ) {
        let mut outer = ClosedLine {
            vertices: vertices.to_vec(),
            angles: angles(particles_of_ring(layer, outermost)),
        };
        for ring in (0..outermost).rev() {
            let particles = particles_of_ring(layer, ring);
            // A ring of one or two bundles is no ring: the pith stands for it.
            if particles.len() <= 2 {
                break;
            }
            let inner = ClosedLine {
                vertices: self.vertices(particles),
                angles: angles(particles),
            };
            self.stitch(&outer, &inner, facing);
            outer = inner;
        }
        let pith = self.vertex(&Particle {
            position: pith,
            ..layer[0]
        });
        let centre = ClosedLine {
            vertices: vec![pith],
            angles: vec![0.0],
        };
        self.stitch(&outer, &centre, facing);
    }

    /// Makes triangles between two closed lines. An inner line of one point is the pith.
    fn stitch(&mut self, outer: &ClosedLine, inner: &ClosedLine, facing: Facing) {
        let n = outer.vertices.len();
        let m = match inner.vertices.len() {
            1 => 0,
            count => count,
        };
        let (mut i, mut j) = (0, 0);
        while i < n || j < m {
            let (a, b) = (
                outer.vertices[i % n],
                inner.vertices[j % inner.vertices.len()],
            );
            let outward = j >= m || (i < n && outer.angle(i + 1) <= inner.angle(j + 1));
            let mut triangle = if outward {
                i += 1;
                [a, outer.vertices[i % n], b]
            } else {
                j += 1;
                [a, inner.vertices[j % m], b]
            };
            // Seen from the base the sectors go round the other way.
            if facing == Facing::Base {
                triangle.swap(1, 2);
            }
            self.mesh.triangles.push(triangle);
        }
    }

    fn finish(mut self) -> Mesh {
        let by = usize::from(self.colouring == SurfaceColouring::Sector);
        let colours = self.data.iter().flat_map(|d| distinct_colour(d[by] as u32));
        let colour = Attribute {
            width: 3,
            data: colours.collect(),
        };
        self.mesh.attributes.insert("COLOR_0".into(), colour);
        for (k, name) in ["_RING", "_SECTOR", "_LAYER"].into_iter().enumerate() {
            let data = self.data.iter().map(|d| d[k]).collect();
            self.mesh
                .attributes
                .insert(name.into(), Attribute { width: 1, data });
        }
        self.mesh
    }
}

/// A linear colour for a number, unlike those of the numbers next to it: hues at the golden angle.
fn distinct_colour(number: u32) -> [f32; 3] {
    let hue = (f64::from(number) * 0.618_033_988_749_895).fract() * 6.0;
    [5.0, 3.0, 1.0].map(|shift: f64| {
        let k = (shift + hue) % 6.0;
        let v = 0.9 * (1.0 - 0.8 * k.min(4.0 - k).clamp(0.0, 1.0));
        libm::pow(v, 2.2) as f32
    })
}
