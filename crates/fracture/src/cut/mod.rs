//! Cutting a stem's mesh along a break surface into a lower and an upper piece that share the broken face.

mod cap;
mod chips;
mod overlay;
mod polygon;

use crate::surface::Surface;
use glam::DVec3;
use overlay::{Overlay, Place};

/// Where a vertex of a cut lies, so that positions and attributes can be taken from the mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Host {
    /// A point of the mesh.
    Point(u32),
    /// On the edge between two points, the smaller number first, at fraction `t` from it.
    Edge {
        /// The edge's points.
        ends: [u32; 2],
        /// Fraction from the first to the second, 0 to 1.
        t: f64,
    },
    /// Inside a triangle of the mesh, with barycentric weights.
    Face {
        /// The triangle.
        triangle: u32,
        /// Weights of its corners; their sum is 1.
        weights: [f64; 3],
    },
    /// Inside the wood, placed by its grain coordinates.
    Inside,
}

/// A vertex made by a cut.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CutVertex {
    /// Grain coordinates (x, y, s), m.
    pub grain: DVec3,
    /// Where it lies.
    pub host: Host,
}

/// What a triangle of the broken face belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CapFace {
    /// Cell (fibre bundle) of the surface's layout; for a wall the one that stands higher.
    pub cell: u32,
    /// True for the top of a cell, false for a wall along the grain.
    pub top: bool,
}

/// A part of a cut triangle of the skin.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SkinTriangle {
    /// The triangle of the mesh it is a part of.
    pub source: u32,
    /// Vertices, numbered as in [`Cut`].
    pub corners: [u32; 3],
    /// Whether it belongs to the upper piece.
    pub upper: bool,
}

/// Which piece a whole triangle of the mesh goes to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// Not part of the shell that was cut.
    Elsewhere,
    /// Unchanged in the lower piece.
    Lower,
    /// Unchanged in the upper piece.
    Upper,
    /// Cut into [`Cut::skin`].
    Split,
}

/// A mesh to cut. Topology is by points: vertices at equal positions have one number.
#[derive(Debug, Clone, Copy)]
pub struct Solid<'a> {
    /// Point numbers of each triangle's corners.
    pub triangles: &'a [[u32; 3]],
    /// Grain coordinates of each point; NaN for points off the limb.
    pub points: &'a [DVec3],
    /// The triangles of the shell to cut.
    pub shell: &'a [u32],
    /// Those of the shell that the surface may meet; all their points have grain coordinates.
    pub limb: &'a [u32],
}

/// A mesh cut in two. Vertices are numbered through: points of the mesh first, then [`Cut::vertices`].
#[derive(Debug, Clone)]
pub struct Cut {
    /// Number of points of the mesh.
    pub points: usize,
    /// Vertices made by the cut.
    pub vertices: Vec<CutVertex>,
    /// Piece of each triangle of the mesh.
    pub sides: Vec<Side>,
    /// Parts of split triangles.
    pub skin: Vec<SkinTriangle>,
    /// The broken face, oriented for the lower piece; the upper piece takes it turned over.
    pub cap: Vec<[u32; 3]>,
    /// What each triangle of `cap` belongs to.
    pub faces: Vec<CapFace>,
}

/// Why a mesh could not be cut. Places are grain coordinates (x, y, s) in m; callers map them to the world.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum CutError {
    /// The layout does not reach beyond the skin.
    #[error("the skin reaches beyond the break surface near {at} (grain coordinates, m)")]
    OffLayout {
        /// Where.
        at: DVec3,
    },
    /// The outline on a triangle of the skin does not close.
    #[error(
        "the break's outline on triangle {triangle} does not close near {at} (grain coordinates, m)"
    )]
    Outline {
        /// The triangle.
        triangle: u32,
        /// Where.
        at: DVec3,
    },
    /// A broken face cannot be closed: the skin has a hole or is not a manifold there.
    #[error(
        "the broken face cannot be closed near {at} (grain coordinates, m): the mesh has a hole or is not a manifold there"
    )]
    Face {
        /// Where.
        at: DVec3,
    },
    /// The surface does not meet the skin.
    #[error("the break surface does not meet the mesh")]
    Misses,
    /// Both sides of the cut are joined elsewhere.
    #[error(
        "the two sides of the break are joined elsewhere by the mesh (at triangle {triangle}), so the cut would not part it"
    )]
    Joined {
        /// A triangle that belongs to both sides.
        triangle: u32,
    },
}

