//! Where in the world wood broke.

use crate::event::{Event, EventKind};
use crate::store::Frame;
use glam::DVec3;

/// Returns the mean of the places (m) at which rods broke, and half of `diameters` diameters of the wood about it; `None` where
/// no rod broke. `first` is the first frame.
pub fn broken_region(first: &Frame, events: &[Event], diameters: f64) -> Option<(DVec3, f64)> {
    let breaks = events.iter().filter(|e| e.kind == EventKind::RodBroke);
    let places: Vec<_> = breaks.map(|e| e.position).collect();
    let sum: DVec3 = places.iter().sum();
    let square: f64 = first.diameter.iter().map(|&d| f64::from(d * d)).sum();
    let radius = 0.5 * diameters * square.sqrt();
    (!places.is_empty()).then(|| (sum / places.len() as f64, radius))
}
