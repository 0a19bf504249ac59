//! A run as files: their names, and what the growing ones begin with.

use super::checkpoint::RecordLengths;
use super::forces::FORCE_HEADER;
use super::frames::frame_header;
use super::tables::{ENERGY_HEADER, EVENT_HEADER};

/// The scene as it was run.
pub const SCENE_FILE: &str = "scene.toml";
/// The last checkpoint.
pub const CHECKPOINT_FILE: &str = "checkpoint.bin";

/// What a run records in a file that only grows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Record {
    /// The energy table.
    Energies,
    /// What broke and yielded.
    Events,
    /// The frames.
    Frames,
    /// The forces of clamps and bodies.
    Forces,
}

impl Record {
    /// All of them; the index of each is its number.
    pub const ALL: [Record; 4] = [
        Record::Energies,
        Record::Events,
        Record::Frames,
        Record::Forces,
    ];

    /// Returns the name of its file.
    pub const fn file_name(self) -> &'static str {
        match self {
            Record::Energies => "energy.csv",
            Record::Events => "events.csv",
            Record::Frames => "frames.gsf",
            Record::Forces => "forces.csv",
        }
    }

    /// Returns what its file begins with.
    pub fn header(self) -> Vec<u8> {
        match self {
            Record::Energies => ENERGY_HEADER.into(),
            Record::Events => EVENT_HEADER.into(),
            Record::Frames => frame_header(),
            Record::Forces => FORCE_HEADER.into(),
        }
    }
}

impl RecordLengths {
    /// Returns the length of a record.
    pub fn of(&self, record: Record) -> u64 {
        match record {
            Record::Energies => self.energies,
            Record::Events => self.events,
            Record::Frames => self.frames,
            Record::Forces => self.forces,
        }
    }
}
