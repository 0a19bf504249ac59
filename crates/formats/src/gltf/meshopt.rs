//! Decoder of meshopt-compressed buffer views, after Appendix A of the glTF extensions `EXT_meshopt_compression`
//! (ratified) and `KHR_meshopt_compression`, which adds version 1 of the attribute stream.

use super::meshopt_filter::{Filter, undo};
use super::schema::Compressed;

/// Decodes a compressed view to `count · byteStride` bytes. The error describes the fault of the stream.
pub(super) fn decode(bytes: &[u8], view: &Compressed) -> Result<Vec<u8>, &'static str> {
    let filter =
        Filter::from_name(view.filter.as_deref().unwrap_or("NONE")).ok_or("unknown filter")?;
    let stride = view.byte_stride;
    let indices = view.mode != "ATTRIBUTES";
    if indices && !(matches!(stride, 2 | 4) && filter == Filter::None) {
        return Err("indices with a filter or with a stride other than 2 or 4");
    }
    let values = match view.mode.as_str() {
        "ATTRIBUTES" => {
            let mut data = decode_attributes(bytes, view.count, stride)?;
            undo(filter, &mut data, stride)?;
            return Ok(data);
        }
        "TRIANGLES" => decode_triangles(bytes, view.count)?,
        "INDICES" => decode_indices(bytes, view.count)?,
        _ => return Err("unknown mode"),
    };
    Ok(match stride {
        2 => values
            .iter()
            .flat_map(|&v| (v as u16).to_le_bytes())
            .collect(),
        _ => values.iter().flat_map(|&v| v.to_le_bytes()).collect(),
    })
}

/// The rest of a stream, read from the front.
struct Stream<'a>(&'a [u8]);

const ENDS_EARLY: &str = "a stream that ends too early";

impl<'a> Stream<'a> {
    /// Reads `n` bytes.
    fn take(&mut self, n: usize) -> Result<&'a [u8], &'static str> {
        let (head, rest) = self.0.split_at_checked(n).ok_or(ENDS_EARLY)?;
        self.0 = rest;
        Ok(head)
    }

    /// Reads one byte.
    fn byte(&mut self) -> Result<u8, &'static str> {
        Ok(self.take(1)?[0])
    }

    /// Reads a variable-length integer of 1 to 5 bytes with 7 bits each, least significant first.
    fn varint(&mut self) -> Result<u32, &'static str> {
        let mut value = 0;
        for shift in (0..35).step_by(7) {
            let byte = self.byte()?;
            value |= u32::from(byte & 0x7f) << shift;
            if byte < 0x80 {
                return Ok(value);
            }
        }
        Err("a number longer than 5 bytes")
    }
}

/// Decodes the zigzag code: even numbers are positive, odd ones negative.
fn unzigzag(v: u32) -> u32 {
    (v >> 1) ^ (v & 1).wrapping_neg()
}

/// Elements of a group.
const GROUP_SIZE: usize = 16;
/// Most elements of a block.
const MAX_BLOCK_ELEMENTS: usize = 256;

/// Decodes mode 0: differences between the bytes of consecutive elements, one byte position after another.
fn decode_attributes(bytes: &[u8], count: usize, stride: usize) -> Result<Vec<u8>, &'static str> {
    if stride == 0 || stride > 256 || !stride.is_multiple_of(4) {
        return Err("a stride that is not a multiple of 4 up to 256");
    }
    let mut stream = Stream(bytes);
    let is_version_1 = match stream.byte()? {
        0xa0 => false,
        0xa1 => true,
        _ => return Err("an attribute stream of an unknown version"),
    };
    let tail_size = stride + if is_version_1 { stride / 4 } else { 0 };
    let padded = tail_size.max(if is_version_1 { 24 } else { 32 });
    let body = stream.0.len().checked_sub(padded).ok_or(ENDS_EARLY)?;
    let tail = &stream.0[stream.0.len() - tail_size..];
    stream.0 = &stream.0[..body];
    let (baseline, channels) = tail.split_at(stride);
    if channels
        .iter()
        .any(|&c| c & 15 > 2 || (c & 15 < 2 && c >> 4 != 0))
    {
        return Err("an unknown channel mode");
    }
    let block = (8192 / stride / GROUP_SIZE * GROUP_SIZE).min(MAX_BLOCK_ELEMENTS);
    // Every block has header or control bytes for each byte position, which bounds the size of the output.
    let least = if is_version_1 { stride / 4 } else { stride };
    if count
        .div_ceil(block)
        .checked_mul(least)
        .is_none_or(|size| size > body)
    {
        return Err("more elements than the stream can hold");
    }
    let mut out = vec![0; count * stride];
    let mut last: [u8; 256] = [0; 256];
    last[..stride].copy_from_slice(baseline);
    let mut deltas = vec![[0_u8; MAX_BLOCK_ELEMENTS]; stride];
    for part in out.chunks_mut(block * stride) {
        let elements = part.len() / stride;
        let control = if is_version_1 {
            stream.take(stride / 4)?
        } else {
            &[]
        };
        for (k, row) in deltas.iter_mut().enumerate() {
            let mode = control.get(k / 4).map(|c| c >> (2 * (k % 4)) & 3);
            decode_block(
                &mut stream,
                mode,
                &mut row[..elements.next_multiple_of(GROUP_SIZE)],
                elements,
            )?;
        }
        for channel in 0..stride / 4 {
            let rows = &deltas[4 * channel..4 * channel + 4];
            let mode = channels.get(channel).copied().unwrap_or(0);
            let previous = &mut last[4 * channel..4 * channel + 4];
            for (i, element) in part.chunks_exact_mut(stride).enumerate() {
                let delta = [rows[0][i], rows[1][i], rows[2][i], rows[3][i]];
                let value = add_delta(
                    [previous[0], previous[1], previous[2], previous[3]],
                    delta,
                    mode,
                );
                previous.copy_from_slice(&value);
                element[4 * channel..4 * channel + 4].copy_from_slice(&value);
            }
        }
    }
    if stream.0.is_empty() {
        Ok(out)
    } else {
        Err("bytes left over after the last element")
    }
}

