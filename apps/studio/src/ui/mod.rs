//! The window: state, panels and dialogs.

mod acting;
mod actions;
pub mod anatomy;
mod answers;
mod breaks;
mod charts;
mod cracks;
mod dialog;
mod dialogs;
mod file_dialog;
mod gallery;
mod handles;
mod menu;
mod parameters;
mod photograph;
mod photograph_view;
mod pictures;
mod section_line;
mod section_picture;
mod simulation;
mod simulation_panel;
mod simulation_view;
mod status;
pub mod studio;
mod viewport;
