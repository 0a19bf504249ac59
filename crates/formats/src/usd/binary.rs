//! Writer of binary layers (`.usdc`), version 0.8.0 of the crate format of OpenUSD (`crateFile.cpp`).
//!
//! Other writers hold all time samples of an attribute in memory before they write the first; here values are written as
//! they come, and only their offsets stay in memory.

use super::coding::{encode_integers, lz4_literals};
use super::layer::{Content, Layer, Metadatum, Prim, Property, Samples, Stored, Value};
use super::paths::PathTable;
use crate::sink::Sink;
use flate2::Crc;
use std::collections::{BTreeMap, HashMap};
use std::hash::{DefaultHasher, Hasher};
use std::io::{Result, SeekFrom};

const IDENTITY: &[u8; 8] = b"PXR-USDC";
const VERSION: [u8; 8] = [0, 8, 0, 0, 0, 0, 0, 0];
/// Length of the header: identity, version, offset of the table of contents, padding.
const HEADER_SIZE: u64 = 88;
/// Shorter arrays of integers are never compressed.
const MIN_COMPRESSED_LENGTH: usize = 16;

/// Flags of a value.
const ARRAY: u64 = 1 << 63;
const INLINED: u64 = 1 << 62;
const COMPRESSED: u64 = 1 << 61;

/// Codes of the types of values.
mod code {
    pub(super) const BOOL: u64 = 1;
    pub(super) const INT: u64 = 3;
    pub(super) const INT64: u64 = 5;
    pub(super) const FLOAT: u64 = 8;
    pub(super) const DOUBLE: u64 = 9;
    pub(super) const STRING: u64 = 10;
    pub(super) const TOKEN: u64 = 11;
    pub(super) const ASSET: u64 = 12;
    pub(super) const MATRIX4D: u64 = 15;
    pub(super) const QUATF: u64 = 17;
    pub(super) const VEC2F: u64 = 20;
    pub(super) const VEC3D: u64 = 23;
    pub(super) const VEC3F: u64 = 24;
    pub(super) const VEC4F: u64 = 28;
    pub(super) const TOKEN_LIST: u64 = 32;
    pub(super) const PATH_LIST: u64 = 34;
    pub(super) const TOKEN_VECTOR: u64 = 41;
    pub(super) const SPECIFIER: u64 = 42;
    pub(super) const VARIABILITY: u64 = 44;
    pub(super) const TIME_SAMPLES: u64 = 46;
    pub(super) const DOUBLE_VECTOR: u64 = 48;
}

/// Codes of the kinds of specs.
const ATTRIBUTE: i32 = 1;
const PRIM: i32 = 6;
const LAYER: i32 = 7;
const RELATIONSHIP: i32 = 8;

/// A value that fits into its own reference.
fn inlined(code: u64, bits: u32) -> Stored {
    Stored(INLINED | code << 48 | u64::from(bits))
}

/// A field of a spec.
struct Field<'a> {
    name: &'a str,
    value: Stored,
}

impl<'a> Field<'a> {
    fn new(name: &'a str, value: Stored) -> Self {
        Field { name, value }
    }
}

/// A binary file under construction.
pub(super) struct CrateWriter<'a> {
    out: &'a mut dyn Sink,
    /// Position of the file in its destination.
    base: u64,
    /// Length of the file so far.
    at: u64,
    /// Checksum of everything but the header.
    crc: Crc,
    tokens: Table<String>,
    /// Strings, as numbers of tokens.
    strings: Table<u32>,
    /// Fields: the token of the name, and the value.
    fields: Table<(u32, u64)>,
    field_sets: Vec<i32>,
    /// For each spec its path, its fields and its kind.
    specs: [Vec<i32>; 3],
    /// Numbers of paths.
    paths: BTreeMap<String, u32>,
    /// Where values are stored, by the fingerprint of their bytes.
    stored: HashMap<Fingerprint, u64>,
}

/// Length and two hashes of bytes: different bytes have the same by chance once in 2¹²⁸ pairs.
type Fingerprint = (usize, u64, u64);

fn fingerprint(bytes: &[u8]) -> Fingerprint {
    let hash = |salt: u8| {
        let mut hasher = DefaultHasher::new();
        hasher.write_u8(salt);
        hasher.write(bytes);
        hasher.finish()
    };
    (bytes.len(), hash(0), hash(1))
}

/// Distinct items in the order in which they were added.
struct Table<T> {
    items: Vec<T>,
    numbers: BTreeMap<T, u32>,
}

