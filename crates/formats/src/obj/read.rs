//! Reading OBJ. Each object or group with faces becomes a node.

use super::material;
use super::unify::{ABSENT, Corner, Unifier};
use crate::attribute::clean_attributes;
use crate::companions::Resolve;
use crate::error::{FormatError, InFile};
use crate::polygon::{FaceStatistics, Triangulator};
use crate::text::{number, quote, tokens};
use glam::{DAffine3, DVec3};
use greenstick_geometry::mesh::NO_MATERIAL;
use greenstick_geometry::{Attribute, Mesh, Node, Scene};
use std::collections::HashMap;
use std::sync::Arc;

/// A face. Its corners are those of [`Group::corners`] from the end of the face before it to `end`.
struct Face {
    end: usize,
    line: usize,
    material: u32,
}

/// The faces of an object or group.
#[derive(Default)]
struct Group {
    name: String,
    corners: Vec<Corner>,
    faces: Vec<Face>,
}

/// The data read so far.
struct Reader<'a> {
    file: InFile<'a>,
    positions: Vec<DVec3>,
    colors: Vec<[f32; 3]>,
    coordinates: Vec<[f32; 2]>,
    normals: Vec<[f32; 3]>,
    groups: Vec<Group>,
    group_numbers: HashMap<String, usize>,
    /// Number of the current group.
    current: usize,
    /// Name of the current object.
    object: String,
    /// Names of the materials in use.
    materials: Vec<String>,
    material_numbers: HashMap<String, u32>,
    /// The current material.
    material: u32,
    /// Material libraries.
    libraries: Vec<String>,
    ignored: Vec<IgnoredLine>,
    /// Number of points, lines and curves.
    dropped: usize,
}

/// A line that is not a known statement.
struct IgnoredLine {
    number: usize,
    text: String,
}

/// Reads an OBJ file and its MTL files.
pub(crate) fn read(bytes: &[u8], name: &str, resolve: Resolve) -> Result<Scene, FormatError> {
    let mut reader = Reader {
        file: InFile(name),
        positions: Vec::new(),
        colors: Vec::new(),
        coordinates: Vec::new(),
        normals: Vec::new(),
        groups: vec![Group::default()],
        group_numbers: HashMap::from([(String::new(), 0)]),
        current: 0,
        object: String::new(),
        materials: Vec::new(),
        material_numbers: HashMap::new(),
        material: NO_MATERIAL,
        libraries: Vec::new(),
        ignored: Vec::new(),
        dropped: 0,
    };
    reader.read_lines(bytes)?;
    reader.finish(bytes, resolve)
}

