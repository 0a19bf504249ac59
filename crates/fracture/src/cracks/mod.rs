//! Cracks of drying wood (Yang 2019 §4) as grooves in a height field.
//!
//! [`plan`] draws the cracks, [`grooves`] sinks them into a break surface and [`end_grooves`] into a sawn end. Cutting
//! along the result gives grooves with two walls that meet at their bottom, in a mesh that is closed by construction.
//!
//! With the corrected formulas the strain of the wood beside a radial crack is
//! ε = ε_T·w·u·z, with w = 1 in the middle of the crack's course and 0 at its ends, u = (σ − d)/σ at the distance d
//! from the crack along the ring, and z = 1 at the face and 0 at the crack's bottom. What the wood lost has opened the
//! crack: its opening is the integral of the strain over the range on both sides,
//! ∫ ε dd from −σ to σ = ε_T·σ·w·z, where σ is the arc at that ring (ring radius × angle). For a tangential crack it is
//! ε_R·σ·w·z with σ a part of the radius. As z falls evenly, the section of a groove is a V. Its bottom follows half an
//! ellipse from end to end, the front of a crack that runs in from a face: depth = D·√(w(2 − w)).

mod end_face;
mod error;
mod groove;
pub mod measure;
mod plan;
mod profile;
mod refine;

pub use end_face::EndFace;
pub use error::CrackError;
pub use groove::{CrackSite, Direction, GroovedSurface, end_grooves, grooves};
pub use plan::{CrackPlan, PlannedCrack, plan};
pub use profile::{relative_depth, relative_opening};
