//! A run as a series of VTK files: rods and bonds with their fields, for ParaView. In the scene's own axes, z up.

use super::error::FilmError;
use super::run::Run;
use glam::DVec3;
use greenstick_fibre::store::Frame;
use greenstick_formats::Encoded;
use greenstick_formats::vtk::{Field, Polylines, TimedFile, collection, write_lines};
use greenstick_geometry::{Context, Values};
use std::ops::Range;

impl Run {
    /// Writes frames of a range as a series: hands every file to `put`, the collection `NAME.pvd` last.
    ///
    /// Rods have the fields `rod`, `part` and `diameter_m` for each line, and `vertex` and `strain` for each point (mean
    /// of its edges); bonds `stretch` (length over that at rest) for each line.
    ///
    /// # Errors
    /// [`FilmError`], and what `put` fails with.
    pub fn series(
        &mut self,
        range: Range<usize>,
        name: &str,
        mut put: impl FnMut(Encoded) -> Result<(), FilmError>,
        context: &Context,
    ) -> Result<usize, FilmError> {
        let mut files = Vec::new();
        let count = range.len();
        for (done, number) in range.enumerate() {
            context.report(done as f64 / count as f64)?;
            let frame = self.frame(number)?;
            for file in [
                self.rods(&frame, &format!("{name}_{number:05}_rods.vtp"))?,
                self.bonds(&frame, &format!("{name}_{number:05}_bonds.vtp"))?,
            ] {
                files.push(TimedFile {
                    time: frame.time,
                    file: file.name.clone(),
                });
                put(file)?;
            }
        }
        put(Encoded {
            name: format!("{name}.pvd"),
            bytes: collection(&files).into_bytes(),
        })?;
        Ok(files.len() + 1)
    }

    fn rods(&self, frame: &Frame, name: &str) -> Result<Encoded, FilmError> {
        let points = places(frame);
        let corners: Vec<u32> = (0..points.len() as u32).collect();
        let mut parts = Vec::new();
        for (rod, parent) in frame.parent.iter().enumerate() {
            let again = rod > 0 && frame.parent[rod - 1] == *parent;
            let before: u32 = parts.last().copied().unwrap_or(0);
            parts.push(if again { before + 1 } else { 0 });
        }
        let point_data = [
            Field::scalar("vertex", Values::U32(frame.origin.clone())),
            Field::scalar("strain", Values::F64(self.strains(frame, &points))),
        ];
        let diameters = frame.diameter.iter().map(|&d| f64::from(d)).collect();
        let line_data = [
            Field::scalar("rod", Values::U32(frame.parent.clone())),
            Field::scalar("part", Values::U32(parts)),
            Field::scalar("diameter_m", Values::F64(diameters)),
        ];
        let rods = Polylines {
            points: &points,
            corners: &corners,
            ends: &frame.rod_offsets[1..],
            point_data: &point_data,
            line_data: &line_data,
        };
        Ok(write_lines(&rods, name).map_err(crate::Error::from)?)
    }

    /// Mean strain of each vertex's edges.
    fn strains(&self, frame: &Frame, points: &[DVec3]) -> Vec<f64> {
        let mut strains = vec![0.0; points.len()];
        for ends in frame.rod_offsets.windows(2) {
            let (from, to) = (ends[0] as usize, ends[1] as usize);
            for i in from..to - 1 {
                let rest = self.bundle.rest_length[frame.origin[i] as usize];
                let strain = points[i].distance(points[i + 1]) / rest - 1.0;
                for v in [i, i + 1] {
                    let edges = if v == from || v + 1 == to { 1.0 } else { 2.0 };
                    strains[v] += strain / edges;
                }
            }
        }
        strains
    }

    fn bonds(&self, frame: &Frame, name: &str) -> Result<Encoded, FilmError> {
        let places = places(frame);
        let bonds = &self.bundle.bonds;
        let (mut points, mut stretch) = (Vec::new(), Vec::new());
        for &[v, e] in &frame.bonds {
            let (x, y, z) = (v as usize, e as usize, e as usize + 1);
            let own = bonds.incidence.vertex_offsets[frame.origin[x] as usize] as usize
                ..bonds.incidence.vertex_offsets[frame.origin[x] as usize + 1] as usize;
            let Some(bond) = own.clone().find(|&b| bonds.edge[b] == frame.origin[y]) else {
                continue;
            };
            let end = places[y].lerp(places[z], bonds.t[bond]);
            stretch.push(places[x].distance(end) / bonds.distance[bond]);
            points.extend([places[x], end]);
        }
        let corners: Vec<u32> = (0..points.len() as u32).collect();
        let ends: Vec<u32> = (1..=stretch.len() as u32).map(|k| 2 * k).collect();
        let line_data = [Field::scalar("stretch", Values::F64(stretch))];
        let made = Polylines {
            points: &points,
            corners: &corners,
            ends: &ends,
            point_data: &[],
            line_data: &line_data,
        };
        Ok(write_lines(&made, name).map_err(crate::Error::from)?)
    }
}

fn places(frame: &Frame) -> Vec<DVec3> {
    let double = |p: &[f32; 3]| DVec3::from_array(p.map(f64::from));
    frame.position.iter().map(double).collect()
}
