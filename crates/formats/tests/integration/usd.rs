//! USD files, parsed by a small reader after OpenUSD's `crateFile.cpp`; OpenUSD itself reads them in `.ci`.

use crate::common::bundle::{Bend, film};
use crate::common::two_cubes;
use glam::{DQuat, DVec3};
use greenstick_formats::film::{FilmReport, write_usd};
use greenstick_formats::usd::{UsdFormat, write};
use greenstick_geometry::{Context, Film, Motion, Pose};
use std::collections::BTreeMap;
use std::io::Cursor;

fn word(bytes: &[u8], at: usize) -> u64 {
    u64::from_le_bytes(bytes[at..at + 8].try_into().unwrap())
}

fn half_word(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap())
}

/// A binary layer.
struct Layer {
    bytes: Vec<u8>,
    tokens: Vec<String>,
    /// Fields of each path.
    specs: BTreeMap<String, BTreeMap<String, u64>>,
    paths: Vec<String>,
}

/// Reads from a position on.
struct Reader<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl Reader<'_> {
    fn word(&mut self) -> usize {
        self.at += 8;
        word(self.bytes, self.at - 8) as usize
    }

    /// An LZ4 block after its length.
    fn block(&mut self) -> Vec<u8> {
        let length = self.word();
        let packed = &self.bytes[self.at..self.at + length];
        self.at += length;
        assert_eq!(packed[0], 0, "one block");
        let mut out: Vec<u8> = Vec::new();
        let mut at = 1;
        let longer = |start: usize, at: &mut usize| {
            let mut length = start;
            let mut further = start == 15;
            while further {
                length += usize::from(packed[*at]);
                further = packed[*at] == 255;
                *at += 1;
            }
            length
        };
        while at < packed.len() {
            let token = usize::from(packed[at]);
            at += 1;
            let literals = longer(token >> 4, &mut at);
            out.extend_from_slice(&packed[at..at + literals]);
            at += literals;
            if at == packed.len() {
                break;
            }
            let back = usize::from(packed[at]) + 256 * usize::from(packed[at + 1]);
            at += 2;
            let repeated = 4 + longer(token & 15, &mut at);
            for _ in 0..repeated {
                out.push(out[out.len() - back]);
            }
        }
        out
    }

    fn integers(&mut self, count: usize) -> Vec<i32> {
        let packed = self.block();
        if count == 0 {
            return Vec::new();
        }
        let common = half_word(&packed, 0) as i32;
        let mut at = 4 + count.div_ceil(4);
        let mut sum = 0_i32;
        let numbers = (0..count).map(|k| {
            let code = packed[4 + k / 4] >> (2 * (k % 4)) & 3;
            let size = [0, 1, 2, 4][usize::from(code)];
            let raw = &packed[at..at + size];
            at += size;
            sum = sum.wrapping_add(match raw {
                [] => common,
                [a] => i32::from(*a as i8),
                [a, b] => i32::from(i16::from_le_bytes([*a, *b])),
                _ => half_word(raw, 0) as i32,
            });
            sum
        });
        let numbers = numbers.collect();
        assert_eq!(at, packed.len());
        numbers
    }
}

