//! Breaks over the frames of a film: when cracks open, which pieces separate, and the crack opening that a file of fixed
//! weights shows too early.

use super::error::FilmError;
use super::report::{GapeReport, SkinReport};
use super::run::Run;
use super::separation::SeparationTracker;
use crate::rods::{BreakHistory, CrackOpening, RodPart, RodSkin};
use greenstick_geometry::Context;
use std::ops::Range;

impl Run {
    /// Records what broke in which frame of a range.
    pub(super) fn break_history(
        &mut self,
        range: Range<usize>,
        context: &Context,
    ) -> Result<BreakHistory, FilmError> {
        let mut history = BreakHistory::new(&self.wood());
        let frames = range.len() as f64;
        for (done, number) in range.enumerate() {
            context.report(done as f64 / frames)?;
            let frame = self.frame(number)?;
            history.push_frame(&self.wood(), &frame, &self.causes)?;
        }
        Ok(history)
    }

    /// Tracks the pieces of `skin` through the frames, and the opening of its cracks before they break.
    pub(super) fn track_pieces(
        &mut self,
        skin: &RodSkin,
        range: Range<usize>,
        report: &mut SkinReport,
        context: &Context,
    ) -> Result<(), FilmError> {
        let edge = |parts: &Vec<(u32, RodPart)>| skin.joints.first_edge(parts[0].0, parts[0].1);
        let mut tracker = SeparationTracker::new(skin.parts.iter().map(edge).collect());
        let mut openings = vec![CrackOpening::default(); skin.pieces.len()];
        let frames = range.len() as f64;
        for (done, number) in range.enumerate() {
            context.report(done as f64 / frames)?;
            let frame = self.frame(number)?;
            tracker.push_frame(&frame);
            (skin.closed_cracks).measure(&skin.joints, done as u32, &frame, &mut openings);
        }
        let names: Vec<String> = report.pieces.iter().map(|p| p.name.clone()).collect();
        for (piece, separation) in report.pieces.iter_mut().zip(tracker.separations()) {
            piece.parted = separation.map(|s| (s.time, names[s.from].clone()));
        }
        for (piece, opening) in report.pieces.iter_mut().zip(&openings) {
            piece.gape_m = opening.distance;
        }
        let spacing = self.wood().spacing();
        let widest = (openings.iter()).max_by(|a, b| a.distance.total_cmp(&b.distance));
        report.gape = widest.filter(|g| g.distance > 0.0).map(|g| GapeReport {
            gape_m: g.distance,
            of_spacing: g.distance / spacing,
            time_s: g.time,
        });
        Ok(())
    }
}
