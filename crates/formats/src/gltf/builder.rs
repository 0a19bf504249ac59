//! A glTF document under construction: its lists, its binary data and its companions.

use crate::companions::Encoded;
use greenstick_geometry::Metadata;
use serde_json::{Map, Value, json};
use std::collections::{BTreeMap, BTreeSet};

const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;
const FLOAT: u32 = 5126;

/// A document under construction.
#[derive(Default)]
pub(super) struct Builder {
    lists: BTreeMap<&'static str, Vec<Value>>,
    binary: Vec<u8>,
    companions: Vec<Encoded>,
    used: BTreeSet<String>,
    required: BTreeSet<String>,
    /// Where the document comes from: extras of its asset.
    metadata: Metadata,
}

impl Builder {
    /// A document without content.
    pub fn with_metadata(metadata: Metadata) -> Self {
        Builder {
            metadata,
            ..Builder::default()
        }
    }

    /// Makes room for about as many bytes of binary data, so that they are not moved as they grow.
    pub fn reserve(&mut self, bytes: usize) {
        self.binary.reserve(bytes);
    }

    /// Appends an entry to a top-level list. Returns its index.
    pub fn push(&mut self, list: &'static str, value: Value) -> usize {
        let entries = self.lists.entry(list).or_default();
        entries.push(value);
        entries.len() - 1
    }

    /// Declares that an extension is used.
    pub fn declare_extension(&mut self, extension: &str, required: bool) {
        self.used.insert(extension.to_owned());
        if required {
            self.required.insert(extension.to_owned());
        }
    }

    /// Adds a companion file.
    pub fn add_companion(&mut self, name: String, bytes: Vec<u8>) {
        self.companions.push(Encoded { name, bytes });
    }

    /// Stores bytes in a buffer view of their own. Returns its index.
    pub fn view(&mut self, bytes: &[u8], target: Option<u32>) -> usize {
        self.view_with(target, |binary| binary.extend_from_slice(bytes))
    }

    /// Stores the bytes that `fill` appends in a buffer view of their own.
    fn view_with(&mut self, target: Option<u32>, fill: impl FnOnce(&mut Vec<u8>)) -> usize {
        self.binary.resize(self.binary.len().next_multiple_of(4), 0);
        let offset = self.binary.len();
        fill(&mut self.binary);
        let mut view = json!({
            "buffer": 0, "byteOffset": offset, "byteLength": self.binary.len() - offset
        });
        if let Some(target) = target {
            view["target"] = json!(target);
        }
        self.push("bufferViews", view)
    }

    /// Stores vertex data. Returns the accessor.
    pub fn floats(&mut self, data: &[f32], width: usize) -> usize {
        self.numbers(data, width, Some(ARRAY_BUFFER))
    }

    /// Stores column-major matrices that are not vertex data. Returns the accessor.
    pub fn matrices(&mut self, data: &[[f32; 16]]) -> usize {
        self.numbers(data.as_flattened(), 16, None)
    }

    /// Stores four joint indices for each vertex, in as few bytes as they need. Returns the accessor.
    pub fn joints(&mut self, data: &[[u16; 4]]) -> usize {
        let is_short = data.as_flattened().iter().all(|&j| j < 256);
        let view = self.view_with(Some(ARRAY_BUFFER), |binary| {
            for &j in data.as_flattened() {
                if is_short {
                    binary.push(j as u8);
                } else {
                    binary.extend_from_slice(&j.to_le_bytes());
                }
            }
        });
        let code = if is_short { 5121 } else { 5123 };
        self.push(
            "accessors",
            json!({ "bufferView": view, "componentType": code, "count": data.len(), "type": "VEC4" }),
        )
    }

    /// Stores numbers. Returns the accessor.
    fn numbers(&mut self, data: &[f32], width: usize, target: Option<u32>) -> usize {
        let view = self.view_with(target, |binary| append(binary, data, |v| v.to_le_bytes()));
        let shape = match width {
            1 => "SCALAR",
            2 => "VEC2",
            3 => "VEC3",
            4 => "VEC4",
            _ => "MAT4",
        };
        let count = data.len() / width;
        let accessor =
            json!({ "bufferView": view, "componentType": FLOAT, "count": count, "type": shape });
        self.push("accessors", accessor)
    }

