//! Loose splinters: fibre bundles that come off both pieces.
//!
//! A bundle that stands out of a piece breaks off near the level of its neighbours. The piece is then cut along a
//! surface that is lower there, while the other piece keeps the socket that the bundle left; what lies between both
//! surfaces over the bundle is the splinter. Nothing is lost: pieces and splinters together are the stem.

use crate::cut::{CapFace, Cut, Skin, Solid};
use crate::layout::FibreBundles;
use crate::surface::{FractureSurface, NONE, SectionLayout};
use glam::DVec3;
use greenstick_wood::noise;

/// Seeds of independent random numbers.
mod purpose {
    pub const CHOICE: u64 = 0x5b11;
    pub const BASE: u64 = 0x5b12;
}

/// How splinters are chosen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SplinterOptions {
    /// Greatest number of splinters.
    pub max_count: usize,
    /// Least mean length of a splinter, m.
    pub min_length: f64,
    /// Seed.
    pub seed: u64,
}

/// A bundle that comes off.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Splinter {
    /// Its cell.
    pub cell: u32,
    /// Whether it stood out of the upper piece, hanging, rather than out of the lower one.
    pub upper: bool,
    /// Its mean length, m.
    pub length: f64,
}

/// The faces of a break without its splinters.
#[derive(Debug, Clone, Default)]
pub struct Loosened {
    /// The face of the lower piece: the surface, lower where splinters stood.
    pub lower: FractureSurface,
    /// The face of the upper piece: the surface, higher where splinters hung.
    pub upper: FractureSurface,
    /// The splinters, by cell.
    pub splinters: Vec<Splinter>,
}

/// Part of its neighbours (by length of border) above which a bundle must stand to break off.
const STANDS_OUT: f64 = 0.8;
/// Irregularity of the break across a splinter, as part of its length.
const RAGGED: f64 = 0.3;

/// A bundle as it stands among its neighbours, seen from one piece.
struct Candidate {
    splinter: Splinter,
    /// Level at which it breaks off.
    base: f64,
    score: f64,
}

/// Chooses splinters among the bundles that are `free` (wholly inside the stem, away from its skin) and takes them off.
pub fn loosen(
    surface: &FractureSurface,
    bundles: &FibreBundles,
    free: &dyn Fn(u32) -> bool,
    options: &SplinterOptions,
) -> Loosened {
    let layout = surface.layout.as_ref();
    let facets = facets_by_cell(layout, bundles.bundles.len());
    let range = surface.range();
    let mut candidates: Vec<Candidate> = Vec::new();
    for (cell, facets) in facets.iter().enumerate() {
        let inside = bundles.tips[cell] != NONE && !bundles.bundles[cell].bark;
        if inside && free(cell as u32) {
            for upper in [false, true] {
                let cell = cell as u32;
                candidates.extend(candidate((surface, range), cell, facets, upper, options));
            }
        }
    }
    candidates.sort_by(|a, b| b.score.total_cmp(&a.score));
    let mut loosened = Loosened {
        lower: surface.clone(),
        upper: surface.clone(),
        splinters: Vec::new(),
    };
    let mut taken = vec![false; facets.len()];
    for c in candidates {
        if loosened.splinters.len() == options.max_count {
            break;
        }
        let cell = c.splinter.cell as usize;
        if taken[cell] {
            continue;
        }
        // Their neighbours stay, so that no two sockets merge.
        taken[cell] = true;
        for edge in borders(layout, &facets[cell]) {
            taken[layout.cells[edge.other.0 as usize] as usize] = true;
        }
        let face = if c.splinter.upper {
            &mut loosened.upper
        } else {
            &mut loosened.lower
        };
        break_off(face, &c, &facets[cell], options);
        loosened.splinters.push(c.splinter);
    }
    loosened.splinters.sort_by_key(|s| s.cell);
    loosened
}

fn facets_by_cell(layout: &SectionLayout, cells: usize) -> Vec<Vec<u32>> {
    let mut facets = vec![Vec::new(); cells];
    for (f, &cell) in layout.cells.iter().enumerate() {
        if let Some(list) = facets.get_mut(cell as usize) {
            list.push(f as u32);
        }
    }
    facets
}

/// A side of a facet at the border of its cell.
struct Border {
    own: (u32, u8),
    /// Facet and side across.
    other: (u32, u8),
}

/// Returns the border of a cell towards other cells, in the order of its facets.
fn borders(layout: &SectionLayout, facets: &[u32]) -> Vec<Border> {
    let mut list = Vec::new();
    for &f in facets {
        for k in 0..3u8 {
            let edge = &layout.edges[layout.sides[f as usize][usize::from(k)] as usize];
            let other = edge.facets[usize::from(edge.facets[0] == (f, k))];
            if other.0 != NONE && layout.cells[other.0 as usize] != layout.cells[f as usize] {
                let own = (f, k);
                list.push(Border { own, other });
            }
        }
    }
    list
}