/// Cuts `solid` along `surface`. Walls along the grain are parted at every `level` m, so that they can follow a bent
/// stem; infinite for a straight one.
///
/// # Errors
/// [`CutError`] where the skin is not a closed surface around the break.
pub fn cut(solid: &Solid, surface: &Surface, level: f64) -> Result<Cut, CutError> {
    let mut overlay = Overlay::new(surface, solid.points);
    let mut sides = vec![Side::Elsewhere; solid.triangles.len()];
    for &t in solid.limb {
        sides[t as usize] = match overlay.lay(t, solid.triangles[t as usize])? {
            Place::Lower => Side::Lower,
            Place::Upper => Side::Upper,
            Place::Split => Side::Split,
        };
    }
    spread(solid, &mut sides)?;
    let cap = cap::build(surface, &mut overlay, level)?;
    let skin = overlay
        .skin
        .iter()
        .map(|&(source, corners, upper)| SkinTriangle {
            source,
            corners,
            upper,
        })
        .collect();
    Ok(Cut {
        points: solid.points.len(),
        vertices: overlay.vertices,
        sides,
        skin,
        cap: cap.triangles,
        faces: cap.faces,
    })
}

/// Gives every triangle of the shell the side of those it is joined to.
fn spread(solid: &Solid, sides: &mut [Side]) -> Result<(), CutError> {
    let mut parent: Vec<u32> = (0..solid.points.len() as u32).collect();
    fn root(parent: &mut [u32], mut i: u32) -> u32 {
        while parent[i as usize] != i {
            parent[i as usize] = parent[parent[i as usize] as usize];
            i = parent[i as usize];
        }
        i
    }
    for &t in solid.shell {
        if sides[t as usize] != Side::Split {
            let [a, b, c] = solid.triangles[t as usize];
            let a = root(&mut parent, a);
            for other in [b, c] {
                let other = root(&mut parent, other);
                parent[other as usize] = a;
            }
        }
    }
    let mut known = vec![Side::Elsewhere; solid.points.len()];
    for &t in solid.limb {
        let side = sides[t as usize];
        if side == Side::Split {
            continue;
        }
        let r = root(&mut parent, solid.triangles[t as usize][0]) as usize;
        if known[r] != Side::Elsewhere && known[r] != side {
            return Err(CutError::Joined { triangle: t });
        }
        known[r] = side;
    }
    for &t in solid.shell {
        if sides[t as usize] == Side::Elsewhere {
            let r = root(&mut parent, solid.triangles[t as usize][0]) as usize;
            // A part that the limb does not touch at all stays with the lower piece.
            sides[t as usize] = if known[r] == Side::Upper {
                Side::Upper
            } else {
                Side::Lower
            };
        }
    }
    Ok(())
}

impl Cut {
    /// Grain coordinates of a vertex; `points` as given to [`cut`].
    pub fn grain(&self, points: &[DVec3], id: u32) -> DVec3 {
        match (id as usize).checked_sub(self.points) {
            None => points[id as usize],
            Some(i) => self.vertices[i].grain,
        }
    }

    /// Where a vertex lies.
    pub fn host(&self, id: u32) -> Host {
        match (id as usize).checked_sub(self.points) {
            None => Host::Point(id),
            Some(i) => self.vertices[i].host,
        }
    }
}
