//! The break surface: heights over a planar triangulation of the section, with steps along the grain.
//!
//! Every facet has its own three corner heights. Where two facets disagree on an edge they share, a wall along the
//! grain joins them; where they agree the surface runs on. A smooth surface has no walls, a fibrous one has a wall
//! around nearly every fibre bundle.

use glam::DVec2;

/// The number of no facet, used beyond the border of the triangulation.
pub const NONE: u32 = u32::MAX;

/// A height field in grain space, discontinuous at facet edges.
#[derive(Debug, Clone, Default)]
pub struct FractureSurface {
    /// The facets and cells, which all surfaces over the same section share.
    pub layout: std::sync::Arc<SectionLayout>,
    /// Length along the axis (m) at each corner of each facet.
    pub heights: Vec<[f64; 3]>,
}

/// A planar triangulation whose facets belong to cells (fibre bundles).
#[derive(Debug, Clone, Default)]
pub struct SectionLayout {
    /// Nodes, grain (x, y) in m.
    pub nodes: Vec<DVec2>,
    /// Facets, three nodes each, counter-clockwise.
    pub facets: Vec<[u32; 3]>,
    /// Cell of each facet; whoever makes the layout decides what it stands for.
    pub cells: Vec<u32>,
    /// Edge of each facet's side k (from its corner k to the next).
    pub sides: Vec<[u32; 3]>,
    /// Edges, see [`Edge`].
    pub edges: Vec<Edge>,
}

/// An edge of a [`SectionLayout`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Edge {
    /// Its nodes, the smaller number first.
    pub nodes: [u32; 2],
    /// The facet on the left of `nodes[0]` → `nodes[1]`, then the one on the right, as (facet, side); the facet is
    /// [`NONE`] beyond the border.
    pub facets: [(u32, u8); 2],
}

impl SectionLayout {
    /// Returns the layout of `facets` over `nodes`. Facets must be counter-clockwise and share whole edges.
    ///
    /// ```
    /// use glam::DVec2;
    /// use greenstick_fracture::surface::SectionLayout;
    ///
    /// let square = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
    /// let nodes = square.map(|(x, y)| DVec2::new(x, y)).to_vec();
    /// let layout = SectionLayout::new(nodes, vec![[0, 1, 2], [0, 2, 3]], vec![0, 0]);
    /// assert_eq!(layout.edges.len(), 5);
    /// ```
    pub fn new(nodes: Vec<DVec2>, facets: Vec<[u32; 3]>, cells: Vec<u32>) -> Self {
        let mut edges: Vec<Edge> = Vec::with_capacity(facets.len() * 3 / 2 + nodes.len() + 8);
        let mut sides = Vec::with_capacity(facets.len());
        // The latest edge from each node to a node of a larger number, and for each edge the one before it there.
        let mut latest = vec![NONE; nodes.len()];
        let mut before: Vec<u32> = Vec::with_capacity(edges.capacity());
        for (f, facet) in facets.iter().enumerate() {
            let mut side = [0; 3];
            for k in 0..3 {
                let (a, b) = (facet[k], facet[(k + 1) % 3]);
                let ends = [a.min(b), a.max(b)];
                let mut e = latest[ends[0] as usize];
                while e != NONE && edges[e as usize].nodes[1] != ends[1] {
                    e = before[e as usize];
                }
                if e == NONE {
                    e = edges.len() as u32;
                    edges.push(Edge {
                        nodes: ends,
                        facets: [(NONE, 0); 2],
                    });
                    before.push(latest[ends[0] as usize]);
                    latest[ends[0] as usize] = e;
                }
                edges[e as usize].facets[usize::from(a > b)] = (f as u32, k as u8);
                side[k] = e;
            }
            sides.push(side);
        }
        SectionLayout {
            nodes,
            facets,
            cells,
            sides,
            edges,
        }
    }
}

impl FractureSurface {
    /// Returns the lowest and the highest length along the axis, m.
    pub fn range(&self) -> (f64, f64) {
        range(self.heights.iter())
    }

    /// Returns the heights of `facet` at the ends of its side `side`, in the order of the edge's nodes.
    pub fn side_heights(&self, facet: u32, side: u8) -> [f64; 2] {
        let (f, k) = (facet as usize, usize::from(side));
        let [a, b] = [self.heights[f][k], self.heights[f][(k + 1) % 3]];
        let nodes = &self.layout.facets[f];
        if nodes[k] < nodes[(k + 1) % 3] {
            [a, b]
        } else {
            [b, a]
        }
    }
}

/// Returns the lowest and the highest of the heights of some facets.
pub(crate) fn range<'a>(heights: impl Iterator<Item = &'a [f64; 3]>) -> (f64, f64) {
    // Three of each, so that no comparison waits for the one before.
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for h in heights {
        for k in 0..3 {
            low[k] = if h[k] < low[k] { h[k] } else { low[k] };
            high[k] = if h[k] > high[k] { h[k] } else { high[k] };
        }
    }
    (
        low[0].min(low[1]).min(low[2]),
        high[0].max(high[1]).max(high[2]),
    )
}