impl<T: Ord + Clone> Table<T> {
    fn new() -> Self {
        Table {
            items: Vec::new(),
            numbers: BTreeMap::new(),
        }
    }

    /// Returns the number of an item and adds it if it is new.
    fn number(&mut self, item: T) -> u32 {
        let next = self.items.len() as u32;
        let number = *self.numbers.entry(item.clone()).or_insert(next);
        if number == next {
            self.items.push(item);
        }
        number
    }
}

impl<'a> CrateWriter<'a> {
    /// Starts a file at the current position of `out`.
    pub fn new(out: &'a mut dyn Sink) -> Result<Self> {
        let base = out.stream_position()?;
        out.write_all(&[0; HEADER_SIZE as usize])?;
        let mut tokens = Table::new();
        // The sign of a token's number says whether it names a property, so that no token may have number 0.
        tokens.number(String::new());
        Ok(CrateWriter {
            out,
            base,
            at: HEADER_SIZE,
            crc: Crc::new(),
            tokens,
            strings: Table::new(),
            fields: Table::new(),
            field_sets: Vec::new(),
            specs: Default::default(),
            paths: BTreeMap::new(),
            stored: HashMap::new(),
        })
    }

    /// Appends bytes.
    fn put(&mut self, bytes: &[u8]) -> Result<()> {
        self.out.write_all(bytes)?;
        self.crc.update(bytes);
        self.at += bytes.len() as u64;
        Ok(())
    }

    /// Appends a value that cannot be inlined. Equal ones, as those of instances, are stored once.
    fn append_value(&mut self, code: u64, bytes: &[u8]) -> Result<Stored> {
        let fingerprint = fingerprint(bytes);
        if let Some(&offset) = self.stored.get(&fingerprint) {
            return Ok(Stored(code << 48 | offset));
        }
        // Readers can use arrays in place only if they are aligned.
        let gap = self.at.next_multiple_of(8) - self.at;
        self.put(&[0; 8][..gap as usize])?;
        let offset = self.at;
        self.put(bytes)?;
        self.stored.insert(fingerprint, offset);
        Ok(Stored(code << 48 | offset))
    }

    /// Appends an array.
    fn array<const N: usize>(
        &mut self,
        code: u64,
        count: usize,
        numbers: impl Iterator<Item = [u8; N]>,
    ) -> Result<Stored> {
        let mut bytes = Vec::with_capacity(8 + count * N);
        bytes.extend((count as u64).to_le_bytes());
        bytes.extend(numbers.flatten());
        Ok(Stored(self.append_value(code, &bytes)?.0 | ARRAY))
    }

    /// Appends an array of vectors.
    fn floats<const N: usize>(&mut self, code: u64, list: &[[f32; N]]) -> Result<Stored> {
        if list.is_empty() {
            // An empty array has no offset.
            return Ok(Stored(ARRAY | code << 48));
        }
        let mut bytes = Vec::with_capacity(8 + 4 * N * list.len());
        bytes.extend((list.len() as u64).to_le_bytes());
        for number in list.as_flattened() {
            bytes.extend(number.to_le_bytes());
        }
        Ok(Stored(self.append_value(code, &bytes)?.0 | ARRAY))
    }

    /// Appends an array of integers.
    fn integers(&mut self, list: &[i32]) -> Result<Stored> {
        if list.len() < MIN_COMPRESSED_LENGTH {
            let numbers = list.iter().map(|n| n.to_le_bytes());
            return self.array(code::INT, list.len(), numbers);
        }
        let compressed = lz4_literals(&encode_integers(list));
        let mut bytes = Vec::with_capacity(16 + compressed.len());
        bytes.extend((list.len() as u64).to_le_bytes());
        bytes.extend((compressed.len() as u64).to_le_bytes());
        bytes.extend(compressed);
        Ok(Stored(
            self.append_value(code::INT, &bytes)?.0 | ARRAY | COMPRESSED,
        ))
    }

    /// The number of a token.
    fn token(&mut self, text: &str) -> u32 {
        self.tokens.number(text.to_owned())
    }

