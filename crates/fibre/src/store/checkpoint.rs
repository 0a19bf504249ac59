//! Checkpoints: everything that a run needs to continue as if it had never stopped. The 8 bytes `GSPOINT\0`, a `u32`
//! version, a `u32` 0, the `u64` hash of what is simulated, the content (postcard), and its `u64` checksum.

use super::checksum::checksum;
use super::error::StoreError;
use super::tables::EnergyLedger;
use crate::bodies::BodiesState;
use crate::solvers::Buckling;
use crate::world::World;
use serde::{Deserialize, Serialize};

const MAGIC: &[u8; 8] = b"GSPOINT\0";
const VERSION: u32 = 6;
const HEAD: usize = 24;

/// Lengths of a run's records, in the unit of what holds them: bytes in files, rows in memory.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct RecordLengths {
    /// Of the energy table.
    pub energies: u64,
    /// Of the events.
    pub events: u64,
    /// Of the frames.
    pub frames: u64,
    /// Of the forces.
    pub forces: u64,
}

/// How far a run is, and what it has recorded.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Progress {
    /// Ticks completed.
    pub ticks: u64,
    /// The last tick that is to be in slow motion.
    pub slow_until: u64,
    /// Frames recorded.
    pub frames: u64,
    /// Events recorded.
    pub events: u64,
    /// Lengths of the records, which are cut back to them when the run is resumed.
    pub lengths: RecordLengths,
    /// Energy that solvers and loads have taken and given so far.
    pub ledger: EnergyLedger,
    /// Where the wood buckled, which ends the run.
    pub buckling: Option<Buckling>,
}

/// A run between two steps.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Checkpoint {
    /// The rods.
    pub world: World,
    /// The bodies.
    pub bodies: BodiesState,
    /// How far the run is.
    pub progress: Progress,
    /// Identifies what is simulated. It stands in the header of the bytes.
    #[serde(skip)]
    pub hash: u64,
}

impl Checkpoint {
    /// Returns the checkpoint as bytes.
    ///
    /// # Errors
    /// [`StoreError::Damaged`] where the state cannot be serialised.
    pub fn to_bytes(&self) -> Result<Vec<u8>, StoreError> {
        let content = postcard::to_stdvec(self).map_err(|e| damaged(e.to_string()))?;
        let mut bytes = Vec::with_capacity(content.len() + HEAD + 8);
        bytes.extend(MAGIC);
        bytes.extend(VERSION.to_le_bytes());
        bytes.extend([0; 4]);
        bytes.extend(self.hash.to_le_bytes());
        bytes.extend(&content);
        bytes.extend(checksum(&content).to_le_bytes());
        Ok(bytes)
    }

    /// Reads a checkpoint.
    ///
    /// # Errors
    /// [`StoreError`] for bytes that are no checkpoint, one of another version, or a damaged one.
    pub fn from_bytes(bytes: &[u8]) -> Result<Checkpoint, StoreError> {
        if !bytes.starts_with(MAGIC) {
            return Err(StoreError::Foreign {
                expected: "checkpoint of a simulation",
                found: String::from_utf8_lossy(&bytes[..bytes.len().min(8)]).into_owned(),
            });
        }
        let word = |at: usize| {
            bytes
                .get(at..at + 4)?
                .try_into()
                .ok()
                .map(u32::from_le_bytes)
        };
        match word(8) {
            Some(found) if found != VERSION => {
                return Err(StoreError::Newer {
                    what: "checkpoint",
                    found,
                    known: VERSION,
                });
            }
            Some(_) if bytes.len() >= HEAD + 8 => {}
            _ => return Err(damaged(format!("it ends after {} bytes", bytes.len()))),
        }
        let (content, sum) = bytes[HEAD..].split_at(bytes.len() - HEAD - 8);
        if sum != checksum(content).to_le_bytes() {
            return Err(damaged("its checksum is wrong".into()));
        }
        let mut hash = [0; 8];
        hash.copy_from_slice(&bytes[16..24]);
        let read: Checkpoint = postcard::from_bytes(content).map_err(|e| damaged(e.to_string()))?;
        Ok(Checkpoint {
            hash: u64::from_le_bytes(hash),
            ..read
        })
    }
}

fn damaged(problem: String) -> StoreError {
    StoreError::Damaged {
        what: "checkpoint",
        problem,
    }
}
