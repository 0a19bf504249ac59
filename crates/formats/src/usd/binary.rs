//! A layer as a binary file (`.usdc`), version 0.8.0 of the crate format, as OpenUSD's `crateFile.cpp` reads it.
//!
//! A writer of our own, since those there are hold every value of an attribute over time before they write the first:
//! here values go to the file as they come, and only where they lie is kept.

use super::coding::{block, integers};
use super::layer::{Content, Layer, Prim, Property, Samples, Stored, Value};
use crate::film::Sink;
use flate2::Crc;
use std::collections::BTreeMap;
use std::io::{Result, SeekFrom};

const IDENTITY: &[u8; 8] = b"PXR-USDC";
const VERSION: [u8; 8] = [0, 8, 0, 0, 0, 0, 0, 0];
/// Length of what stands at the file's beginning: identity, version, place of the contents, room.
const HEAD: u64 = 88;
/// Arrays of fewer whole numbers are never packed.
const LEAST_PACKED: usize = 16;

const ARRAY: u64 = 1 << 63;
const INLINED: u64 = 1 << 62;
const PACKED: u64 = 1 << 61;

/// Codes of types.
mod kind {
    pub const BOOL: u64 = 1;
    pub const INT: u64 = 3;
    pub const INT64: u64 = 5;
    pub const FLOAT: u64 = 8;
    pub const DOUBLE: u64 = 9;
    pub const STRING: u64 = 10;
    pub const TOKEN: u64 = 11;
    pub const ASSET: u64 = 12;
    pub const MATRIX4D: u64 = 15;
    pub const QUATF: u64 = 17;
    pub const VEC2F: u64 = 20;
    pub const VEC3D: u64 = 23;
    pub const VEC3F: u64 = 24;
    pub const VEC4F: u64 = 28;
    pub const TOKEN_LIST: u64 = 32;
    pub const PATH_LIST: u64 = 34;
    pub const TOKEN_VECTOR: u64 = 41;
    pub const SPECIFIER: u64 = 42;
    pub const VARIABILITY: u64 = 44;
    pub const TIME_SAMPLES: u64 = 46;
    pub const DOUBLE_VECTOR: u64 = 48;
}

/// Codes of specs.
const ATTRIBUTE: i32 = 1;
const PRIM: i32 = 6;
const LAYER: i32 = 7;
const RELATIONSHIP: i32 = 8;

fn inlined(kind: u64, bits: u32) -> Stored {
    Stored(INLINED | kind << 48 | u64::from(bits))
}

/// A binary file under construction.
pub struct Crate<'a> {
    out: &'a mut dyn Sink,
    /// Where the file begins in what it is written to.
    base: u64,
    at: u64,
    /// Of everything but the head.
    crc: Crc,
    tokens: Table<String>,
    /// Texts, as numbers of tokens.
    strings: Table<u32>,
    fields: Table<(u32, u64)>,
    sets: Vec<i32>,
    /// Of each spec its path, its fields and its kind.
    specs: [Vec<i32>; 3],
    paths: BTreeMap<String, u32>,
}

/// Different things in the order in which they came.
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

    fn number(&mut self, item: T) -> u32 {
        let next = self.items.len() as u32;
        let number = *self.numbers.entry(item.clone()).or_insert(next);
        if number == next {
            self.items.push(item);
        }
        number
    }
}

impl<'a> Crate<'a> {
    /// Begins a file where `out` stands.
    pub fn new(out: &'a mut dyn Sink) -> Result<Self> {
        let base = out.stream_position()?;
        out.write_all(&[0; HEAD as usize])?;
        let mut tokens = Table::new();
        // The sign of a token's number says whether it names a property, so that none may have number 0.
        tokens.number(String::new());
        Ok(Crate {
            out,
            base,
            at: HEAD,
            crc: Crc::new(),
            tokens,
            strings: Table::new(),
            fields: Table::new(),
            sets: Vec::new(),
            specs: Default::default(),
            paths: BTreeMap::new(),
        })
    }

    fn put(&mut self, bytes: &[u8]) -> Result<()> {
        self.out.write_all(bytes)?;
        self.crc.update(bytes);
        self.at += bytes.len() as u64;
        Ok(())
    }

    /// Puts a value that is too long to be told by its place.
    fn lay(&mut self, kind: u64, bytes: &[u8]) -> Result<Stored> {
        // Readers use arrays where they lie if their numbers lie at whole multiples.
        let gap = self.at.next_multiple_of(8) - self.at;
        self.put(&[0; 8][..gap as usize])?;
        let place = self.at;
        self.put(bytes)?;
        Ok(Stored(kind << 48 | place))
    }

