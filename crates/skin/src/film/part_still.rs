//! Moving the pieces of a still of rods apart, as those of a drawn break.

use super::error::FilmError;
use super::make_still::Still;
use super::run::Run;
use crate::finish::{Half, Parted, Separation, Way};
use crate::simulated::SimulatedFracture;
use glam::DVec3;
use greenstick_geometry::{Context, Node};

impl Run {
    /// Moves what lies beyond the break of frame `number` apart from the lower piece of a still at rest, with all that it carries.
    /// The report says where that is farther than asked for.
    ///
    /// # Errors
    /// [`FilmError`] where the frame cannot be read, or the caller cancelled.
    pub fn part(
        &self,
        still: &mut Still,
        number: usize,
        asked: Separation,
        context: &Context,
    ) -> Result<(), FilmError> {
        let nodes = &still.scene.nodes;
        let named = |name: &str| nodes.iter().position(|n| n.name == name);
        let (Some(lower), Some(upper)) = (named("lower"), named("upper")) else {
            return Ok(());
        };
        let fractures = SimulatedFracture::find(&self.wood(), &self.observed(number)?);
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for range in fractures.iter().filter(|f| f.parted).map(|f| f.range()) {
            (low, high) = (low.min(range.low), high.max(range.high));
        }
        let stem = self.stem();
        if low > high {
            (low, high) = (stem.location, stem.location);
        }
        let to_world = |p: DVec3| stem.grain.to_world(p);
        let way = Way::new(stem, (low, high), &to_world);
        let half = |node: &'_ Node| (node.mesh.clone(), node.transform);
        let [(below, at_rest), (above, moved)] = [lower, upper].map(|n| half(&nodes[n]));
        let half = |mesh, transform| Half {
            mesh,
            transform,
            inner: still.inner,
        };
        let halves = [&half(&below, at_rest), &half(&above, moved)];
        let parted = Parted::of(&way, asked, halves, context);
        context.check()?;
        let motion = way.after(parted.way);
        for (number, node) in still.scene.nodes.iter_mut().enumerate() {
            if number == upper || node.parent == Some(upper) {
                node.transform = motion * node.transform;
            }
        }
        still.report.parting = parted.note.map(|note| note.to_string());
        Ok(())
    }
}
