//! What the handles of fans hold.

use crate::model::fan::{Fan, FanKind, FanPart};

/// A part that the pointer holds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct HeldFan {
    pub(super) part: FanPart,
    /// The fan when it was taken hold of.
    pub(super) before: Fan,
    /// Where the pointer was then: its angle, degrees, ring coordinate, and height, m.
    pub(super) from: FanGrip,
}

/// Where the pointer is about the stem. Who looks along it sees no height.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct FanGrip {
    pub(super) angle: f64,
    pub(super) rho: f64,
    pub(super) height: Option<f64>,
}

/// The handles of fans.
#[derive(Debug, Default)]
pub struct FanTool {
    /// The fan that has the handles; none where the plane of the break has them.
    pub kind: Option<FanKind>,
    pub(super) held: Option<HeldFan>,
}