    fn array<const N: usize>(
        &mut self,
        kind: u64,
        count: usize,
        numbers: impl Iterator<Item = [u8; N]>,
    ) -> Result<Stored> {
        let mut bytes = Vec::with_capacity(8 + count * N);
        bytes.extend((count as u64).to_le_bytes());
        bytes.extend(numbers.flatten());
        Ok(Stored(self.lay(kind, &bytes)?.0 | ARRAY))
    }

    fn floats<const N: usize>(&mut self, kind: u64, list: &[[f32; N]]) -> Result<Stored> {
        if list.is_empty() {
            // An array of nothing has no place.
            return Ok(Stored(ARRAY | kind << 48));
        }
        let mut bytes = Vec::with_capacity(8 + 4 * N * list.len());
        bytes.extend((list.len() as u64).to_le_bytes());
        for number in list.as_flattened() {
            bytes.extend(number.to_le_bytes());
        }
        Ok(Stored(self.lay(kind, &bytes)?.0 | ARRAY))
    }

    fn integers(&mut self, list: &[i32]) -> Result<Stored> {
        if list.len() < LEAST_PACKED {
            let numbers = list.iter().map(|n| n.to_le_bytes());
            return self.array(kind::INT, list.len(), numbers);
        }
        let packed = block(&integers(list));
        let mut bytes = Vec::with_capacity(16 + packed.len());
        bytes.extend((list.len() as u64).to_le_bytes());
        bytes.extend((packed.len() as u64).to_le_bytes());
        bytes.extend(packed);
        Ok(Stored(self.lay(kind::INT, &bytes)?.0 | ARRAY | PACKED))
    }

    fn token(&mut self, text: &str) -> u32 {
        self.tokens.number(text.to_owned())
    }

    /// Puts a value into the file.
    pub fn value(&mut self, value: &Value) -> Result<Stored> {
        fn bytes<const N: usize>(numbers: &[f32; N]) -> Vec<u8> {
            numbers.iter().flat_map(|n| n.to_le_bytes()).collect()
        }
        let precise =
            |numbers: &[f64]| -> Vec<u8> { numbers.iter().flat_map(|n| n.to_le_bytes()).collect() };
        match value {
            Value::Stored(stored) => Ok(*stored),
            Value::Bool(v) => Ok(inlined(kind::BOOL, u32::from(*v))),
            Value::Int64(v) => self.lay(kind::INT64, &v.to_le_bytes()),
            Value::Float(v) => Ok(inlined(kind::FLOAT, v.to_bits())),
            Value::Double(v) => self.lay(kind::DOUBLE, &v.to_le_bytes()),
            Value::Token(v) => Ok(inlined(kind::TOKEN, self.token(v))),
            Value::Asset(v) => Ok(inlined(kind::ASSET, self.token(v))),
            Value::Text(v) => {
                let token = self.token(v);
                Ok(inlined(kind::STRING, self.strings.number(token)))
            }
            Value::Float2(v) => self.lay(kind::VEC2F, &bytes(v)),
            Value::Float3(v) => self.lay(kind::VEC3F, &bytes(v)),
            Value::Float4(v) => self.lay(kind::VEC4F, &bytes(v)),
            Value::Turn(v) => self.lay(kind::QUATF, &bytes(v)),
            Value::Double3(v) => self.lay(kind::VEC3D, &precise(v)),
            Value::Matrix(rows) => self.lay(kind::MATRIX4D, &precise(rows.as_flattened())),
            Value::Tokens(names) => {
                let numbers: Vec<u32> = names.iter().map(|n| self.token(n)).collect();
                let count = numbers.len();
                self.array(kind::TOKEN, count, numbers.iter().map(|n| n.to_le_bytes()))
            }
            Value::Prepended(names) => {
                let numbers: Vec<u32> = names.iter().map(|n| self.token(n)).collect();
                self.list(kind::TOKEN_LIST, 1 << 5, &numbers)
            }
            Value::Ints(v) => self.integers(v),
            Value::Floats(v) => self.floats(kind::FLOAT, v.as_chunks::<1>().0),
            Value::Doubles(v) => {
                self.array(kind::DOUBLE, v.len(), v.iter().map(|n| n.to_le_bytes()))
            }
            Value::Float2s(v) => self.floats(kind::VEC2F, v),
            Value::Float3s(v) => self.floats(kind::VEC3F, v),
            Value::Float4s(v) => self.floats(kind::VEC4F, v),
        }
    }

    /// A list of changes to a list, with one kind of change.
    fn list(&mut self, kind: u64, change: u8, numbers: &[u32]) -> Result<Stored> {
        let mut bytes = vec![change];
        bytes.extend((numbers.len() as u64).to_le_bytes());
        bytes.extend(numbers.iter().flat_map(|n| n.to_le_bytes()));
        self.lay(kind, &bytes)
    }