/// Adds differences to four bytes of the previous element, in the mode of the channel.
fn add_delta(previous: [u8; 4], delta: [u8; 4], mode: u8) -> [u8; 4] {
    match mode & 15 {
        0 => std::array::from_fn(|k| previous[k].wrapping_add(unzigzag(delta[k].into()) as u8)),
        1 => {
            let half = |k: usize| {
                let d = unzigzag(u16::from_le_bytes([delta[k], delta[k + 1]]).into()) as u16;
                u16::from_le_bytes([previous[k], previous[k + 1]])
                    .wrapping_add(d)
                    .to_le_bytes()
            };
            let (low, high) = (half(0), half(2));
            [low[0], low[1], high[0], high[1]]
        }
        _ => {
            let d = u32::from_le_bytes(delta).rotate_left(u32::from(mode >> 4));
            (u32::from_le_bytes(previous) ^ d).to_le_bytes()
        }
    }
}

/// Decodes the differences of one byte position in one block. `mode` is the control mode of version 1.
fn decode_block(
    stream: &mut Stream,
    mode: Option<u8>,
    out: &mut [u8],
    elements: usize,
) -> Result<(), &'static str> {
    let widths: [u32; 4] = match mode {
        None => [0, 2, 4, 8],
        Some(0) => [0, 1, 2, 4],
        Some(1) => [1, 2, 4, 8],
        Some(2) => {
            out.fill(0);
            return Ok(());
        }
        Some(_) => {
            out[..elements].copy_from_slice(stream.take(elements)?);
            return Ok(());
        }
    };
    let header = stream.take((out.len() / GROUP_SIZE).div_ceil(4))?;
    for (g, group) in out.chunks_exact_mut(GROUP_SIZE).enumerate() {
        let width = widths[usize::from(header[g / 4] >> (2 * (g % 4)) & 3)];
        match width {
            0 => group.fill(0),
            8 => group.copy_from_slice(stream.take(GROUP_SIZE)?),
            _ => {
                let packed = stream.take(GROUP_SIZE * width as usize / 8)?;
                let sentinel = (1 << width) - 1;
                for (i, delta) in group.iter_mut().enumerate() {
                    let bit = i as u32 * width;
                    let byte = packed[bit as usize / 8];
                    // Single bits start at the least significant bit, wider fields at the most significant one.
                    let shift = if width == 1 {
                        bit % 8
                    } else {
                        8 - width - bit % 8
                    };
                    let value = byte >> shift & sentinel;
                    *delta = if value == sentinel {
                        stream.byte()?
                    } else {
                        value
                    };
                }
            }
        }
    }
    Ok(())
}

/// The last 16 entries, the newest at index 0.
struct Recent<T> {
    entries: [Option<T>; 16],
    next: usize,
}

impl<T: Copy> Recent<T> {
    fn new() -> Self {
        Recent {
            entries: [None; 16],
            next: 0,
        }
    }

    fn push(&mut self, entry: T) {
        self.entries[self.next] = Some(entry);
        self.next = (self.next + 1) % 16;
    }

    fn get(&self, age: usize) -> Result<T, &'static str> {
        self.entries[(self.next + 15 - age) % 16].ok_or("a reference before the first triangle")
    }
}

/// State of the triangle decoder.
struct TriangleDecoder<'a> {
    data: Stream<'a>,
    next: u32,
    last: u32,
    edges: Recent<[u32; 2]>,
    vertices: Recent<u32>,
}

