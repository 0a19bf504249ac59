//! Curves: what charts of runs and tests draw.

/// Points that belong together, in the order in which a chart connects them.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    /// What the curve is of.
    pub name: String,
    /// Its points: what the horizontal and what the vertical axis measures, in the units of the axes.
    pub points: Vec<[f64; 2]>,
}
