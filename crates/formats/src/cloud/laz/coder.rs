//! The arithmetic decoder (A. Said, *Introduction to Arithmetic Coding – Theory and Practice*, Hewlett-Packard
//! Laboratories report HPL-2004-76, 2004): 32-bit intervals, adaptive models with periodic updates.

use super::error::Damage;
use super::model::{BIT_SHIFT, BitModel, SYMBOL_SHIFT, SymbolModel};

/// Intervals shorter than this are lengthened by another byte of the data.
const MIN_LENGTH: u32 = 1 << 24;
/// Raw bits decoded at once; more would leave an interval too short.
const MAX_RAW_BITS: u32 = 19;

/// Decodes symbols from bytes. `value` is the offset within the current interval and always less than `length`.
pub(super) struct Decoder<'a> {
    data: &'a [u8],
    position: usize,
    value: u32,
    length: u32,
}

impl<'a> Decoder<'a> {
    /// Starts at a byte of the data.
    pub fn new(data: &'a [u8], position: usize) -> Result<Self, Damage> {
        let start = data.get(position..).and_then(|rest| rest.first_chunk());
        let value = u32::from_be_bytes(*start.ok_or(Damage::Truncated)?);
        if value == u32::MAX {
            return Err(Damage::Contradictory);
        }
        Ok(Decoder {
            data,
            position: position + 4,
            value,
            length: u32::MAX,
        })
    }

    /// The first byte that has not been read.
    pub fn position(&self) -> usize {
        self.position
    }

    fn renormalize(&mut self) -> Result<(), Damage> {
        while self.length < MIN_LENGTH {
            let byte = *self.data.get(self.position).ok_or(Damage::Truncated)?;
            self.position += 1;
            self.value = self.value << 8 | u32::from(byte);
            self.length <<= 8;
        }
        Ok(())
    }

    /// Decodes a bit with an adaptive model.
    pub fn bit(&mut self, model: &mut BitModel) -> Result<bool, Damage> {
        let split = model.zero_probability() * (self.length >> BIT_SHIFT);
        let bit = self.value >= split;
        if bit {
            self.value -= split;
            self.length -= split;
        } else {
            self.length = split;
        }
        self.renormalize()?;
        model.count(bit);
        Ok(bit)
    }

    /// Decodes a symbol with an adaptive model.
    pub fn symbol(&mut self, model: &mut SymbolModel) -> Result<u32, Damage> {
        let unit = self.length >> SYMBOL_SHIFT;
        let found = model.find(self.value / unit);
        let low = found.low * unit;
        let high = found.high.map_or(self.length, |high| high * unit);
        self.value -= low;
        self.length = high - low;
        self.renormalize()?;
        model.count(found.symbol);
        Ok(found.symbol)
    }

    /// Decodes up to 32 equally probable bits.
    pub fn bits(&mut self, count: u32) -> Result<u32, Damage> {
        if count > MAX_RAW_BITS {
            let low = self.bits(16)?;
            return Ok(self.bits(count - 16)? << 16 | low);
        }
        self.length >>= count;
        let bits = self.value / self.length;
        if bits >> count != 0 {
            return Err(Damage::Contradictory);
        }
        self.value -= bits * self.length;
        self.renormalize()?;
        Ok(bits)
    }

    /// Decodes 64 equally probable bits.
    pub fn wide(&mut self) -> Result<u64, Damage> {
        let low = u64::from(self.bits(32)?);
        Ok(u64::from(self.bits(32)?) << 32 | low)
    }
}
