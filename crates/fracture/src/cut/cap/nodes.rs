//! The vertices over the nodes of a surface, which do not depend on the skin.

use super::super::facet_grid::FacetGrid;
use super::column::HeightColumn;
use crate::surface::FractureSurface;
use glam::DVec3;

/// The vertices over the nodes of a surface.
pub(in super::super) enum Nodes {
    /// Those of a surface without steps: the height at every node, m.
    Even(Vec<f64>),
    /// Those of a surface with steps.
    Stepped(Columns),
}

/// One vertex for every distinct height of the facets about every node.
pub(in super::super) struct Columns {
    /// Their grain coordinates, m.
    pub(super) inside: Vec<DVec3>,
    /// The nodes that they lie over.
    pub(super) nodes: Vec<u32>,
    /// For each node where its vertices start, ascending, and their number.
    pub(super) starts: Vec<u32>,
    /// Vertex at each corner of each facet.
    pub(super) corners: Vec<[u32; 3]>,
}

impl Nodes {
    pub(super) fn is_stepped(&self) -> bool {
        matches!(self, Nodes::Stepped(_))
    }
}

/// Returns the height at every node of a surface without steps.
pub(in super::super) fn one_height_each(surface: &FractureSurface) -> Option<Vec<f64>> {
    let layout = &surface.layout;
    let mut heights = vec![f64::NAN; layout.nodes.len()];
    for (facet, h) in layout.facets.iter().zip(&surface.heights) {
        for (&n, &h) in facet.iter().zip(h) {
            let known = &mut heights[n as usize];
            if known.is_nan() {
                *known = h;
            } else if *known != h {
                return None;
            }
        }
    }
    // A node of no facet has no vertex; that is left to the general way.
    heights.iter().all(|h| !h.is_nan()).then_some(heights)
}

impl Columns {
    /// Makes one vertex for every distinct height at every node.
    pub(in super::super) fn new(surface: &FractureSurface, grid: &FacetGrid) -> Self {
        let height = |&(f, k): &(u32, u8)| surface.heights[f as usize][usize::from(k)];
        let of_cells: Vec<f64> = grid.cell_corners.iter().map(height).collect();
        // The facets of a cell nearly always have one height at a node.
        let mut shared = true;
        for (heights, cells) in surface.heights.iter().zip(&grid.corner_cells) {
            let ([x, y, z], [a, b, c]) = (heights, cells.map(|c| c as usize));
            shared &= (*x == of_cells[a]) & (*y == of_cells[b]) & (*z == of_cells[c]);
        }
        if shared {
            let (mut made, vertices) = Columns::over(surface, &grid.cell_starts, &of_cells);
            let vertex = |cell: u32| vertices[cell as usize];
            let corners =
                (grid.corner_cells.iter()).map(|&[a, b, c]| [vertex(a), vertex(b), vertex(c)]);
            made.corners = corners.collect();
            made
        } else {
            let heights: Vec<f64> = grid.around.iter().map(height).collect();
            let (mut made, vertices) = Columns::over(surface, &grid.node_starts, &heights);
            made.corners = vec![[0; 3]; surface.heights.len()];
            for (&(f, k), vertex) in grid.around.iter().zip(vertices) {
                made.corners[f as usize][usize::from(k)] = vertex;
            }
            made
        }
    }

    /// Makes one vertex for every distinct one of the `heights` about every node, which start at `starts`. Returns also the
    /// vertex of each.
    fn over(surface: &FractureSurface, starts: &[u32], heights: &[f64]) -> (Self, Vec<u32>) {
        let layout = &surface.layout;
        let room = layout.nodes.len() * 4;
        let mut made = Columns {
            inside: Vec::with_capacity(room),
            nodes: Vec::with_capacity(room),
            starts: Vec::with_capacity(layout.nodes.len() + 1),
            corners: Vec::new(),
        };
        let mut vertices = Vec::with_capacity(heights.len());
        let mut column = HeightColumn::default();
        for (n, (node, about)) in (0..).zip(layout.nodes.iter().zip(starts.windows(2))) {
            let start = made.inside.len() as u32;
            made.starts.push(start);
            let about = &heights[about[0] as usize..about[1] as usize];
            let (ascending, ranks) = column.rank(about);
            for &z in ascending {
                made.inside.push(node.extend(z));
                made.nodes.push(n);
            }
            vertices.extend(ranks.iter().map(|rank| start + rank));
        }
        made.starts.push(made.inside.len() as u32);
        (made, vertices)
    }
}
