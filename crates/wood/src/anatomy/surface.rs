//! The surface rebuilt from particles (forests-2023 Fig. 12): a ring's particles in all layers joined to a side, and the
//! particles of all rings within it, in the first and the last layer, to two ends.

use super::particles::{Layout, Particle};
use glam::DVec3;
use greenstick_geometry::Mesh;
use greenstick_geometry::mesh::Attribute;
use std::f64::consts::{PI, TAU};

/// What colours tell apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum SurfaceColours {
    /// Annual rings (Fig. 12a).
    #[default]
    Ring,
    /// Sectors (Fig. 12b).
    Sector,
}

/// The closed surface over the particles of `ring` (1 to the layout's number). `layers` are those of a round stem, each
/// with its particles in the order of [`super::field_particles`]; inner rings may lack some. `piths` are the pith in the
/// first and the last layer, m. `None` where there are fewer than two layers or three sectors, or `ring` is not whole in a
/// layer.
pub fn rebuilt_surface(
    layers: &[&[Particle]],
    layout: &Layout,
    ring: u16,
    piths: [DVec3; 2],
    colours: SurfaceColours,
) -> Option<Mesh> {
    let rings = usize::from(ring);
    let around = *layout.sectors.get(rings.checked_sub(1)?)?;
    let count = layers.len();
    let of_ring = |layer: usize, k: usize| {
        let all = layers[layer];
        let start = all.partition_point(|p| usize::from(p.ring) <= k);
        let end = all.partition_point(|p| usize::from(p.ring) <= k + 1);
        &all[start..end]
    };
    let whole = |layer: usize| of_ring(layer, rings - 1).len() == around as usize;
    if count < 2 || around < 3 || !(0..count).all(whole) {
        return None;
    }
    let mut made = Builder {
        mesh: Mesh::default(),
        data: Vec::new(),
        colours,
    };
    let mut rows: Vec<Vec<u32>> = Vec::with_capacity(count);
    for layer in 0..count {
        rows.push(
            of_ring(layer, rings - 1)
                .iter()
                .map(|p| made.vertex(p))
                .collect(),
        );
    }
    for pair in rows.windows(2) {
        for j in 0..around as usize {
            let next = (j + 1) % around as usize;
            let (a, b, c, d) = (pair[0][j], pair[0][next], pair[1][next], pair[1][j]);
            made.mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    for (end, layer) in [0, count - 1].into_iter().enumerate() {
        // Seen from the base the sectors go round the other way.
        let flip = end == 0;
        let mut outer = rows[layer].clone();
        let angles = |k: usize| {
            let mut angles: Vec<f64> = of_ring(layer, k).iter().map(|p| p.angle).collect();
            // The first may lie a little before angle 0.
            if let Some(first) = angles.first_mut().filter(|a| **a > PI) {
                *first -= TAU;
            }
            angles
        };
        for k in (0..rings).rev() {
            // A ring of one or two bundles is no ring: the pith stands for it.
            let Some(within) = k.checked_sub(1).filter(|&w| of_ring(layer, w).len() > 2) else {
                let pith = made.pith(&layers[layer][0], piths[end]);
                made.stitch((&outer, &angles(k)), (&[pith], &[0.0]), flip);
                break;
            };
            let inner: Vec<u32> = of_ring(layer, within)
                .iter()
                .map(|p| made.vertex(p))
                .collect();
            made.stitch((&outer, &angles(k)), (&inner, &angles(within)), flip);
            outer = inner;
        }
    }
    Some(made.finish())
}

struct Builder {
    mesh: Mesh,
    /// Ring, sector, layer of each vertex.
    data: Vec<[f32; 3]>,
    colours: SurfaceColours,
}

impl Builder {
    fn vertex(&mut self, p: &Particle) -> u32 {
        self.mesh.positions.push(p.position);
        self.data
            .push([p.ring.into(), p.sector as f32, p.layer as f32]);
        self.mesh.positions.len() as u32 - 1
    }

    fn pith(&mut self, nearest: &Particle, at: DVec3) -> u32 {
        self.vertex(&Particle {
            position: at,
            ..*nearest
        })
    }

    /// Triangles between two closed lines about the pith, each with its rising angles (rad) from about 0 on. An inner line
    /// of one point is the pith.
    fn stitch(&mut self, outer: (&[u32], &[f64]), inner: (&[u32], &[f64]), flip: bool) {
        let (n, m) = (
            outer.0.len(),
            if inner.0.len() == 1 { 0 } else { inner.0.len() },
        );
        let at = |line: (&[u32], &[f64]), i: usize| {
            let count = line.0.len();
            line.1[i % count] + TAU * (i / count) as f64
        };
        let (mut i, mut j) = (0, 0);
        while i < n || j < m {
            let (a, b) = (outer.0[i % n], inner.0[j % inner.0.len()]);
            let forward = j >= m || (i < n && at(outer, i + 1) <= at(inner, j + 1));
            let mut triangle = if forward {
                i += 1;
                [a, outer.0[i % n], b]
            } else {
                j += 1;
                [a, inner.0[j % m], b]
            };
            if flip {
                triangle.swap(1, 2);
            }
            self.mesh.triangles.push(triangle);
        }
    }

    fn finish(mut self) -> Mesh {
        let by = usize::from(self.colours == SurfaceColours::Sector);
        let colours = self.data.iter().flat_map(|d| told_apart(d[by] as u32));
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
fn told_apart(number: u32) -> [f32; 3] {
    let hue = (f64::from(number) * 0.618_033_988_749_895).fract() * 6.0;
    [5.0, 3.0, 1.0].map(|shift: f64| {
        let k = (shift + hue) % 6.0;
        let v = 0.9 * (1.0 - 0.8 * k.min(4.0 - k).clamp(0.0, 1.0));
        libm::pow(v, 2.2) as f32
    })
}
