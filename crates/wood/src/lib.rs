//! Wood: the stem and the address of a point in it, species with their measured properties,
//! moisture and tissue.
#![deny(missing_docs)]

pub mod appearance;
pub mod moisture;
pub mod noise;
pub mod primitive;
pub mod species;
mod bark;
pub mod stem;
pub mod tissue;
