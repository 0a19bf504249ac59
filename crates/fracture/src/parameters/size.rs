//! What the size of a stem changes about its broken face. Wood of any size is made of the same fibres: slabs and slivers grow
//! more slowly than the stem, so a thick one has more of them, and slivers are shorter against its radius.

use super::{BreakParameters, SurfaceStyle};

/// Diameter of the stem that counts and heights stand for, m: that of the branch that they were matched on.
pub const REFERENCE_DIAMETER: f64 = 0.04;
/// Range of factors on that diameter within which faces change with size. Below it a sliver would be a single fibre; above
/// it the bundles of a layout are too wide to show more slivers.
const SIZE_RANGE: (f64, f64) = (1.0 / 16.0, 32.0);
/// Least and greatest number of slabs and of slivers that the size of a stem leads to: fewer make no splintered face, more
/// have no bundles of their own.
const SLABS: (f64, f64) = (4.0, 40.0);
const SLIVERS: (f64, f64) = (16.0, 600.0);
/// Least and greatest number of strips of bark, likewise.
const STRIPS: (f64, f64) = (6.0, 24.0);
/// The tallest tongues of bark that the size of a stem leads to, radii: those of a thin one would else be longer than its splinters.
const TALLEST_BARK: f64 = 1.2;
/// Greatest factor on rings and on sectors of a thick stem, so that its slivers have bundles to show: a face has twice the
/// triangles then. A twig keeps its own: what is seen from near shows them.
const MAX_FINER: f64 = 1.4;

impl BreakParameters {
    /// Returns the parameters of a face on a stem of `diameter` (m).
    ///
    /// Slivers are as many as the stem is thicker, so each is wider by the root of that, and bark tears into strips by the root
    /// more; slabs are as many as its fourth root. Slabs stand out as far against the radius, slivers and fibres by the fourth
    /// root less, bark and the steps of brittle and of crushed wood by the root less.
    ///
    /// ```
    /// use greenstick_fracture::parameters::BreakParameters;
    ///
    /// let p = BreakParameters::default();
    /// assert_eq!(p.at_size(0.04), p);
    /// let (twig, log) = (p.at_size(0.01), p.at_size(0.6));
    /// assert!(twig.sliver_count < p.sliver_count && p.sliver_count < log.sliver_count);
    /// // In metres splinters of a log are longer than those of a branch, but not in proportion.
    /// assert!(log.sliver_height < p.sliver_height && log.sliver_height * 0.6 > p.sliver_height * 0.04);
    /// ```
    pub fn at_size(&self, diameter: f64) -> BreakParameters {
        let size = (diameter / REFERENCE_DIAMETER).clamp(SIZE_RANGE.0, SIZE_RANGE.1);
        // The published face is one of ratios.
        if self.size_effect == 0.0 || self.surface == SurfaceStyle::Smooth || size.is_nan() {
            return self.clone();
        }
        let size = libm::pow(size, self.size_effect);
        let root = size.sqrt();
        let fourth = root.sqrt();
        let finer = |count: u32| {
            let factor = match self.spiral_angle {
                // Faces in spiral grain are bisected until they do not cross: a finer layout has more to bisect.
                0.0 => in_steps(fourth.sqrt(), 5.0).clamp(1.0, MAX_FINER),
                _ => 1.0,
            };
            (f64::from(count) * factor).round() as u32
        };
        let count = |count: u32, factor: f64, (least, most): (f64, f64)| {
            let given = f64::from(count);
            // Given counts beyond the limits stay.
            let wanted = (given * factor).clamp(least.min(given), most.max(given));
            wanted.round() as u32
        };
        BreakParameters {
            rings: finer(self.rings),
            sectors: finer(self.sectors),
            slab_count: count(self.slab_count, fourth, SLABS),
            sliver_count: count(self.sliver_count, size, SLIVERS),
            bark_strips: count(self.bark_strips, in_steps(root, 2.0), STRIPS),
            sliver_height: self.sliver_height / fourth,
            fibre_height: self.fibre_height / fourth,
            step_height: self.step_height / root,
            compression_height: self.compression_height / root,
            bark_offset: self.bark_offset / root,
            bark_height: (self.bark_height / root).min(self.bark_height.max(TALLEST_BARK)),
            ..self.clone()
        }
    }
}

/// Rounds a factor to steps, so many to 1. With every change of the number of strips or rings all of them move; along a stem
/// that tapers that must be rare.
fn in_steps(factor: f64, steps: f64) -> f64 {
    (steps * factor).round().max(1.0) / steps
}
