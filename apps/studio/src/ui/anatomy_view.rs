//! What the section browser shows and holds.

use super::section_picture::Lie;
use crate::model::rings::PithPart;
use crate::model::section_book::{SectionBook, SectionRings};
use eframe::egui::{Rect, TextureHandle, Vec2};
use std::sync::Arc;

/// The section browser.
#[derive(Default)]
pub struct AnatomyView {
    /// Whether it is open.
    pub open: bool,
    /// The sections, with a number that tells books apart, or why there are none.
    pub(super) book: Option<Result<(u64, Arc<SectionBook>), String>>,
    /// The section that is shown; none for that of the break.
    pub(super) at: Option<usize>,
    /// The rings of the section that was drawn last.
    pub(super) rings: Option<(u64, usize, Arc<SectionRings>)>,
    /// The picture of a board's section, with what it shows.
    pub(super) board: Option<(u64, usize, Vec<f64>, TextureHandle)>,
    /// The ring that is held, and the edges of all rings before.
    pub(super) held: Option<(usize, Vec<f64>)>,
    /// Whether the pith or the onset is held.
    pub(super) pith_held: Option<PithPart>,
    /// Edges that were dragged, until an answer has them.
    pub(super) edges: Option<Vec<f64>>,
    /// How near the section is, and by how much it is shifted, points.
    pub(super) near: Option<(f32, Vec2)>,
    /// The ring over which the pointer was, from 0.
    pub(super) over: Option<usize>,
    /// Where the section's picture was drawn.
    pub(super) lie: Option<(Rect, Lie)>,
    /// Whether the pointer holds the section on the stem.
    pub(super) holds_section: bool,
}
