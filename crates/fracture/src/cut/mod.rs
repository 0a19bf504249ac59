//! Cutting a stem's mesh along a break surface into a lower and an upper piece that share the broken face.

mod cap;
mod chips;
mod error;
mod facet_grid;
mod follow;
mod layers;
mod overlay;
mod parts;
mod polygon;
mod skin;

pub use error::CutError;
pub use facet_grid::FacetGrid;
pub use parts::{CapFace, CutVertex, Host, Side, SkinTriangle, Solid};
pub use skin::{Sides, Skin};

use crate::surface::{FractureSurface, NONE, SectionLayout};
use glam::DVec3;
use greenstick_geometry::{Context, Unions};
use overlay::clips::Clips;
use overlay::outline::Overlay;
use overlay::{Place, SplitMemory};
use std::sync::Arc;

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

/// Cuts `solid` along `surface`.
///
/// # Errors
/// [`CutError`] where the skin is not a closed surface around the break.
pub fn cut(solid: &Solid, surface: &FractureSurface) -> Result<Cut, CutError> {
    let skin = Skin::new(solid, surface.range());
    let grid = FacetGrid::new(&skin, &surface.layout);
    let mut workspace = CutWorkspace::default();
    cut_again(
        solid,
        &skin,
        &grid,
        surface,
        &mut workspace,
        &Context::quiet(),
    )
}

/// The cache that one cut leaves for the next: which part of each triangle of the skin lies over which facet, as far as
/// cuts have needed it. A cut is the same with a fresh workspace.
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
/// lie, the `grid` of the surface's facets near it, and the workspace that earlier cuts have left.
///
/// # Errors
/// As [`cut`], and [`CutError::Cancelled`].
pub fn cut_again(
    solid: &Solid,
    skin: &Skin,
    grid: &FacetGrid,
    surface: &FractureSurface,
    workspace: &mut CutWorkspace,
    context: &Context,
) -> Result<Cut, CutError> {
    context.check()?;
    let clips = workspace.clips(skin, &surface.layout);
    let even = cap::one_height_each(surface);
    let mut overlay = Overlay::new(
        (surface, even.is_none()),
        solid.points,
        clips.made + clips.made / 4,
    );
    let (sides, nodes) = rayon::join(
        || overlay_skin(solid, (skin, grid), surface, clips, &mut overlay, context),
        || match even {
            Some(heights) => cap::Nodes::Even(heights),
            None => cap::Nodes::Stepped(cap::Columns::new(surface, grid)),
        },
    );
    let sides = sides?;
    clips.made = overlay.vertices.len();
    context.check()?;
    let outlines = outlines(&overlay);
    let cap = cap::build(surface, grid, &mut overlay, nodes, context)?;
    Ok(Cut {
        points: solid.points.len(),
        vertices: overlay.vertices,
        inside: cap.inside,
        nodes: cap.nodes,
        sides,
        skin: overlay.skin,
        cap: cap.faces.triangles,
        faces: cap.faces.faces,
        walls: cap.faces.walls,
        outlines,
    })
}

/// Overlays the skin and the surface: finds the side of every triangle and cuts those that the surface meets.
fn overlay_skin(
    solid: &Solid,
    (skin, grid): (&Skin, &FacetGrid),
    surface: &FractureSurface,
    clips: &mut Clips,
    overlay: &mut Overlay,
    context: &Context,
) -> Result<Sides, CutError> {
    let band = surface.range();
    let mut relief = facet_grid::Relief::new(skin, grid, surface);
    let mut memory = SplitMemory::default();
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
                    context.check()?;
                    let corners = solid.triangles[t as usize];
                    let parts = clips.of(rank, skin, grid, solid);
                    let facets = clips.facets(parts);
                    match relief.compare((low, high), facets) {
                        // No facet at all.
                        Side::Elsewhere => {
                            return Err(CutError::OffLayout {
                                at: solid.points[corners[0] as usize],
                            });
                        }
                        Side::Split => {
                            match overlay.split(t, corners, clips, parts, &mut memory)? {
                                Place::Lower => Side::Lower,
                                Place::Upper => Side::Upper,
                                Place::Split => Side::Split,
                            }
                        }
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
    /// Returns the lowest and the highest length along the axis that the broken face reaches, m. `points` are those of the
    /// mesh in grain coordinates.
    pub fn face_range(&self, points: &[DVec3]) -> (f64, f64) {
        let ids = self.cap.iter().flatten();
        let lengths = ids.map(|&id| self.grain(points, id).z);
        lengths.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), z| {
            (low.min(z), high.max(z))
        })
    }

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
