//! The cross-section of a specimen as rods: their cells, and the facets between them.

use super::specimen::{FractureTest, RodArrangement};
use crate::placement::{VoronoiCell, poisson_disk, voronoi_cells};
use glam::DVec2;
use greenstick_geometry::{Cancelled, Context};

/// Lloyd iterations of scattered rods, as in scenes.
const LLOYD_ITERATIONS: usize = 3;
/// Facets narrower than this fraction of the distance of their rods get no bond.
const MIN_RELATIVE_WIDTH: f64 = 1e-3;

/// A rod of the section.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct SectionRod {
    /// Position across the width and above the middle plane, m.
    pub position: DVec2,
    /// Area of its cell, m².
    pub area: f64,
}

/// A facet between two rods.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct SectionFacet {
    pub rods: [usize; 2],
    /// Width in the section, m.
    pub width: f64,
}

/// The section of a specimen, or of the slice of it that is tested.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct TestSection {
    pub rods: Vec<SectionRod>,
    pub facets: Vec<SectionFacet>,
    /// Width of what is tested, m.
    pub width: f64,
}

impl TestSection {
    pub fn new(test: &FractureTest, context: &Context) -> Result<Self, Cancelled> {
        match test.arrangement {
            RodArrangement::Layers => Ok(TestSection::layers(test)),
            RodArrangement::Scattered => TestSection::scattered(test, context),
        }
    }

    /// Layers of square cells. As nothing changes across the width, one rod of each is enough.
    fn layers(test: &FractureTest) -> Self {
        let count = 2 * (test.arm() / test.spacing).round().max(1.0) as usize;
        let side = test.height / count as f64;
        let rod = |layer: usize| SectionRod {
            position: DVec2::Y * ((layer as f64 + 0.5) * side - test.arm()),
            area: side * side,
        };
        let facet = |below: usize| SectionFacet {
            rods: [below, below + 1],
            width: side,
        };
        TestSection {
            rods: (0..count).map(rod).collect(),
            facets: (0..count - 1).map(facet).collect(),
            width: side,
        }
    }

    fn scattered(test: &FractureTest, context: &Context) -> Result<Self, Cancelled> {
        let corner = DVec2::new(0.5 * test.width, test.arm());
        let signs = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
        let outline = signs.map(|sign| corner * DVec2::from_array(sign));
        let mut points = poisson_disk(&outline, test.spacing, test.seed, context)?;
        for _ in 0..LLOYD_ITERATIONS {
            context.check()?;
            let cells = voronoi_cells(&outline, &points);
            points = cells.iter().map(|c| c.centroid).collect();
        }
        let cells = voronoi_cells(&outline, &points);
        let rod = |cell: &VoronoiCell| SectionRod {
            position: cell.centroid,
            area: cell.area,
        };
        let facets = cells.iter().enumerate().flat_map(|(number, cell)| {
            let pair = move |f: &crate::placement::Facet| SectionFacet {
                rods: [number, f.neighbour as usize],
                width: f.width,
            };
            cell.facets.iter().map(pair)
        });
        let is_bonded = |f: &SectionFacet| {
            let [a, b] = f.rods.map(|r| cells[r].centroid);
            f.rods[0] < f.rods[1] && f.width >= MIN_RELATIVE_WIDTH * a.distance(b)
        };
        Ok(TestSection {
            rods: cells.iter().map(rod).collect(),
            facets: facets.filter(is_bonded).collect(),
            width: test.width,
        })
    }

    /// Returns the rods above or below the middle plane.
    pub fn arm(&self, above: bool) -> Vec<usize> {
        let rods = 0..self.rods.len();
        rods.filter(|&r| (self.rods[r].position.y > 0.0) == above)
            .collect()
    }

    /// Whether a facet between two rods is part of the crack's plane.
    pub fn is_crossed(&self, [a, b]: [usize; 2]) -> bool {
        (self.rods[a].position.y > 0.0) != (self.rods[b].position.y > 0.0)
    }

    /// Returns the area of the facets along which the crack runs over that of its plane.
    pub fn roughness(&self) -> f64 {
        let crossed = self.facets.iter().filter(|f| self.is_crossed(f.rods));
        crossed.map(|f| f.width).sum::<f64>() / self.width
    }
}
