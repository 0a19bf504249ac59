//! The bending moment that a section bears until its first fibre breaks in tension: section analysis of wood that is linear in
//! tension and yields in compression, while plane sections stay plane.
//!
//! The section is of rods or solid. A few rods differ from solid wood in two ways. A rod is counted to break when its surface
//! does, which lies where a round rod of its area reaches and not at the face; and its stress is that of its axis, to which its
//! own bending adds a part that does not yield. [`tension_factor`] is what makes up for both.

use super::voronoi::VoronoiCell;
use glam::DVec2;
use greenstick_wood::stem::StemKind;
use std::f64::consts::{PI, TAU};

/// Fibres that share their strain, in a section that is bent.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Element {
    /// Where they are, m.
    pub position: DVec2,
    /// Area, m².
    pub area: f64,
    /// How far their surface lies from there, m.
    pub radius: f64,
    /// Modulus along the grain, Pa.
    pub modulus: f64,
    /// Tensile strength, Pa.
    pub tension: f64,
    /// Crushing strength, Pa.
    pub compression: f64,
}

impl Element {
    /// Returns the radius of a round rod, m.
    pub fn rod_radius(area: f64) -> f64 {
        (area / PI).sqrt()
    }

    /// Returns the stress (Pa) under a strain.
    fn stress(&self, strain: f64) -> f64 {
        (self.modulus * strain).max(-self.compression)
    }

    /// Returns the strain on the element's surface over that at which it breaks, at a height (m) above the neutral axis.
    fn demand(&self, curvature: f64, height: f64) -> f64 {
        curvature * (height + self.radius) * self.modulus / self.tension
    }

    /// Returns the second moment of area about the element's own axis, m⁴.
    fn inertia(&self) -> f64 {
        0.25 * self.area * self.radius * self.radius
    }
}

/// Directions in which a section without faces is bent.
const DIRECTIONS: usize = 8;
/// Slices of a solid section.
const SLICES: usize = 256;
/// Relative width at which a search for a root ends, and the most steps it takes.
const ROOT_TOLERANCE: f64 = 1e-13;
const MAX_ROOT_STEPS: usize = 100;
/// Limits of [`tension_factor`]; wood whose tables fit together stays far within them.
const TENSION_FACTORS: (f64, f64) = (1.0 / 64.0, 64.0);

/// Returns the directions of bending whose mean counts: for a board those across its faces, as in the tests from which tables
/// are made; for others, all around.
pub(super) fn bending_directions(kind: StemKind, outline: &[DVec2]) -> Vec<DVec2> {
    let edges = (0..outline.len()).map(|i| outline[(i + 1) % outline.len()] - outline[i]);
    let longest = edges.max_by(|a, b| a.length_squared().total_cmp(&b.length_squared()));
    let face = longest.unwrap_or(DVec2::X).normalize_or(DVec2::X);
    let (first, count) = match kind {
        StemKind::Board => (face, 4),
        _ => (DVec2::X, DIRECTIONS),
    };
    let turned = |k| DVec2::from_angle(TAU * k as f64 / count as f64).rotate(first);
    (0..count).map(turned).collect()
}

/// Returns the moment (N m) at which the first rod breaks in tension on its surface, the mean over the directions of bending.
#[cfg(test)]
pub(super) fn moment_capacity(elements: &[Element], directions: &[DVec2]) -> f64 {
    mean(directions, |d| Bent::new(elements, d).capacity(1.0))
}

fn mean(directions: &[DVec2], value: impl Fn(DVec2) -> f64) -> f64 {
    directions.iter().map(|&d| value(d)).sum::<f64>() / directions.len() as f64
}

/// Returns the factor of all tensile strengths with which rods bear a moment (N m), the mean over the directions of bending.
pub(super) fn tension_factor(elements: &[Element], directions: &[DVec2], moment: f64) -> f64 {
    let bent: Vec<Bent> = directions.iter().map(|&d| Bent::new(elements, d)).collect();
    let excess = |factor: f64| {
        let sum: f64 = bent.iter().map(|b| b.capacity(factor)).sum();
        sum / bent.len() as f64 - moment
    };
    let (mut low, mut high) = (1.0, 1.0);
    while low > TENSION_FACTORS.0 && excess(low) > 0.0 {
        low *= 0.5;
    }
    while high < TENSION_FACTORS.1 && excess(high) < 0.0 {
        high *= 2.0;
    }
    root(excess, low, high)
}

