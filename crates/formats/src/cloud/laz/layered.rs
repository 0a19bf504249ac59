//! Chunks of point formats 6 to 10 (LASzip versions 3 and 4): a first record as it is, then each field of the others in
//! a layer of its own. Only the layers of coordinates, classification, flags and colour are decoded; the other fields
//! keep the values of the first record.

use super::bytes::{i32_at, put, u16_at, u32_at};
use super::coder::Decoder;
use super::colour::{Colour, ColourModels};
use super::description::{Item, ItemKind};
use super::error::Damage;
use super::integer::IntegerDecoder;
use super::median::RunningMedian;
use super::model::{LazyModels, SymbolModel};
use super::returns::{Returns, coordinate_context};

/// Scanner channels, each of which has its own models.
const CHANNELS: usize = 4;
// Where the fields of a point are.
const RETURNS: usize = 14;
const FLAGS: usize = 15;
const CLASSIFICATION: usize = 16;

/// The last point of a channel, as far as it is decoded.
#[derive(Debug, Clone, Copy)]
struct Point {
    position: [i32; 3],
    returns: Returns,
    /// Classification flags, scanner channel, scan direction and edge of flight line, as in the record.
    flags: u8,
    classification: u8,
}

impl Point {
    fn read(record: &[u8]) -> Self {
        Point {
            position: [0, 4, 8].map(|at| i32_at(record, at)),
            returns: Returns {
                number: record[RETURNS] & 15,
                count: record[RETURNS] >> 4,
            },
            flags: record[FLAGS],
            classification: record[CLASSIFICATION],
        }
    }

    fn write(&self, record: &mut [u8]) {
        for (i, coordinate) in self.position.iter().enumerate() {
            put(record, 4 * i, coordinate.to_le_bytes());
        }
        record[RETURNS] = self.returns.count << 4 | self.returns.number;
        record[FLAGS] = self.flags;
        record[CLASSIFICATION] = self.classification;
    }

    fn channel(&self) -> usize {
        usize::from(self.flags >> 4 & 3)
    }
}

/// The models of a channel.
struct Channel {
    last: Point,
    time_changed: bool,
    changes: LazyModels,
    channel: SymbolModel,
    return_counts: LazyModels,
    return_numbers: LazyModels,
    return_steps: SymbolModel,
    x: IntegerDecoder,
    x_differences: [RunningMedian; 12],
    y: IntegerDecoder,
    y_differences: [RunningMedian; 12],
    z: IntegerDecoder,
    last_height: [i32; 8],
    classification: LazyModels,
    flags: LazyModels,
}

impl Channel {
    fn new(last: Point) -> Self {
        Channel {
            last,
            time_changed: false,
            changes: LazyModels::new(8, 128),
            channel: SymbolModel::new(CHANNELS as u32 - 1),
            return_counts: LazyModels::new(16, 16),
            return_numbers: LazyModels::new(16, 16),
            return_steps: SymbolModel::new(13),
            x: IntegerDecoder::new(32, 2),
            x_differences: [RunningMedian::new(); 12],
            y: IntegerDecoder::new(32, 22),
            y_differences: [RunningMedian::new(); 12],
            z: IntegerDecoder::new(32, 20),
            last_height: [last.position[2]; 8],
            classification: LazyModels::new(64, 256),
            flags: LazyModels::new(64, 64),
        }
    }

    /// The context of the symbol that says what changes: whether the last return was the first or the last of its pulse,
    /// and whether its time had changed.
    fn change_context(&self) -> usize {
        let Returns { number, count } = self.last.returns;
        usize::from(number == 1)
            | usize::from(number >= count) << 1
            | usize::from(self.time_changed) << 2
    }

    fn returns(&mut self, decoder: &mut Decoder, changes: u32) -> Result<Returns, Damage> {
        let before = self.last.returns;
        let mut count = before.count;
        if changes & 4 != 0 {
            let model = self.return_counts.get(usize::from(count));
            count = decoder.symbol(model)? as u8;
        }
        let number = match changes & 3 {
            0 => before.number,
            1 => (before.number + 1) & 15,
            2 => (before.number + 15) & 15,
            _ if self.time_changed => {
                let model = self.return_numbers.get(usize::from(before.number));
                decoder.symbol(model)? as u8
            }
            _ => {
                let step = decoder.symbol(&mut self.return_steps)? as u8;
                (before.number + step + 2) & 15
            }
        };
        Ok(Returns { number, count })
    }

