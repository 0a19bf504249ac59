//! The window: state, panels and dialogs.

mod acting;
mod actions;
mod answers;
mod breaks;
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
mod status;
pub mod studio;
mod viewport;