    /// Writes a value.
    pub fn value(&mut self, value: &Value) -> Result<Stored> {
        fn bytes<const N: usize>(numbers: &[f32; N]) -> Vec<u8> {
            numbers.iter().flat_map(|n| n.to_le_bytes()).collect()
        }
        let doubles =
            |numbers: &[f64]| -> Vec<u8> { numbers.iter().flat_map(|n| n.to_le_bytes()).collect() };
        match value {
            Value::Stored(stored) => Ok(*stored),
            Value::Bool(v) => Ok(inlined(code::BOOL, u32::from(*v))),
            Value::Int64(v) => self.append_value(code::INT64, &v.to_le_bytes()),
            Value::Float(v) => Ok(inlined(code::FLOAT, v.to_bits())),
            Value::Double(v) => self.append_value(code::DOUBLE, &v.to_le_bytes()),
            Value::Token(v) => Ok(inlined(code::TOKEN, self.token(v))),
            Value::Asset(v) => Ok(inlined(code::ASSET, self.token(v))),
            Value::Text(v) => {
                let token = self.token(v);
                Ok(inlined(code::STRING, self.strings.number(token)))
            }
            Value::Float2(v) => self.append_value(code::VEC2F, &bytes(v)),
            Value::Float3(v) => self.append_value(code::VEC3F, &bytes(v)),
            Value::Float4(v) => self.append_value(code::VEC4F, &bytes(v)),
            Value::Quaternion(v) => self.append_value(code::QUATF, &bytes(v)),
            Value::Double3(v) => self.append_value(code::VEC3D, &doubles(v)),
            Value::Matrix(rows) => self.append_value(code::MATRIX4D, &doubles(rows.as_flattened())),
            Value::Tokens(names) => {
                let numbers: Vec<u32> = names.iter().map(|n| self.token(n)).collect();
                let count = numbers.len();
                self.array(code::TOKEN, count, numbers.iter().map(|n| n.to_le_bytes()))
            }
            Value::Prepended(names) => {
                let numbers: Vec<u32> = names.iter().map(|n| self.token(n)).collect();
                self.list_op(code::TOKEN_LIST, 1 << 5, &numbers)
            }
            Value::Ints(v) => self.integers(v),
            Value::Floats(v) => self.floats(code::FLOAT, v.as_chunks::<1>().0),
            Value::Doubles(v) => {
                self.array(code::DOUBLE, v.len(), v.iter().map(|n| n.to_le_bytes()))
            }
            Value::Float2s(v) => self.floats(code::VEC2F, v),
            Value::Float3s(v) => self.floats(code::VEC3F, v),
            Value::Float4s(v) => self.floats(code::VEC4F, v),
        }
    }

    /// Writes a list operation with one kind of change.
    fn list_op(&mut self, code: u64, change: u8, numbers: &[u32]) -> Result<Stored> {
        let mut bytes = vec![change];
        bytes.extend((numbers.len() as u64).to_le_bytes());
        bytes.extend(numbers.iter().flat_map(|n| n.to_le_bytes()));
        self.append_value(code, &bytes)
    }

