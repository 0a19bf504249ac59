//! The window: state, panels and dialogs.

mod acting;
mod actions;
mod breaks;
mod dialog;
mod dialogs;
mod file_dialog;
mod gallery;
mod handles;
mod menu;
mod parameters;
mod pictures;
mod status;
pub mod studio;
mod viewport;
