//! What does not change with a break but is not needed for drawing one: measured when it is first asked for, then kept.

use super::PreparedStem;
use greenstick_geometry::repair::KnownPositions;
use greenstick_wood::appearance::EndSection;
use std::sync::OnceLock;

/// Measures of a stem that were asked for so far.
#[derive(Debug, Clone, Default)]
pub(super) struct Measured {
    ends: OnceLock<Vec<EndSection>>,
    closed_volume: OnceLock<(bool, Option<f64>)>,
    positions: OnceLock<KnownPositions>,
}

impl PreparedStem {
    /// Returns the sections at the ends of a round stem. An end is left out where the stem has none, or where it is so
    /// torn that no outline parallel to its face is closed.
    pub fn end_sections(&self) -> &[EndSection] {
        self.measured.ends.get_or_init(|| self.find_end_sections())
    }

    /// Returns whether the shell that is cut is closed, and the volume that it encloses if it is oriented too, m³.
    pub(crate) fn closed_volume(&self) -> (bool, Option<f64>) {
        *self.measured.closed_volume.get_or_init(|| {
            let shell = self.found.shell.iter().map(|&t| t as usize);
            let (closed, volume) = self.node().mesh.submesh(shell).closed_volume();
            (closed, volume.map(|v| v * self.volume_scale()))
        })
    }

    /// Returns the positions of the mesh that is cut, whose own faults breaks leave as they are.
    pub(crate) fn known_positions(&self) -> &KnownPositions {
        self.measured
            .positions
            .get_or_init(|| KnownPositions::from_mesh(&self.node().mesh))
    }
}
