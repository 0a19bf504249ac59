//! The record `laszip encoded`, which describes how the points of a file are compressed.

use super::bytes::{u16_at, u32_at};
use super::extra::WAVE_PACKET_SIZE;
use super::point::POINT_SIZE;

/// Bytes before the list of items.
const HEADER_SIZE: usize = 34;
/// Bytes of a point of format 6.
const LAYERED_POINT_SIZE: usize = 30;
/// Bytes of an entry in the list of items.
const ENTRY_SIZE: usize = 6;

/// The kind of an item.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ItemKind {
    /// The fields of point format 0.
    Point,
    Time,
    Colour,
    WavePacket,
    Extra,
    /// The fields of point format 6.
    LayeredPoint,
    LayeredColour,
    /// Colour and near infrared.
    LayeredColourAndInfrared,
    LayeredWavePacket,
    LayeredExtra,
}

/// A part of each record.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Item {
    pub kind: ItemKind,
    /// Bytes in a record.
    pub size: usize,
    pub version: u16,
}

/// How points are distributed over the data.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Layout {
    /// All in one chunk.
    Single,
    /// In chunks of the same number of points.
    Chunks(u32),
    /// In chunks whose numbers of points are in the table of chunks.
    VariableChunks,
    /// In chunks of the same number of points, each with its fields in layers.
    LayeredChunks(u32),
    /// In chunks with their own number of points, each with its fields in layers.
    VariableLayeredChunks,
}

/// How points are compressed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(in crate::cloud) struct Description {
    pub(super) layout: Layout,
    pub(super) items: Vec<Item>,
}

/// Why a description cannot be used.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(in crate::cloud) struct Unusable {
    pub found: String,
    pub right: String,
}

fn unusable(found: impl Into<String>, right: impl Into<String>) -> Unusable {
    Unusable {
        found: found.into(),
        right: right.into(),
    }
}

impl Description {
    /// Reads the content of the record.
    pub fn read(content: &[u8], record_size: usize) -> Result<Self, Unusable> {
        if content.len() < HEADER_SIZE {
            let found = format!("{} bytes", content.len());
            return Err(unusable(found, format!("at least {HEADER_SIZE}")));
        }
        let count = usize::from(u16_at(content, HEADER_SIZE - 2));
        let entries = &content[HEADER_SIZE..];
        if entries.len() < count * ENTRY_SIZE {
            let found = format!("{count} items in {} bytes", content.len());
            return Err(unusable(found, format!("{ENTRY_SIZE} bytes per item")));
        }
        let items = entries
            .chunks_exact(ENTRY_SIZE)
            .take(count)
            .map(read_item)
            .collect::<Result<Vec<Item>, Unusable>>()?;
        let total: usize = items.iter().map(|item| item.size).sum();
        if items.is_empty() || total != record_size {
            let found = format!("items of {total} bytes");
            let right = format!("{record_size}, the size of a point in the header");
            return Err(unusable(found, right));
        }
        let layout = read_layout(content)?;
        if !matches!(items[0].kind, ItemKind::Point | ItemKind::LayeredPoint) {
            let right = "the fields of point format 0 or 6 first";
            return Err(unusable("no point as the first item", right));
        }
        let layered = matches!(
            layout,
            Layout::LayeredChunks(_) | Layout::VariableLayeredChunks
        );
        if items.iter().any(|item| item.is_layered() != layered) {
            let right = "items of one kind, in layers or not";
            return Err(unusable("items with and without layers", right));
        }
        Ok(Description { layout, items })
    }
}

fn read_layout(content: &[u8]) -> Result<Layout, Unusable> {
    let coder = u16_at(content, 2);
    if coder != 0 {
        let right = "0, the arithmetic coder";
        return Err(unusable(format!("coder {coder}"), right));
    }
    let variable = |size| size == 0 || size == u32::MAX;
    match (u16_at(content, 0), u32_at(content, 12)) {
        (1, _) => Ok(Layout::Single),
        (2, size) if variable(size) => Ok(Layout::VariableChunks),
        (2, size) => Ok(Layout::Chunks(size)),
        (3, size) if variable(size) => Ok(Layout::VariableLayeredChunks),
        (3, size) => Ok(Layout::LayeredChunks(size)),
        (other, _) => Err(unusable(format!("compressor {other}"), "1, 2 or 3")),
    }
}

fn read_item(entry: &[u8]) -> Result<Item, Unusable> {
    let [number, size, version] = [0, 2, 4].map(|at| u16_at(entry, at));
    let size = usize::from(size);
    let (kind, expected_size) = match number {
        0 => (ItemKind::Extra, size),
        6 => (ItemKind::Point, POINT_SIZE),
        7 => (ItemKind::Time, 8),
        8 => (ItemKind::Colour, 6),
        9 => (ItemKind::WavePacket, WAVE_PACKET_SIZE),
        10 => (ItemKind::LayeredPoint, LAYERED_POINT_SIZE),
        11 => (ItemKind::LayeredColour, 6),
        12 => (ItemKind::LayeredColourAndInfrared, 8),
        13 => (ItemKind::LayeredWavePacket, WAVE_PACKET_SIZE),
        14 => (ItemKind::LayeredExtra, size),
        _ => {
            let found = format!("an item of kind {number}");
            return Err(unusable(found, "one of point formats 0 to 10"));
        }
    };
    if size != expected_size {
        let found = format!("{size} bytes for an item of kind {number}");
        return Err(unusable(found, expected_size.to_string()));
    }
    let item = Item {
        kind,
        size,
        version,
    };
    let versions = if item.is_layered() { [3, 4] } else { [1, 2] };
    if !versions.contains(&version) {
        let found = format!("version {version} of an item of kind {number}");
        return Err(unusable(
            found,
            format!("{} or {}", versions[0], versions[1]),
        ));
    }
    Ok(item)
}

impl Item {
    /// Whether its fields are compressed in layers.
    fn is_layered(&self) -> bool {
        matches!(
            self.kind,
            ItemKind::LayeredPoint
                | ItemKind::LayeredColour
                | ItemKind::LayeredColourAndInfrared
                | ItemKind::LayeredWavePacket
                | ItemKind::LayeredExtra
        )
    }

    /// Number of layers.
    pub fn layers(&self) -> usize {
        match self.kind {
            ItemKind::LayeredPoint => 9,
            ItemKind::LayeredColour | ItemKind::LayeredWavePacket => 1,
            ItemKind::LayeredColourAndInfrared => 2,
            ItemKind::LayeredExtra => self.size,
            _ => 0,
        }
    }
}
