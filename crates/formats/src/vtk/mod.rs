//! VTK's XML files, for ParaView: image data (`.vti`), points and lines (`.vtp`), lists of files (`.vtm`) and of files over
//! time (`.pvd`).
//!
//! Arrays are appended raw and compressed with zlib in blocks (*VTK File Formats*, "XML file formats"), 64-bit headers.

mod image;
mod lines;
mod points;

pub use image::{Image, ImageArray, ImageNumber, compress, write_image, write_multiblock};
pub use lines::{Field, Polylines, collection, lines};
pub(crate) use points::write_points;

use greenstick_geometry::Values;

/// Uncompressed bytes of a block of an array that is compressed here.
const BLOCK: usize = 1 << 18;

/// First line of all these files.
fn opening(kind: &str, version: &str) -> String {
    format!(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"{kind}\" version=\"{version}\" byte_order=\"LittleEndian\" \
         header_type=\"UInt64\" compressor=\"vtkZLibDataCompressor\">\n"
    )
}

/// Arrays to be appended, and how long they are together.
#[derive(Default)]
struct Appended<'a> {
    arrays: Vec<(Vec<u8>, Vec<&'a [u8]>)>,
    length: usize,
}

impl<'a> Appended<'a> {
    /// Adds an array in compressed blocks, all of which hold `block` bytes but for the last, which holds `last`; gives its
    /// offset.
    fn push(&mut self, blocks: Vec<&'a [u8]>, block: usize, last: usize) -> usize {
        let offset = self.length;
        // A size of 0 says that the last block is as large as the others.
        let partial = if last == block { 0 } else { last };
        let mut head = Vec::with_capacity(8 * (3 + blocks.len()));
        let sizes = blocks.iter().map(|b| b.len());
        for number in [blocks.len(), block, partial].into_iter().chain(sizes) {
            head.extend_from_slice(&(number as u64).to_le_bytes());
        }
        self.length += head.len() + blocks.iter().map(|b| b.len()).sum::<usize>();
        self.arrays.push((head, blocks));
        offset
    }

    /// The file: its text, then the arrays.
    fn finish(self, text: String) -> Vec<u8> {
        const BEFORE: &str = "  <AppendedData encoding=\"raw\">\n_";
        const AFTER: &str = "\n  </AppendedData>\n</VTKFile>\n";
        let mut bytes = Vec::with_capacity(text.len() + self.length + 100);
        bytes.extend_from_slice(text.as_bytes());
        bytes.extend_from_slice(BEFORE.as_bytes());
        for (head, blocks) in self.arrays {
            bytes.extend_from_slice(&head);
            blocks.iter().for_each(|b| bytes.extend_from_slice(b));
        }
        bytes.extend_from_slice(AFTER.as_bytes());
        bytes
    }
}

/// An array in compressed blocks.
struct Packed {
    blocks: Vec<Vec<u8>>,
    last: usize,
}

impl Packed {
    fn of(bytes: &[u8]) -> Self {
        Packed {
            blocks: bytes.chunks(BLOCK).map(compress).collect(),
            last: match bytes.len() % BLOCK {
                0 => BLOCK,
                rest => rest,
            },
        }
    }
}

/// Adds an array: its entry, a line of the text, and its numbers.
fn add<'a>(text: &mut String, appended: &mut Appended<'a>, entry: &str, packed: &'a Packed) {
    let blocks = packed.blocks.iter().map(Vec::as_slice).collect();
    let offset = appended.push(blocks, BLOCK, packed.last);
    *text += &format!("        <DataArray {entry} format=\"appended\" offset=\"{offset}\"/>\n");
}

/// VTK's name of a type of numbers, and the numbers as bytes.
fn bytes_of(values: &Values) -> (&'static str, Vec<u8>) {
    match values {
        Values::U8(v) => ("UInt8", v.clone()),
        Values::U32(v) => ("UInt32", v.iter().flat_map(|n| n.to_le_bytes()).collect()),
        Values::F64(v) => ("Float64", v.iter().flat_map(|n| n.to_le_bytes()).collect()),
    }
}

/// A text as an XML attribute.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('"', "&quot;")
}