impl Reader<'_> {
    /// Reads all lines.
    fn read_lines(&mut self, bytes: &[u8]) -> Result<(), FormatError> {
        let mut continued: Vec<u8> = Vec::new();
        for (number, line) in crate::text::lines(bytes) {
            // A backslash at the end continues a line.
            if let Some(part) = line.strip_suffix(b"\\") {
                continued.extend_from_slice(part);
                continued.push(b' ');
            } else if continued.is_empty() {
                self.statement(line, number)?;
            } else {
                continued.extend_from_slice(line);
                self.statement(&continued, number)?;
                continued.clear();
            }
        }
        Ok(())
    }

    /// Reads one statement.
    fn statement(&mut self, line: &[u8], at: usize) -> Result<(), FormatError> {
        let line = line.split(|&b| b == b'#').next().unwrap_or_default();
        let mut words = tokens(line);
        let Some(keyword) = words.next() else {
            return Ok(());
        };
        match keyword {
            b"v" => self.position(words, line, at)?,
            b"vt" => {
                let [u, v] = self.floats(words, line, at, 1)?;
                self.coordinates.push([u, 1.0 - v]);
            }
            b"vn" => {
                let normal = self.floats(words, line, at, 3)?;
                self.normals.push(normal);
            }
            b"f" | b"fo" => self.face(words, line, at)?,
            b"o" => {
                self.object = rest_of(line, keyword);
                self.enter_group(self.object.clone());
            }
            b"g" => {
                let group = rest_of(line, keyword);
                let name = match (self.object.as_str(), group.as_str()) {
                    ("", group) => group.to_owned(),
                    (object, "" | "default") => object.to_owned(),
                    (object, group) if object == group => object.to_owned(),
                    (object, group) => format!("{object}/{group}"),
                };
                self.enter_group(name);
            }
            b"usemtl" => {
                let name = rest_of(line, keyword);
                let next = self.materials.len() as u32;
                self.material = *self.material_numbers.entry(name.clone()).or_insert(next);
                if self.material == next {
                    self.materials.push(name);
                }
            }
            b"mtllib" => self.libraries.push(rest_of(line, keyword)),
            b"s" | b"vp" => {}
            b"l" | b"p" | b"curv" | b"curv2" | b"surf" => self.dropped += 1,
            _ => self.ignored.push(IgnoredLine {
                number: at,
                text: quote(line.trim_ascii()),
            }),
        }
        Ok(())
    }

    /// Reads `v`.
    fn position<'w>(
        &mut self,
        mut words: impl Iterator<Item = &'w [u8]>,
        line: &[u8],
        at: usize,
    ) -> Result<(), FormatError> {
        let mut values = [0.0_f64; 7];
        let mut count = 0;
        for (slot, word) in values.iter_mut().zip(&mut words) {
            *slot = number(word).ok_or_else(|| self.not_a_number(word, at))?;
            count += 1;
        }
        if count < 3 {
            let place = format!("line {at}");
            return Err(self
                .file
                .malformed(place, quote(line), "`v` and three numbers"));
        }
        let p = DVec3::new(values[0], values[1], values[2]);
        if !p.is_finite() {
            return Err(FormatError::NotFinite {
                file: self.file.0.to_owned(),
                element: format!("line {at}"),
                vertex: self.positions.len(),
                value: p
                    .to_array()
                    .into_iter()
                    .find(|v| !v.is_finite())
                    .unwrap_or(f64::NAN),
            });
        }
        // Six numbers are a position and a colour; of seven, the fourth is a weight.
        if count >= 6 {
            let white = [1.0; 3];
            self.colors.resize(self.positions.len(), white);
            let c = &values[count - 3..count];
            self.colors.push([c[0] as f32, c[1] as f32, c[2] as f32]);
        }
        self.positions.push(p);
        Ok(())
    }

    fn not_a_number(&self, word: &[u8], at: usize) -> FormatError {
        self.file
            .malformed(format!("line {at}"), quote(word), "a number")
    }

    /// Reads at most `N` numbers; fewer than `least` are an error.
    fn floats<'w, const N: usize>(
        &self,
        words: impl Iterator<Item = &'w [u8]>,
        line: &[u8],
        at: usize,
        least: usize,
    ) -> Result<[f32; N], FormatError> {
        let mut values = [0.0; N];
        let mut count = 0;
        for (slot, word) in values.iter_mut().zip(words) {
            *slot = number(word).ok_or_else(|| self.not_a_number(word, at))?;
            count += 1;
        }
        if count >= least {
            return Ok(values);
        }
        let right = format!("at least {least} numbers");
        Err(self
            .file
            .malformed(format!("line {at}"), quote(line), right))
    }

    /// Makes a group the current one.
    fn enter_group(&mut self, name: String) {
        let next = self.groups.len();
        self.current = *self.group_numbers.entry(name.clone()).or_insert(next);
        if self.current == next {
            self.groups.push(Group {
                name,
                ..Group::default()
            });
        }
    }

    /// Reads `f`.
    fn face<'w>(
        &mut self,
        words: impl Iterator<Item = &'w [u8]>,
        line: &[u8],
        at: usize,
    ) -> Result<(), FormatError> {
        let lists = [
            self.positions.len(),
            self.coordinates.len(),
            self.normals.len(),
        ];
        let group = &mut self.groups[self.current];
        for word in words {
            let mut corner = [ABSENT; 3];
            let mut parts = word.split(|&b| b == b'/');
            for (k, slot) in corner.iter_mut().enumerate() {
                let part = parts.next().unwrap_or_default();
                if part.is_empty() && k > 0 {
                    continue;
                }
                let index = integer(part).ok_or_else(|| {
                    self.file.malformed(
                        format!("line {at}"),
                        quote(line.trim_ascii()),
                        "`f` and corners such as 1, 1/1, 1//1 or 1/1/1",
                    )
                })?;
                // Positive numbers count from 1, negative ones from the end; 0 is invalid.
                let number = if index > 0 {
                    index - 1
                } else {
                    lists[k] as i64 + index
                };
                *slot = match u32::try_from(number) {
                    Ok(i) if index != 0 && i != ABSENT => i,
                    _ => return Err(self.out_of_range(at, index, lists[k], k)),
                };
            }
            group.corners.push(corner);
        }
        group.faces.push(Face {
            end: group.corners.len(),
            line: at,
            material: self.material,
        });
        Ok(())
    }

    /// The error for a number that is not in list `list`.
    fn out_of_range(&self, line: usize, index: i64, count: usize, list: usize) -> FormatError {
        let kind = ["v", "vt", "vn"][list];
        FormatError::IndexOutOfRange {
            file: self.file.0.to_owned(),
            element: format!(
                "line {line}, list `{kind}` (counted from 1, from the end if negative)"
            ),
            face: self.groups.iter().map(|g| g.faces.len()).sum(),
            index,
            count,
        }
    }

    /// Builds the scene.
    fn finish(mut self, bytes: &[u8], resolve: Resolve) -> Result<Scene, FormatError> {
        let faces: usize = self.groups.iter().map(|g| g.faces.len()).sum();
        if faces == 0 && !self.positions.is_empty() {
            return Err(FormatError::PointCloud {
                file: self.file.0.to_owned(),
                points: self.positions.len(),
            });
        }
        if faces == 0 {
            return Err(FormatError::NotThisFormat {
                file: self.file.0.to_owned(),
                format: "OBJ",
                found: format!("no `v` and no `f` lines; it begins with {}", quote(bytes)),
                right: "lines such as `v 0 0 0` and `f 1 2 3`".to_owned(),
            });
        }
        let mut scene = Scene::default();
        self.note_ignored(&mut scene);
        let materials = self.read_materials(&mut scene, resolve);
        let white = [1.0; 3];
        if !self.colors.is_empty() {
            self.colors.resize(self.positions.len(), white);
        }
        let mut unifier = Unifier::new(self.positions.len());
        let mut triangulator = Triangulator::default();
        let mut statistics = FaceStatistics::default();
        for group in &self.groups {
            let mut mesh = self.mesh(
                group,
                &materials,
                &mut unifier,
                &mut triangulator,
                &mut statistics,
            )?;
            if !mesh.triangles.is_empty() {
                clean_attributes(&mut mesh, &mut scene.notes);
                let (name, transform) = (group.name.clone(), DAffine3::IDENTITY);
                scene.nodes.push(Node {
                    name,
                    transform,
                    mesh: Arc::new(mesh),
                    parent: None,
                    is_detail: false,
                });
            }
        }
        statistics.add_notes(&mut scene.notes);
        Ok(scene)
    }

    /// Adds notes on what is left out.
    fn note_ignored(&self, scene: &mut Scene) {
        if self.dropped > 0 {
            scene.notes.push(format!(
                "{} points, lines and curves were dropped.",
                self.dropped
            ));
        }
        if let Some(IgnoredLine { number, text }) = self.ignored.first() {
            scene.notes.push(format!(
                "{} lines that are not valid OBJ were ignored, the first one is line {number}: {text}.",
                self.ignored.len()
            ));
        }
    }

    /// Reads the material libraries. Returns the number of each material in use among those of the scene.
    fn read_materials(&self, scene: &mut Scene, resolve: Resolve) -> Vec<u32> {
        for library in &self.libraries {
            // One file with spaces in its name, or several files.
            if let Ok(bytes) = resolve(library) {
                material::read(&bytes, scene);
                continue;
            }
            for path in library.split_whitespace() {
                match resolve(path) {
                    Ok(bytes) => material::read(&bytes, scene),
                    Err(error) => scene.notes.push(format!(
                        "The materials in {path} cannot be read ({error}); only their names are known."
                    )),
                }
            }
        }
        let mut numbers_by_name = HashMap::new();
        for (i, material) in scene.materials.iter().enumerate() {
            numbers_by_name
                .entry(material.name.clone())
                .or_insert(i as u32);
        }
        let mut numbers = Vec::with_capacity(self.materials.len());
        for name in &self.materials {
            if name == material::NO_MATERIAL_NAME && !numbers_by_name.contains_key(name) {
                numbers.push(NO_MATERIAL);
                continue;
            }
            numbers.push(numbers_by_name.get(name).copied().unwrap_or_else(|| {
                scene
                    .materials
                    .push(material::default_material(name.clone()));
                scene.materials.len() as u32 - 1
            }));
        }
        numbers
    }

    /// Builds the mesh of a group.
    fn mesh(
        &self,
        group: &Group,
        materials: &[u32],
        unifier: &mut Unifier,
        triangulator: &mut Triangulator,
        statistics: &mut FaceStatistics,
    ) -> Result<Mesh, FormatError> {
        let lists = [
            self.positions.len(),
            self.coordinates.len(),
            self.normals.len(),
        ];
        let mut start = 0;
        for face in &group.faces {
            for corner in &group.corners[start..face.end] {
                for (k, &i) in corner.iter().enumerate() {
                    if i as usize >= lists[k] && (k == 0 || i != ABSENT) {
                        return Err(self.out_of_range(face.line, i64::from(i) + 1, lists[k], k));
                    }
                }
            }
            start = face.end;
        }
        let (vertices, numbers) = unifier.unify(&group.corners);
        let mut mesh = Mesh {
            positions: vertices
                .iter()
                .map(|c| self.positions[c[0] as usize])
                .collect(),
            ..Mesh::default()
        };
        let mut start = 0;
        let mut points = Vec::new();
        let has_material = group.faces.iter().any(|f| f.material != NO_MATERIAL);
        for face in &group.faces {
            let corners = &numbers[start..face.end];
            start = face.end;
            let before = mesh.triangles.len();
            if let [a, b, c] = *corners {
                mesh.triangles.push([a, b, c]);
            } else {
                statistics.count(corners.len());
                points.clear();
                points.extend(corners.iter().map(|&i| mesh.positions[i as usize]));
                let triangles = triangulator.triangulate(&points);
                mesh.triangles
                    .extend(triangles.iter().map(|t| t.map(|k| corners[k as usize])));
            }
            if has_material {
                let material = materials.get(face.material as usize).copied();
                let added = mesh.triangles.len() - before;
                mesh.materials
                    .extend(std::iter::repeat_n(material.unwrap_or(NO_MATERIAL), added));
            }
        }
        self.add_attributes(&vertices, &mut mesh);
        Ok(mesh)
    }

    /// Adds the attributes of the vertices, given by their corners, to a mesh.
    fn add_attributes(&self, vertices: &[Corner], mesh: &mut Mesh) {
        let used = |k: usize| vertices.iter().any(|c| c[k] != ABSENT);
        if used(1) {
            let at = |c: &Corner| {
                self.coordinates
                    .get(c[1] as usize)
                    .copied()
                    .unwrap_or_default()
            };
            let data = vertices.iter().flat_map(at).collect();
            mesh.attributes
                .insert("TEXCOORD_0".to_owned(), Attribute { width: 2, data });
        }
        if used(2) {
            let at = |c: &Corner| self.normals.get(c[2] as usize).copied().unwrap_or_default();
            let data = vertices.iter().flat_map(at).collect();
            mesh.attributes
                .insert("NORMAL".to_owned(), Attribute { width: 3, data });
        }
        if !self.colors.is_empty() {
            let data = vertices
                .iter()
                .flat_map(|c| self.colors[c[0] as usize])
                .collect();
            mesh.attributes
                .insert("COLOR_0".to_owned(), Attribute { width: 3, data });
        }
    }
}

/// The text after the keyword.
fn rest_of(line: &[u8], keyword: &[u8]) -> String {
    let rest = line
        .trim_ascii()
        .get(keyword.len()..)
        .unwrap_or_default()
        .trim_ascii();
    String::from_utf8_lossy(rest).into_owned()
}

/// Parses an integer. A million triangles have at least three million of them, for which `str::parse` is too slow.
fn integer(token: &[u8]) -> Option<i64> {
    let (negative, digits) = match token.split_first()? {
        (b'-', rest) => (true, rest),
        (b'+', rest) => (false, rest),
        _ => (false, token),
    };
    if digits.is_empty() || digits.len() > 18 {
        return None;
    }
    let mut value = 0_i64;
    for &d in digits {
        if !d.is_ascii_digit() {
            return None;
        }
        value = 10 * value + i64::from(d - b'0');
    }
    Some(if negative { -value } else { value })
}
