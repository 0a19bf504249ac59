//! Reading buffers, buffer views and accessors (§3.6).

use super::schema::{Accessor, Compressed, Document, SparsePart};
use super::{container, meshopt};
use crate::companions::Resolve;
use crate::error::{FormatError, InFile};
use crate::uri::unescape;
use std::borrow::Cow;
use std::cell::{Cell, OnceCell};

/// Most elements of an accessor without a buffer view, which is all zeros by §3.6.2.3: no bytes in the file bound them.
pub(super) const MAX_ZERO_ELEMENTS: usize = 1 << 20;

/// Most bytes that decompression and copying may produce: references are short, and each could stand for the whole file.
const MAX_UNPACKED_SIZE: usize = 1 << 31;

/// The document with its data, which are fetched and decompressed on demand.
pub(super) struct Source<'a> {
    pub file: InFile<'a>,
    pub document: &'a Document,
    binary: Option<&'a [u8]>,
    resolve: Resolve<'a>,
    buffers: Vec<OnceCell<Cow<'a, [u8]>>>,
    decoded: Vec<OnceCell<Vec<u8>>>,
    copied: Cell<usize>,
}

/// Component types (§3.6.2.2).
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
    fn from_code(code: u32) -> Option<Component> {
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

/// The elements of an accessor in a buffer view.
struct Layout<'b> {
    bytes: &'b [u8],
    stride: usize,
    count: usize,
    width: usize,
}

/// The number and size of elements.
#[derive(Clone, Copy)]
struct Shape {
    count: usize,
    /// Components of an element.
    width: usize,
    /// Bytes of a component.
    size: usize,
}