    /// Writes a vector of names.
    fn names<'n>(&mut self, names: impl Iterator<Item = &'n str>) -> Result<Stored> {
        let numbers: Vec<u32> = names.map(|n| self.token(n)).collect();
        let mut bytes = (numbers.len() as u64).to_le_bytes().to_vec();
        bytes.extend(numbers.iter().flat_map(|n| n.to_le_bytes()));
        self.append_value(code::TOKEN_VECTOR, &bytes)
    }

    /// Writes a list of times for [`Samples`].
    pub fn times(&mut self, times: &[f64]) -> Result<Stored> {
        let mut bytes = (times.len() as u64).to_le_bytes().to_vec();
        bytes.extend(times.iter().flat_map(|t| t.to_le_bytes()));
        self.append_value(code::DOUBLE_VECTOR, &bytes)
    }

    /// Writes time samples, whose times and values are written already.
    fn samples(&mut self, samples: &Samples) -> Result<Stored> {
        // The distance to the reference to the times, and that reference; then the same for the values.
        let mut bytes = 8_i64.to_le_bytes().to_vec();
        bytes.extend(samples.times.0.to_le_bytes());
        bytes.extend(8_i64.to_le_bytes());
        bytes.extend((samples.values.len() as u64).to_le_bytes());
        bytes.extend(samples.values.iter().flat_map(|v| v.0.to_le_bytes()));
        self.append_value(code::TIME_SAMPLES, &bytes)
    }

    /// Writes the values of a prim and its descendants at once, so that they need not stay in memory.
    pub fn store(&mut self, prim: &mut Prim) -> Result<()> {
        for property in &mut prim.properties {
            if let Content::Attribute {
                value: Some(value), ..
            } = &mut property.content
            {
                *value = Value::Stored(self.value(value)?);
            }
        }
        prim.children.iter_mut().try_for_each(|c| self.store(c))
    }

    /// Adds a spec with its fields.
    fn spec(&mut self, path: &str, kind: i32, fields: Vec<Field>) {
        let path = self.paths.get(path).copied().unwrap_or(0);
        let spec = [path as i32, self.field_sets.len() as i32, kind];
        for (list, number) in self.specs.iter_mut().zip(spec) {
            list.push(number);
        }
        for Field { name, value } in fields {
            let name = self.token(name);
            self.field_sets
                .push(self.fields.number((name, value.0)) as i32);
        }
        self.field_sets.push(-1);
    }

    /// Writes metadata as fields.
    fn metadata<'m>(&mut self, entries: &'m [Metadatum]) -> Result<Vec<Field<'m>>> {
        let write = |entry: &'m Metadatum| {
            Ok(Field {
                name: entry.key,
                value: self.value(&entry.value)?,
            })
        };
        entries.iter().map(write).collect()
    }

    /// Adds the specs of a prim and its descendants.
    fn prim(&mut self, prim: &Prim, path: &str) -> Result<()> {
        let kind = self.token(prim.kind);
        let mut fields = vec![
            Field::new("specifier", inlined(code::SPECIFIER, 0)),
            Field::new("typeName", inlined(code::TOKEN, kind)),
        ];
        fields.extend(self.metadata(&prim.metadata)?);
        if !prim.properties.is_empty() {
            let names = self.names(prim.properties.iter().map(|p| p.name.as_str()))?;
            fields.push(Field::new("properties", names));
        }
        if !prim.children.is_empty() {
            let names = self.names(prim.children.iter().map(|p| p.name.as_str()))?;
            fields.push(Field::new("primChildren", names));
        }
        self.spec(path, PRIM, fields);
        for property in &prim.properties {
            self.property(property, &format!("{path}.{}", property.name))?;
        }
        let mut children = prim.children.iter();
        children.try_for_each(|c| self.prim(c, &format!("{path}/{}", c.name)))
    }

    /// Adds the spec of a property.
    fn property(&mut self, property: &Property, path: &str) -> Result<()> {
        let mut fields = self.metadata(&property.metadata)?;
        match &property.content {
            Content::Relationship(targets) => {
                fields.push(Field::new("variability", inlined(code::VARIABILITY, 1)));
                fields.push(Field::new("targetPaths", self.targets(targets)?));
                self.spec(path, RELATIONSHIP, fields);
            }
            Content::Attribute {
                kind,
                uniform,
                custom,
                value,
                samples,
                connection,
            } => {
                let kind = self.token(kind);
                fields.push(Field::new("typeName", inlined(code::TOKEN, kind)));
                if *uniform {
                    fields.push(Field::new("variability", inlined(code::VARIABILITY, 1)));
                }
                if *custom {
                    fields.push(Field::new("custom", inlined(code::BOOL, 1)));
                }
                if let Some(value) = value {
                    fields.push(Field::new("default", self.value(value)?));
                }
                if let Some(samples) = samples {
                    fields.push(Field::new("timeSamples", self.samples(samples)?));
                }
                if let Some(path) = connection {
                    let paths = self.targets(std::slice::from_ref(path))?;
                    fields.push(Field::new("connectionPaths", paths));
                }
                self.spec(path, ATTRIBUTE, fields);
            }
        }
        Ok(())
    }

    /// Writes the paths of targets.
    fn targets(&mut self, targets: &[String]) -> Result<Stored> {
        // All targets are in the layer.
        let known = targets.iter().filter_map(|t| self.paths.get(t).copied());
        let numbers: Vec<u32> = known.collect();
        self.list_op(code::PATH_LIST, 1 | 1 << 1, &numbers)
    }

    /// Writes the tables of the layer and the header. Returns the length and the checksum of the file.
    pub fn finish(mut self, layer: &Layer) -> Result<(u64, u32)> {
        let mut table = PathTable::default();
        table.add(0, 1, false);
        self.paths.insert("/".to_owned(), 0);
        self.number_paths(&layer.root, "", true, &mut table);
        let mut fields = self.metadata(&layer.metadata)?;
        let names = self.names(std::iter::once(layer.root.name.as_str()))?;
        fields.push(Field::new("primChildren", names));
        self.spec("/", LAYER, fields);
        self.prim(&layer.root, &format!("/{}", layer.root.name))?;
        self.write_tables(&table)
    }

    /// Numbers the paths of a prim, its properties and its descendants.
    fn number_paths(&mut self, prim: &Prim, parent: &str, is_last: bool, table: &mut PathTable) {
        let path = format!("{parent}/{}", prim.name);
        let token = self.token(&prim.name);
        let own = table.len();
        self.paths.insert(path.clone(), own as u32);
        let children = prim.properties.len() + prim.children.len();
        table.add(token as i32, children, !is_last);
        for (k, property) in prim.properties.iter().enumerate() {
            let token = self.token(&property.name);
            let number = table.len() as u32;
            self.paths
                .insert(format!("{path}.{}", property.name), number);
            table.add(-(token as i32), 0, k + 1 < children);
        }
        for (k, child) in prim.children.iter().enumerate() {
            self.number_paths(child, &path, k + 1 == prim.children.len(), table);
        }
        if !is_last && children > 0 {
            table.set_subtree_size(own);
        }
    }

    /// Writes the tables, the table of contents and the header. Returns the length and the checksum of the file.
    fn write_tables(mut self, table: &PathTable) -> Result<(u64, u32)> {
        let sections = self.sections(table);
        let mut contents = (sections.len() as u64).to_le_bytes().to_vec();
        for Section { name, bytes } in &sections {
            let mut entry = [0; 16];
            entry[..name.len()].copy_from_slice(name.as_bytes());
            contents.extend(entry);
            contents.extend(self.at.to_le_bytes());
            contents.extend((bytes.len() as u64).to_le_bytes());
            self.put(bytes)?;
        }
        let offset = self.at;
        self.put(&contents)?;
        let mut header = [0; HEADER_SIZE as usize];
        header[..8].copy_from_slice(IDENTITY);
        header[8..16].copy_from_slice(&VERSION);
        header[16..24].copy_from_slice(&offset.to_le_bytes());
        self.out.seek(SeekFrom::Start(self.base))?;
        self.out.write_all(&header)?;
        self.out.seek(SeekFrom::Start(self.base + self.at))?;
        let mut crc = Crc::new();
        crc.update(&header);
        crc.combine(&self.crc);
        Ok((self.at, crc.sum()))
    }

    /// Encodes the tables.
    fn sections(&self, table: &PathTable) -> [Section; 6] {
        let mut texts = Vec::new();
        for token in &self.tokens.items {
            texts.extend(token.bytes().filter(|&b| b != 0));
            texts.push(0);
        }
        let names: Vec<i32> = self.fields.items.iter().map(|f| f.0 as i32).collect();
        let values = self.fields.items.iter().flat_map(|f| f.1.to_le_bytes());
        let values: Vec<u8> = values.collect();
        let strings = self.strings.items.iter().flat_map(|s| s.to_le_bytes());
        let integers = |list: &[i32]| sized(lz4_literals(&encode_integers(list)));
        let section = |name, parts: &[Vec<u8>]| Section {
            name,
            bytes: parts.concat(),
        };
        let count = |n: usize| (n as u64).to_le_bytes().to_vec();
        [
            section(
                "TOKENS",
                &[
                    count(self.tokens.items.len()),
                    count(texts.len()),
                    sized(lz4_literals(&texts)),
                ],
            ),
            section(
                "STRINGS",
                &[count(self.strings.items.len()), strings.collect()],
            ),
            section(
                "FIELDS",
                &[
                    count(names.len()),
                    integers(&names),
                    sized(lz4_literals(&values)),
                ],
            ),
            section(
                "FIELDSETS",
                &[count(self.field_sets.len()), integers(&self.field_sets)],
            ),
            section(
                "PATHS",
                &[
                    count(table.len()),
                    count(table.len()),
                    integers(&table.paths),
                    integers(&table.tokens),
                    integers(&table.jumps),
                ],
            ),
            section(
                "SPECS",
                &[
                    count(self.specs[0].len()),
                    integers(&self.specs[0]),
                    integers(&self.specs[1]),
                    integers(&self.specs[2]),
                ],
            ),
        ]
    }
}

/// A table of the file.
struct Section {
    name: &'static str,
    bytes: Vec<u8>,
}

/// Bytes after their number.
fn sized(bytes: Vec<u8>) -> Vec<u8> {
    [(bytes.len() as u64).to_le_bytes().to_vec(), bytes].concat()
}