impl Layer {
    fn new(bytes: &[u8]) -> Self {
        assert_eq!(&bytes[..8], b"PXR-USDC");
        assert_eq!(&bytes[8..16], &[0, 8, 0, 0, 0, 0, 0, 0]);
        let contents = word(bytes, 16) as usize;
        let sections: BTreeMap<String, usize> = (0..word(bytes, contents) as usize)
            .map(|k| {
                let entry = contents + 8 + 32 * k;
                let name = bytes[entry..entry + 16].split(|&b| b == 0).next().unwrap();
                let name = String::from_utf8(name.to_vec()).unwrap();
                (name, word(bytes, entry + 16) as usize)
            })
            .collect();
        let section = |name: &str| Reader {
            bytes,
            at: sections[name],
        };
        let mut reader = section("TOKENS");
        let (count, length) = (reader.word(), reader.word());
        let texts = reader.block();
        assert_eq!((texts.len(), texts.last()), (length, Some(&0)));
        let texts = texts[..length - 1].split(|&b| b == 0);
        let tokens: Vec<String> = texts
            .map(|t| String::from_utf8(t.to_vec()).unwrap())
            .collect();
        assert_eq!(tokens.len(), count);
        let mut reader = section("FIELDS");
        let count = reader.word();
        let names = reader.integers(count);
        let values = reader.block();
        let mut reader = section("FIELDSETS");
        let count = reader.word();
        let sets = reader.integers(count);
        let mut reader = section("PATHS");
        let count = reader.word();
        assert_eq!(reader.word(), count);
        let [numbers, parts, jumps] = [(); 3].map(|()| reader.integers(count));
        let mut paths = vec![String::new(); count];
        // Paths to visit, with their parents.
        let mut waiting = vec![(0_usize, String::new())];
        while let Some((at, above)) = waiting.pop() {
            let part = &tokens[parts[at].unsigned_abs() as usize];
            let own = match (above.as_str(), parts[at] < 0) {
                ("", _) => "/".to_owned(),
                ("/", _) => format!("/{part}"),
                (_, true) => format!("{above}.{part}"),
                (_, false) => format!("{above}/{part}"),
            };
            let (below, beside) = (jumps[at] > 0 || jumps[at] == -1, jumps[at] >= 0);
            if beside {
                let next = if below { jumps[at] as usize } else { 1 };
                waiting.push((at + next, above));
            }
            if below {
                waiting.push((at + 1, own.clone()));
            }
            paths[numbers[at] as usize] = own;
        }
        let mut reader = section("SPECS");
        let count = reader.word();
        let [of_paths, of_sets, _] = [(); 3].map(|()| reader.integers(count));
        let specs = of_paths.iter().zip(&of_sets).map(|(&path, &set)| {
            let own = sets[set as usize..].iter().take_while(|&&f| f >= 0);
            let fields = own.map(|&f| {
                let name = &tokens[names[f as usize] as usize];
                (name.clone(), word(&values, 8 * f as usize))
            });
            (paths[path as usize].clone(), fields.collect())
        });
        Layer {
            specs: specs.collect(),
            bytes: bytes.to_vec(),
            tokens,
            paths,
        }
    }

    fn field(&self, path: &str, name: &str) -> u64 {
        let spec = self.specs.get(path).unwrap_or_else(|| panic!("no {path}"));
        *spec
            .get(name)
            .unwrap_or_else(|| panic!("{path} has no {name}: {spec:?}"))
    }

    fn token(&self, path: &str, name: &str) -> &str {
        let value = self.field(path, name);
        assert_eq!(value >> 48, 0x400B, "a token in its place");
        &self.tokens[(value & 0xFFFF_FFFF) as usize]
    }

    fn place(value: u64) -> usize {
        (value & ((1 << 48) - 1)) as usize
    }

    fn floats(&self, value: u64) -> Vec<DVec3> {
        assert_eq!(value >> 48, 0x8018, "an array of three floats");
        let at = Self::place(value);
        let count = word(&self.bytes, at) as usize;
        let floats = self.bytes[at + 8..at + 8 + 12 * count].as_chunks::<12>().0;
        floats
            .iter()
            .map(|b| {
                let number = |k: usize| f64::from(f32::from_bits(half_word(b, 4 * k)));
                DVec3::new(number(0), number(1), number(2))
            })
            .collect()
    }

    /// Times and values of an attribute.
    fn samples(&self, path: &str) -> (Vec<f64>, Vec<u64>) {
        let value = self.field(path, "timeSamples");
        assert_eq!(value >> 48, 46);
        let at = Self::place(value);
        let times = at + word(&self.bytes, at) as usize;
        let list = Self::place(word(&self.bytes, times));
        let count = word(&self.bytes, list) as usize;
        let time = |k| f64::from_bits(word(&self.bytes, list + 8 + 8 * k));
        let values = times + 8 + word(&self.bytes, times + 8) as usize;
        assert_eq!(word(&self.bytes, values) as usize, count);
        let value = |k| word(&self.bytes, values + 8 + 8 * k);
        (
            (0..count).map(time).collect(),
            (0..count).map(value).collect(),
        )
    }
}

