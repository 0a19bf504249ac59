//! Points of formats 0 to 5, compressed by LASzip version 2: each field with its own models, coordinates in the contexts
//! of their returns.

use super::bytes::{i32_at, put};
use super::coder::Decoder;
use super::error::Damage;
use super::integer::IntegerDecoder;
use super::median::RunningMedian;
use super::model::{LazyModels, SymbolModel};
use super::returns::{Returns, coordinate_context};

/// Bytes of a point of format 0.
pub(super) const POINT_SIZE: usize = 20;
// Where the fields of a point are.
pub(super) const INTENSITY: usize = 12;
pub(super) const RETURNS: usize = 14;
pub(super) const CLASSIFICATION: usize = 15;
pub(super) const SCAN_ANGLE: usize = 16;
pub(super) const USER_DATA: usize = 17;
pub(super) const SOURCE: usize = 18;

/// Decodes points.
pub(super) struct PointDecoder {
    last: [u8; POINT_SIZE],
    changes: SymbolModel,
    returns: LazyModels,
    classification: LazyModels,
    scan_angle: LazyModels,
    user_data: LazyModels,
    intensity: IntegerDecoder,
    last_intensity: [u16; 16],
    source: IntegerDecoder,
    x: IntegerDecoder,
    x_differences: [RunningMedian; 16],
    y: IntegerDecoder,
    y_differences: [RunningMedian; 16],
    z: IntegerDecoder,
    last_height: [i32; 8],
}

impl PointDecoder {
    /// Starts with the first point of a chunk.
    pub fn new(first: &[u8; POINT_SIZE]) -> Self {
        let mut last = *first;
        put(&mut last, INTENSITY, 0u16.to_le_bytes());
        PointDecoder {
            last,
            changes: SymbolModel::new(64),
            returns: LazyModels::new(256, 256),
            classification: LazyModels::new(256, 256),
            scan_angle: LazyModels::new(2, 256),
            user_data: LazyModels::new(256, 256),
            intensity: IntegerDecoder::new(16, 4),
            last_intensity: [0; 16],
            source: IntegerDecoder::new(16, 1),
            x: IntegerDecoder::new(32, 2),
            x_differences: [RunningMedian::new(); 16],
            y: IntegerDecoder::new(32, 22),
            y_differences: [RunningMedian::new(); 16],
            z: IntegerDecoder::new(32, 20),
            last_height: [0; 8],
        }
    }

    /// Decodes the next point.
    pub fn next(&mut self, decoder: &mut Decoder) -> Result<&[u8], Damage> {
        let changes = decoder.symbol(&mut self.changes)?;
        if changes & 32 != 0 {
            let before = usize::from(self.last[RETURNS]);
            self.last[RETURNS] = decoder.symbol(self.returns.get(before))? as u8;
        }
        let returns = Returns {
            number: self.last[RETURNS] & 7,
            count: self.last[RETURNS] >> 3 & 7,
        };
        if changes != 0 {
            self.other_fields(decoder, changes, returns.context_of_8())?;
        }
        self.coordinates(decoder, returns)?;
        Ok(&self.last)
    }

    /// Decodes the fields other than the numbers of returns and the coordinates.
    fn other_fields(
        &mut self,
        decoder: &mut Decoder,
        changes: u32,
        context: usize,
    ) -> Result<(), Damage> {
        if changes & 16 != 0 {
            let before = i32::from(self.last_intensity[context]);
            let intensity = self.intensity.decode(decoder, before, context.min(3))?;
            self.last_intensity[context] = intensity as u16;
        }
        put(
            &mut self.last,
            INTENSITY,
            self.last_intensity[context].to_le_bytes(),
        );
        if changes & 8 != 0 {
            let before = usize::from(self.last[CLASSIFICATION]);
            self.last[CLASSIFICATION] = decoder.symbol(self.classification.get(before))? as u8;
        }
        if changes & 4 != 0 {
            let direction = usize::from(self.last[RETURNS] >> 6 & 1);
            let difference = decoder.symbol(self.scan_angle.get(direction))? as u8;
            self.last[SCAN_ANGLE] = self.last[SCAN_ANGLE].wrapping_add(difference);
        }
        if changes & 2 != 0 {
            let before = usize::from(self.last[USER_DATA]);
            self.last[USER_DATA] = decoder.symbol(self.user_data.get(before))? as u8;
        }
        if changes & 1 != 0 {
            let before = u16::from_le_bytes([self.last[SOURCE], self.last[SOURCE + 1]]);
            let source = self.source.decode(decoder, i32::from(before), 0)? as u16;
            put(&mut self.last, SOURCE, source.to_le_bytes());
        }
        Ok(())
    }

    fn coordinates(&mut self, decoder: &mut Decoder, returns: Returns) -> Result<(), Damage> {
        let context = returns.context_of_8();
        let median = self.x_differences[context].get();
        let dx = self
            .x
            .decode(decoder, median, usize::from(returns.is_single()))?;
        self.x_differences[context].add(dx);

        let median = self.y_differences[context].get();
        let y_context = coordinate_context(self.x.bits(), 20, returns);
        let dy = self.y.decode(decoder, median, y_context)?;
        self.y_differences[context].add(dy);

        let bits = (self.x.bits() + self.y.bits()) / 2;
        let height = &mut self.last_height[returns.level()];
        *height = self
            .z
            .decode(decoder, *height, coordinate_context(bits, 18, returns))?;

        let x = i32_at(&self.last, 0).wrapping_add(dx);
        let y = i32_at(&self.last, 4).wrapping_add(dy);
        put(&mut self.last, 0, x.to_le_bytes());
        put(&mut self.last, 4, y.to_le_bytes());
        put(&mut self.last, 8, height.to_le_bytes());
        Ok(())
    }
}
