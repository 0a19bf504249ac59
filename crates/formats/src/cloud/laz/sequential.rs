//! Chunks of point formats 0 to 5: a first record as it is, then all items of each record in turn from one stream.

use super::bytes::{array_at, put, u16_at, u64_at};
use super::coder::Decoder;
use super::colour::{Colour, ColourDecoderV1, ColourModels};
use super::description::{Item, ItemKind};
use super::error::Damage;
use super::extra::{ExtraDecoder, WavePacketDecoder};
use super::point::PointDecoder;
use super::point_v1::PointDecoderV1;
use super::time::{TimeDecoder, TimeDecoderV1};

/// The decoder of an item.
enum ItemDecoder {
    PointV1(Box<PointDecoderV1>),
    Point(Box<PointDecoder>),
    TimeV1(Box<TimeDecoderV1>),
    Time(Box<TimeDecoder>),
    ColourV1(Box<ColourDecoderV1>),
    Colour(Box<ColourModels>, Colour),
    WavePacket(Box<WavePacketDecoder>),
    Extra(ExtraDecoder),
}

fn colour_at(record: &[u8]) -> Colour {
    [0, 2, 4].map(|at| u16_at(record, at))
}

fn put_colour(out: &mut [u8], colour: Colour) {
    for (component, value) in colour.iter().enumerate() {
        put(out, 2 * component, value.to_le_bytes());
    }
}

impl ItemDecoder {
    /// Starts with the bytes of the item in the first record of a chunk.
    fn new(item: &Item, first: &[u8]) -> Self {
        let time = || u64_at(first, 0) as i64;
        match (item.kind, item.version) {
            (ItemKind::Point, 1) => {
                ItemDecoder::PointV1(Box::new(PointDecoderV1::new(&array_at(first, 0))))
            }
            (ItemKind::Point, _) => {
                ItemDecoder::Point(Box::new(PointDecoder::new(&array_at(first, 0))))
            }
            (ItemKind::Time, 1) => ItemDecoder::TimeV1(Box::new(TimeDecoderV1::new(time()))),
            (ItemKind::Time, _) => ItemDecoder::Time(Box::new(TimeDecoder::new(time()))),
            (ItemKind::Colour, 1) => {
                ItemDecoder::ColourV1(Box::new(ColourDecoderV1::new(colour_at(first))))
            }
            (ItemKind::Colour, _) => {
                ItemDecoder::Colour(Box::new(ColourModels::new()), colour_at(first))
            }
            (ItemKind::WavePacket, _) => {
                ItemDecoder::WavePacket(Box::new(WavePacketDecoder::new(&array_at(first, 0))))
            }
            (_, _) => ItemDecoder::Extra(ExtraDecoder::new(first)),
        }
    }

    /// Decodes the item of the next record.
    fn next(&mut self, decoder: &mut Decoder, out: &mut [u8]) -> Result<(), Damage> {
        match self {
            ItemDecoder::PointV1(points) => out.copy_from_slice(points.next(decoder)?),
            ItemDecoder::Point(points) => out.copy_from_slice(points.next(decoder)?),
            ItemDecoder::TimeV1(times) => put(out, 0, times.next(decoder)?.to_le_bytes()),
            ItemDecoder::Time(times) => put(out, 0, times.next(decoder)?.to_le_bytes()),
            ItemDecoder::ColourV1(colours) => put_colour(out, colours.next(decoder)?),
            ItemDecoder::Colour(models, last) => {
                *last = models.next(decoder, *last)?;
                put_colour(out, *last);
            }
            ItemDecoder::WavePacket(packets) => out.copy_from_slice(packets.next(decoder)?),
            ItemDecoder::Extra(bytes) => out.copy_from_slice(bytes.next(decoder)?),
        }
        Ok(())
    }
}

/// Decodes the records of a chunk.
pub(super) struct SequentialChunk<'a> {
    decoder: Decoder<'a>,
    items: Vec<ItemDecoder>,
    /// Size of each item.
    sizes: Vec<usize>,
}

impl<'a> SequentialChunk<'a> {
    /// Starts a chunk at a byte of the data, with the first record in `record`.
    pub fn new(
        data: &'a [u8],
        position: usize,
        items: &[Item],
        record: &mut [u8],
    ) -> Result<Self, Damage> {
        let first = data
            .get(position..)
            .and_then(|rest| rest.get(..record.len()));
        record.copy_from_slice(first.ok_or(Damage::Truncated)?);
        let mut at = 0;
        let decoders = items.iter().map(|item| {
            let first = &record[at..at + item.size];
            at += item.size;
            ItemDecoder::new(item, first)
        });
        Ok(SequentialChunk {
            items: decoders.collect(),
            sizes: items.iter().map(|item| item.size).collect(),
            decoder: Decoder::new(data, position + record.len())?,
        })
    }

    /// Decodes the next record.
    pub fn next(&mut self, record: &mut [u8]) -> Result<(), Damage> {
        let mut rest = record;
        for (item, &size) in self.items.iter_mut().zip(&self.sizes) {
            let (out, after) = rest.split_at_mut(size);
            item.next(&mut self.decoder, out)?;
            rest = after;
        }
        Ok(())
    }

    /// The first byte after the chunk, once all its records have been decoded.
    pub fn end(&self) -> usize {
        self.decoder.position()
    }
}