fn written(format: UsdFormat, film: &Film, frames: usize) -> (Vec<u8>, FilmReport) {
    let mut out = Cursor::new(Vec::new());
    let mut motion = Bend::new(film, frames);
    let context = Context::quiet();
    let name = format!("a film.{}", format.extension());
    let (report, files) = write_usd(format, film, &mut motion, &name, &mut out, &context).unwrap();
    assert_eq!(files.len(), usize::from(format == UsdFormat::Usdc));
    assert_eq!(report.bytes, out.get_ref().len() as u64);
    (out.into_inner(), report)
}

#[test]
fn a_file_reproduces_the_film() {
    let film = film(20, 30, 5);
    let (bytes, report) = written(UsdFormat::Usdc, &film, 40);
    assert_eq!((report.skinned, report.rigid), (1, 2));
    let layer = Layer::new(&bytes);
    assert_eq!(layer.token("/", "defaultPrim"), "a_film");
    assert_eq!(layer.token("/", "upAxis"), "Y");
    let (codes, points) = layer.samples("/a_film/stick.points");
    let (_, normals) = layer.samples("/a_film/stick.normals");
    let (_, extents) = layer.samples("/a_film/stick.extent");
    assert_eq!(codes, (0..40).map(f64::from).collect::<Vec<_>>());
    let mut poses = vec![Pose::IDENTITY; film.joints.len()];
    let (mut maps, mut places, mut directions) = (Vec::new(), Vec::new(), Vec::new());
    let mut motion = Bend::new(&film, 40);
    for frame in 0..40 {
        motion.poses(frame, &mut poses).unwrap();
        film.pose_piece(0, &poses, &mut places);
        film.joint_maps(&poses, &mut maps);
        film.deform_normals(0, &maps, &mut directions);
        for (right, value) in [(&places, points[frame]), (&directions, normals[frame])] {
            let found = layer.floats(value);
            assert_eq!(found.len(), right.len());
            let away = found.iter().zip(right).map(|(a, b)| a.distance(*b));
            assert!(away.fold(0.0, f64::max) < 2e-7, "frame {frame}");
        }
        let found = layer.floats(points[frame]);
        let low = found.iter().copied().reduce(DVec3::min).unwrap();
        let high = found.iter().copied().reduce(DVec3::max).unwrap();
        assert_eq!(layer.floats(extents[frame]), [low, high]);
    }
    // A rigid mesh: its points are constant, its translation and rotation vary.
    let rest = layer.floats(layer.field("/a_film/half.points", "default"));
    let (_, turns) = layer.samples("/a_film/half.xformOp:orient");
    let (_, moves) = layer.samples("/a_film/half.xformOp:translate");
    motion.poses(23, &mut poses).unwrap();
    film.pose_piece(1, &poses, &mut places);
    let at = Layer::place(moves[23]);
    let shift = [0, 8, 16].map(|k| f64::from_bits(word(&layer.bytes, at + k)));
    let at = Layer::place(turns[23]);
    let turn = [0, 4, 8, 12].map(|k| f64::from(f32::from_bits(half_word(&layer.bytes, at + k))));
    let (shift, turn) = (DVec3::from_array(shift), DQuat::from_array(turn));
    let away = rest
        .iter()
        .zip(&places)
        .map(|(p, q)| (turn * *p + shift).distance(*q));
    assert!(away.fold(0.0, f64::max) < 5e-7);
    // The hammer does not rotate.
    layer.field("/a_film/hammer.xformOp:orient", "default");
    assert_eq!(report.constant, 1);
}

#[test]
fn bound_materials_exist() {
    let (bytes, _) = written(UsdFormat::Usdc, &film(4, 5, 2), 3);
    let layer = Layer::new(&bytes);
    let mut targets = 0;
    for spec in layer.specs.values() {
        for name in ["targetPaths", "connectionPaths"] {
            let Some(&value) = spec.get(name) else {
                continue;
            };
            let at = Layer::place(value);
            assert_eq!(
                (value >> 48, layer.bytes[at], word(&layer.bytes, at + 1)),
                (34, 3, 1)
            );
            let path = &layer.paths[half_word(&layer.bytes, at + 9) as usize];
            assert!(layer.specs.contains_key(path));
            targets += 1;
        }
    }
    // Two subsets of four meshes, two surfaces, a texture with its coordinates, vertex colours.
    assert_eq!(targets, 8 + 2 + 2 + 1);
    let bound = layer.field("/a_film/stick/material_1.material:binding", "targetPaths");
    let path = half_word(&layer.bytes, Layer::place(bound) + 9) as usize;
    assert_eq!(layer.paths[path], "/a_film/materials/wood_inside");
}

