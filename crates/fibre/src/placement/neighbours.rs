//! Which rods are bonded, and the width of the facet that each bond stands for.

use super::options::Neighbours;
use super::voronoi::{Facet, VoronoiCell};

/// Facets narrower than this fraction of the distance of their rods get no bond.
const MIN_RELATIVE_WIDTH: f64 = 1e-3;

/// Returns for each cell the facets to the rods that it is bonded to, none farther away than `reach` (m).
pub(super) fn bonded_facets(
    neighbours: Neighbours,
    cells: &[VoronoiCell],
    reach: f64,
) -> Vec<Vec<Facet>> {
    match neighbours {
        Neighbours::Facets => cells.iter().map(|c| own_facets(cells, c, reach)).collect(),
        Neighbours::WithinReach => within_reach(cells, reach),
    }
}

fn own_facets(cells: &[VoronoiCell], cell: &VoronoiCell, reach: f64) -> Vec<Facet> {
    let is_bonded = |facet: &&Facet| {
        let other = cells[facet.neighbour as usize].centroid;
        let distance = cell.centroid.distance(other);
        distance <= reach && facet.width >= MIN_RELATIVE_WIDTH * distance
    };
    cell.facets.iter().filter(is_bonded).copied().collect()
}

/// Bonds every pair of rods within reach. A pair has the mean of what each of its cells has for each of its bonds: the width
/// of all its facets divided by their number.
fn within_reach(cells: &[VoronoiCell], reach: f64) -> Vec<Vec<Facet>> {
    let mut by_x: Vec<usize> = (0..cells.len()).collect();
    by_x.sort_by(|&a, &b| cells[a].centroid.x.total_cmp(&cells[b].centroid.x));
    let mut bonded: Vec<Vec<u32>> = vec![Vec::new(); cells.len()];
    for (k, &a) in by_x.iter().enumerate() {
        let p = cells[a].centroid;
        for &b in &by_x[k + 1..] {
            let q = cells[b].centroid;
            if q.x - p.x > reach {
                break;
            }
            if p.distance(q) <= reach {
                bonded[a].push(b as u32);
                bonded[b].push(a as u32);
            }
        }
    }
    bonded.iter_mut().for_each(|list| list.sort_unstable());
    let share = |cell: usize| {
        let width: f64 = cells[cell].facets.iter().map(|f| f.width).sum();
        width / bonded[cell].len().max(1) as f64
    };
    let facets = |(cell, list): (usize, &Vec<u32>)| {
        let facet = |&neighbour: &u32| Facet {
            neighbour,
            width: 0.5 * (share(cell) + share(neighbour as usize)),
        };
        list.iter().map(facet).collect()
    };
    bonded.iter().enumerate().map(facets).collect()
}

#[cfg(test)]
mod tests {
    use super::super::voronoi::voronoi_cells;
    use super::*;
    use glam::DVec2;

    #[test]
    fn all_rods_within_reach_are_bonded_by_the_same_facets_in_all() {
        let square =
            [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, y)| DVec2::new(x, y));
        let points: Vec<DVec2> = (0..49)
            .map(|k| DVec2::new(f64::from(k % 7) - 3.0, f64::from(k / 7) - 3.0) * 0.28)
            .collect();
        let cells = voronoi_cells(&square, &points);
        // Cells of the middle are squares of 0.28: eight neighbours lie within 0.4, four of them beyond a corner.
        let all = bonded_facets(Neighbours::WithinReach, &cells, 0.41);
        assert_eq!(all[24].len(), 8);
        assert_eq!(bonded_facets(Neighbours::Facets, &cells, 0.41)[24].len(), 4);
        let total = |facets: &[Vec<Facet>]| facets.iter().flatten().map(|f| f.width).sum::<f64>();
        let own: f64 = cells.iter().flat_map(|c| &c.facets).map(|f| f.width).sum();
        assert!(
            (total(&all) / own - 1.0).abs() < 1e-9,
            "{}",
            total(&all) / own
        );
        for (cell, list) in all.iter().enumerate() {
            for facet in list {
                let back = &all[facet.neighbour as usize];
                assert!(
                    back.iter()
                        .any(|f| f.neighbour as usize == cell && f.width == facet.width)
                );
            }
        }
    }
}
