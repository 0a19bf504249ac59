//! Cuts and cracks of whole stems.

mod cracks;
mod cut;
mod faces;
mod layout;
