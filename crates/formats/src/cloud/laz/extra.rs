//! Fields that are decoded only because others follow them: wave packets of point formats 4 and 5, and extra bytes.

use super::bytes::{i32_at, put, u32_at, u64_at};
use super::coder::Decoder;
use super::error::Damage;
use super::integer::IntegerDecoder;
use super::model::{LazyModels, SymbolModel};

/// Bytes of a wave packet: an index, an offset, a size, a return point and a vector.
pub(super) const WAVE_PACKET_SIZE: usize = 29;

/// Decodes wave packets.
pub(super) struct WavePacketDecoder {
    last: [u8; WAVE_PACKET_SIZE],
    index: SymbolModel,
    /// How the offset follows from that of the last packet, by how it did so for the last one.
    offset_kinds: LazyModels,
    last_kind: u32,
    offset_difference: IntegerDecoder,
    last_offset_difference: i32,
    size: IntegerDecoder,
    return_point: IntegerDecoder,
    vector: IntegerDecoder,
}

impl WavePacketDecoder {
    /// Starts with the first packet of a chunk.
    pub fn new(first: &[u8; WAVE_PACKET_SIZE]) -> Self {
        WavePacketDecoder {
            last: *first,
            index: SymbolModel::new(256),
            offset_kinds: LazyModels::new(4, 4),
            last_kind: 0,
            offset_difference: IntegerDecoder::new(32, 1),
            last_offset_difference: 0,
            size: IntegerDecoder::new(32, 1),
            return_point: IntegerDecoder::new(32, 1),
            vector: IntegerDecoder::new(32, 3),
        }
    }

    /// Decodes the next packet.
    pub fn next(&mut self, decoder: &mut Decoder) -> Result<&[u8], Damage> {
        self.last[0] = decoder.symbol(&mut self.index)? as u8;
        let (offset, size) = (u64_at(&self.last, 1), u32_at(&self.last, 9));
        self.last_kind = decoder.symbol(self.offset_kinds.get(self.last_kind as usize))?;
        let offset = match self.last_kind {
            0 => offset,
            1 => offset.wrapping_add(u64::from(size)),
            2 => {
                let prediction = self.last_offset_difference;
                let difference = self.offset_difference.decode(decoder, prediction, 0)?;
                self.last_offset_difference = difference;
                offset.wrapping_add_signed(i64::from(difference))
            }
            _ => decoder.wide()?,
        };
        put(&mut self.last, 1, offset.to_le_bytes());
        // The bits of floating-point numbers are predicted as integers.
        integer(&mut self.last, 9, decoder, &mut self.size, 0)?;
        integer(&mut self.last, 13, decoder, &mut self.return_point, 0)?;
        for component in 0..3 {
            let at = 17 + 4 * component;
            integer(&mut self.last, at, decoder, &mut self.vector, component)?;
        }
        Ok(&self.last)
    }
}

/// Replaces an integer of a record by the one that follows it.
fn integer(
    record: &mut [u8],
    at: usize,
    decoder: &mut Decoder,
    integers: &mut IntegerDecoder,
    context: usize,
) -> Result<(), Damage> {
    let value = integers.decode(decoder, i32_at(record, at), context)?;
    put(record, at, value.to_le_bytes());
    Ok(())
}

/// Decodes extra bytes, each by its difference from the last one.
pub(super) struct ExtraDecoder {
    last: Vec<u8>,
    models: LazyModels,
}

impl ExtraDecoder {
    /// Starts with the first bytes of a chunk.
    pub fn new(first: &[u8]) -> Self {
        ExtraDecoder {
            last: first.to_vec(),
            models: LazyModels::new(first.len(), 256),
        }
    }

    /// Decodes the next bytes.
    pub fn next(&mut self, decoder: &mut Decoder) -> Result<&[u8], Damage> {
        for (i, byte) in self.last.iter_mut().enumerate() {
            let difference = decoder.symbol(self.models.get(i))? as u8;
            *byte = byte.wrapping_add(difference);
        }
        Ok(&self.last)
    }
}
