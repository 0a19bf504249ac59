//! Which cell of a face a point belongs to.

use glam::DVec2;
use greenstick_fracture::surface::FractureSurface;

/// Distance within which a point on the border of a facet counts as lying in it, as part of the layout's extent.
const ON_BORDER: f64 = 1e-8;

/// Distances, as parts of that extent, and the number of directions in which wood is looked for beside a point over the face.
const NEAR: [f64; 3] = [0.001, 0.004, 0.012];
const DIRECTIONS: i32 = 8;

/// The facets of a surface by place.
pub(crate) struct FacetPlaces<'a> {
    surface: &'a FractureSurface,
    sign: f64,
    low: DVec2,
    size: usize,
    /// Width of a square of the grid, m.
    width: DVec2,
    starts: Vec<u32>,
    facets: Vec<u32>,
    border: f64,
    /// Height above which a point lies over the face, m.
    over: f64,
    extent: f64,
}

impl<'a> FacetPlaces<'a> {
    /// Sorts the facets of a surface into squares. Heights count `sign` times.
    pub fn new(surface: &'a FractureSurface, sign: f64) -> Self {
        let layout = surface.layout.as_ref();
        let none = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        let (low, high) = (layout.nodes.iter()).fold(none, |(l, h), &p| (l.min(p), h.max(p)));
        let extent = (high - low).max(DVec2::splat(f64::MIN_POSITIVE));
        let size = (layout.facets.len() as f64).sqrt().ceil().max(1.0) as usize;
        let mut places = FacetPlaces {
            surface,
            sign,
            low,
            size,
            width: extent / size as f64,
            starts: vec![0; size * size + 1],
            facets: Vec::new(),
            border: ON_BORDER * extent.max_element(),
            over: ON_BORDER * extent.max_element(),
            extent: extent.max_element(),
        };
        let mut pairs: Vec<(u32, u32)> = Vec::new();
        for (f, facet) in layout.facets.iter().enumerate() {
            let [a, b, c] = facet.map(|n| layout.nodes[n as usize]);
            let margin = DVec2::splat(places.border);
            let [i, j] = places.square(a.min(b).min(c) - margin);
            let [k, l] = places.square(a.max(b).max(c) + margin);
            for row in j..=l {
                pairs.extend((i..=k).map(|column| ((row * size + column) as u32, f as u32)));
            }
        }
        pairs.sort_unstable();
        for &(square, _) in &pairs {
            places.starts[square as usize + 1] += 1;
        }
        for i in 0..size * size {
            places.starts[i + 1] += places.starts[i];
        }
        places.facets = pairs.into_iter().map(|(_, f)| f).collect();
        places
    }

    fn square(&self, at: DVec2) -> [usize; 2] {
        let place = (at - self.low) / self.width;
        [place.x, place.y].map(|p| (p.max(0.0) as usize).min(self.size - 1))
    }

    /// Returns the cell that stands highest at a point, and its height there; `None` off the layout.
    pub fn highest(&self, at: DVec2) -> Option<(u32, f64)> {
        let [i, j] = self.square(at);
        let square = j * self.size + i;
        let (from, to) = (self.starts[square], self.starts[square + 1]);
        let layout = self.surface.layout.as_ref();
        let mut highest: Option<(u32, f64)> = None;
        for &f in &self.facets[from as usize..to as usize] {
            let corners = layout.facets[f as usize].map(|n| layout.nodes[n as usize]);
            let Some(weights) = self.weights(corners, at) else {
                continue;
            };
            let heights = self.surface.heights[f as usize];
            let height: f64 = (0..3).map(|k| self.sign * heights[k] * weights[k]).sum();
            if highest.is_none_or(|h| height > h.1) {
                highest = Some((layout.cells[f as usize], height));
            }
        }
        highest
    }

    /// Returns the cell of wood at a point and a height. Where that lies over the face, as on a straight edge of curved wood, it is
    /// that of the wood beside it that reaches as high, or highest.
    pub fn cell(&self, at: DVec2, height: f64) -> Option<u32> {
        let mut best = self.highest(at)?;
        if best.1 >= height - self.over {
            return Some(best.0);
        }
        for distance in NEAR {
            for direction in 0..DIRECTIONS {
                let turn = std::f64::consts::TAU * f64::from(direction) / f64::from(DIRECTIONS);
                let (sin, cos) = libm::sincos(turn);
                let beside = at + DVec2::new(cos, sin) * (distance * self.extent);
                if let Some(found) = self.highest(beside).filter(|found| found.1 > best.1) {
                    best = found;
                }
            }
            if best.1 >= height - self.over {
                break;
            }
        }
        Some(best.0)
    }

    /// Returns the weights of a facet's corners at a point in it.
    fn weights(&self, [a, b, c]: [DVec2; 3], at: DVec2) -> Option<[f64; 3]> {
        let twice = (b - a).perp_dot(c - a);
        let mut weights = [0.0; 3];
        for (weight, (p, q)) in weights.iter_mut().zip([(b, c), (c, a), (a, b)]) {
            let side = (q - p).perp_dot(at - p);
            if side < -self.border * p.distance(q) {
                return None;
            }
            *weight = side / twice;
        }
        (twice > 0.0).then_some(weights)
    }
}
