//! Buffers, buffer views and accessors (§3.6): from indices in the JSON to numbers.

use super::schema::{Accessor, Compressed, Document, SparsePart};
use super::{container, meshopt};
use crate::Resolve;
use crate::error::{FormatError, InFile};
use std::borrow::Cow;
use std::cell::{Cell, OnceCell};

/// Elements an accessor without any data of its own (all zeros by §3.6.2.3) may claim, as no bytes back it.
const MOST_UNBACKED: usize = 1 << 20;

/// Bytes that decompression and copies may make of a file altogether: references are short and could each stand for
/// the whole file.
const MOST_COPIED: usize = 1 << 31;

/// The document with its data, fetched and decompressed when asked for.
pub struct Source<'a> {
    pub file: InFile<'a>,
    pub document: &'a Document,
    binary: Option<&'a [u8]>,
    resolve: Resolve<'a>,
    buffers: Vec<OnceCell<Cow<'a, [u8]>>>,
    decoded: Vec<OnceCell<Vec<u8>>>,
    copied: Cell<usize>,
}

/// Component types by their codes (§3.6.2.2).
#[derive(Clone, Copy, PartialEq)]
enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    fn of(code: u32) -> Option<Component> {
        Some(match code {
            5120 => Component::I8,
            5121 => Component::U8,
            5122 => Component::I16,
            5123 => Component::U16,
            5125 => Component::U32,
            5126 => Component::F32,
            _ => return None,
        })
    }

    fn size(self) -> usize {
        match self {
            Component::I8 | Component::U8 => 1,
            Component::I16 | Component::U16 => 2,
            Component::U32 | Component::F32 => 4,
        }
    }
}

/// Where an accessor's elements lie.
struct Layout<'b> {
    bytes: &'b [u8],
    stride: usize,
    count: usize,
    width: usize,
}

impl Layout<'_> {
    fn each<const N: usize, T>(&self, out: &mut Vec<T>, convert: impl Fn([u8; N]) -> T) {
        out.reserve(self.count * self.width);
        for element in self.bytes.chunks(self.stride.max(1)).take(self.count) {
            for raw in element.as_chunks::<N>().0.iter().take(self.width) {
                out.push(convert(*raw));
            }
        }
    }
}

impl<'a> Source<'a> {
    pub fn new(
        file: InFile<'a>,
        document: &'a Document,
        binary: Option<&'a [u8]>,
        resolve: Resolve<'a>,
    ) -> Self {
        Source {
            file,
            document,
            binary,
            resolve,
            buffers: document.buffers.iter().map(|_| OnceCell::new()).collect(),
            decoded: document
                .buffer_views
                .iter()
                .map(|_| OnceCell::new())
                .collect(),
            copied: Cell::new(0),
        }
    }

    fn missing(&self, what: &str, index: usize, count: usize) -> FormatError {
        self.file.malformed(
            format!("{what}[{index}]"),
            "a reference to it, but it does not exist",
            format!("a number below {count}"),
        )
    }

    /// Counts bytes that are about to be made from a reference, and refuses to make too many.
    pub fn charge(&self, bytes: usize, place: &str) -> Result<(), FormatError> {
        let total = self.copied.get().saturating_add(bytes);
        self.copied.set(total);
        if total <= MOST_COPIED {
            return Ok(());
        }
        let found = format!("{total} bytes unpacked so far");
        let right = format!("{MOST_COPIED} at most");
        Err(self.file.malformed(place, found, right))
    }

