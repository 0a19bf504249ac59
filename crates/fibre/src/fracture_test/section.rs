//! The cross-section of a specimen as rods: their cells, and the facets between them.

use super::specimen::{FractureTest, FractureTestKind, RodArrangement};
use crate::placement::{VoronoiCell, poisson_disk, voronoi_cells};
use glam::DVec2;
use greenstick_geometry::{Cancelled, Context};

/// Lloyd iterations of scattered rods, as in scenes.
const LLOYD_ITERATIONS: usize = 3;
/// Facets narrower than this fraction of the distance of their rods get no bond.
const MIN_RELATIVE_WIDTH: f64 = 1e-3;

/// Layers of a notched beam become thicker by this factor from one to the next, up to the distance of rods; at the crack they have
/// this part of it.
const LAYER_GROWTH: f64 = 1.5;
const THINNEST_LAYER: f64 = 4.0;

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
            RodArrangement::Layers => Ok(TestSection::layers(test, &arm_layers(test))),
            RodArrangement::Scattered => TestSection::scattered(test, context),
        }
    }

    /// Layers as high as those of an arm, given from the plane on, in a slice as wide as the last is high. As nothing changes across
    /// the width, one rod of each is enough.
    fn layers(test: &FractureTest, arm: &[f64]) -> Self {
        let width = arm.last().copied().unwrap_or(test.arm());
        let mut bottom = -test.arm();
        let mut rod = |&height: &f64| {
            let position = DVec2::Y * (bottom + 0.5 * height);
            bottom += height;
            SectionRod {
                position,
                area: width * height,
            }
        };
        let rods: Vec<SectionRod> = arm.iter().rev().chain(arm).map(&mut rod).collect();
        let facet = |below: usize| SectionFacet {
            rods: [below, below + 1],
            width,
        };
        TestSection {
            facets: (0..rods.len() - 1).map(facet).collect(),
            rods,
            width,
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

/// Returns the heights of the layers of an arm, from the crack's plane on, m. The halves of a notched beam turn against each other
/// by some degrees, which bonds between rods far apart take for sliding: there layers are thin.
fn arm_layers(test: &FractureTest) -> Vec<f64> {
    let arm = test.arm();
    if test.kind != FractureTestKind::SingleEdgeNotchedBeam {
        let count = (arm / test.spacing).round().max(1.0);
        return vec![arm / count; count as usize];
    }
    let (mut layers, mut sum) = (Vec::new(), 0.0);
    let mut height = test.spacing / THINNEST_LAYER;
    while sum < arm * (1.0 - 1e-9) {
        layers.push(height);
        sum += height;
        height = (LAYER_GROWTH * height).min(test.spacing);
    }
    layers.iter_mut().for_each(|h| *h *= arm / sum);
    layers
}