/// Returns how near each rod of a section that is bent towards `direction` is to breaking when the first one breaks: its
/// demand over the largest, 0 in compression.
pub(crate) fn relative_demands(elements: &[Element], direction: DVec2) -> Vec<f64> {
    let bent = Bent::new(elements, direction);
    let curvature = bent.curvature_at_break(1.0);
    let axis = bent.neutral_axis(curvature);
    let largest = bent.demand(curvature, axis);
    let relative = |(e, y): (&Element, f64)| e.demand(curvature, y - axis).max(0.0) / largest;
    bent.pairs().map(relative).collect()
}

/// Returns the moments that a section bears when it is bent towards `direction`, with all tensile strengths multiplied by a
/// factor, over the one that it bears without.
pub(crate) fn relative_capacities(
    elements: &[Element],
    direction: DVec2,
    factors: impl Iterator<Item = f64>,
) -> Vec<f64> {
    let bent = Bent::new(elements, direction);
    let own = bent.capacity(1.0);
    factors.map(|factor| bent.capacity(factor) / own).collect()
}

/// Wood that is the same everywhere.
#[derive(Debug, Clone, Copy)]
pub(super) struct EvenWood {
    /// Modulus along the grain, Pa.
    pub modulus: f64,
    /// Tensile strength, Pa.
    pub tension: f64,
    /// Crushing strength, Pa.
    pub compression: f64,
}

/// Returns the moment (N m) at which a solid section of even wood breaks in tension at its face, the mean over the directions
/// of bending. The section consists of cells, each with the part of its area that is wood.
pub(super) fn solid_moment_capacity(
    cells: &[(&VoronoiCell, f64)],
    directions: &[DVec2],
    wood: EvenWood,
) -> f64 {
    mean(directions, |direction| {
        let slices = slices(cells, direction, wood);
        Bent::new(&slices, direction).capacity(1.0)
    })
}

/// Divides a section into slices across a direction. Each has the area of what is nearer to it than to the next, and both
/// faces are slices without area.
fn slices(cells: &[(&VoronoiCell, f64)], direction: DVec2, wood: EvenWood) -> Vec<Element> {
    let corners = cells.iter().flat_map(|(cell, _)| &cell.corners);
    let (low, high) = range(corners.map(|corner| corner.dot(direction)));
    let step = (high - low) / (SLICES - 1) as f64;
    let mut areas = [0.0; SLICES];
    let mut add = |height: f64, area: f64| {
        let place = ((height - low) / step).clamp(0.0, (SLICES - 1) as f64);
        let slice = (place as usize).min(SLICES - 2);
        let upper = place - slice as f64;
        areas[slice] += area * (1.0 - upper);
        areas[slice + 1] += area * upper;
    };
    for &(cell, part) in cells {
        let reach = (cell.corners.iter()).fold(0.0, |r: f64, c| r.max(c.distance(cell.centroid)));
        let divisions = (reach / step).ceil().clamp(1.0, 16.0) as u32;
        for (point, weight) in cell.samples(|_| divisions) {
            add(point.dot(direction), cell.area * part * weight);
        }
    }
    let slice = |(k, &area): (usize, &f64)| Element {
        position: direction * (low + step * k as f64),
        area,
        radius: 0.0,
        modulus: wood.modulus,
        tension: wood.tension,
        compression: wood.compression,
    };
    areas.iter().enumerate().map(slice).collect()
}

/// Returns the least and the greatest of values.
fn range(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| {
        (low.min(v), high.max(v))
    })
}

