//! Thorns of a smooth face: slender hexahedra with irregular triangular pyramids on them (Yang 2019 §3.5).
//!
//! A thorn stands on a whole cell of the grid, and its sides run along the grain. It stays below the skin, so that it
//! never pierces the bark: where the stem tapers or bends away it ends earlier, and where the cell is bark there is none.

use crate::height_model::{HeightModel, Thorn, purpose};
use crate::layout::{FibreBundles, InnerEdge};
use crate::surface::{NONE, SectionLayout};
use glam::DVec2;
use greenstick_wood::noise;
use std::borrow::Cow;
use std::ops::Range;

/// Length of the shortest thorn that is made, radii.
const MIN_LENGTH: f64 = 1e-3;
/// Most nodes of a cell.
const CORNERS: usize = 4;

/// A smooth face with its thorns.
pub(crate) struct ThornedFace<'a> {
    /// Height of every node of the layout, then of every corner of every thorn, radii.
    pub heights: Vec<f64>,
    /// Node that each of the thorns' corners lies over.
    pub nodes: Vec<u32>,
    /// For each facet the heights of its corners.
    pub corners: Cow<'a, [[u32; 3]]>,
    /// The thorns.
    pub thorns: Vec<Thorn>,
}

/// The cell that a thorn stands on.
struct Cell {
    facets: Range<usize>,
    nodes: [u32; CORNERS],
    count: usize,
}

impl Cell {
    fn new(layout: &SectionLayout, facets: Range<usize>) -> Self {
        let mut cell = Cell {
            nodes: [NONE; CORNERS],
            count: 0,
            facets,
        };
        for &node in layout.facets[cell.facets.clone()].iter().flatten() {
            if !cell.nodes().contains(&node) && cell.count < CORNERS {
                cell.nodes[cell.count] = node;
                cell.count += 1;
            }
        }
        cell
    }

    fn nodes(&self) -> &[u32] {
        &self.nodes[..self.count]
    }

    fn middle(&self, layout: &SectionLayout) -> DVec2 {
        let nodes = self.nodes().iter().map(|&n| layout.nodes[n as usize]);
        nodes.sum::<DVec2>() / self.count as f64
    }
}

/// Lets thorns stand on a face whose nodes have the heights `base`, radii.
pub(crate) fn add_thorns<'a>(
    bundles: &'a FibreBundles,
    model: &HeightModel,
    base: Vec<f64>,
) -> ThornedFace<'a> {
    let layout = &*bundles.layout;
    let mut face = ThornedFace {
        heights: base,
        nodes: Vec::new(),
        corners: Cow::Borrowed(&layout.facets),
        thorns: Vec::new(),
    };
    if !model.has_thorns() {
        return face;
    }
    let mut facets = 0..0;
    for run in layout.cells.chunk_by(|a, b| a == b) {
        facets = facets.end..facets.end + run.len();
        let cell = Cell::new(layout, facets.clone());
        face.add(bundles, model, run[0], &cell);
    }
    face.keep_manifold(layout);
    face
}

