//! The mechanics of rods and bonds against what is known.

mod accuracy;
mod arcs;
mod bend_test;
mod bodies;
mod fracture_test;
mod mechanics;
mod modes;
mod motion;
mod parted;
mod scenes;
mod solvers;
mod specimens;
mod steered;
#[path = "../support/mod.rs"]
mod support;
mod torsion;
mod work;