    /// Decodes x and y.
    fn horizontal(&mut self, decoder: &mut Decoder) -> Result<(), Damage> {
        let returns = self.last.returns;
        let context = returns.context_of_16() << 1 | usize::from(self.time_changed);
        let median = self.x_differences[context].get();
        let dx = self
            .x
            .decode(decoder, median, usize::from(returns.is_single()))?;
        self.x_differences[context].add(dx);
        let median = self.y_differences[context].get();
        let y_context = coordinate_context(self.x.bits(), 20, returns);
        let dy = self.y.decode(decoder, median, y_context)?;
        self.y_differences[context].add(dy);
        let [x, y, _] = &mut self.last.position;
        *x = x.wrapping_add(dx);
        *y = y.wrapping_add(dy);
        Ok(())
    }

    fn height(&mut self, decoder: &mut Decoder) -> Result<(), Damage> {
        let returns = self.last.returns;
        let bits = (self.x.bits() + self.y.bits()) / 2;
        let height = &mut self.last_height[returns.level()];
        *height = self
            .z
            .decode(decoder, *height, coordinate_context(bits, 18, returns))?;
        self.last.position[2] = *height;
        Ok(())
    }

    fn classification(&mut self, decoder: &mut Decoder) -> Result<(), Damage> {
        let Returns { number, count } = self.last.returns;
        let only_return = number == 1 && number >= count;
        let context = usize::from(self.last.classification & 31) << 1 | usize::from(only_return);
        self.last.classification = decoder.symbol(self.classification.get(context))? as u8;
        Ok(())
    }

    fn flags(&mut self, decoder: &mut Decoder) -> Result<(), Damage> {
        // The coded symbol has the bits of the scanner channel left out.
        let last = self.last.flags;
        let context = usize::from(last >> 6 << 4 | last & 15);
        let symbol = decoder.symbol(self.flags.get(context))? as u8;
        self.last.flags = symbol >> 4 << 6 | last & 0x30 | symbol & 15;
        Ok(())
    }
}

/// Decodes the points of a chunk.
struct PointLayers<'a> {
    version: u16,
    channels: [Option<Box<Channel>>; CHANNELS],
    current: usize,
    /// Channels, returns, x and y.
    horizontal: Option<Decoder<'a>>,
    height: Option<Decoder<'a>>,
    classification: Option<Decoder<'a>>,
    flags: Option<Decoder<'a>>,
}

impl<'a> PointLayers<'a> {
    fn new(version: u16, record: &[u8], layers: &[&'a [u8]]) -> Result<Self, Damage> {
        let first = Point::read(record);
        let mut channels = [const { None }; CHANNELS];
        channels[first.channel()] = Some(Box::new(Channel::new(first)));
        Ok(PointLayers {
            version,
            channels,
            current: first.channel(),
            horizontal: layer_decoder(layers[0])?,
            height: layer_decoder(layers[1])?,
            classification: layer_decoder(layers[2])?,
            flags: layer_decoder(layers[3])?,
        })
    }

    /// Decodes the next point. Returns the channel in which the other items of the record are decoded.
    fn next(&mut self, record: &mut [u8]) -> Result<usize, Damage> {
        let decoder = self.horizontal.as_mut().ok_or(Damage::Truncated)?;
        let mut channel = current(&mut self.channels, self.current)?;
        let context = channel.change_context();
        let changes = decoder.symbol(channel.changes.get(context))?;
        // In version 3, items after the point know of a channel only where it has changed.
        let mut announced = 0;
        if changes & 64 != 0 {
            let step = decoder.symbol(&mut channel.channel)? as usize + 1;
            let last = channel.last;
            self.current = (self.current + step) % CHANNELS;
            let slot = &mut self.channels[self.current];
            channel = slot.get_or_insert_with(|| Box::new(Channel::new(last)));
            channel.last.flags = channel.last.flags & !0x30 | (self.current as u8) << 4;
            announced = self.current;
        }
        channel.time_changed = changes & 16 != 0;
        channel.last.returns = channel.returns(decoder, changes)?;
        channel.horizontal(decoder)?;
        if let Some(decoder) = &mut self.height {
            channel.height(decoder)?;
        }
        if let Some(decoder) = &mut self.classification {
            channel.classification(decoder)?;
        }
        if let Some(decoder) = &mut self.flags {
            channel.flags(decoder)?;
        }
        channel.last.write(record);
        Ok(if self.version == 3 {
            announced
        } else {
            self.current
        })
    }
}

fn current(channels: &mut [Option<Box<Channel>>], at: usize) -> Result<&mut Channel, Damage> {
    channels[at].as_deref_mut().ok_or(Damage::Contradictory)
}

fn layer_decoder(layer: &[u8]) -> Result<Option<Decoder<'_>>, Damage> {
    (!layer.is_empty())
        .then(|| Decoder::new(layer, 0))
        .transpose()
}