#[test]
fn constant_values_are_written_once() {
    let film = film(20, 200, 5);
    let size = |frames: usize| written(UsdFormat::Usdc, &film, frames).0.len();
    struct Still(Bend);
    impl Motion for Still {
        type Error = std::convert::Infallible;
        fn frames(&self) -> usize {
            100
        }
        fn time(&self, frame: usize) -> f64 {
            self.0.time(frame)
        }
        fn poses(&mut self, frame: usize, poses: &mut [Pose]) -> Result<(), Self::Error> {
            self.0.poses(frame.min(1), poses)
        }
    }
    let mut out = Cursor::new(Vec::new());
    let mut motion = Still(Bend::new(&film, 2));
    let context = Context::quiet();
    write_usd(UsdFormat::Usdc, &film, &mut motion, "x", &mut out, &context).unwrap();
    let (two, hundred) = (size(2), out.get_ref().len());
    // Eight bytes for each repeated value, and the times.
    assert!(hundred < two + 100 * 8 * 8, "{two} {hundred}");
    let bytes = out.into_inner();
    let (codes, values) = Layer::new(&bytes).samples("/x/stick.points");
    assert_eq!(codes.len(), 100);
    assert!(values[1..].iter().all(|v| *v == values[1]) && values[0] != values[1]);
}

/// The members of an archive: name and content. Asserts their alignment and checksums.
fn members(bytes: &[u8]) -> Vec<(String, Vec<u8>)> {
    let end = bytes.len() - 22;
    assert_eq!(&bytes[end..end + 4], b"PK\x05\x06");
    let count = usize::from(bytes[end + 10]);
    let mut at = half_word(bytes, end + 16) as usize;
    let mut out = Vec::new();
    for _ in 0..count {
        assert_eq!(&bytes[at..at + 4], b"PK\x01\x02");
        assert_eq!(&bytes[at + 10..at + 12], [0, 0], "not packed");
        let (sum, length) = (
            half_word(bytes, at + 16),
            half_word(bytes, at + 20) as usize,
        );
        let name = usize::from(bytes[at + 28]);
        let local = half_word(bytes, at + 42) as usize;
        let text = String::from_utf8(bytes[at + 46..at + 46 + name].to_vec()).unwrap();
        assert_eq!(&bytes[local..local + 4], b"PK\x03\x04");
        assert_eq!(half_word(bytes, local + 14), sum);
        assert_eq!(half_word(bytes, local + 22) as usize, length);
        let room = usize::from(u16::from_le_bytes([bytes[local + 28], bytes[local + 29]]));
        let start = local + 30 + name + room;
        assert_eq!(start % 64, 0, "{text}");
        let content = bytes[start..start + length].to_vec();
        let mut crc = flate2::Crc::new();
        crc.update(&content);
        assert_eq!(crc.sum(), sum, "{text}");
        out.push((text, content));
        at += 46 + name;
    }
    assert_eq!(at, end);
    out
}

#[test]
fn archives_contain_the_layer_and_its_textures() {
    let film = film(4, 5, 2);
    let archive = members(&written(UsdFormat::Usdz, &film, 7).0);
    let names: Vec<&str> = archive.iter().map(|m| m.0.as_str()).collect();
    assert_eq!(names, ["a film.usdc", "a_film_grain.png"]);
    assert_eq!(archive[0].1, written(UsdFormat::Usdc, &film, 7).0);
    let still = write(UsdFormat::Usdz, &two_cubes(), "s.usdz").unwrap();
    assert_eq!(still.len(), 1);
    let archive = members(&still[0].bytes);
    let names: Vec<&str> = archive.iter().map(|m| m.0.as_str()).collect();
    assert_eq!(names, ["s.usdc", "s_color.png"]);
    Layer::new(&archive[0].1);
}

