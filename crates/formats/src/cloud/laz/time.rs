//! GPS times of point formats 1 and 3 to 5. Their bits, taken as integers, are predicted by a multiple of the last
//! difference, in version 2 within one of four sequences of times. Nothing reads the times, but the fields that follow
//! are found only by decoding them.

use super::coder::Decoder;
use super::error::Damage;
use super::integer::IntegerDecoder;
use super::model::SymbolModel;

/// Largest multiple of the last difference in version 2.
const MAX_MULTIPLE: i32 = 500;
/// Smallest, negative, multiple in version 2.
const MIN_MULTIPLE: i32 = -10;
/// The symbol in version 2 for an unchanged time; the next one is for a time that is not predicted, and then three for
/// switches to another sequence.
const UNCHANGED: i32 = MAX_MULTIPLE - MIN_MULTIPLE + 1;
/// Number of symbols for multiples in version 1; the last two are for times that are not predicted and unchanged ones.
const MULTIPLES_V1: u32 = 512;
/// The last difference is replaced after more extreme multiples than this in a row.
const MAX_EXTREMES: u32 = 3;

/// A sequence of times with similar differences.
#[derive(Debug, Clone, Copy, Default)]
struct Sequence {
    time: i64,
    difference: i32,
    /// How often the multiple was extreme in a row.
    extremes: u32,
}

impl Sequence {
    /// Adds a difference; an extreme one replaces the last difference after some repetitions.
    fn advance(&mut self, difference: i32, extreme: bool) {
        self.time = self.time.wrapping_add(i64::from(difference));
        if extreme {
            self.extremes += 1;
            if self.extremes > MAX_EXTREMES {
                self.difference = difference;
                self.extremes = 0;
            }
        }
    }
}

/// Decodes times of version 1.
pub(super) struct TimeDecoderV1 {
    sequence: Sequence,
    multiples: SymbolModel,
    without_difference: SymbolModel,
    differences: IntegerDecoder,
}

impl TimeDecoderV1 {
    /// Starts with the first time of a chunk.
    pub fn new(first: i64) -> Self {
        TimeDecoderV1 {
            sequence: Sequence {
                time: first,
                ..Sequence::default()
            },
            multiples: SymbolModel::new(MULTIPLES_V1),
            without_difference: SymbolModel::new(3),
            differences: IntegerDecoder::new(32, 6),
        }
    }

    /// Decodes the next time.
    pub fn next(&mut self, decoder: &mut Decoder) -> Result<i64, Damage> {
        let last = self.sequence.difference;
        if last == 0 {
            match decoder.symbol(&mut self.without_difference)? {
                1 => {
                    let difference = self.differences.decode(decoder, 0, 0)?;
                    self.sequence.difference = difference;
                    self.sequence.advance(difference, false);
                }
                2 => self.sequence.time = decoder.wide()? as i64,
                _ => {}
            }
            return Ok(self.sequence.time);
        }
        let multiple = decoder.symbol(&mut self.multiples)?;
        match multiple {
            1 => {
                let difference = self.differences.decode(decoder, last, 1)?;
                self.sequence.advance(difference, false);
                self.sequence.difference = difference;
                self.sequence.extremes = 0;
            }
            0 => {
                let difference = self.differences.decode(decoder, last / 4, 2)?;
                self.sequence.advance(difference, true);
            }
            _ if multiple < MULTIPLES_V1 - 2 => {
                let context = match multiple {
                    0..10 => 3,
                    10..50 => 4,
                    _ => 5,
                };
                let prediction = last.wrapping_mul(multiple as i32);
                let difference = self.differences.decode(decoder, prediction, context)?;
                self.sequence
                    .advance(difference, multiple == MULTIPLES_V1 - 3);
            }
            _ if multiple == MULTIPLES_V1 - 2 => self.sequence.time = decoder.wide()? as i64,
            _ => {}
        }
        Ok(self.sequence.time)
    }
}

/// Decodes times of version 2.
pub(super) struct TimeDecoder {
    sequences: [Sequence; 4],
    current: usize,
    /// The sequence that was started last.
    newest: usize,
    multiples: SymbolModel,
    without_difference: SymbolModel,
    differences: IntegerDecoder,
}

impl TimeDecoder {
    /// Starts with the first time of a chunk.
    pub fn new(first: i64) -> Self {
        let mut sequences = [Sequence::default(); 4];
        sequences[0].time = first;
        TimeDecoder {
            sequences,
            current: 0,
            newest: 0,
            multiples: SymbolModel::new(UNCHANGED as u32 + 5),
            without_difference: SymbolModel::new(6),
            differences: IntegerDecoder::new(32, 9),
        }
    }

    /// Decodes the next time.
    pub fn next(&mut self, decoder: &mut Decoder) -> Result<i64, Damage> {
        // A compressor switches only to a sequence in which the time can be predicted.
        if self.in_sequence(decoder)? || self.in_sequence(decoder)? {
            Ok(self.sequences[self.current].time)
        } else {
            Err(Damage::Contradictory)
        }
    }

    /// Decodes the next time in the current sequence, or a switch to another one; returns whether it was a time.
    fn in_sequence(&mut self, decoder: &mut Decoder) -> Result<bool, Damage> {
        let sequence = &mut self.sequences[self.current];
        let switch = if sequence.difference == 0 {
            let symbol = decoder.symbol(&mut self.without_difference)? as i32;
            if symbol == 1 {
                let difference = self.differences.decode(decoder, 0, 0)?;
                sequence.difference = difference;
                sequence.extremes = 0;
                sequence.advance(difference, false);
            }
            symbol - 1
        } else {
            let symbol = decoder.symbol(&mut self.multiples)? as i32;
            if symbol < UNCHANGED {
                self.multiple(decoder, symbol)?;
            }
            symbol - UNCHANGED
        };
        match switch {
            1 => self.start_sequence(decoder)?,
            2.. => {
                self.current = (self.current + switch as usize - 1) & 3;
                return Ok(false);
            }
            _ => {}
        }
        Ok(true)
    }

    /// Decodes a time that is predicted by a multiple of the last difference.
    fn multiple(&mut self, decoder: &mut Decoder, symbol: i32) -> Result<(), Damage> {
        let sequence = &mut self.sequences[self.current];
        let last = sequence.difference;
        let (multiple, context) = match symbol {
            0 => (0, 7),
            1 => (1, 1),
            2..10 => (symbol, 2),
            10..MAX_MULTIPLE => (symbol, 3),
            MAX_MULTIPLE => (symbol, 4),
            _ if MAX_MULTIPLE - symbol > MIN_MULTIPLE => (MAX_MULTIPLE - symbol, 5),
            _ => (MIN_MULTIPLE, 6),
        };
        let prediction = last.wrapping_mul(multiple);
        let difference = self.differences.decode(decoder, prediction, context)?;
        if symbol == 1 {
            sequence.extremes = 0;
        }
        sequence.advance(difference, matches!(context, 4 | 6 | 7));
        Ok(())
    }

    /// Decodes a time that is not predicted, which starts a new sequence in the place of the oldest.
    fn start_sequence(&mut self, decoder: &mut Decoder) -> Result<(), Damage> {
        let high = (self.sequences[self.current].time >> 32) as i32;
        let high = self.differences.decode(decoder, high, 8)?;
        let low = decoder.bits(32)?;
        self.newest = (self.newest + 1) & 3;
        self.current = self.newest;
        self.sequences[self.current] = Sequence {
            time: i64::from(high) << 32 | i64::from(low),
            ..Sequence::default()
        };
        Ok(())
    }
}
