//! Integers that are coded as corrections of a prediction: the number of bits of the correction, then its value (M.
//! Isenburg, *LASzip: lossless compression of LiDAR data*, Photogrammetric Engineering & Remote Sensing 79, 2013).

use super::coder::Decoder;
use super::error::Damage;
use super::model::{BitModel, LazyModels, SymbolModel};

/// Bits of a correction that are coded with a model; the lower ones of longer corrections are raw.
const MODELLED_BITS: u32 = 8;

/// Decodes integers of up to 32 bits.
pub(super) struct IntegerDecoder {
    /// 2 to the number of bits; 0 for 32.
    range: i32,
    /// Number of bits of the last correction.
    bits: u32,
    lengths: LazyModels,
    single_bit: BitModel,
    /// For each number of bits, the model of its highest ones.
    values: Vec<Option<SymbolModel>>,
}

impl IntegerDecoder {
    /// Prepares the decoding of integers of 8, 16 or 32 bits in a number of contexts.
    pub fn new(bits: u32, contexts: usize) -> Self {
        IntegerDecoder {
            range: if bits < 32 { 1 << bits } else { 0 },
            bits: 0,
            lengths: LazyModels::new(contexts, bits + 1),
            single_bit: BitModel::new(),
            values: vec![None; bits as usize],
        }
    }

    /// The number of bits of the last correction, which often chooses the context of what comes next.
    pub fn bits(&self) -> u32 {
        self.bits
    }

    /// Decodes an integer. All arithmetic wraps.
    pub fn decode(
        &mut self,
        decoder: &mut Decoder,
        prediction: i32,
        context: usize,
    ) -> Result<i32, Damage> {
        let value = prediction.wrapping_add(self.correction(decoder, context)?);
        Ok(if value < 0 {
            value.wrapping_add(self.range)
        } else if value >= self.range {
            value.wrapping_sub(self.range)
        } else {
            value
        })
    }

    fn correction(&mut self, decoder: &mut Decoder, context: usize) -> Result<i32, Damage> {
        self.bits = decoder.symbol(self.lengths.get(context))?;
        let bits = self.bits;
        if bits == 0 {
            return Ok(i32::from(decoder.bit(&mut self.single_bit)?));
        }
        if bits == 32 {
            return Ok(i32::MIN);
        }
        let modelled = bits.min(MODELLED_BITS);
        let model =
            self.values[bits as usize - 1].get_or_insert_with(|| SymbolModel::new(1 << modelled));
        let mut value = decoder.symbol(model)?;
        if bits > modelled {
            value = value << (bits - modelled) | decoder.bits(bits - modelled)?;
        }
        // The upper half of the values stands for 2^(bits - 1) + 1 to 2^bits, the lower one for the negatives of
        // 2^bits - 1 to 2^(bits - 1).
        Ok(if value >= 1 << (bits - 1) {
            (value as i32).wrapping_add(1)
        } else {
            value as i32 - ((1u32 << bits) - 1) as i32
        })
    }
}