/// Returns where a function that changes its sign once is zero, by the Illinois variant of regula falsi (Dowell and Jarratt,
/// *BIT* 11, 1971).
fn root(f: impl Fn(f64) -> f64, mut a: f64, mut b: f64) -> f64 {
    let (mut at_a, mut at_b) = (f(a), f(b));
    for _ in 0..MAX_ROOT_STEPS {
        if at_a == 0.0 || at_a.signum() == at_b.signum() {
            return a;
        }
        if at_b == 0.0 || (b - a).abs() <= ROOT_TOLERANCE * b.abs().max(a.abs()) {
            return b;
        }
        let c = b - at_b * (b - a) / (at_b - at_a);
        let at_c = f(c);
        if at_c.signum() == at_b.signum() {
            at_a *= 0.5;
        } else {
            (a, at_a) = (b, at_b);
        }
        (b, at_b) = (c, at_c);
    }
    b
}

/// A section bent about one axis: per element its height towards the side in tension.
struct Bent<'a> {
    elements: &'a [Element],
    heights: Vec<f64>,
    low: f64,
    high: f64,
}

impl<'a> Bent<'a> {
    fn new(elements: &'a [Element], direction: DVec2) -> Self {
        let heights: Vec<f64> = elements.iter().map(|e| e.position.dot(direction)).collect();
        let (low, high) = range(heights.iter().copied());
        Bent {
            elements,
            heights,
            low,
            high,
        }
    }

    fn pairs(&self) -> impl Iterator<Item = (&Element, f64)> {
        self.elements.iter().zip(self.heights.iter().copied())
    }

    /// Returns the height of the neutral axis at a curvature (1/m), m.
    fn neutral_axis(&self, curvature: f64) -> f64 {
        let force = |axis: f64| -> f64 {
            self.pairs()
                .map(|(e, y)| e.area * e.stress(curvature * (y - axis)))
                .sum()
        };
        // Below the upper end all is in compression: a section that has yielded throughout has it there.
        root(force, self.low, self.high)
    }

    /// Returns the largest demand: strain on an element's surface over that at which it breaks.
    fn demand(&self, curvature: f64, axis: f64) -> f64 {
        self.pairs()
            .fold(0.0, |most, (e, y)| most.max(e.demand(curvature, y - axis)))
    }

    /// Returns the curvature at the first break, 1/m, with tensile strengths multiplied by a factor.
    fn curvature_at_break(&self, tension_factor: f64) -> f64 {
        let excess =
            |curvature: f64| self.demand(curvature, self.neutral_axis(curvature)) - tension_factor;
        // At this curvature nothing breaks: no fibre is farther from the axis than the section is high.
        let reach = (self.high - self.low)
            + (self.elements.iter()).fold(f64::MIN_POSITIVE, |r, e| r.max(e.radius));
        let weakest =
            (self.elements.iter()).fold(f64::INFINITY, |m: f64, e| m.min(e.tension / e.modulus));
        let mut low = tension_factor * weakest / reach;
        let mut high = 2.0 * low;
        while excess(high) < 0.0 && high.is_finite() {
            (low, high) = (high, 2.0 * high);
        }
        root(excess, low, high)
    }

    /// Returns the moment at the first break, N m, with tensile strengths multiplied by a factor.
    fn capacity(&self, tension_factor: f64) -> f64 {
        let curvature = self.curvature_at_break(tension_factor);
        let axis = self.neutral_axis(curvature);
        self.pairs()
            .map(|(e, y)| {
                let stress = e.stress(curvature * (y - axis));
                e.area * stress * (y - axis) + e.modulus * e.inertia() * curvature
            })
            .sum()
    }
}

#[cfg(test)]
mod tests {
    use super::super::voronoi::cells_of_points;
    use super::*;
    use greenstick_geometry::Context;
    use greenstick_wood::species::nominal_bending_strength;

    const WOOD: EvenWood = EvenWood {
        modulus: 12e9,
        tension: 100e6,
        compression: 50e6,
    };

    /// A square of some cells, and its rods.
    fn square(side: f64, count: u32) -> Vec<VoronoiCell> {
        let half = 0.5 * side;
        let outline = [(-half, -half), (half, -half), (half, half), (-half, half)];
        let outline = outline.map(|(x, y)| DVec2::new(x, y));
        let at = |k: u32| side * ((f64::from(k) + 0.5) / f64::from(count) - 0.5);
        let points: Vec<DVec2> = (0..count * count)
            .map(|k| DVec2::new(at(k % count), at(k / count)))
            .collect();
        cells_of_points(&outline, &points, &Context::quiet()).unwrap()
    }

