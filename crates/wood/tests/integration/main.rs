//! Stems, rings and boards against annotated and analytic ones.

mod anatomy;
mod board_elements;
mod boards;
mod grain;
mod looks;
mod mensuration;
mod refused_stems;
mod rings;
mod stem;
mod support;
