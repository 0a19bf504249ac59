//! The window: state, panels and dialogs.

pub mod actions;
mod dialogs;
mod file_dialog;
mod gallery;
mod menu;
mod parameters;
mod status;
pub mod studio;
mod viewport;
