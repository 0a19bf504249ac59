//! Colours, byte by byte. From version 2 on, the changes of green and blue are predicted by that of red.

use super::coder::Decoder;
use super::error::Damage;
use super::integer::IntegerDecoder;
use super::model::SymbolModel;

/// Red, green and blue.
pub(super) type Colour = [u16; 3];

/// The bytes of a colour: the low and the high one of each component.
fn bytes_of(colour: Colour) -> [[u8; 2]; 3] {
    colour.map(u16::to_le_bytes)
}

/// Decodes colours of version 1.
pub(super) struct ColourDecoderV1 {
    last: Colour,
    changes: SymbolModel,
    bytes: IntegerDecoder,
}

impl ColourDecoderV1 {
    /// Starts with the first colour of a chunk.
    pub fn new(first: Colour) -> Self {
        ColourDecoderV1 {
            last: first,
            changes: SymbolModel::new(64),
            bytes: IntegerDecoder::new(8, 6),
        }
    }

    /// Decodes the next colour.
    pub fn next(&mut self, decoder: &mut Decoder) -> Result<Colour, Damage> {
        let changes = decoder.symbol(&mut self.changes)?;
        let mut bytes = bytes_of(self.last);
        for (i, byte) in bytes.as_flattened_mut().iter_mut().enumerate() {
            if changes >> i & 1 != 0 {
                *byte = self.bytes.decode(decoder, i32::from(*byte), i)? as u8;
            }
        }
        self.last = bytes.map(u16::from_le_bytes);
        Ok(self.last)
    }
}

/// Models of colours from version 2 on.
pub(super) struct ColourModels {
    changes: SymbolModel,
    /// Corrections of the low and the high byte of each component.
    bytes: [[SymbolModel; 2]; 3],
}

impl ColourModels {
    pub fn new() -> Self {
        let bytes = || [SymbolModel::new(256), SymbolModel::new(256)];
        ColourModels {
            changes: SymbolModel::new(128),
            bytes: [bytes(), bytes(), bytes()],
        }
    }

    /// Decodes the colour that follows `last`.
    pub fn next(&mut self, decoder: &mut Decoder, last: Colour) -> Result<Colour, Damage> {
        let changes = decoder.symbol(&mut self.changes)?;
        let changed = |component: usize, half: usize| changes >> (2 * component + half) & 1 != 0;
        let last = bytes_of(last);
        let mut new = last;
        for half in 0..2 {
            if changed(0, half) {
                let correction = decoder.symbol(&mut self.bytes[0][half])? as u8;
                new[0][half] = last[0][half].wrapping_add(correction);
            }
        }
        if changes & 64 == 0 {
            return Ok([u16::from_le_bytes(new[0]); 3]);
        }
        for half in 0..2 {
            let change = |new: &[[u8; 2]; 3], component: usize| {
                i32::from(new[component][half]) - i32::from(last[component][half])
            };
            let mut prediction = change(&new, 0);
            for component in 1..3 {
                if component == 2 {
                    prediction = (prediction + change(&new, 1)) / 2;
                }
                if changed(component, half) {
                    let correction = decoder.symbol(&mut self.bytes[component][half])? as u8;
                    let predicted = i32::from(last[component][half]) + prediction;
                    new[component][half] = (predicted.clamp(0, 255) as u8).wrapping_add(correction);
                }
            }
        }
        Ok(new.map(u16::from_le_bytes))
    }
}