    fn buffer(&self, index: usize) -> Result<&[u8], FormatError> {
        let count = self.buffers.len();
        let cell = self
            .buffers
            .get(index)
            .ok_or_else(|| self.missing("buffers", index, count))?;
        if let Some(bytes) = cell.get() {
            return Ok(bytes);
        }
        let buffer = &self.document.buffers[index];
        let place = format!("buffers[{index}]");
        let bytes: Cow<'a, [u8]> = match (&buffer.uri, self.binary) {
            (None, Some(binary)) if index == 0 => Cow::Borrowed(binary),
            (None, _) => {
                let found = "neither a uri nor a binary chunk";
                return Err(self
                    .file
                    .malformed(place, found, "a uri, or a GLB's first buffer"));
            }
            (Some(uri), _) => Cow::Owned(self.fetch(uri, &place)?),
        };
        if bytes.len() < buffer.byte_length {
            let found = format!("{} bytes", bytes.len());
            let right = format!("{} bytes", buffer.byte_length);
            return Err(self.file.truncated(place, found, right));
        }
        Ok(cell.get_or_init(|| bytes))
    }

    fn fetch(&self, uri: &str, place: &str) -> Result<Vec<u8>, FormatError> {
        match container::data_uri(uri) {
            Some(Ok((_, bytes))) => Ok(bytes),
            Some(Err(found)) => Err(self.file.malformed(place, found, "base64")),
            None => {
                let path = String::from_utf8_lossy(&container::unescape(uri)).into_owned();
                (self.resolve)(&path).map_err(|source| FormatError::Companion {
                    file: self.file.0.to_owned(),
                    companion: path,
                    source,
                })
            }
        }
    }

    fn range<'b>(
        &self,
        bytes: &'b [u8],
        offset: usize,
        length: usize,
        place: &str,
    ) -> Result<&'b [u8], FormatError> {
        let end = offset.checked_add(length).filter(|&end| end <= bytes.len());
        end.map(|end| &bytes[offset..end]).ok_or_else(|| {
            let found = format!("bytes {offset} to {offset}+{length}");
            let right = format!("a range in the {} bytes there are", bytes.len());
            self.file.malformed(place, found, right)
        })
    }

    /// The bytes of a buffer view, decompressed, and its stride.
    pub fn view(&self, index: usize) -> Result<(&[u8], Option<usize>), FormatError> {
        let views = &self.document.buffer_views;
        let view = views
            .get(index)
            .ok_or_else(|| self.missing("bufferViews", index, views.len()))?;
        let place = format!("bufferViews[{index}]");
        let extension = ["EXT_meshopt_compression", "KHR_meshopt_compression"]
            .into_iter()
            .find_map(|name| view.extensions.get(name));
        let Some(extension) = extension else {
            let bytes = self.buffer(view.buffer)?;
            let bytes = self.range(bytes, view.byte_offset, view.byte_length, &place)?;
            return Ok((bytes, view.byte_stride));
        };
        if let Some(bytes) = self.decoded[index].get() {
            return Ok((bytes, view.byte_stride));
        }
        let wrong = |found: &str, right: &str| self.file.malformed(&place, found, right);
        let compressed: Compressed = serde_json::from_value(extension.clone()).map_err(|e| {
            wrong(
                &e.to_string(),
                "meshopt compression as its extension has it",
            )
        })?;
        let bytes = self.range(
            self.buffer(compressed.buffer)?,
            compressed.byte_offset,
            compressed.byte_length,
            &place,
        )?;
        let size = compressed.count.saturating_mul(compressed.byte_stride);
        self.charge(size, &place)?;
        let decoded = meshopt::decode(bytes, &compressed)
            .map_err(|found| wrong(found, "a sound meshopt stream"))?;
        let decoded = self.decoded[index].get_or_init(|| decoded);
        Ok((decoded, view.byte_stride.or(Some(compressed.byte_stride))))
    }

    fn accessor(&self, index: usize) -> Result<&'a Accessor, FormatError> {
        let accessors = &self.document.accessors;
        accessors
            .get(index)
            .ok_or_else(|| self.missing("accessors", index, accessors.len()))
    }

    fn component(&self, code: u32, place: &str) -> Result<Component, FormatError> {
        Component::of(code).ok_or_else(|| {
            let found = format!("component type {code}");
            self.file
                .malformed(place, found, "5120, 5121, 5122, 5123, 5125 or 5126")
        })
    }

    fn layout(
        &self,
        view: usize,
        offset: usize,
        (count, width, size): (usize, usize, usize),
        place: &str,
    ) -> Result<Layout<'_>, FormatError> {
        let (bytes, stride) = self.view(view)?;
        let element = width * size;
        let stride = stride.unwrap_or(element);
        if stride < element {
            let right = format!("{element} at least");
            return Err(self
                .file
                .malformed(place, format!("a stride of {stride} bytes"), right));
        }
        let bytes = bytes.get(offset..).unwrap_or_default();
        // The last element may end before its stride does.
        let possible = if bytes.len() < element {
            0
        } else {
            (bytes.len() - element) / stride + 1
        };
        if count > possible {
            return Err(FormatError::CountTooLarge {
                file: self.file.0.to_owned(),
                element: place.to_owned(),
                claimed: count as u64,
                possible: possible as u64,
                available: bytes.len() as u64,
            });
        }
        Ok(Layout {
            bytes,
            stride,
            count,
            width,
        })
    }

    /// How many elements an accessor claims and how wide they are, without looking at its data.
    fn shape(&self, accessor: &Accessor, place: &str) -> Result<usize, FormatError> {
        match accessor.shape.as_str() {
            "SCALAR" => Ok(1),
            "VEC2" => Ok(2),
            "VEC3" => Ok(3),
            "VEC4" => Ok(4),
            "MAT2" if accessor.component_type == 5126 => Ok(4),
            "MAT3" if accessor.component_type == 5126 => Ok(9),
            "MAT4" => Ok(16),
            other => {
                let found = format!("elements of type {other}");
                Err(self
                    .file
                    .malformed(place, found, "SCALAR, VEC2, VEC3, VEC4 or MAT4"))
            }
        }
    }

    /// The accessor's numbers and how many of them make an element; integers that are `normalized` become fractions
    /// (§3.11).
    pub fn numbers(&self, index: usize) -> Result<(usize, Vec<f32>), FormatError> {
        let accessor = self.accessor(index)?;
        let place = format!("accessors[{index}]");
        let width = self.shape(accessor, &place)?;
        let component = self.component(accessor.component_type, &place)?;
        let mut out = Vec::new();
        let read = |layout: Layout, out: &mut Vec<f32>| {
            let scaled = accessor.normalized;
            match component {
                Component::F32 => layout.each(out, f32::from_le_bytes),
                Component::I8 if scaled => {
                    layout.each(out, |b| (f32::from(i8::from_le_bytes(b)) / 127.0).max(-1.0));
                }
                Component::U8 if scaled => {
                    layout.each(out, |b| f32::from(u8::from_le_bytes(b)) / 255.0);
                }
                Component::I16 if scaled => {
                    layout.each(out, |b| {
                        (f32::from(i16::from_le_bytes(b)) / 32767.0).max(-1.0)
                    });
                }
                Component::U16 if scaled => {
                    layout.each(out, |b| f32::from(u16::from_le_bytes(b)) / 65535.0);
                }
                Component::I8 => layout.each(out, |b| f32::from(i8::from_le_bytes(b))),
                Component::U8 => layout.each(out, |b| f32::from(u8::from_le_bytes(b))),
                Component::I16 => layout.each(out, |b| f32::from(i16::from_le_bytes(b))),
                Component::U16 => layout.each(out, |b| f32::from(u16::from_le_bytes(b))),
                Component::U32 => layout.each(out, |b| u32::from_le_bytes(b) as f32),
            }
        };
        self.fill(
            accessor,
            (width, component.size(), 0.0),
            &place,
            read,
            &mut out,
        )?;
        Ok((width, out))
    }

    /// The accessor's whole numbers: vertex indices.
    pub fn integers(&self, index: usize) -> Result<Vec<u32>, FormatError> {
        let accessor = self.accessor(index)?;
        let place = format!("accessors[{index}]");
        let component = self.component(accessor.component_type, &place)?;
        let unsigned = matches!(component, Component::U8 | Component::U16 | Component::U32);
        if accessor.shape != "SCALAR" || !unsigned {
            let found = format!(
                "indices of type {} {}",
                accessor.shape, accessor.component_type
            );
            return Err(self
                .file
                .malformed(place, found, "SCALAR and 5121, 5123 or 5125"));
        }
        let mut out = Vec::new();
        let read = |layout: Layout, out: &mut Vec<u32>| read_unsigned(&layout, component, out);
        self.fill(accessor, (1, component.size(), 0), &place, read, &mut out)?;
        Ok(out)
    }

    /// Reads the elements through `read`, then puts the sparse ones in their places.
    fn fill<T: Copy>(
        &self,
        accessor: &Accessor,
        (width, size, zero): (usize, usize, T),
        place: &str,
        read: impl Fn(Layout, &mut Vec<T>),
        out: &mut Vec<T>,
    ) -> Result<(), FormatError> {
        match accessor.buffer_view {
            Some(view) => {
                let shape = (accessor.count, width, size);
                read(self.layout(view, accessor.byte_offset, shape, place)?, out);
            }
            None => {
                if accessor.count > MOST_UNBACKED {
                    return Err(FormatError::CountTooLarge {
                        file: self.file.0.to_owned(),
                        element: format!("{place}, which has no bufferView,"),
                        claimed: accessor.count as u64,
                        possible: MOST_UNBACKED as u64,
                        available: 0,
                    });
                }
                out.resize(accessor.count * width, zero);
            }
        }
        let Some(sparse) = &accessor.sparse else {
            return Ok(());
        };
        let part = |part: &SparsePart, width: usize, size: usize| {
            let shape = (sparse.count, width, size);
            self.layout(
                part.buffer_view,
                part.byte_offset,
                shape,
                &format!("{place}.sparse"),
            )
        };
        let component = self.component(
            sparse.indices.component_type.unwrap_or(0),
            &format!("{place}.sparse"),
        )?;
        let mut places = Vec::new();
        read_unsigned(
            &part(&sparse.indices, 1, component.size())?,
            component,
            &mut places,
        );
        let mut values = Vec::new();
        read(part(&sparse.values, width, size)?, &mut values);
        for (&at, value) in places.iter().zip(values.chunks_exact(width)) {
            let at = at as usize;
            if at >= accessor.count {
                let found = format!("index {at}");
                let right = format!("indices below {}", accessor.count);
                return Err(self.file.malformed(format!("{place}.sparse"), found, right));
            }
            out[at * width..][..width].copy_from_slice(value);
        }
        Ok(())
    }
}

fn read_unsigned(layout: &Layout, component: Component, out: &mut Vec<u32>) {
    match component {
        Component::U8 | Component::I8 => layout.each(out, |b: [u8; 1]| b[0].into()),
        Component::U16 | Component::I16 => layout.each(out, |b| u16::from_le_bytes(b).into()),
        Component::U32 | Component::F32 => layout.each(out, u32::from_le_bytes),
    }
}