    /// Stores vertex positions with their bounds. Returns the accessor.
    pub fn positions(&mut self, points: &[[f32; 3]]) -> usize {
        let accessor = self.floats(points.as_flattened(), 3);
        let first = points.first().copied().unwrap_or_default();
        let (mut low, mut high) = (first, first);
        for p in points {
            for k in 0..3 {
                low[k] = low[k].min(p[k]);
                high[k] = high[k].max(p[k]);
            }
        }
        if let Some(json) = self
            .lists
            .get_mut("accessors")
            .and_then(|l| l.get_mut(accessor))
        {
            json["min"] = json!(low.map(f64::from));
            json["max"] = json!(high.map(f64::from));
        }
        accessor
    }

    /// Stores the vertex indices of triangles. Returns the accessor.
    pub fn indices(&mut self, triangles: &[[u32; 3]], vertices: usize) -> usize {
        // 65535 is not a valid 16-bit index: it restarts primitives (§3.7.2.1).
        let is_short = vertices <= 65535;
        let indices = triangles.as_flattened();
        let view = self.view_with(Some(ELEMENT_ARRAY_BUFFER), |binary| {
            if is_short {
                append(binary, indices, |i| (i as u16).to_le_bytes());
            } else {
                append(binary, indices, |i| i.to_le_bytes());
            }
        });
        let code = if is_short { 5123 } else { 5125 };
        self.push(
            "accessors",
            json!({
                "bufferView": view, "componentType": code, "count": 3 * triangles.len(), "type": "SCALAR"
            }),
        )
    }

    /// Length of the binary data with their padding.
    pub fn binary_length(&self) -> usize {
        self.binary.len().next_multiple_of(4)
    }

    /// Finishes the document. Its binary data are stored at `uri`, or in the file itself, and are followed by `further` bytes.
    pub fn finish(mut self, uri: Option<String>, further: usize) -> Finished {
        self.binary.resize(self.binary_length(), 0);
        let mut buffer = json!({ "byteLength": self.binary.len() + further });
        if let Some(uri) = uri {
            buffer["uri"] = json!(uri);
        }
        self.push("buffers", buffer);
        let mut document = Map::new();
        let mut asset = json!({ "version": "2.0", "generator": "Greenstick" });
        if !self.metadata.is_empty() {
            let entries = self.metadata.entries.into_iter();
            let extras: Map<String, Value> = entries.map(|e| (e.name, json!(e.text))).collect();
            asset["extras"] = json!(extras);
        }
        document.insert("asset".to_owned(), asset);
        document.insert("scene".to_owned(), json!(0));
        for (key, list) in self.lists {
            document.insert(key.to_owned(), Value::Array(list));
        }
        for (key, set) in [
            ("extensionsUsed", self.used),
            ("extensionsRequired", self.required),
        ] {
            if !set.is_empty() {
                document.insert(key.to_owned(), json!(set));
            }
        }
        Finished {
            json: Value::Object(document).to_string().into_bytes(),
            binary: self.binary,
            companions: self.companions,
        }
    }
}

/// Appends numbers as bytes, in one piece.
fn append<T: Copy, const N: usize>(
    binary: &mut Vec<u8>,
    numbers: &[T],
    bytes: impl Fn(T) -> [u8; N],
) {
    let start = binary.len();
    binary.resize(start + N * numbers.len(), 0);
    let places = binary[start..].as_chunks_mut::<N>().0;
    for (place, &number) in places.iter_mut().zip(numbers) {
        *place = bytes(number);
    }
}

/// A complete document.
pub(super) struct Finished {
    /// The JSON.
    pub json: Vec<u8>,
    /// The binary data, a multiple of 4 bytes.
    pub binary: Vec<u8>,
    /// Companion files.
    pub companions: Vec<Encoded>,
}