/// The bundle of a cell, if it stands out of its neighbours far enough to break off. The surface comes with the range of
/// its heights.
fn candidate(
    (surface, (low, high)): (&FractureSurface, (f64, f64)),
    cell: u32,
    facets: &[u32],
    upper: bool,
    options: &SplinterOptions,
) -> Option<Candidate> {
    let layout = surface.layout.as_ref();
    // Heights as seen from the piece: what hangs out of the upper one is turned over.
    let sign = if upper { -1.0 } else { 1.0 };
    let mut neighbours: Vec<(f64, f64)> = Vec::new();
    let (mut own, mut around) = (0.0, 0.0);
    for border in borders(layout, facets) {
        let edge = layout.sides[border.own.0 as usize][usize::from(border.own.1)];
        let [a, b] = layout.edges[edge as usize].nodes;
        let length = layout.nodes[a as usize].distance(layout.nodes[b as usize]);
        let level = |(f, k): (u32, u8)| {
            let [a, b] = surface.side_heights(f, k);
            sign * (a + b) / 2.0
        };
        neighbours.push((level(border.other), length));
        own += level(border.own) * length;
        around += length;
    }
    neighbours.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut passed = 0.0;
    let base = neighbours.iter().find(|n| {
        passed += n.1;
        passed >= STANDS_OUT * around
    })?;
    let length = own / around - base.0;
    let deepest = base.0 - RAGGED * length;
    let within = if upper {
        -deepest < high
    } else {
        deepest > low
    };
    if length.is_nan() || length < options.min_length || !within {
        return None;
    }
    let random = noise::unit(
        options.seed ^ purpose::CHOICE,
        i64::from(cell),
        i64::from(upper),
        0,
    );
    let splinter = Splinter {
        cell,
        upper,
        length,
    };
    Some(Candidate {
        splinter,
        base: sign * base.0,
        score: length * (0.4 + 0.6 * random),
    })
}

/// Takes a splinter off the face of its piece.
fn break_off(face: &mut FractureSurface, c: &Candidate, facets: &[u32], options: &SplinterOptions) {
    let Splinter {
        cell,
        upper,
        length,
    } = c.splinter;
    let layout = face.layout.clone();
    for &f in facets {
        for k in 0..3 {
            let node = i64::from(layout.facets[f as usize][k]);
            let random = noise::unit(options.seed ^ purpose::BASE, i64::from(cell), node, 0);
            let off = length * RAGGED * random;
            let height = &mut face.heights[f as usize][k];
            // A splinter has some length at every corner.
            let thin = 0.25 * length;
            *height = if upper {
                (c.base + off).max(*height + thin)
            } else {
                (c.base - off).min(*height - thin)
            };
        }
    }
}

/// Returns the solid between two surfaces over a cell, as a cut with no other face, oriented outwards.
///
/// `faces` are its bottom and its top. The top must be higher everywhere on the cell, and both must have one height at each of
/// its nodes.
pub fn splinter_solid(
    solid: &Solid,
    skin: &Skin,
    like: &Cut,
    faces: [&FractureSurface; 2],
    cell: u32,
) -> Cut {
    let layout = faces[1].layout.as_ref();
    let mut sides = like.sides.clone();
    (sides.below, sides.above) = (0, skin.order.len());
    sides.between = vec![crate::cut::Side::Elsewhere; skin.order.len()];
    let mut made = Cut {
        points: solid.points.len(),
        vertices: Vec::new(),
        inside: Vec::new(),
        nodes: Vec::new(),
        sides,
        skin: Vec::new(),
        cap: Vec::new(),
        faces: Vec::new(),
        walls: Vec::new(),
        outlines: 0,
    };
    let facets: Vec<u32> = (0..layout.facets.len() as u32)
        .filter(|&f| layout.cells[f as usize] == cell)
        .collect();
    let mut corners = Corners {
        faces,
        first: made.points as u32,
        inside: Vec::new(),
        nodes: Vec::new(),
    };
    for &f in &facets {
        made.cap.push([0, 1, 2].map(|k| corners.vertex(f, k, 1)));
    }
    for &f in &facets {
        made.cap.push([0, 2, 1].map(|k| corners.vertex(f, k, 0)));
    }
    made.faces = vec![CapFace { cell, top: true }; made.cap.len()];
    for border in borders(layout, &facets) {
        let (f, k) = (border.own.0, usize::from(border.own.1));
        let next = (k + 1) % 3;
        let [a, b] = [k, next].map(|k| corners.vertex(f, k, 0));
        let [d, c] = [k, next].map(|k| corners.vertex(f, k, 1));
        made.walls.push(made.cap.len() as u32);
        made.cap.extend([[a, b, c], [a, c, d]]);
    }
    made.faces
        .resize(made.cap.len(), CapFace { cell, top: false });
    (made.inside, made.nodes) = (corners.inside, corners.nodes);
    made
}

/// The vertices of a splinter while they are made.
struct Corners<'a> {
    /// Bottom and top.
    faces: [&'a FractureSurface; 2],
    /// Number of the first.
    first: u32,
    inside: Vec<DVec3>,
    /// Node of each, bottom and top in turn.
    nodes: Vec<u32>,
}

impl Corners<'_> {
    /// Returns the vertex at corner `k` of facet `f`, at the bottom (0) or at the top (1).
    fn vertex(&mut self, f: u32, k: usize, which: usize) -> u32 {
        let layout = &self.faces[0].layout;
        let node = layout.facets[f as usize][k];
        let known = self.nodes.iter().position(|&n| n == node);
        let at = known.unwrap_or_else(|| {
            let heights = self.faces.map(|s| s.heights[f as usize][k]);
            let across = layout.nodes[node as usize];
            self.inside.extend(heights.map(|h| across.extend(h)));
            self.nodes.extend([node; 2]);
            self.nodes.len() - 2
        });
        self.first + (at + which) as u32
    }
}
