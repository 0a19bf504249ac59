//! Points of formats 0 to 5, compressed by LASzip version 1: differences of coordinates are predicted by the median of
//! the last three.

use super::bytes::{i32_at, put, u16_at};
use super::coder::Decoder;
use super::error::Damage;
use super::integer::IntegerDecoder;
use super::model::{LazyModels, SymbolModel};
use super::point::{CLASSIFICATION, INTENSITY, POINT_SIZE, RETURNS, SCAN_ANGLE, SOURCE, USER_DATA};

/// Contexts of y and z: the number of bits of the correction before, up to this.
const MAX_CONTEXT: usize = 19;

/// Decodes points.
pub(super) struct PointDecoderV1 {
    last: [u8; POINT_SIZE],
    changes: SymbolModel,
    returns: LazyModels,
    classification: LazyModels,
    user_data: LazyModels,
    intensity: IntegerDecoder,
    scan_angle: IntegerDecoder,
    source: IntegerDecoder,
    x: IntegerDecoder,
    y: IntegerDecoder,
    z: IntegerDecoder,
    /// The last three differences of x, and of y.
    differences: [[i32; 3]; 2],
    /// Which of the three is replaced next.
    oldest: usize,
}

fn median([a, b, c]: [i32; 3]) -> i32 {
    a.min(b).max(a.max(b).min(c))
}

impl PointDecoderV1 {
    /// Starts with the first point of a chunk.
    pub fn new(first: &[u8; POINT_SIZE]) -> Self {
        PointDecoderV1 {
            last: *first,
            changes: SymbolModel::new(64),
            returns: LazyModels::new(256, 256),
            classification: LazyModels::new(256, 256),
            user_data: LazyModels::new(256, 256),
            intensity: IntegerDecoder::new(16, 1),
            scan_angle: IntegerDecoder::new(8, 2),
            source: IntegerDecoder::new(16, 1),
            x: IntegerDecoder::new(32, 1),
            y: IntegerDecoder::new(32, MAX_CONTEXT + 1),
            z: IntegerDecoder::new(32, MAX_CONTEXT + 1),
            differences: [[0; 3]; 2],
            oldest: 0,
        }
    }

    /// Decodes the next point.
    pub fn next(&mut self, decoder: &mut Decoder) -> Result<&[u8], Damage> {
        let [medians_x, medians_y] = self.differences.map(median);
        let dx = self.x.decode(decoder, medians_x, 0)?;
        let context = (self.x.bits() as usize).min(MAX_CONTEXT);
        let dy = self.y.decode(decoder, medians_y, context)?;
        let bits = (self.x.bits() + self.y.bits()) / 2;
        let context = (bits as usize).min(MAX_CONTEXT);
        let z = self.z.decode(decoder, i32_at(&self.last, 8), context)?;
        self.differences[0][self.oldest] = dx;
        self.differences[1][self.oldest] = dy;
        self.oldest = (self.oldest + 1) % 3;
        let x = i32_at(&self.last, 0).wrapping_add(dx);
        let y = i32_at(&self.last, 4).wrapping_add(dy);
        put(&mut self.last, 0, x.to_le_bytes());
        put(&mut self.last, 4, y.to_le_bytes());
        put(&mut self.last, 8, z.to_le_bytes());
        let changes = decoder.symbol(&mut self.changes)?;
        if changes != 0 {
            self.other_fields(decoder, changes, bits)?;
        }
        Ok(&self.last)
    }

    /// Decodes the fields other than the coordinates.
    fn other_fields(
        &mut self,
        decoder: &mut Decoder,
        changes: u32,
        bits: u32,
    ) -> Result<(), Damage> {
        let last = &mut self.last;
        if changes & 32 != 0 {
            let before = i32::from(u16_at(last, INTENSITY));
            let intensity = self.intensity.decode(decoder, before, 0)? as u16;
            put(last, INTENSITY, intensity.to_le_bytes());
        }
        for (bit, field, models) in [
            (16, RETURNS, &mut self.returns),
            (8, CLASSIFICATION, &mut self.classification),
        ] {
            if changes & bit != 0 {
                last[field] = decoder.symbol(models.get(usize::from(last[field])))? as u8;
            }
        }
        if changes & 4 != 0 {
            let before = i32::from(last[SCAN_ANGLE]);
            let context = usize::from(bits < 3);
            last[SCAN_ANGLE] = self.scan_angle.decode(decoder, before, context)? as u8;
        }
        if changes & 2 != 0 {
            let model = self.user_data.get(usize::from(last[USER_DATA]));
            last[USER_DATA] = decoder.symbol(model)? as u8;
        }
        if changes & 1 != 0 {
            let before = i32::from(u16_at(last, SOURCE));
            let source = self.source.decode(decoder, before, 0)? as u16;
            put(last, SOURCE, source.to_le_bytes());
        }
        Ok(())
    }
}