/// Decodes the colours of a chunk.
struct ColourLayer<'a> {
    version: u16,
    /// Where the colour is in a record.
    offset: usize,
    decoder: Option<Decoder<'a>>,
    models: [Option<Box<ColourModels>>; CHANNELS],
    last: [Colour; CHANNELS],
    current: usize,
}

impl<'a> ColourLayer<'a> {
    fn new(item: &Item, offset: usize, record: &[u8], layer: &'a [u8]) -> Result<Self, Damage> {
        let channel = Point::read(record).channel();
        let mut models = [const { None }; CHANNELS];
        models[channel] = Some(Box::new(ColourModels::new()));
        let mut last = [[0; 3]; CHANNELS];
        last[channel] = [0, 2, 4].map(|at| u16_at(record, offset + at));
        Ok(ColourLayer {
            version: item.version,
            offset,
            decoder: layer_decoder(layer)?,
            models,
            last,
            current: channel,
        })
    }

    /// Decodes the next colour in a channel.
    fn next(&mut self, record: &mut [u8], channel: usize) -> Result<(), Damage> {
        // Version 3 predicts the colour by that of the channel before, except where a channel is new.
        let mut predicting = self.current;
        let is_new = self.models[channel].is_none();
        if is_new {
            self.last[channel] = self.last[self.current];
        }
        if channel != self.current && (self.version == 4 || is_new) {
            predicting = channel;
        }
        self.current = channel;
        let models = self.models[channel].get_or_insert_with(|| Box::new(ColourModels::new()));
        let last = &mut self.last[predicting];
        if let Some(decoder) = &mut self.decoder {
            *last = models.next(decoder, *last)?;
        }
        for (component, value) in last.iter().enumerate() {
            put(record, self.offset + 2 * component, value.to_le_bytes());
        }
        Ok(())
    }
}

/// Decodes the records of a chunk.
pub(super) struct LayeredChunk<'a> {
    points: PointLayers<'a>,
    colour: Option<ColourLayer<'a>>,
    count: u32,
    end: usize,
}

impl<'a> LayeredChunk<'a> {
    /// Starts a chunk at a byte of the data, with the first record in `record`. The first item must be the point.
    pub fn new(
        data: &'a [u8],
        position: usize,
        items: &[Item],
        record: &mut [u8],
    ) -> Result<Self, Damage> {
        let size = record.len();
        let layer_count: usize = items.iter().map(Item::layers).sum();
        let head = data
            .get(position..)
            .and_then(|rest| rest.get(..size + 4 + 4 * layer_count));
        let head = head.ok_or(Damage::Truncated)?;
        record.copy_from_slice(&head[..size]);
        let mut end = position + head.len();
        let mut layers = Vec::with_capacity(layer_count);
        for length in head[size + 4..].chunks_exact(4) {
            let length = u32_at(length, 0) as usize;
            let layer = data.get(end..).and_then(|rest| rest.get(..length));
            layers.push(layer.ok_or(Damage::Truncated)?);
            end += length;
        }
        let (mut offset, mut layer, mut colour) = (0, 0, None);
        for item in items {
            if matches!(
                item.kind,
                ItemKind::LayeredColour | ItemKind::LayeredColourAndInfrared
            ) {
                colour = Some(ColourLayer::new(item, offset, record, layers[layer])?);
            }
            offset += item.size;
            layer += item.layers();
        }
        Ok(LayeredChunk {
            points: PointLayers::new(items[0].version, record, &layers)?,
            colour,
            count: u32_at(head, size),
            end,
        })
    }

    /// Number of records in the chunk, the first included.
    pub fn count(&self) -> u32 {
        self.count
    }

    /// Decodes the next record.
    pub fn next(&mut self, record: &mut [u8]) -> Result<(), Damage> {
        let channel = self.points.next(record)?;
        match &mut self.colour {
            Some(colour) => colour.next(record, channel),
            None => Ok(()),
        }
    }

    /// The first byte after the chunk.
    pub fn end(&self) -> usize {
        self.end
    }
}
