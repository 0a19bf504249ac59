//! Levelling the few cells of a fracture surface whose walls cross in spiral grain, whatever is done to their triangles.
//!
//! What crosses are high walls that lie close together, or close to the skin. Where the surface runs on from cell to cell at
//! low slope there are none, so in the neighbourhood of such walls the cells give up their own heights: every node gets one
//! height for all cells about it, drawn out smoothly between the cells around.

use greenstick_fracture::surface::{FractureSurface, NONE, SectionLayout};
use std::collections::BTreeSet;

/// Rounds in which the height of a node becomes the mean of its neighbours'. Regions are a few cells wide, so that few are
/// enough to leave no slope that is much steeper than others.
const SMOOTHING: usize = 24;

/// Adds the cells that share an edge with one of `cells`.
pub(super) fn grow(layout: &SectionLayout, cells: &mut BTreeSet<u32>) {
    let mut beside = Vec::new();
    for edge in &layout.edges {
        let [a, b] = edge.facets.map(|(facet, _)| facet);
        if a == NONE || b == NONE {
            continue;
        }
        let of = [a, b].map(|facet| layout.cells[facet as usize]);
        match of.map(|cell| cells.contains(&cell)) {
            [true, false] => beside.push(of[1]),
            [false, true] => beside.push(of[0]),
            _ => {}
        }
    }
    cells.extend(beside);
}

/// Returns a surface whose cells in `cells` have one height at each node, smooth from node to node; the nodes that they share
/// with other cells have the mean height there.
pub(super) fn levelled(surface: &FractureSurface, cells: &BTreeSet<u32>) -> FractureSurface {
    let layout = &surface.layout;
    let is_inside: Vec<bool> = layout
        .cells
        .iter()
        .map(|cell| cells.contains(cell))
        .collect();
    let count = layout.nodes.len();
    let (mut sums, mut corners) = (vec![0.0; count], vec![0u32; count]);
    let (mut inner, mut outer) = (vec![false; count], vec![false; count]);
    for (f, facet) in layout.facets.iter().enumerate() {
        for (&node, &height) in facet.iter().zip(&surface.heights[f]) {
            sums[node as usize] += height;
            corners[node as usize] += 1;
            let side = if is_inside[f] { &mut inner } else { &mut outer };
            side[node as usize] = true;
        }
    }
    let mut heights: Vec<f64> = (sums.iter().zip(&corners))
        .map(|(sum, &n)| sum / f64::from(n.max(1)))
        .collect();
    // Where no other cell is met, all of the region's nodes are free; the border of the section is met by none.
    let is_free = |node: usize| inner[node] && !outer[node];
    for _ in 0..SMOOTHING {
        let (mut sums, mut met) = (vec![0.0; count], vec![0u32; count]);
        for edge in &layout.edges {
            let [a, b] = edge.nodes.map(|node| node as usize);
            if is_free(a) {
                sums[a] += heights[b];
                met[a] += 1;
            }
            if is_free(b) {
                sums[b] += heights[a];
                met[b] += 1;
            }
        }
        for node in (0..count).filter(|&node| met[node] > 0) {
            heights[node] = sums[node] / f64::from(met[node]);
        }
    }
    let mut made = surface.clone();
    for (f, facet) in layout.facets.iter().enumerate() {
        if is_inside[f] {
            made.heights[f] = facet.map(|node| heights[node as usize]);
        }
    }
    made
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec2;
    use std::sync::Arc;

    /// A grid of square cells of two facets each, with a height for each cell.
    fn grid(n: u32, height: impl Fn(u32) -> f64) -> FractureSurface {
        let nodes =
            (0..=n).flat_map(|j| (0..=n).map(move |i| DVec2::new(f64::from(i), f64::from(j))));
        let (mut facets, mut cells, mut heights) = (Vec::new(), Vec::new(), Vec::new());
        for j in 0..n {
            for i in 0..n {
                let [a, b] = [j * (n + 1) + i, (j + 1) * (n + 1) + i];
                facets.extend([[a, a + 1, b + 1], [a, b + 1, b]]);
                cells.extend([j * n + i; 2]);
                heights.extend([[height(j * n + i); 3]; 2]);
            }
        }
        FractureSurface {
            layout: Arc::new(SectionLayout::new(nodes.collect(), facets, cells)),
            heights,
        }
    }

    #[test]
    fn levelled_cells_have_no_walls_between_them_and_others_stay() {
        let rough = |cell: u32| f64::from(cell * 7919 % 13);
        let surface = grid(9, rough);
        let mut cells = BTreeSet::from([40]);
        grow(&surface.layout, &mut cells);
        assert_eq!(
            cells.iter().copied().collect::<Vec<_>>(),
            [31, 39, 40, 41, 49]
        );
        grow(&surface.layout, &mut cells);
        let level = levelled(&surface, &cells);
        let mut walls = [0.0f64; 2];
        for (e, edge) in surface.layout.edges.iter().enumerate() {
            let [(f, i), (g, j)] = edge.facets;
            if f == NONE || g == NONE {
                continue;
            }
            let both = [f, g]
                .iter()
                .all(|f| cells.contains(&surface.layout.cells[*f as usize]));
            for (kind, of) in [&surface, &level].into_iter().enumerate() {
                let ([a, b], [c, d]) = (of.side_heights(f, i), of.side_heights(g, j));
                if both {
                    walls[kind] = walls[kind].max((a - c).abs()).max((b - d).abs());
                } else if kind == 1 && !cells.contains(&surface.layout.cells[f as usize]) {
                    assert_eq!(of.heights[f as usize], surface.heights[f as usize], "{e}");
                }
            }
        }
        assert!(walls[0] > 5.0);
        assert_eq!(walls[1], 0.0);
        let (low, high) = level.range();
        assert!(low >= 0.0 && high <= 12.0);
    }
}