impl Layout<'_> {
    /// Converts all components of all elements.
    fn convert<const N: usize, T>(&self, out: &mut Vec<T>, convert: impl Fn([u8; N]) -> T) {
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

    /// The error for a reference to an entry that does not exist.
    fn missing(&self, list: &str, index: usize, count: usize) -> FormatError {
        self.file.malformed(
            format!("{list}[{index}]"),
            "it is referred to, but does not exist",
            format!("a number below {count}"),
        )
    }

    /// Counts bytes that are about to be produced from a reference, and refuses too many.
    pub fn charge(&self, bytes: usize, place: &str) -> Result<(), FormatError> {
        let total = self.copied.get().saturating_add(bytes);
        self.copied.set(total);
        if total <= MAX_UNPACKED_SIZE {
            return Ok(());
        }
        let found = format!("{total} bytes unpacked so far");
        let right = format!("{MAX_UNPACKED_SIZE} at most");
        Err(self.file.malformed(place, found, right))
    }

    /// The bytes of a buffer.
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
                let found = "it has neither a uri nor a binary chunk";
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

    /// Reads a buffer from its URI.
    fn fetch(&self, uri: &str, place: &str) -> Result<Vec<u8>, FormatError> {
        match container::data_uri(uri) {
            Some(Ok((_, bytes))) => Ok(bytes),
            Some(Err(found)) => Err(self.file.malformed(place, found, "base64")),
            None => {
                let path = String::from_utf8_lossy(&unescape(uri)).into_owned();
                (self.resolve)(&path).map_err(|source| FormatError::Companion {
                    file: self.file.0.to_owned(),
                    companion: path,
                    source,
                })
            }
        }
    }

    /// A range of bytes.
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
            let right = format!("a range within {} bytes", bytes.len());
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
        let compressed: Compressed = serde_json::from_value(extension.clone())
            .map_err(|e| wrong(&e.to_string(), "the properties of the meshopt extension"))?;
        let bytes = self.range(
            self.buffer(compressed.buffer)?,
            compressed.byte_offset,
            compressed.byte_length,
            &place,
        )?;
        let size = compressed.count.saturating_mul(compressed.byte_stride);
        self.charge(size, &place)?;
        let decoded = meshopt::decode(bytes, &compressed)
            .map_err(|found| wrong(found, "a valid meshopt stream"))?;
        let decoded = self.decoded[index].get_or_init(|| decoded);
        Ok((decoded, view.byte_stride.or(Some(compressed.byte_stride))))
    }

    /// An entry of the list of accessors.
    fn accessor(&self, index: usize) -> Result<&'a Accessor, FormatError> {
        let accessors = &self.document.accessors;
        accessors
            .get(index)
            .ok_or_else(|| self.missing("accessors", index, accessors.len()))
    }

    fn component(&self, code: u32, place: &str) -> Result<Component, FormatError> {
        Component::from_code(code).ok_or_else(|| {
            let found = format!("component type {code}");
            self.file
                .malformed(place, found, "5120, 5121, 5122, 5123, 5125 or 5126")
        })
    }

    /// The elements that start at `offset` of a buffer view.
    fn layout(
        &self,
        view: usize,
        offset: usize,
        shape: Shape,
        place: &str,
    ) -> Result<Layout<'_>, FormatError> {
        let Shape { count, width, size } = shape;
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
        // The last element need not fill its stride.
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

    /// The number of components of an element.
    fn width(&self, accessor: &Accessor, place: &str) -> Result<usize, FormatError> {
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

    /// Reads an accessor as numbers. Returns the number of components of an element and all components; `normalized`
    /// integers become fractions (§3.11).
    pub fn numbers(&self, index: usize) -> Result<(usize, Vec<f32>), FormatError> {
        let accessor = self.accessor(index)?;
        let place = format!("accessors[{index}]");
        let width = self.width(accessor, &place)?;
        let component = self.component(accessor.component_type, &place)?;
        let read = |layout: Layout, out: &mut Vec<f32>| {
            let scaled = accessor.normalized;
            match component {
                Component::F32 => layout.convert(out, f32::from_le_bytes),
                Component::I8 if scaled => {
                    layout.convert(out, |b| (f32::from(i8::from_le_bytes(b)) / 127.0).max(-1.0));
                }
                Component::U8 if scaled => {
                    layout.convert(out, |b| f32::from(u8::from_le_bytes(b)) / 255.0);
                }
                Component::I16 if scaled => {
                    layout.convert(out, |b| {
                        (f32::from(i16::from_le_bytes(b)) / 32767.0).max(-1.0)
                    });
                }
                Component::U16 if scaled => {
                    layout.convert(out, |b| f32::from(u16::from_le_bytes(b)) / 65535.0);
                }
                Component::I8 => layout.convert(out, |b| f32::from(i8::from_le_bytes(b))),
                Component::U8 => layout.convert(out, |b| f32::from(u8::from_le_bytes(b))),
                Component::I16 => layout.convert(out, |b| f32::from(i16::from_le_bytes(b))),
                Component::U16 => layout.convert(out, |b| f32::from(u16::from_le_bytes(b))),
                Component::U32 => layout.convert(out, |b| u32::from_le_bytes(b) as f32),
            }
        };
        let numbers = self.fill(accessor, width, component.size(), &place, read)?;
        Ok((width, numbers))
    }

    /// Reads an accessor as unsigned integers: vertex indices.
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
        let read = |layout: Layout, out: &mut Vec<u32>| read_unsigned(&layout, component, out);
        self.fill(accessor, 1, component.size(), &place, read)
    }

    /// Reads the elements through `read`, then replaces those that are stored sparsely.
    fn fill<T: Copy + Default>(
        &self,
        accessor: &Accessor,
        width: usize,
        size: usize,
        place: &str,
        read: impl Fn(Layout, &mut Vec<T>),
    ) -> Result<Vec<T>, FormatError> {
        let mut out = Vec::new();
        match accessor.buffer_view {
            Some(view) => {
                let shape = Shape {
                    count: accessor.count,
                    width,
                    size,
                };
                read(
                    self.layout(view, accessor.byte_offset, shape, place)?,
                    &mut out,
                );
            }
            None => {
                if accessor.count > MAX_ZERO_ELEMENTS {
                    return Err(FormatError::CountTooLarge {
                        file: self.file.0.to_owned(),
                        element: format!("{place}, which has no bufferView,"),
                        claimed: accessor.count as u64,
                        possible: MAX_ZERO_ELEMENTS as u64,
                        available: 0,
                    });
                }
                if accessor.sparse.is_none() {
                    return Err(self.file.malformed(
                        place,
                        "neither a bufferView nor sparse values, so that all of its numbers are 0",
                        "a bufferView",
                    ));
                }
                out.resize(accessor.count * width, T::default());
            }
        }
        let Some(sparse) = &accessor.sparse else {
            return Ok(out);
        };
        let part = |part: &SparsePart, width: usize, size: usize| {
            let shape = Shape {
                count: sparse.count,
                width,
                size,
            };
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
        Ok(out)
    }
}

/// Reads unsigned integers of any size.
fn read_unsigned(layout: &Layout, component: Component, out: &mut Vec<u32>) {
    match component {
        Component::U8 | Component::I8 => layout.convert(out, |b: [u8; 1]| b[0].into()),
        Component::U16 | Component::I16 => layout.convert(out, |b| u16::from_le_bytes(b).into()),
        Component::U32 | Component::F32 => layout.convert(out, u32::from_le_bytes),
    }
}
