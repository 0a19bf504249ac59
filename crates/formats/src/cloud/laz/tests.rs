//! Points are compressed with the laz crate and decompressed here.

use super::{CompressedPoints, Description, Failure, decompress};
use laz::las::{Point0, Point1, Point2, Point3, Point6, Point7, Point8};
use laz::{LasZipCompressor, LazItem, LazItemRecordBuilder, LazItemType, LazVlr, LazVlrBuilder};
use std::io::Cursor;

/// Pseudo-random numbers (SplitMix64).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ z >> 31
    }

    /// A number less than `end`, mostly small.
    fn below(&mut self, end: u64) -> u64 {
        let reach = self.next() % end + 1;
        self.next() % reach
    }

    fn one_in(&mut self, n: u64) -> bool {
        self.next().is_multiple_of(n)
    }
}

/// How points are to be compressed.
struct Case {
    items: Vec<LazItem>,
    /// Points in each chunk.
    chunks: Vec<usize>,
    variable: bool,
}

/// A compressed file, less the parts before the points.
struct Packed {
    data: Vec<u8>,
    description: Vec<u8>,
    record_size: usize,
    count: u64,
}

impl Packed {
    fn new(case: &Case, records: &[u8]) -> Self {
        let builder = LazVlrBuilder::new(case.items.clone());
        let vlr: LazVlr = if case.variable {
            builder.with_variable_chunk_size().build()
        } else {
            builder.with_fixed_chunk_size(case.chunks[0] as u32).build()
        };
        let mut description = Vec::new();
        vlr.write_to(&mut description).unwrap();
        let record_size = vlr.items_size() as usize;
        let mut data = Cursor::new(Vec::new());
        let mut compressor = LasZipCompressor::new(&mut data, vlr).unwrap();
        let mut rest = records;
        for count in &case.chunks {
            let (chunk, after) = rest.split_at(rest.len().min(count * record_size));
            compressor.compress_many(chunk).unwrap();
            rest = after;
            if case.variable {
                compressor.finish_current_chunk().unwrap();
            }
        }
        compressor.done().unwrap();
        drop(compressor);
        Packed {
            data: data.into_inner(),
            description,
            record_size,
            count: (records.len() / record_size) as u64,
        }
    }

    fn unpack(&self, data: &[u8]) -> Result<Vec<u8>, Failure> {
        let description = Description::read(&self.description, self.record_size).unwrap();
        let points = CompressedPoints {
            data,
            start: 0,
            count: self.count,
            record_size: self.record_size,
        };
        let mut out = Vec::new();
        decompress(&points, &description, &mut |record| out.extend(record))?;
        Ok(out)
    }
}

/// Whether a point of these items has its fields in layers.
fn is_layered(items: &[LazItem]) -> bool {
    items[0].version() >= 3
}

/// Bytes that the compressor cannot be given: the high byte of blue in version 1, for which it takes the context of
/// green, and the highest one of the offset of a wave packet, whose differences overflow.
fn constant_bytes(items: &[LazItem]) -> Vec<usize> {
    let mut offset = 0;
    let mut constant = Vec::new();
    for item in items {
        match (item.item_type(), item.version()) {
            (LazItemType::RGB12, 1) => constant.push(offset + 5),
            (LazItemType::WavePacket13 | LazItemType::WavePacket14, _) => constant.push(offset + 8),
            _ => {}
        }
        offset += usize::from(item.size());
    }
    constant
}

/// Changes a record as scanners do: most fields little or not at all, sometimes everything.
fn advance(record: &mut [u8], items: &[LazItem], random: &mut Random) {
    let layered = is_layered(items);
    for axis in 0..3 {
        let at = 4 * axis;
        let value = i32::from_le_bytes(record[at..at + 4].try_into().unwrap());
        // Larger steps overflow in the compressor of version 1.
        let largest = if items[0].version() == 1 {
            1 << 22
        } else {
            1 << 31
        };
        let reach = if random.one_in(40) { largest } else { 500 };
        let step = random.below(reach) as i32 - 50;
        record[at..at + 4].copy_from_slice(&value.wrapping_add(step).to_le_bytes());
    }
    let returns = [
        (1, 1),
        (1, 2),
        (2, 2),
        (1, 3),
        (2, 3),
        (3, 3),
        (0, 0),
        (5, 2),
        (7, 7),
    ];
    let (number, count) = returns[random.below(9) as usize];
    if random.one_in(2) {
        record[14] = if layered {
            count << 4 | number
        } else {
            count << 3 | number
        };
    }
    let time = if layered {
        Some(22)
    } else {
        (items.len() > 1).then_some(20)
    };
    let constant = constant_bytes(items);
    for (at, byte) in record.iter_mut().enumerate().skip(12) {
        let of_time = time.is_some_and(|start| (start..start + 8).contains(&at));
        if at != 14 && !of_time && !constant.contains(&at) && random.one_in(8) {
            *byte = byte.wrapping_add(random.below(256) as u8);
        }
    }
    if let Some(at) = time
        && record.len() >= at + 8
        && random.one_in(2)
    {
        let bits = i64::from_le_bytes(record[at..at + 8].try_into().unwrap());
        let step = match random.next() % 12 {
            0 => random.next() as i64 >> 10,
            1 => random.next() as i64 >> 33,
            2 => -3000,
            3..6 => 1000,
            n => 100 * n as i64,
        };
        record[at..at + 8].copy_from_slice(&bits.wrapping_add(step).to_le_bytes());
    }
}

