//! What tells one stem from another, whatever place on it is asked for.

use super::surface::Surface;
use super::trace::Trace;
use crate::noise;
use glam::DVec3;
use greenstick_geometry::{Cancelled, Context, Unions};
use std::f64::consts::TAU;

/// Steps between a size and its double in which sizes count as equal: each is between a two hundredth and a four hundredth of
/// the size. Coarser than what rounding to other units and formats, or a search for the end of a stem, moves a size by;
/// finer than two stems that grew are alike.
const STEPS_PER_DOUBLING: f64 = 211.0;
/// Where the edge between two steps lies, in steps. No multiple of a simple fraction: sizes that people draw are such
/// multiples, and rounding would throw one on an edge to either side.
const STEP_EDGE: f64 = 0.381_966_011;
/// Triangles between two checks for cancellation.
const CHECK_INTERVAL: usize = 1 << 12;

/// What tells a stem from others: the same for every place on it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StemIdentity {
    /// Length from end to end, m; of a limb, that of the stem that it grows on.
    pub length: f64,
    /// Mean girth, m; of a limb, that of the stem that it grows on.
    pub girth: f64,
    /// Number of the connected part of the model that it is, or grows on.
    pub shell: usize,
    /// The first triangle of the limb and of what grows on it; none for the stem that runs along the whole part.
    pub limb: Option<u32>,
}

impl StemIdentity {
    /// Returns a hash of the shell's and the limb's numbers and of length and girth, which are rounded to steps of at most half
    /// a percent.
    ///
    /// ```
    /// use greenstick_wood::stem::StemIdentity;
    ///
    /// let pole = StemIdentity { length: 2.0, girth: 0.3, shell: 0, limb: None };
    /// let rounded = StemIdentity { length: 2.0 - 1e-9, ..pole };
    /// let longer = StemIdentity { length: 2.02, ..pole };
    /// assert_eq!(pole.hash(), rounded.hash());
    /// assert_ne!(pole.hash(), longer.hash());
    /// ```
    pub fn hash(&self) -> u64 {
        let limb = self.limb.map_or(-1, i64::from);
        let number = noise::hash(0, self.shell as i64, limb, 0);
        noise::hash(number, step(self.length), step(self.girth), 1)
    }
}

/// The number of the step that a size (above 0) lies in. Takes the number apart instead of its logarithm, which differs
/// from machine to machine.
fn step(size: f64) -> i64 {
    const FRACTION_BITS: u32 = 52;
    let bits = size.to_bits();
    let doublings = (bits >> FRACTION_BITS) as i64;
    let fraction = bits & ((1 << FRACTION_BITS) - 1);
    let part = 1.0 + fraction as f64 / (1u64 << FRACTION_BITS) as f64;
    let within = (part * STEPS_PER_DOUBLING + STEP_EDGE) as i64;
    let steps = STEPS_PER_DOUBLING as i64;
    // The last step of a doubling is the first of the next.
    if within >= 2 * steps {
        (doublings + 1) * steps
    } else {
        doublings * steps + within - steps
    }
}

/// Length and mean girth of a stem as it was followed, m.
pub(super) fn size_of_trace(trace: &Trace) -> (f64, f64) {
    let centres = trace.sections.iter().map(|s| s.centre);
    let mut length = 0.0;
    let mut last = trace.tips[0];
    for at in centres.chain([trace.tips[1]]) {
        length += last.distance(at);
        last = at;
    }
    let radius: f64 = trace.sections.iter().map(|s| s.radius).sum();
    (length, TAU * radius / trace.sections.len() as f64)
}

/// Returns the number of the limb at a point of a surface along which a stem runs that `covers` points of it: the first triangle of all that hangs
/// together with the point without being part of the main stem. It does not depend on where on the limb the point is.
///
/// # Errors
/// [`Cancelled`].
pub(super) fn limb_at(
    surface: &Surface,
    covers: impl Fn(DVec3) -> bool,
    point: DVec3,
    context: &Context,
) -> Result<Option<u32>, Cancelled> {
    let mut beside: Vec<usize> = Vec::new();
    for i in 0..surface.len() {
        if i % CHECK_INTERVAL == 0 {
            context.check()?;
        }
        if !covers(surface.corners(i).into_iter().sum::<DVec3>() / 3.0) {
            beside.push(i);
        }
    }
    let points = beside.iter().flat_map(|&i| surface.corner_points(i)).max();
    let mut sets = Unions::new(points.map_or(0, |m| m as usize + 1));
    for &i in &beside {
        let [a, b, c] = surface.corner_points(i);
        sets.join(a, b);
        sets.join(a, c);
    }
    let Some((triangle, _)) = surface.nearest(point) else {
        return Ok(None);
    };
    let at = beside
        .iter()
        .find(|&&i| surface.mesh_triangle(i) == triangle);
    let Some(root) = at.map(|&i| sets.root(surface.corner_points(i)[0])) else {
        return Ok(None);
    };
    let of_limb = beside
        .iter()
        .filter(|&&i| sets.root(surface.corner_points(i)[0]) == root);
    Ok(of_limb.map(|&i| surface.mesh_triangle(i)).min())
}
