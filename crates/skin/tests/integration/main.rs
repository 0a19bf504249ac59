//! The skin of simulated wood.

mod common;
mod over_time;
mod rods;