#[test]
fn static_scenes_in_text_and_binary_are_equal() {
    let scene = two_cubes();
    let [text, binary] = [UsdFormat::Usda, UsdFormat::Usdc].map(|format| {
        let name = format!("2 cubes.{}", format.extension());
        let files = write(format, &scene, &name).unwrap();
        assert_eq!(files[1].name, "2_cubes_color.png");
        files.into_iter().next().unwrap().bytes
    });
    let text = String::from_utf8(text).unwrap();
    let layer = Layer::new(&binary);
    // Both have the same prims and properties.
    let mut above: Vec<String> = Vec::new();
    let mut seen = 0;
    let brackets = |l: &&str| !matches!(l.trim(), "" | "(" | ")" | "{" | "}");
    for line in text.lines().filter(brackets) {
        let depth = line.len() - line.trim_start().len();
        above.truncate(depth / 4);
        let words: Vec<&str> = line.split_whitespace().collect();
        let path = above.concat();
        match words.as_slice() {
            ["def", _, name, ..] => {
                above.push(format!("/{}", name.trim_matches('"')));
                assert!(layer.specs.contains_key(&above.concat()), "{line}");
            }
            _ if above.is_empty() || line.contains("\"vertex\"") || line.contains("apiSchemas") => {
                continue;
            }
            _ => {
                let types = [
                    "uniform", "rel", "token", "float", "normal", "int", "point3f",
                ];
                let more = [
                    "color", "texCoord", "asset", "string", "matrix", "quatf", "bool",
                ];
                let mut kinds = types.iter().chain(&more);
                if !kinds.any(|t| words.first().is_some_and(|w| w.starts_with(t))) {
                    continue;
                }
                let skip = if words[0] == "uniform" { 2 } else { 1 };
                let name = words[skip].trim_end_matches(".connect");
                let path = format!("{path}.{name}");
                assert!(layer.specs.contains_key(&path), "{path}: {line}");
            }
        }
        seen += 1;
    }
    // Everything but the layer itself.
    assert_eq!(seen, layer.specs.len() - 1);
    assert!(text.starts_with("#usda 1.0\n(\n    defaultPrim = \"_2_cubes\"\n"));
    // The corner of the second cube is at its position; matrices are for row vectors.
    assert!(text.contains("(3, -1, 0.25, 1))"), "{text}");
    assert!(text.contains("texCoord2f[] primvars:st = [(0, 0.75), (1, 0.75), (1, 0.25)"));
    assert!(text.contains("asset inputs:file = @2_cubes_color.png@"));
}

#[test]
fn meshes_of_several_nodes_are_stored_once() {
    let mut scene = two_cubes();
    scene.nodes.truncate(1);
    let mut again = scene.nodes[0].clone();
    scene.nodes[0].name = "a".into();
    again.name = "b".into();
    again.transform.translation += DVec3::new(5.0, 0.0, 0.0);
    scene.nodes.push(again);
    let files = write(UsdFormat::Usdc, &scene, "x.usdc").unwrap();
    let layer = Layer::new(&files[0].bytes);
    let value = |path: &str| layer.specs[path]["default"];
    for name in ["points", "faceVertexIndices", "primvars:st"] {
        let [a, b] = ["a", "b"].map(|node| value(&format!("/x/{node}.{name}")));
        assert_eq!(a, b, "{name}");
    }
    let [a, b] = ["a", "b"].map(|node| value(&format!("/x/{node}.xformOp:transform")));
    assert_ne!(a, b);
}

#[test]
fn output_is_deterministic_and_text_films_are_refused() {
    let film = film(4, 5, 2);
    for format in [UsdFormat::Usdc, UsdFormat::Usdz] {
        assert_eq!(written(format, &film, 5), written(format, &film, 5));
    }
    let mut out = Cursor::new(Vec::new());
    let mut motion = Bend::new(&film, 5);
    let context = Context::quiet();
    let error = write_usd(
        UsdFormat::Usda,
        &film,
        &mut motion,
        "x.usda",
        &mut out,
        &context,
    );
    assert!(error.unwrap_err().to_string().contains(".usdc"));
    let mut scene = two_cubes();
    scene.nodes[0].mesh_mut().positions[3].y = f64::INFINITY;
    let error = write(UsdFormat::Usdc, &scene, "x.usdc").unwrap_err();
    assert!(error.to_string().contains("vertex 3"), "{error}");
}
