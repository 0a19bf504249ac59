//! Decompression of LAZ files (LASzip versions 1 to 4): M. Isenburg, *LASzip: lossless compression of LiDAR data*,
//! Photogrammetric Engineering & Remote Sensing 79(2), 2013, and the *LAZ Specification 1.4*, rapidlasso, 2021.
//!
//! Any bytes are decoded or refused: an error never depends on the compressor having been right.

mod bytes;
mod chunks;
mod coder;
mod colour;
mod description;
mod error;
mod extra;
mod integer;
mod layered;
mod median;
mod model;
mod point;
mod point_v1;
mod returns;
mod sequential;
#[cfg(test)]
mod tests;
mod time;

pub(super) use description::Description;
pub(super) use error::Damage;

use description::Layout;
use layered::LayeredChunk;
use sequential::SequentialChunk;

/// Bytes of the position of the table of chunks, before the first chunk.
const TABLE_POSITION_SIZE: usize = 8;

/// Compressed points.
pub(super) struct CompressedPoints<'a> {
    /// The whole file.
    pub data: &'a [u8],
    /// Where the points start.
    pub start: usize,
    pub count: u64,
    /// Bytes of a point.
    pub record_size: usize,
}

/// Why decompression stopped, and at which point, counted from 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Failure {
    pub point: u64,
    pub damage: Damage,
}

/// A chunk of either kind.
enum Chunk<'a> {
    Sequential(SequentialChunk<'a>),
    Layered(Box<LayeredChunk<'a>>),
}

impl Chunk<'_> {
    fn next(&mut self, record: &mut [u8]) -> Result<(), Damage> {
        match self {
            Chunk::Sequential(chunk) => chunk.next(record),
            Chunk::Layered(chunk) => chunk.next(record),
        }
    }

    fn end(&self) -> usize {
        match self {
            Chunk::Sequential(chunk) => chunk.end(),
            Chunk::Layered(chunk) => chunk.end(),
        }
    }
}

/// Decompresses points and passes the record of each to `emit`. Of point formats from 6 on, only coordinates, numbers of
/// returns, flags, classification and colour are decoded.
pub(super) fn decompress(
    points: &CompressedPoints,
    description: &Description,
    emit: &mut dyn FnMut(&[u8]),
) -> Result<(), Failure> {
    let mut emitted = 0;
    let outcome = decompress_all(points, description, &mut |record| {
        emitted += 1;
        emit(record);
    });
    outcome.map_err(|damage| Failure {
        point: emitted,
        damage,
    })
}

fn decompress_all(
    points: &CompressedPoints,
    description: &Description,
    emit: &mut dyn FnMut(&[u8]),
) -> Result<(), Damage> {
    let &CompressedPoints { data, start, .. } = points;
    let items = &description.items;
    let counts = match description.layout {
        Layout::VariableChunks => chunks::read_counts(data, start)?,
        _ => Vec::new(),
    };
    let mut counts = counts.iter();
    let mut position = match description.layout {
        Layout::Single => start,
        _ => start + TABLE_POSITION_SIZE,
    };
    let mut record = vec![0; points.record_size];
    let mut left = points.count;
    while left > 0 {
        let layered = matches!(
            description.layout,
            Layout::LayeredChunks(_) | Layout::VariableLayeredChunks
        );
        let mut chunk = if layered {
            let chunk = LayeredChunk::new(data, position, items, &mut record)?;
            Chunk::Layered(Box::new(chunk))
        } else {
            Chunk::Sequential(SequentialChunk::new(data, position, items, &mut record)?)
        };
        let in_chunk = match (description.layout, &chunk) {
            (Layout::Single, _) => left,
            (Layout::Chunks(count) | Layout::LayeredChunks(count), _) => u64::from(count),
            (_, Chunk::Layered(chunk)) => u64::from(chunk.count()),
            (_, Chunk::Sequential(_)) => u64::from(*counts.next().ok_or(Damage::Contradictory)?),
        };
        if in_chunk == 0 {
            return Err(Damage::Contradictory);
        }
        emit(&record);
        for _ in 1..in_chunk.min(left) {
            chunk.next(&mut record)?;
            emit(&record);
        }
        left -= in_chunk.min(left);
        position = chunk.end();
    }
    Ok(())
}