    fn names<'n>(&mut self, names: impl Iterator<Item = &'n str>) -> Result<Stored> {
        let numbers: Vec<u32> = names.map(|n| self.token(n)).collect();
        let mut bytes = (numbers.len() as u64).to_le_bytes().to_vec();
        bytes.extend(numbers.iter().flat_map(|n| n.to_le_bytes()));
        self.lay(kind::TOKEN_VECTOR, &bytes)
    }

    /// Puts a list of times into the file, for [`Samples`].
    pub fn times(&mut self, times: &[f64]) -> Result<Stored> {
        let mut bytes = (times.len() as u64).to_le_bytes().to_vec();
        bytes.extend(times.iter().flat_map(|t| t.to_le_bytes()));
        self.lay(kind::DOUBLE_VECTOR, &bytes)
    }

    fn samples(&mut self, samples: &Samples) -> Result<Stored> {
        // Where the times are, by how far on that is told; then where the values are, likewise.
        let mut bytes = 8_i64.to_le_bytes().to_vec();
        bytes.extend(samples.times.0.to_le_bytes());
        bytes.extend(8_i64.to_le_bytes());
        bytes.extend((samples.values.len() as u64).to_le_bytes());
        bytes.extend(samples.values.iter().flat_map(|v| v.0.to_le_bytes()));
        self.lay(kind::TIME_SAMPLES, &bytes)
    }

    /// Puts the values of a prim and those below it into the file at once, so that they need not be held.
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

    fn spec(&mut self, path: &str, kind: i32, fields: Vec<(&str, Stored)>) {
        let path = self.paths.get(path).copied().unwrap_or(0);
        let spec = [path as i32, self.sets.len() as i32, kind];
        for (list, number) in self.specs.iter_mut().zip(spec) {
            list.push(number);
        }
        for (name, value) in fields {
            let name = self.token(name);
            self.sets.push(self.fields.number((name, value.0)) as i32);
        }
        self.sets.push(-1);
    }

    fn metadata<'m>(
        &mut self,
        entries: &'m [(&'static str, Value)],
    ) -> Result<Vec<(&'m str, Stored)>> {
        let put = |(key, value): &'m (&'static str, Value)| Ok((*key, self.value(value)?));
        entries.iter().map(put).collect()
    }

    fn prim(&mut self, prim: &Prim, path: &str) -> Result<()> {
        let kind = self.token(prim.kind);
        let mut fields = vec![
            ("specifier", inlined(kind::SPECIFIER, 0)),
            ("typeName", inlined(kind::TOKEN, kind)),
        ];
        fields.extend(self.metadata(&prim.metadata)?);
        if !prim.properties.is_empty() {
            let names = self.names(prim.properties.iter().map(|p| p.name.as_str()))?;
            fields.push(("properties", names));
        }
        if !prim.children.is_empty() {
            let names = self.names(prim.children.iter().map(|p| p.name.as_str()))?;
            fields.push(("primChildren", names));
        }
        self.spec(path, PRIM, fields);
        for property in &prim.properties {
            self.property(property, &format!("{path}.{}", property.name))?;
        }
        let mut children = prim.children.iter();
        children.try_for_each(|c| self.prim(c, &format!("{path}/{}", c.name)))
    }

    fn property(&mut self, property: &Property, path: &str) -> Result<()> {
        let mut fields = self.metadata(&property.metadata)?;
        match &property.content {
            Content::Relationship(targets) => {
                fields.push(("variability", inlined(kind::VARIABILITY, 1)));
                fields.push(("targetPaths", self.targets(targets)?));
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
                fields.push(("typeName", inlined(kind::TOKEN, kind)));
                if *uniform {
                    fields.push(("variability", inlined(kind::VARIABILITY, 1)));
                }
                if *custom {
                    fields.push(("custom", inlined(kind::BOOL, 1)));
                }
                if let Some(value) = value {
                    fields.push(("default", self.value(value)?));
                }
                if let Some(samples) = samples {
                    fields.push(("timeSamples", self.samples(samples)?));
                }
                if let Some(path) = connection {
                    let paths = self.targets(std::slice::from_ref(path))?;
                    fields.push(("connectionPaths", paths));
                }
                self.spec(path, ATTRIBUTE, fields);
            }
        }
        Ok(())
    }

    fn targets(&mut self, targets: &[String]) -> Result<Stored> {
        // Everything that is pointed at is in the layer.
        let known = targets.iter().filter_map(|t| self.paths.get(t).copied());
        let numbers: Vec<u32> = known.collect();
        self.list(kind::PATH_LIST, 1 | 1 << 1, &numbers)
    }

    /// Puts the layer's tables and the head; gives the file's length and checksum.
    pub fn finish(mut self, layer: &Layer) -> Result<(u64, u32)> {
        let mut tree = Tree::default();
        tree.add(0, 1, false);
        self.paths.insert("/".to_owned(), 0);
        self.walk(&layer.root, "", true, &mut tree);
        let mut fields = self.metadata(&layer.metadata)?;
        let names = self.names(std::iter::once(layer.root.name.as_str()))?;
        fields.push(("primChildren", names));
        self.spec("/", LAYER, fields);
        self.prim(&layer.root, &format!("/{}", layer.root.name))?;
        self.tables(&tree)
    }

    /// Numbers the paths of a prim and what is below it; tells the length of its branch.
    fn walk(&mut self, prim: &Prim, above: &str, last: bool, tree: &mut Tree) {
        let path = format!("{above}/{}", prim.name);
        let token = self.token(&prim.name);
        let own = tree.paths.len();
        self.paths.insert(path.clone(), own as u32);
        let below = prim.properties.len() + prim.children.len();
        tree.add(token as i32, below, !last);
        for (k, property) in prim.properties.iter().enumerate() {
            let token = self.token(&property.name);
            let number = tree.paths.len() as u32;
            self.paths
                .insert(format!("{path}.{}", property.name), number);
            tree.add(-(token as i32), 0, k + 1 < below);
        }
        for (k, child) in prim.children.iter().enumerate() {
            self.walk(child, &path, k + 1 == prim.children.len(), tree);
        }
        if !last && below > 0 {
            tree.jumps[own] = (tree.paths.len() - own) as i32;
        }
    }

    fn tables(mut self, tree: &Tree) -> Result<(u64, u32)> {
        let count = |n: usize| (n as u64).to_le_bytes().to_vec();
        let sized =
            |packed: Vec<u8>| [(packed.len() as u64).to_le_bytes().to_vec(), packed].concat();
        let numbers = |list: &[i32]| sized(block(&integers(list)));
        let mut texts = Vec::new();
        for token in &self.tokens.items {
            texts.extend(token.bytes().filter(|&b| b != 0));
            texts.push(0);
        }
        let names: Vec<i32> = self.fields.items.iter().map(|f| f.0 as i32).collect();
        let values = self.fields.items.iter().flat_map(|f| f.1.to_le_bytes());
        let values: Vec<u8> = values.collect();
        let strings = self.strings.items.iter().flat_map(|s| s.to_le_bytes());
        let sections = [
            (
                "TOKENS",
                [
                    count(self.tokens.items.len()),
                    count(texts.len()),
                    sized(block(&texts)),
                ]
                .concat(),
            ),
            (
                "STRINGS",
                [count(self.strings.items.len()), strings.collect()].concat(),
            ),
            (
                "FIELDS",
                [count(names.len()), numbers(&names), sized(block(&values))].concat(),
            ),
            (
                "FIELDSETS",
                [count(self.sets.len()), numbers(&self.sets)].concat(),
            ),
            (
                "PATHS",
                [
                    count(tree.paths.len()),
                    count(tree.paths.len()),
                    numbers(&tree.paths),
                    numbers(&tree.tokens),
                    numbers(&tree.jumps),
                ]
                .concat(),
            ),
            (
                "SPECS",
                [
                    count(self.specs[0].len()),
                    numbers(&self.specs[0]),
                    numbers(&self.specs[1]),
                    numbers(&self.specs[2]),
                ]
                .concat(),
            ),
        ];
        let mut contents = count(sections.len());
        for (name, bytes) in &sections {
            let mut entry = [0; 16];
            entry[..name.len()].copy_from_slice(name.as_bytes());
            contents.extend(entry);
            contents.extend(self.at.to_le_bytes());
            contents.extend(count(bytes.len()));
            self.put(bytes)?;
        }
        let place = self.at;
        self.put(&contents)?;
        let mut head = [0; HEAD as usize];
        head[..8].copy_from_slice(IDENTITY);
        head[8..16].copy_from_slice(&VERSION);
        head[16..24].copy_from_slice(&place.to_le_bytes());
        self.out.seek(SeekFrom::Start(self.base))?;
        self.out.write_all(&head)?;
        self.out.seek(SeekFrom::Start(self.base + self.at))?;
        let mut crc = Crc::new();
        crc.update(&head);
        crc.combine(&self.crc);
        Ok((self.at, crc.sum()))
    }
}

/// Paths in depth-first order: numbers, last parts (negative for properties), and how to go on: how far away the next one
/// beside it is where something is below it too, 0 where nothing is, -1 where only something is below, -2 where neither.
#[derive(Default)]
struct Tree {
    paths: Vec<i32>,
    tokens: Vec<i32>,
    jumps: Vec<i32>,
}

impl Tree {
    fn add(&mut self, token: i32, below: usize, beside: bool) {
        self.paths.push(self.paths.len() as i32);
        self.tokens.push(token);
        self.jumps.push(match (below > 0, beside) {
            (true, _) => -1,
            (false, true) => 0,
            (false, false) => -2,
        });
    }
}
