//! Breaks, films and simulations from input to files.

mod board_rings;
mod chips;
mod cracks;
mod declared_stages;
mod dowel_rings;
mod drawn_films;
#[cfg(feature = "files")]
mod files;
mod films;
mod fit;
mod fraying;
mod hanging;
mod inside_out;
mod kinds;
mod leaning;
mod one_inside;
mod parting;
#[cfg(feature = "files")]
mod photographed_cracks;
mod random_breaks;
mod scan_poses;
mod scanned_cracks;
mod seams;
mod sessions;
mod simulate;
mod simulated_faces;
mod species_heights;
#[cfg(feature = "files")]
mod strands;
mod support;
mod triangle_budget;
mod twins;
mod whole_bark;
