//! What a run records: frames, tables and checkpoints, as bytes through `io` traits. Nothing here opens a file: a run is
//! recorded by a [`RunSink`] and read from a [`RunSource`], such as a [`MemoryRun`].
//!
//! # Frames
//! All numbers are little-endian. It begins with the 8 bytes `GSFRAMES`, a `u32` version and a `u32` 0. Then each
//! frame is one record: the `u64` length of its content, the content, and the `u64` [`checksum`] of the content. Bytes behind
//! the last complete record are ignored. Content: `f64` time (s), `u64`
//! step, `u32` rods R, `u32` vertices V, `u32` bonds B, `u32` bodies K, then
//! - R + 1 × `u32`: first vertex of each rod; R × `u32`: its rod in the unbroken bundle; R × `f32`: diameter (m);
//! - V × `u32`: vertex of the unbroken bundle; V × 3 `f32`: position (m); V × 3 `f32`: material director of the edge that
//!   begins there (unit);
//! - B × 2 `u32`: vertex and edge that a bond connects;
//! - K × 7 `f64`: centre (m) and orientation (x, y, z, w) of each body.
//!
//! # Tables
//! `energy.csv`, `events.csv` and `forces.csv` have one row a line ([`EnergyRow`], [`event_line`], [`ForceRow`]). Numbers are
//! the shortest decimals that give the same `f64` back.

mod checkpoint;
mod checksum;
mod error;
mod files;
mod forces;
mod frames;
mod index;
mod memory;
mod parse;
mod record;
mod tables;

pub use checkpoint::{Checkpoint, Progress, RecordLengths};
pub use checksum::checksum;
pub use error::{RunError, StoreError};
pub use files::{CHECKPOINT_FILE, Record, SCENE_FILE};
pub use forces::ForceRow;
pub use frames::{BodyPose, Frame};
pub use index::IndexedFrames;
pub use memory::MemoryRun;
pub use parse::{parse_energies, parse_events, parse_forces};
pub use record::{FrameTimes, RunSink, RunSource, RunStore};
pub use tables::{EnergyLedger, EnergyRow, event_line, stagger_velocities};
pub(crate) use tables::{cause_name, kind_name};