impl ThornedFace<'_> {
    /// Draws the thorn of a bundle and lets it stand on the bundle's cell.
    fn add(&mut self, bundles: &FibreBundles, model: &HeightModel, number: u32, cell: &Cell) {
        let bundle = &bundles.bundles[number as usize];
        let proportions = model.p.proportions();
        let zone = proportions.zone_at(bundle.rho, 1.0 / f64::from(model.p.rings));
        let key = i64::from(number);
        let length = model.thorn(
            bundle.rho,
            bundle.phi,
            zone,
            |purpose, length, probability| model.drawn_thorn(key, purpose, length, probability),
        );
        // Beyond the bark the surface runs on, but no thorn stands there.
        let edges = cell
            .nodes()
            .iter()
            .map(|&n| bundles.addresses[n as usize].0);
        let edge = edges.fold(0.0, f64::max);
        if length < MIN_LENGTH || edge > 1.0 {
            return;
        }
        let feet = cell.nodes().iter().map(|&n| self.heights[n as usize]);
        let (lowest, sum) = feet.fold((f64::INFINITY, 0.0), |(l, s), h| (h.min(l), s + h));
        let foot = sum / cell.count as f64;
        let site = model.site;
        // The highest end below the skin.
        let highest = match &bundles.skin {
            None => f64::INFINITY,
            Some(skin) => {
                let edge = InnerEdge {
                    rho: edge,
                    phi: bundle.phi,
                    half_width: bundle.half_width,
                };
                let end = skin.covered_up_to(&edge, site.place + lowest * site.radius);
                end.map_or(foot, |end| (end - site.place) / site.radius)
            }
        };
        let end = highest.min(foot + length);
        let length = end - foot;
        if length < MIN_LENGTH {
            return;
        }
        // A quadrangle is split from its first to its third corner: over one of the others stands the pyramid's tip.
        let tip = noise::unit(model.seed(purpose::SHAFT), key, 0, 0);
        let tip = match cell.count {
            CORNERS => 1 + 2 * usize::from(tip < 0.5),
            count => ((tip * count as f64) as usize).min(count - 1),
        };
        let first = self.heights.len() as u32;
        for (k, &node) in cell.nodes().iter().enumerate() {
            // Thorns side by side that the skin ends have one height there, to the last bit: a wall of an ulp between them would
            // have no room for the levels that it is split at.
            let height = if k == tip {
                end
            } else {
                foot + model.p.thorn_shaft * length
            };
            // A thorn on a slope covers its cell, to the last bit.
            let height = height.max(self.heights[node as usize]);
            self.heights.push(height);
            self.nodes.push(node);
        }
        for corner in self.corners.to_mut()[cell.facets.clone()]
            .iter_mut()
            .flatten()
        {
            let k = cell.nodes().iter().position(|n| n == corner);
            *corner = k.map_or(*corner, |k| first + k as u32);
        }
        self.thorns.push(Thorn {
            bundle: number,
            length: length * site.radius,
        });
    }

    /// Lowers corners of thorns where two that touch in one node alone would make an edge of four faces there: around a
    /// node, heights fall from the highest to both sides.
    fn keep_manifold(&mut self, layout: &SectionLayout) {
        let mut thorns_at = vec![0u8; layout.nodes.len()];
        for &n in &self.nodes {
            thorns_at[n as usize] = thorns_at[n as usize].saturating_add(1);
        }
        // Corners about such nodes: node, angle of the cell seen from it, number of the height.
        let mut around: Vec<(u32, f64, u32)> = Vec::new();
        let mut facets = 0..0;
        for run in layout.cells.chunk_by(|a, b| a == b) {
            facets = facets.end..facets.end + run.len();
            let nodes = &layout.facets[facets.clone()];
            if nodes.iter().flatten().all(|&n| thorns_at[n as usize] < 2) {
                continue;
            }
            let cell = Cell::new(layout, facets.clone());
            let middle = cell.middle(layout);
            for &node in cell.nodes() {
                if thorns_at[node as usize] > 1 {
                    let away = middle - layout.nodes[node as usize];
                    let at = nodes.iter().flatten().position(|&n| n == node);
                    let heights = self.corners[facets.clone()].iter().flatten();
                    let height = at.and_then(|at| heights.copied().nth(at)).unwrap_or(node);
                    around.push((node, libm::atan2(away.y, away.x), height));
                }
            }
        }
        around.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
        for cells in around.chunk_by(|a, b| a.0 == b.0) {
            self.fall_to_both_sides(cells);
        }
    }

    /// Lowers the heights of the `cells` about a node, which follow each other around it, to fall from the highest.
    fn fall_to_both_sides(&mut self, cells: &[(u32, f64, u32)]) {
        let heights: Vec<f64> = cells.iter().map(|c| self.heights[c.2 as usize]).collect();
        let count = heights.len();
        let Some(top) = (0..count).max_by(|&a, &b| heights[a].total_cmp(&heights[b])) else {
            return;
        };
        let mut lowered = vec![f64::NEG_INFINITY; count];
        for step in [1, count - 1] {
            let (mut at, mut least) = (top, f64::INFINITY);
            for _ in 0..count {
                least = least.min(heights[at]);
                lowered[at] = lowered[at].max(least);
                at = (at + step) % count;
            }
        }
        for (cell, height) in cells.iter().zip(lowered) {
            self.heights[cell.2 as usize] = height;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::height_model::BreakSite;
    use crate::layout::{self, LayoutOptions};
    use crate::parameters::BreakParameters;
    use greenstick_wood::rings::RingField;

    fn grid(rings: usize, sectors: usize) -> FibreBundles {
        let circle: Vec<DVec2> = (0..64)
            .map(|i| DVec2::from_angle(f64::from(i) * std::f64::consts::TAU / 64.0) * 0.01)
            .collect();
        let field = RingField::from_outline(&circle, DVec2::ZERO).unwrap();
        let options = LayoutOptions {
            rings,
            sectors,
            reach: (0.0, 1.0),
            radius: 0.0101,
            arc: None,
            bark: None,
            bark_below: Vec::new(),
            ring_edges: Vec::new(),
            seed: 0,
        };
        layout::smooth(&field, &options)
    }

    fn site() -> BreakSite {
        BreakSite {
            radius: 0.01,
            place: 0.1,
            usable: (0.0, 0.2),
            pith: DVec2::ZERO,
            wedge: None,
            relief: 1.0,
        }
    }

    fn parameters(probability: f64) -> BreakParameters {
        let mut p = BreakParameters {
            rings: 20,
            sectors: 30,
            ..BreakParameters::default()
        };
        (p.brittle.thorn_length, p.ductile.thorn_length) = (2.0, 2.0);
        p.brittle.thorn_probability = probability;
        p.ductile.thorn_probability = probability;
        p
    }

    /// Eq. 8: P of the cells carry a thorn, of lengths even between 0 and L.
    #[test]
    fn thorns_are_as_many_and_as_long_as_equation_8_says() {
        let (bundles, site, p) = (grid(20, 30), site(), parameters(0.3));
        let model = HeightModel::new(&p, &site);
        let base = vec![0.0; bundles.layout.nodes.len()];
        let face = add_thorns(&bundles, &model, base);
        let expected = 0.3 * 600.0;
        let count = face.thorns.len() as f64;
        assert!(
            (count - expected).abs() < 3.0 * (expected * 0.7f64).sqrt(),
            "{count}"
        );
        let mean = face.thorns.iter().map(|t| t.length).sum::<f64>() / count;
        assert!(
            (mean - 0.01).abs() < 3.0 * 0.02 / (12.0 * count).sqrt(),
            "{mean}"
        );
    }

    #[test]
    fn a_thorn_is_a_hexahedron_with_a_triangular_pyramid() {
        let (bundles, site, p) = (grid(20, 30), site(), parameters(0.01));
        let model = HeightModel::new(&p, &site);
        let base = vec![0.0; bundles.layout.nodes.len()];
        let nodes = base.len();
        let face = add_thorns(&bundles, &model, base);
        assert!(!face.thorns.is_empty());
        for thorn in &face.thorns {
            let length = thorn.length / site.radius;
            let (shaft, mut tips) = (p.thorn_shaft * length, 0);
            for (facet, &cell) in face.corners.iter().zip(&bundles.layout.cells) {
                if cell == thorn.bundle {
                    let heights = facet.map(|i| face.heights[i as usize]);
                    let at = |h: f64| heights.iter().filter(|x| (*x - h).abs() < 1e-12).count();
                    assert_eq!(at(length) + at(shaft), 3, "{heights:?}");
                    tips += at(length);
                    assert!(facet.iter().all(|&i| i as usize >= nodes));
                }
            }
            assert_eq!(tips, 1, "one facet of the two rises to the tip");
        }
    }

    /// However dense thorns are, of the cells about a node those above any height follow each other.
    #[test]
    fn dense_thorns_meet_in_no_edge_of_four_faces() {
        let (bundles, site, p) = (grid(20, 30), site(), parameters(0.6));
        let model = HeightModel::new(&p, &site);
        let layout = &bundles.layout;
        let face = add_thorns(&bundles, &model, vec![0.0; layout.nodes.len()]);
        let mut around: Vec<Vec<(f64, f64)>> = vec![Vec::new(); layout.nodes.len()];
        for (f, (nodes, corners)) in layout.facets.iter().zip(face.corners.iter()).enumerate() {
            let middle = nodes
                .iter()
                .map(|&n| layout.nodes[n as usize])
                .sum::<DVec2>()
                / 3.0;
            for (&n, &h) in nodes.iter().zip(corners) {
                let away = middle - layout.nodes[n as usize];
                around[n as usize].push((away.to_angle(), face.heights[h as usize]));
            }
            assert!(f < layout.facets.len());
        }
        for list in &mut around {
            list.sort_by(|a, b| a.0.total_cmp(&b.0));
            let heights: Vec<f64> = list.iter().map(|c| c.1).collect();
            for level in &heights {
                let above = |k: usize| heights[k % heights.len()] > *level;
                let rises = (0..heights.len())
                    .filter(|&k| !above(k) && above(k + 1))
                    .count();
                assert!(rises <= 1, "{heights:?}");
            }
        }
    }
}