    fn rods(cells: &[VoronoiCell], wood: EvenWood) -> Vec<Element> {
        let rod = |cell: &VoronoiCell| Element {
            position: cell.centroid,
            area: cell.area,
            radius: Element::rod_radius(cell.area),
            modulus: wood.modulus,
            tension: wood.tension,
            compression: wood.compression,
        };
        cells.iter().map(rod).collect()
    }

    fn with_tension(rods: &[Element], factor: f64) -> Vec<Element> {
        let scaled = |e: &Element| Element {
            tension: factor * e.tension,
            ..*e
        };
        rods.iter().map(scaled).collect()
    }

    #[test]
    fn a_rectangle_bears_what_section_analysis_says() {
        let side = 0.04;
        let cells = square(side, 5);
        let whole: Vec<(&VoronoiCell, f64)> = cells.iter().map(|c| (c, 1.0)).collect();
        for (tension, compression) in [(60e6, 60e6), (100e6, 50e6), (150e6, 30e6)] {
            let wood = EvenWood {
                tension,
                compression,
                ..WOOD
            };
            let slices = slices(&whole, DVec2::Y, wood);
            let bent = Bent::new(&slices, DVec2::Y).capacity(1.0);
            let exact = nominal_bending_strength(tension, compression) * side.powi(3) / 6.0;
            assert!(
                (bent / exact - 1.0).abs() < 2e-3,
                "{tension}: {}",
                bent / exact
            );
        }
    }

    #[test]
    fn few_rods_bear_the_moment_of_solid_wood_with_the_factor_and_many_hardly_need_it() {
        let faces = [DVec2::X, DVec2::Y, -DVec2::X, -DVec2::Y];
        for (tension, compression) in [(60e6, 60e6), (100e6, 50e6), (200e6, 30e6)] {
            let wood = EvenWood {
                tension,
                compression,
                ..WOOD
            };
            let factors = [4, 24].map(|count| {
                let cells = square(0.05, count);
                let whole: Vec<(&VoronoiCell, f64)> = cells.iter().map(|c| (c, 1.0)).collect();
                let solid = solid_moment_capacity(&whole, &faces, wood);
                let rods = rods(&cells, wood);
                let factor = tension_factor(&rods, &faces, solid);
                let stronger = with_tension(&rods, factor);
                let bears = moment_capacity(&stronger, &faces);
                assert!(
                    (bears / solid - 1.0).abs() < 1e-9,
                    "{count}: {}",
                    bears / solid
                );
                factor
            });
            // 24 by 24 rods are nearly solid, 4 by 4 of wood that yields much are not.
            assert!((factors[1] - 1.0).abs() < 0.03, "{factors:?}");
            assert!(
                tension < 4.0 * compression || factors[0] < 0.7,
                "{factors:?}"
            );
        }
    }

    #[test]
    fn a_board_is_bent_across_its_faces() {
        let turned = DVec2::from_angle(0.3);
        let corners = [(-2.0, -1.0), (2.0, -1.0), (2.0, 1.0), (-2.0, 1.0)];
        let outline = corners.map(|(x, y)| turned.rotate(DVec2::new(x, y)));
        let directions = bending_directions(StemKind::Board, &outline);
        assert_eq!(directions.len(), 4);
        for d in directions {
            let along = d.dot(turned).abs();
            assert!(along < 1e-12 || (along - 1.0).abs() < 1e-12, "{d}");
        }
    }

    #[test]
    fn strength_scales_the_moment() {
        let ring = |k: usize, factor: f64| Element {
            position: DVec2::from_angle(k as f64) * (0.3 + 0.01 * k as f64),
            area: 1e-3,
            radius: Element::rod_radius(1e-3),
            modulus: 10e9 * (1.0 + 0.02 * k as f64),
            tension: factor * 90e6,
            compression: factor * 40e6,
        };
        let [one, two] = [1.0, 2.0].map(|f| {
            let elements: Vec<Element> = (0..40).map(|k| ring(k, f)).collect();
            moment_capacity(&elements, &[DVec2::X, DVec2::Y])
        });
        assert!((two / one - 2.0).abs() < 1e-9, "{}", two / one);
    }
}
