//! The program, run as a user would.

mod anatomy;
mod bending;
mod breaking;
mod cracks;
mod provenance;
mod rings;
mod scanning;
mod simulated_breaks;
mod skin;
mod strange_files;
mod support;
mod sweeping;
mod toughness;
mod wrong_requests;
