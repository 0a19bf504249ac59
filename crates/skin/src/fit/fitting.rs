//! The stages of a fit: the break that is fitted, its face at a location of the stem, and the relief of that face.

use super::breaks::{AddressSpace, AddressedBreak, MainBreak, mean_edge_length};
use super::face_shape::{FaceShape, Observations};
use super::parameters::FittedValue;
use super::report::{FitReport, HeightSummary};
use crate::rods::{FractureState, Wood};
use glam::DVec3;
use greenstick_fracture::parameters::{BreakParameters, SurfaceStyle};
use greenstick_schema::{Parameters, Value};
use greenstick_wood::stem::{Stem, StemLocation};

/// Least and greatest factor on the relief: what is farther off is not for the relief to make up.
const RELIEF_FACTOR: [f64; 2] = [0.25, 4.0];
/// Bisections of the range of the factor.
const BISECTIONS: usize = 10;
/// Fractions of a stem's length are rounded to one over this.
const FRACTION_STEPS: f64 = 1e4;

/// A break of a bundle of rods that is to be fitted.
///
/// The break is fitted in three steps: find where it is along the stem ([`BreakFit::location`]), fit a face
/// to it there ([`BreakFit::face`]), and match the relief of that face ([`FaceFit::match_relief`]).
pub struct BreakFit<'a> {
    wood: &'a Wood<'a>,
    found: MainBreak,
    /// Mean length of the edges of rods, m.
    edge: f64,
    neighbours: Vec<[usize; 2]>,
    seed: u64,
}

/// A face fitted to a break at a location of the stem.
pub struct FaceFit {
    shape: FaceShape,
    report: FitReport,
}

impl<'a> BreakFit<'a> {
    /// Chooses the break in which most of the section broke; `None` where no rod is broken. `seed` becomes that of the
    /// fitted parameters.
    pub fn new(wood: &'a Wood<'a>, state: &FractureState, seed: u64) -> Option<Self> {
        let found = MainBreak::find(wood, state);
        if found.broken.is_empty() {
            return None;
        }
        Some(BreakFit {
            wood,
            edge: mean_edge_length(wood),
            neighbours: found.neighbours(wood),
            found,
            seed,
        })
    }

    /// The length along the axis of the run's stem, m, at which the middle layer of the break lies.
    fn length_along(&self) -> f64 {
        let stem = self.wood.stem;
        let (shape, _) = self.shape(&self.space(stem, &|p| stem.grain.to_grain(p)));
        stem.location + shape.level * stem.radius
    }

    /// Returns where on the run's stem that is: a point of the axis, or a fraction of the length.
    pub fn location(&self, by_point: bool) -> StemLocation {
        let (stem, along) = (self.wood.stem, self.length_along());
        if by_point {
            return StemLocation::Point(stem.grain.axis().frame(along).origin);
        }
        let fraction = (along / stem.length * FRACTION_STEPS).round() / FRACTION_STEPS;
        StemLocation::Fraction(fraction.clamp(0.0, 1.0))
    }

    /// Fits a face to the break at `location`, where the stem is `stem`; `to_grain` leads from the world to the stem's grain
    /// coordinates, m.
    pub fn face(
        &self,
        location: &StemLocation,
        stem: &Stem,
        to_grain: &dyn Fn(DVec3) -> DVec3,
    ) -> FaceFit {
        let space = self.space(stem, to_grain);
        let (shape, breaks) = self.shape(&space);
        let mut report = FitReport::new(self.wood, &breaks, &shape, stem, location);
        // Whole wood is drawn too, flat.
        let section = space.address(&self.found.section());
        report.relief_m = HeightSummary::new(&section, stem.radius).spread;
        report.edge_m = self.edge;
        report.breaks_again = self.found.repeated;
        report.breaks_elsewhere = self.found.elsewhere;
        FaceFit { shape, report }
    }

    fn space<'b>(
        &'b self,
        stem: &'b Stem,
        to_grain: &'b dyn Fn(DVec3) -> DVec3,
    ) -> AddressSpace<'b> {
        AddressSpace {
            stem,
            outline: self.wood.outline,
            to_grain,
        }
    }

    /// The shape of the face in a section, and the addresses of the breaks.
    fn shape(&self, space: &AddressSpace) -> (FaceShape, Vec<AddressedBreak>) {
        let breaks = space.address(&self.found.broken);
        let section = space.address(&self.found.section());
        let shape = FaceShape::new(&Observations {
            breaks: &breaks,
            section: &section,
            neighbours: &self.neighbours,
            edge: self.edge / space.stem.radius,
            seed: self.seed,
        });
        (shape, breaks)
    }
}

impl FaceFit {
    /// Scales the relief until the drawn face is as high as the simulated one from the 5th to the 95th percentile, as far
    /// as it may be scaled. `relief_range` returns that height (m) of a face with given parameters.
    ///
    /// # Errors
    /// Those of `relief_range`.
    pub fn match_relief<E>(
        &mut self,
        mut relief_range: impl FnMut(&BreakParameters) -> Result<f64, E>,
    ) -> Result<(), E> {
        let fitted = &mut self.shape.parameters;
        let fibrous = fitted.face.surface == SurfaceStyle::Fibrous;
        let scaled: Vec<FittedValue> = fitted
            .values
            .iter()
            .filter(|v| match fibrous {
                true => v.key == "slab_height" || v.key == "sliver_height",
                false => v.key.ends_with("perlin_amplitude"),
            })
            .cloned()
            .collect();
        if !scaled.is_empty() && self.shape.has_relief {
            let [mut low, mut high] = RELIEF_FACTOR;
            for _ in 0..BISECTIONS {
                let middle = 0.5 * (low + high);
                let face = with_scaled(&fitted.face, &scaled, middle);
                if relief_range(&face)? < self.report.relief_m {
                    low = middle;
                } else {
                    high = middle;
                }
            }
            let factor = 0.5 * (low + high);
            for v in scaled {
                let basis = format!(
                    "{}, × {factor:.3} for the height of the whole face",
                    v.basis
                );
                fitted.set(v.key.clone(), v.value * factor, v.breaks, basis);
            }
        }
        self.report.face_m = relief_range(&fitted.face)?;
        Ok(())
    }

    /// The fitted parameters, and a report on them.
    pub fn finish(self) -> (BreakParameters, FitReport) {
        let (mut fitted, mut report) = (self.shape.parameters, self.report);
        fitted.leave_others();
        report.values = fitted.values;
        report.unfitted = fitted.unfitted;
        (fitted.face, report)
    }
}

/// A face whose values `scaled` are multiplied by a factor, as far as their ranges allow.
fn with_scaled(face: &BreakParameters, scaled: &[FittedValue], factor: f64) -> BreakParameters {
    let mut face = face.clone();
    let table = BreakParameters::table();
    for v in scaled {
        let most = table.iter().find(|p| p.key == v.key);
        let most = most.and_then(|p| p.max()).unwrap_or(f64::INFINITY);
        // A number in its range is never refused.
        let _ = face.set(&v.key, &Value::Number((v.value * factor).min(most)));
    }
    face
}