fn records(items: &[LazItem], count: usize, seed: u64) -> Vec<u8> {
    let size: u16 = items.iter().map(LazItem::size).sum();
    let mut random = Random(seed);
    let mut record = vec![0; usize::from(size)];
    let mut out = Vec::new();
    for _ in 0..count {
        out.extend(&record);
        advance(&mut record, items, &mut random);
    }
    out
}

/// Fails where a field that is decoded differs.
fn assert_same(items: &[LazItem], unpacked: &[u8], expected: &[u8]) {
    assert_eq!(unpacked.len(), expected.len());
    let size: usize = items.iter().map(|item| usize::from(item.size())).sum();
    let mut decoded = vec![!is_layered(items); size];
    if is_layered(items) {
        decoded[..12].fill(true);
        decoded[14..17].fill(true);
        if items.len() > 1
            && matches!(
                items[1].item_type(),
                LazItemType::RGB14 | LazItemType::RGBNIR14
            )
        {
            decoded[30..36].fill(true);
        }
    }
    let pairs = unpacked.chunks(size).zip(expected.chunks(size));
    for (number, (found, expected)) in pairs.enumerate() {
        for at in (0..size).filter(|&at| decoded[at]) {
            assert_eq!(found[at], expected[at], "byte {at} of point {number}");
        }
    }
}

fn all_items() -> Vec<Vec<LazItem>> {
    let mut all = Vec::new();
    for extra in [0, 3] {
        all.extend([
            LazItemRecordBuilder::version_1_of::<Point0>(extra),
            LazItemRecordBuilder::version_1_of::<Point1>(extra),
            LazItemRecordBuilder::version_1_of::<Point3>(extra),
            LazItemRecordBuilder::version_2_of::<Point0>(extra),
            LazItemRecordBuilder::version_2_of::<Point2>(extra),
            LazItemRecordBuilder::version_3_of::<Point6>(extra),
            LazItemRecordBuilder::version_3_of::<Point7>(extra),
            LazItemRecordBuilder::version_3_of::<Point8>(extra),
            LazItemRecordBuilder::version_4_of::<Point6>(extra),
            LazItemRecordBuilder::version_4_of::<Point8>(extra),
        ]);
        for format in [1, 3, 4, 5, 9, 10] {
            all.push(LazItemRecordBuilder::default_for_point_format_id(format, extra).unwrap());
        }
    }
    all
}

#[test]
fn all_point_formats_are_decompressed() {
    for (number, items) in all_items().into_iter().enumerate() {
        for (chunks, variable) in [
            (vec![3000], false),
            (vec![700; 5], false),
            (vec![1, 2, 900, 1, 60], true),
        ] {
            let case = Case {
                items: items.clone(),
                chunks,
                variable,
            };
            let total = case.chunks.iter().sum::<usize>().min(3000);
            let original = records(&items, total, number as u64);
            let packed = Packed::new(&case, &original);
            let unpacked = packed.unpack(&packed.data).unwrap();
            assert_same(&items, &unpacked, &original);
        }
    }
}

#[test]
fn points_without_chunks_are_decompressed() {
    let items = LazItemRecordBuilder::version_1_of::<Point3>(0);
    let original = records(&items, 500, 1);
    let case = Case {
        items: items.clone(),
        chunks: vec![500],
        variable: false,
    };
    let mut packed = Packed::new(&case, &original);
    // One chunk of everything has no position of a table before it.
    packed.description[0] = 1;
    let unpacked = packed.unpack(&packed.data[8..]).unwrap();
    assert_same(&items, &unpacked, &original);
}

#[test]
fn damaged_points_are_decompressed_or_refused() {
    let mut random = Random(5);
    for items in all_items() {
        let case = Case {
            items: items.clone(),
            chunks: vec![40, 30, 50],
            variable: true,
        };
        let mut packed = Packed::new(&case, &records(&items, 120, 3));
        packed.count = 1000;
        for _ in 0..60 {
            let mut data = packed.data.clone();
            for _ in 0..=random.next() % 4 {
                let at = random.next() as usize % data.len();
                data[at] = random.next() as u8;
            }
            data.truncate(data.len() - random.below(30) as usize);
            let _ = packed.unpack(&data);
        }
    }
}