impl TriangleDecoder<'_> {
    /// The next vertex that was not used before.
    fn new_vertex(&mut self) -> u32 {
        let index = self.next;
        self.next = self.next.wrapping_add(1);
        index
    }

    /// A vertex stored as the difference from the last one stored.
    fn explicit_vertex(&mut self) -> Result<u32, &'static str> {
        self.last = self.last.wrapping_add(unzigzag(self.data.varint()?));
        Ok(self.last)
    }

    /// Decodes a corner from its four bits: the next vertex, a recent one, or an explicit one. Also returns whether it is
    /// to be added to the recent vertices.
    fn corner(&mut self, code: u8) -> Result<(u32, bool), &'static str> {
        match code {
            0 => Ok((self.new_vertex(), true)),
            15 => Ok((self.explicit_vertex()?, true)),
            z => Ok((self.vertices.get(usize::from(z) - 1)?, false)),
        }
    }

    /// Decodes a triangle that shares a recent edge.
    fn triangle_on_edge(&mut self, x: u8, y: u8) -> Result<[u32; 3], &'static str> {
        let [a, b] = self.edges.get(usize::from(x))?;
        let (c, remember) = match y {
            0 => (self.new_vertex(), true),
            0xd | 0xe => {
                let step = if y == 0xd { u32::MAX } else { 1 };
                self.last = self.last.wrapping_add(step);
                (self.last, true)
            }
            0xf => (self.explicit_vertex()?, true),
            _ => (self.vertices.get(usize::from(y))?, false),
        };
        self.edges.push([c, b]);
        self.edges.push([a, c]);
        if remember {
            self.vertices.push(c);
        }
        Ok([a, b, c])
    }

    /// Decodes a triangle that shares no recent edge.
    fn separate_triangle(&mut self, y: u8, table: &[u8]) -> Result<[u32; 3], &'static str> {
        let pair = if y < 0xe {
            table[usize::from(y)]
        } else {
            self.data.byte()?
        };
        if y >= 0xe && pair == 0 {
            self.next = 0;
        }
        let a = if y == 0xf {
            self.explicit_vertex()?
        } else {
            self.new_vertex()
        };
        let (b, remember_b) = self.corner(pair >> 4)?;
        let (c, remember_c) = self.corner(pair & 15)?;
        for edge in [[b, a], [c, b], [a, c]] {
            self.edges.push(edge);
        }
        self.vertices.push(a);
        for (vertex, remember) in [(b, remember_b), (c, remember_c)] {
            if remember {
                self.vertices.push(vertex);
            }
        }
        Ok([a, b, c])
    }
}

/// Decodes mode 1: triangles by the edges that they share with recent ones.
fn decode_triangles(bytes: &[u8], count: usize) -> Result<Vec<u32>, &'static str> {
    if !count.is_multiple_of(3) {
        return Err("a number of indices that is not a multiple of 3");
    }
    let mut stream = Stream(bytes);
    if stream.byte()? != 0xe1 {
        return Err("a triangle stream of an unknown version");
    }
    let codes = stream.take(count / 3)?;
    let table_at = stream.0.len().checked_sub(16).ok_or(ENDS_EARLY)?;
    let (data, table) = stream.0.split_at(table_at);
    if table[14..] != [0, 0] || table.iter().any(|t| t >> 4 == 15 || t & 15 == 15) {
        return Err("an invalid table of triangle codes");
    }
    let mut state = TriangleDecoder {
        data: Stream(data),
        next: 0,
        last: 0,
        edges: Recent::new(),
        vertices: Recent::new(),
    };
    let mut out = Vec::with_capacity(count);
    for &code in codes {
        let (x, y) = (code >> 4, code & 15);
        let triangle = if x < 15 {
            state.triangle_on_edge(x, y)?
        } else {
            state.separate_triangle(y, table)?
        };
        out.extend_from_slice(&triangle);
    }
    if state.data.0.is_empty() {
        Ok(out)
    } else {
        Err("bytes left over after the last triangle")
    }
}

/// Decodes mode 2: indices as differences from one of two earlier ones.
fn decode_indices(bytes: &[u8], count: usize) -> Result<Vec<u32>, &'static str> {
    let mut stream = Stream(bytes);
    if stream.byte()? != 0xd1 {
        return Err("an index stream of an unknown version");
    }
    let body = stream.0.len().checked_sub(4).ok_or(ENDS_EARLY)?;
    stream.0 = &stream.0[..body];
    if count > body {
        return Err("more indices than the stream can hold");
    }
    let mut last = [0_u32; 2];
    let mut out = Vec::with_capacity(count);
    for _ in 0..count {
        let v = stream.varint()?;
        let baseline = &mut last[(v & 1) as usize];
        *baseline = baseline.wrapping_add(unzigzag(v >> 1));
        out.push(*baseline);
    }
    if stream.0.is_empty() {
        Ok(out)
    } else {
        Err("bytes left over after the last index")
    }
}

#[cfg(test)]
mod tests;
