//! Appended arrays, and other parts that all files share.

use flate2::{Compression, write::ZlibEncoder};
use greenstick_geometry::{Metadata, MetadataEntry, Values};
use std::io::Write;

/// Uncompressed size of the blocks of an array.
const BLOCK_SIZE: usize = 1 << 18;

/// The start of a file of some type.
pub(super) fn file_start(kind: &str, version: &str) -> String {
    format!(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"{kind}\" version=\"{version}\" byte_order=\"LittleEndian\" \
         header_type=\"UInt64\" compressor=\"vtkZLibDataCompressor\">\n"
    )
}

/// An array with its header.
struct AppendedArray<'a> {
    header: Vec<u8>,
    blocks: Vec<&'a [u8]>,
}

/// The arrays to append to the text of a file.
#[derive(Default)]
pub(super) struct Appended<'a> {
    arrays: Vec<AppendedArray<'a>>,
    /// Total length.
    length: usize,
}

impl<'a> Appended<'a> {
    /// Adds an array of compressed blocks. Each contains `block` uncompressed bytes, except the last one, which contains `last`.
    /// Returns the offset of the array.
    pub fn push(&mut self, blocks: Vec<&'a [u8]>, block: usize, last: usize) -> usize {
        let offset = self.length;
        // A size of 0 means that the last block is as large as the others.
        let partial = if last == block { 0 } else { last };
        let mut header = Vec::with_capacity(8 * (3 + blocks.len()));
        let sizes = blocks.iter().map(|b| b.len());
        for number in [blocks.len(), block, partial].into_iter().chain(sizes) {
            header.extend_from_slice(&(number as u64).to_le_bytes());
        }
        self.length += header.len() + blocks.iter().map(|b| b.len()).sum::<usize>();
        self.arrays.push(AppendedArray { header, blocks });
        offset
    }

    /// Returns the file: its text, followed by the arrays.
    pub fn finish(self, text: String) -> Vec<u8> {
        const BEFORE: &str = "  <AppendedData encoding=\"raw\">\n_";
        const AFTER: &str = "\n  </AppendedData>\n</VTKFile>\n";
        let mut bytes = Vec::with_capacity(text.len() + self.length + 100);
        bytes.extend_from_slice(text.as_bytes());
        bytes.extend_from_slice(BEFORE.as_bytes());
        for AppendedArray { header, blocks } in self.arrays {
            bytes.extend_from_slice(&header);
            blocks.iter().for_each(|b| bytes.extend_from_slice(b));
        }
        bytes.extend_from_slice(AFTER.as_bytes());
        bytes
    }
}

/// An array in compressed blocks.
pub(super) struct CompressedArray {
    blocks: Vec<Vec<u8>>,
    /// Uncompressed size of the last block.
    last: usize,
}

impl CompressedArray {
    /// Compresses an array.
    pub fn new(bytes: &[u8]) -> Self {
        CompressedArray {
            blocks: bytes.chunks(BLOCK_SIZE).map(compress).collect(),
            last: match bytes.len() % BLOCK_SIZE {
                0 => BLOCK_SIZE,
                rest => rest,
            },
        }
    }
}

/// Adds an array, with its attributes in the text.
pub(super) fn add_array<'a>(
    text: &mut String,
    appended: &mut Appended<'a>,
    attributes: &str,
    array: &'a CompressedArray,
) {
    let blocks = array.blocks.iter().map(Vec::as_slice).collect();
    let offset = appended.push(blocks, BLOCK_SIZE, array.last);
    *text +=
        &format!("        <DataArray {attributes} format=\"appended\" offset=\"{offset}\"/>\n");
}

/// The VTK name of the type of values, and the values as bytes.
pub(super) fn bytes_of(values: &Values) -> (&'static str, Vec<u8>) {
    match values {
        Values::U8(v) => ("UInt8", v.clone()),
        Values::U32(v) => ("UInt32", v.iter().flat_map(|n| n.to_le_bytes()).collect()),
        Values::F64(v) => ("Float64", v.iter().flat_map(|n| n.to_le_bytes()).collect()),
        Values::Text(v) => {
            let ended = v.iter().flat_map(|text| text.bytes().chain([0]));
            ("String", ended.collect())
        }
    }
}

/// Metadata as field data of a data set: an array of one string each, written as the codes of its bytes and a 0.
pub(super) fn field_data(metadata: &Metadata) -> String {
    if metadata.is_empty() {
        return String::new();
    }
    let mut text = String::from("    <FieldData>\n");
    for MetadataEntry { name, text: value } in &metadata.entries {
        let codes: Vec<String> = value.bytes().chain([0]).map(|b| b.to_string()).collect();
        text += &format!(
            "      <DataArray type=\"String\" Name=\"{}\" NumberOfTuples=\"1\" format=\"ascii\">\n        {}\n      </DataArray>\n",
            escape(name),
            codes.join(" ")
        );
    }
    text + "    </FieldData>\n"
}

/// Escapes text for an XML attribute.
pub(super) fn escape(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('"', "&quot;")
}

/// Compression level: on runs of equal numbers, higher levels cost more time than they save space.
const COMPRESSION_LEVEL: u32 = 2;

/// Compresses bytes as a zlib stream.
pub fn compress(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::new(COMPRESSION_LEVEL));
    // Writing to memory cannot fail.
    let _ = encoder.write_all(bytes);
    encoder.finish().unwrap_or_default()
}
