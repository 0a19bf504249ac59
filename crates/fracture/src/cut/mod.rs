//! Cutting a stem's mesh along a break surface into a lower and an upper piece that share the broken face.

mod cap;
mod chips;
mod follow;
mod ground;
mod layers;
mod overlay;
mod polygon;

use crate::surface::{FractureSurface, NONE, SectionLayout};
use glam::DVec3;
use greenstick_geometry::Unions;
pub use ground::{Ground, Sides, Skin};
use overlay::{Overlay, Place, clips::Clips};
use std::sync::Arc;

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

/// A mesh cut in two. Vertices are numbered through: points of the mesh first, then [`Cut::vertices`], then those within
/// the wood.
#[derive(Debug, Clone)]
pub struct Cut {
    /// Number of points of the mesh.
    pub points: usize,
    /// Vertices made by the cut on the skin.
    pub vertices: Vec<CutVertex>,
    /// Grain coordinates (x, y, s) of the vertices within the wood, m.
    pub inside: Vec<DVec3>,
    /// Node of the layout that each of `inside` lies over, or [`crate::surface::NONE`].
    pub nodes: Vec<u32>,
    /// Piece of each triangle of the mesh.
    pub sides: Sides,
    /// Parts of split triangles.
    pub skin: Vec<SkinTriangle>,
    /// The broken face, oriented for the lower piece; the upper piece takes it turned over. Tops of cells come first.
    pub cap: Vec<[u32; 3]>,
    /// What each triangle of `cap` belongs to.
    pub faces: Vec<CapFace>,
    /// For every wall its first triangle in `cap`.
    pub walls: Vec<u32>,
    /// Closed outlines of the break on the skin.
    pub outlines: usize,
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

/// Cuts `solid` along `surface`.
///
/// # Errors
/// [`CutError`] where the skin is not a closed surface around the break.
pub fn cut(solid: &Solid, surface: &FractureSurface) -> Result<Cut, CutError> {
    let skin = Skin::new(solid, surface.range());
    let ground = Ground::new(&skin, &surface.layout);
    cut_again(solid, &skin, &ground, surface, &mut CutWorkspace::default())
}

/// What one cut leaves for the next: which part of each triangle of the skin lies over which facet, as far as cuts have
/// asked for it. A cut is the same with a fresh workspace.
#[derive(Debug, Default)]
pub struct CutWorkspace {
    clips: Clips,
    /// The skin and the layout that `clips` are of.
    of: Option<(Arc<Vec<u32>>, Arc<SectionLayout>)>,
}

impl CutWorkspace {
    /// The clips of a skin and a layout, those from before where they are of the same.
    fn clips(&mut self, skin: &Skin, layout: &Arc<SectionLayout>) -> &mut Clips {
        let same = self.of.as_ref().is_some_and(|(ranks, known)| {
            Arc::ptr_eq(ranks, &skin.ranks) && Arc::ptr_eq(known, layout)
        });
        if !same {
            self.of = Some((skin.ranks.clone(), layout.clone()));
        }
        let sizes = (skin.order.len(), layout.facets.len());
        self.clips.begin(same, sizes);
        &mut self.clips
    }
}

/// [`cut`] with what stays the same from cut to cut: the sorted `skin` of `solid`, within whose reach the surface must
/// lie, the `ground` of the surface's layout on it, and the workspace that earlier cuts have left.
///
/// # Errors
/// As [`cut`].
pub fn cut_again(
    solid: &Solid,
    skin: &Skin,
    ground: &Ground,
    surface: &FractureSurface,
    workspace: &mut CutWorkspace,
) -> Result<Cut, CutError> {
    let clips = workspace.clips(skin, &surface.layout);
    let mut overlay = Overlay::new(surface, solid.points, clips.made + clips.made / 4);
    let sides = lay(solid, skin, ground, surface, clips, &mut overlay)?;
    clips.made = overlay.vertices.len();
    let outlines = outlines(&overlay);
    let cap = cap::build(surface, ground, &mut overlay)?;
    Ok(Cut {
        points: solid.points.len(),
        vertices: overlay.vertices,
        inside: cap.inside,
        nodes: cap.nodes,
        sides,
        skin: overlay.skin,
        cap: cap.triangles,
        faces: cap.faces,
        walls: cap.walls,
        outlines,
    })
}

/// Lays the skin over the surface: finds the side of every triangle and cuts those that the surface meets.
fn lay(
    solid: &Solid,
    skin: &Skin,
    ground: &Ground,
    surface: &FractureSurface,
    clips: &mut Clips,
    overlay: &mut Overlay,
) -> Result<Sides, CutError> {
    let band = surface.range();
    let mut relief = ground::Relief::new(skin, ground, surface);
    let window = skin.window(band);
    let mut sides = Sides::new(skin, window);
    let mut doubtful = false;
    for rank in window.0..window.1 {
        let (low, high) = skin.span(rank);
        let t = skin.order[rank];
        sides.between[rank - window.0] = if high <= band.0 {
            Side::Lower
        } else if low > band.1 {
            Side::Upper
        } else if !skin.is_limb(rank) {
            doubtful = true;
            Side::Elsewhere
        } else {
            match relief.meet(rank) {
                Side::Split => {
                    let corners = solid.triangles[t as usize];
                    let parts = clips.of(rank, skin, ground, solid);
                    let facets = clips.facets(parts);
                    match relief.compare((low, high), facets) {
                        // No facet at all.
                        Side::Elsewhere => {
                            return Err(CutError::OffLayout {
                                at: solid.points[corners[0] as usize],
                            });
                        }
                        Side::Split => match overlay.split(t, corners, clips, parts)? {
                            Place::Lower => Side::Lower,
                            Place::Upper => Side::Upper,
                            Place::Split => Side::Split,
                        },
                        side => side,
                    }
                }
                side => side,
            }
        };
    }
    if doubtful {
        spread(solid, skin, &mut sides)?;
    }
    Ok(sides)
}

/// Number of closed lines that the outline of the break consists of.
fn outlines(overlay: &Overlay) -> usize {
    let edges = overlay.tops.iter().chain(&overlay.walls);
    // All of its vertices are the cut's own.
    let points = overlay.points() as u32;
    let mut next = vec![NONE; overlay.vertices.len()];
    for &(_, [a, b]) in edges {
        if let Some(next) = next.get_mut(a.wrapping_sub(points) as usize) {
            *next = b;
        }
    }
    let mut take = |at: u32| {
        let next = next.get_mut(at.wrapping_sub(points) as usize)?;
        let to = std::mem::replace(next, NONE);
        (to != NONE).then_some(to)
    };
    let mut count = 0;
    for (_, [start, _]) in &overlay.tops {
        let Some(mut at) = take(*start) else {
            continue;
        };
        while let Some(to) = take(at) {
            at = to;
        }
        count += 1;
    }
    count
}

/// Gives parts of the shell off the limb the side of those they are joined to. On the limb, triangles on different
/// sides never share a point: the surface has one height over it.
fn spread(solid: &Solid, skin: &Skin, sides: &mut Sides) -> Result<(), CutError> {
    let mut joined = Unions::new(solid.points.len());
    for &t in solid.shell {
        if sides[t as usize] != Side::Split {
            joined.join_triangle(solid.triangles[t as usize]);
        }
    }
    let mut known = vec![Side::Elsewhere; solid.points.len()];
    for &t in solid.limb {
        let side = sides[t as usize];
        if side == Side::Split {
            continue;
        }
        let r = joined.root(solid.triangles[t as usize][0]) as usize;
        if known[r] != Side::Elsewhere && known[r] != side {
            return Err(CutError::Joined { triangle: t });
        }
        known[r] = side;
    }
    for (i, side) in sides.between.iter_mut().enumerate() {
        if *side == Side::Elsewhere {
            let t = skin.order[sides.below + i] as usize;
            let r = joined.root(solid.triangles[t][0]) as usize;
            // A part that the limb does not touch at all stays with the lower piece.
            *side = if known[r] == Side::Upper {
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
        let Some(i) = (id as usize).checked_sub(self.points) else {
            return points[id as usize];
        };
        match self.vertices.get(i) {
            Some(vertex) => vertex.grain,
            None => self.inside[i - self.vertices.len()],
        }
    }

    /// Where a vertex lies.
    pub fn host(&self, id: u32) -> Host {
        match (id as usize).checked_sub(self.points) {
            None => Host::Point(id),
            Some(i) => self.vertices.get(i).map_or(Host::Inside, |v| v.host),
        }
    }
}
