//! What a run leaves: frames, tables and checkpoints, as bytes in and out of `io` traits. Nothing here opens a file.
//!
//! # Frames
//! All numbers little-endian. The file begins with the 8 bytes `GSFRAMES`, a `u32` version and a `u32` 0. Then each
//! frame is one record: `u64` length of its content, the content, and the `u64` [`checksum`] of the content. A record is
//! there as a whole or not at all; what follows the last whole one is to be left alone. Content: `f64` time (s), `u64`
//! step, `u32` rods R, `u32` vertices V, `u32` bonds B, `u32` bodies K, then
//! - R + 1 × `u32`: first vertex of each rod; R × `u32`: its rod in the unbroken bundle; R × `f32`: diameter (m);
//! - V × `u32`: vertex of the unbroken bundle; V × 3 `f32`: place (m); V × 3 `f32`: material director of the edge that
//!   begins there (unit);
//! - B × 2 `u32`: vertex and edge that a bond joins;
//! - K × 7 `f64`: centre (m) and orientation (x, y, z, w) of each body.

mod checkpoint;
mod forces;
mod frames;
mod index;
mod tables;

pub use checkpoint::{Checkpoint, Progress};
pub use forces::{FORCE_HEADER, ForceRow};
pub use frames::{Frame, FrameReader, write_header};
pub use index::FrameFile;
pub use tables::{ENERGY_HEADER, EVENT_HEADER, EnergyRow, Ledger, event_row, set_back};

use std::io;

/// Why stored bytes cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    /// Bytes of something else.
    #[error("these are no {expected}: they begin with {found:?}")]
    Foreign {
        /// What they should be.
        expected: &'static str,
        /// The first bytes.
        found: String,
    },
    /// Written by a newer program, or one so old that it cannot be read.
    #[error(
        "the {what} is of version {found}, and this program reads version {known}; use the program that wrote it"
    )]
    Newer {
        /// What it is.
        what: &'static str,
        /// Its version.
        found: u32,
        /// The one known here.
        known: u32,
    },
    /// Changed or cut since it was written.
    #[error("the {what} is damaged: {problem}")]
    Damaged {
        /// What it is.
        what: &'static str,
        /// What does not fit.
        problem: String,
    },
    /// Reading or writing failed.
    #[error(transparent)]
    Io(#[from] io::Error),
}

/// 64 bits that change when the bytes do (FNV-1a over words of 8 bytes; the last one filled with zeros, then the length).
pub fn checksum(bytes: &[u8]) -> u64 {
    const PRIME: u64 = 0x0000_0100_0000_01b3;
    let mix = |h: u64, word: u64| {
        let h = (h ^ word).wrapping_mul(PRIME);
        // FNV alone carries nothing from high bits to low ones.
        h ^ (h >> 29)
    };
    let mut hash = 0xcbf2_9ce4_8422_2325;
    for chunk in bytes.chunks(8) {
        let mut word = [0; 8];
        word[..chunk.len()].copy_from_slice(chunk);
        hash = mix(hash, u64::from_le_bytes(word));
    }
    mix(hash, bytes.len() as u64)
}
