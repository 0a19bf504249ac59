//! What a film's frames tell of its breaks: when cracks open, which pieces part, and how far cracks gape before in a file
//! whose weights are fixed.

use super::error::FilmError;
use super::pieces::Following;
use super::report::{GapeReport, SkinReport};
use super::run::Run;
use crate::rods::{BreakHistory, CrackOpening, RodPart, RodSkin};
use greenstick_geometry::Context;
use std::ops::Range;

impl Run {
    /// What broke in which frame of a range.
    pub(super) fn history(
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

    /// Follows the pieces of `skin` through the frames, and how far its cracks gape before they open.
    pub(super) fn follow(
        &mut self,
        skin: &RodSkin,
        range: Range<usize>,
        report: &mut SkinReport,
        context: &Context,
    ) -> Result<(), FilmError> {
        let edge = |parts: &Vec<(u32, RodPart)>| skin.joints.first_edge(parts[0].0, parts[0].1);
        let mut following = Following::new(skin.parts.iter().map(edge).collect());
        let mut gapes = vec![CrackOpening::default(); skin.pieces.len()];
        let frames = range.len() as f64;
        for (done, number) in range.enumerate() {
            context.report(done as f64 / frames)?;
            let frame = self.frame(number)?;
            following.see(&frame);
            (skin.closed_cracks).measure(&skin.joints, done as u32, &frame, &mut gapes);
        }
        let names: Vec<String> = report.pieces.iter().map(|p| p.name.clone()).collect();
        for (piece, parted) in report.pieces.iter_mut().zip(following.parted()) {
            piece.parted = parted.map(|(time, from)| (time, names[from].clone()));
        }
        for (piece, gape) in report.pieces.iter_mut().zip(&gapes) {
            piece.gape_m = gape.distance;
        }
        let spacing = self.wood().spacing();
        let most = (gapes.iter()).max_by(|a, b| a.distance.total_cmp(&b.distance));
        report.gape = most.filter(|g| g.distance > 0.0).map(|g| GapeReport {
            gape_m: g.distance,
            of_spacing: g.distance / spacing,
            time_s: g.time,
        });
        Ok(())
    }
}
