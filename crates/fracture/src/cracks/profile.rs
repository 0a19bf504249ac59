//! The profile of a crack along its course.

/// Returns the opening over the greatest opening at the same ring, at a fraction `t` (0 to 1) of the course: w of the
/// corrected Eqs. 13 and 21 of Yang 2019.
/// A crack whose end is open at the bark (`open`) is widest there.
///
/// ```
/// use greenstick_fracture::cracks::{relative_depth, relative_opening};
///
/// assert_eq!(relative_opening(0.5, false), 1.0);
/// assert_eq!(relative_opening(1.0, true), 1.0);
/// assert_eq!(relative_depth(1.0), 1.0);
/// ```
pub fn relative_opening(t: f64, open: bool) -> f64 {
    let t = t.clamp(0.0, 1.0);
    if open { t } else { 1.0 - (2.0 * t - 1.0).abs() }
}

/// Returns the depth over the greatest depth where the opening is `w` of the greatest: half an ellipse over the course.
pub fn relative_depth(w: f64) -> f64 {
    let w = w.clamp(0.0, 1.0);
    (w * (2.0 - w)).sqrt()
}
