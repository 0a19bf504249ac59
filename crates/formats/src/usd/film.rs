//! Films as binary layers: points, normals and extents of deforming pieces over time, and transforms of rigid ones.

use super::archive::write_archive;
use super::binary::CrateWriter;
use super::format::UsdFormat;
use super::layer::{
    Content, Layer, Metadatum, Prim, Property, Samples, Stored, TransformOp, Value,
};
use super::mesh::extent;
use super::names::Names;
use super::stage::Stage;
use crate::check::Surfaces;
use crate::companions::{Encoded, stem};
use crate::error::{FormatError, InFile};
use crate::film::{FilmError, FilmReport, Frames};
use crate::position::to_f32;
use crate::sink::Sink;
use glam::{DAffine3, DQuat, DVec3};
use greenstick_geometry::{Context, Extra, Film, Mesh, Pose, RigidBody, SkinnedMesh};
use std::collections::BTreeMap;
use std::io::{Error, Result as IoResult};

/// Writes a film. Also returns its texture files, unless the archive contains them.
pub(crate) fn write_film(
    format: UsdFormat,
    film: &Film,
    frames: &mut Frames,
    out: &mut dyn Sink,
    context: &Context,
) -> Result<(FilmReport, Vec<Encoded>), FilmError> {
    let is_archive = format == UsdFormat::Usdz;
    if format == UsdFormat::Usda {
        let right = "a .usdc or .usdz file, because text with time samples would be huge";
        return Err(frames
            .file()
            .unwritable("a film as .usda text", right)
            .into());
    }
    let pieces = film.pieces.iter().map(|p| &p.mesh);
    let nodes = film.bodies.iter().map(|b| &b.node).chain(&film.fixed);
    let meshes = pieces.chain(nodes.map(|n| &*n.mesh));
    let mut stage = Stage::new(Surfaces::from_film(film), meshes, frames.name, is_archive);
    let files = std::mem::take(&mut stage.materials.files);
    let mut report = FilmReport {
        frames: frames.count(),
        ..FilmReport::default()
    };
    let name = frames.name;
    // An error of the film has to pass through the archive, whose errors are those of its destination.
    let mut film_error = None;
    let mut stage = Some(stage);
    let mut write_layer = |out: &mut dyn Sink| -> IoResult<(u64, u32)> {
        let Some(stage) = stage.take() else {
            return Err(Error::other("a layer is written only once"));
        };
        Recording::write(film, stage, frames, out, context, &mut report).map_err(|e| {
            film_error = Some(e);
            Error::other("the film cannot be written")
        })
    };
    let written = if is_archive {
        write_archive(
            out,
            &format!("{}.usdc", stem(name)),
            &mut write_layer,
            &files,
        )
    } else {
        write_layer(out).and_then(|(length, _)| out.flush().map(|()| length))
    };
    match (written, film_error) {
        (Ok(bytes), _) => {
            report.bytes = bytes;
            Ok((report, if is_archive { Vec::new() } else { files }))
        }
        (Err(_), Some(error)) => Err(error),
        (Err(source), None) => Err(frames.write_error(source)),
    }
}

/// A value over time, written as it comes.
#[derive(Default)]
struct Track {
    values: Vec<Stored>,
    /// The last value; an equal one that follows refers to the same bytes.
    last: Option<Value>,
}

impl Track {
    /// Writes the value of the next frame.
    fn push(&mut self, value: Value, file: &mut CrateWriter) -> IoResult<()> {
        match (&self.last, self.values.last()) {
            (Some(last), Some(&stored)) if *last == value => self.values.push(stored),
            _ => {
                self.values.push(file.value(&value)?);
                self.last = Some(value);
            }
        }
        Ok(())
    }

    /// Sets the values of the property. Returns whether they change.
    fn set_on(self, property: Option<&mut Property>, times: Stored) -> bool {
        let changes = self.values.windows(2).any(|w| w[0] != w[1]);
        if let Some(Content::Attribute { value, samples, .. }) = property.map(|p| &mut p.content) {
            if changes {
                *value = None;
                *samples = Some(Samples {
                    times,
                    values: self.values,
                });
            } else {
                *value = self.values.first().map(|&s| Value::Stored(s));
            }
        }
        changes
    }
}

/// A prim that moves.
struct Moving {
    prim: Prim,
    motion: PrimMotion,
}

/// The motion of a prim.
enum PrimMotion {
    /// A deforming piece.
    Deforming {
        piece: usize,
        /// Normals at rest.
        normals: Vec<[f32; 3]>,
        /// Values of [`DEFORMING_PROPERTIES`].
        tracks: [Track; 3],
    },
    /// A rigid mesh.
    Rigid {
        joint: u32,
        /// Rotation in the last frame.
        last: Option<DQuat>,
        /// Values of [`RIGID_PROPERTIES`].
        tracks: [Track; 2],
    },
}

/// Properties of deforming pieces that vary over time.
const DEFORMING_PROPERTIES: [&str; 3] = ["points", "extent", "normals"];
/// Properties of rigid meshes that vary over time.
const RIGID_PROPERTIES: [&str; 2] = ["xformOp:translate", "xformOp:orient"];

/// A mesh that moves rigidly.
struct RigidMesh<'a> {
    name: &'a str,
    mesh: &'a Mesh,
    /// Its transform to the world when its joint is at rest.
    at_rest: DAffine3,
    joint: u32,
    extras: &'a BTreeMap<String, Extra>,
}

/// A film while its frames are written.
struct Recording<'a> {
    moving: Vec<Moving>,
    film: &'a Film,
}

impl Recording<'_> {
    /// Writes the layer of a film. Returns its length and checksum.
    fn write(
        film: &Film,
        mut stage: Stage,
        frames: &mut Frames,
        out: &mut dyn Sink,
        context: &Context,
        report: &mut FilmReport,
    ) -> Result<(u64, u32), FilmError> {
        let mut file = CrateWriter::new(out).map_err(|e| frames.write_error(e))?;
        for node in &film.fixed {
            if let Some(mut prim) = stage.static_prim(node, frames.file())? {
                file.store(&mut prim).map_err(|e| frames.write_error(e))?;
                stage.root.children.push(prim);
            }
        }
        let mut recording = Recording {
            moving: Vec::new(),
            film,
        };
        recording.add_prims(&mut stage, frames, &mut file)?;
        for Moving { motion, .. } in &recording.moving {
            match motion {
                PrimMotion::Deforming { .. } => report.skinned += 1,
                PrimMotion::Rigid { .. } => report.rigid += 1,
            }
        }
        recording.write_frames(frames, &mut file, context)?;
        let rate = film.frames_per_second;
        let codes: Vec<f64> = frames.times.iter().map(|t| time_code(t * rate)).collect();
        let times = file.times(&codes).map_err(|e| frames.write_error(e))?;
        for Moving { mut prim, motion } in recording.moving {
            let (names, tracks): (&[&str], Vec<Track>) = match motion {
                PrimMotion::Deforming { tracks, .. } => (&DEFORMING_PROPERTIES, tracks.into()),
                PrimMotion::Rigid { tracks, .. } => (&RIGID_PROPERTIES, tracks.into()),
            };
            for (name, track) in names.iter().zip(tracks) {
                if track.values.is_empty() {
                    continue;
                }
                let changes = track.set_on(prim.property(name), times);
                report.channels += 1;
                report.constant += usize::from(!changes);
            }
            stage.root.children.push(prim);
        }
        let (first, last) = (codes.first().copied(), codes.last().copied());
        let about_time = vec![
            Metadatum::new("framesPerSecond", Value::Double(rate)),
            Metadatum::new("timeCodesPerSecond", Value::Double(rate)),
            Metadatum::new("startTimeCode", Value::Double(first.unwrap_or(0.0))),
            Metadatum::new("endTimeCode", Value::Double(last.unwrap_or(0.0))),
        ];
        let (layer, _): (Layer, _) = stage.finish(about_time, &film.metadata);
        file.finish(&layer).map_err(|e| frames.write_error(e))
    }

    /// Adds prims for everything that moves, and writes their constant values.
    fn add_prims(
        &mut self,
        stage: &mut Stage,
        frames: &Frames,
        file: &mut CrateWriter,
    ) -> Result<(), FilmError> {
        let film = self.film;
        let no_extras = BTreeMap::new();
        for (p, piece) in film.pieces.iter().enumerate() {
            match piece.binding.used_joints().as_slice() {
                [joint] if piece.earlier.count() == 0 => {
                    let rigid = RigidMesh {
                        name: &piece.name,
                        mesh: &piece.mesh,
                        at_rest: DAffine3::IDENTITY,
                        joint: *joint,
                        extras: &piece.extras,
                    };
                    self.add_rigid(&rigid, stage, frames, file)?;
                }
                _ => self.add_deforming(p, piece, stage, frames, file)?,
            }
        }
        for RigidBody { node, joint } in &film.bodies {
            let rigid = RigidMesh {
                name: &node.name,
                mesh: &node.mesh,
                at_rest: node.transform,
                joint: *joint,
                extras: &no_extras,
            };
            self.add_rigid(&rigid, stage, frames, file)?;
        }
        Ok(())
    }

    /// Adds a deforming piece.
    fn add_deforming(
        &mut self,
        number: usize,
        piece: &SkinnedMesh,
        stage: &mut Stage,
        frames: &Frames,
        file: &mut CrateWriter,
    ) -> Result<(), FilmError> {
        let Some(mut shape) = stage.mesh(&piece.mesh, &piece.name, frames.file())? else {
            return Ok(());
        };
        // Their values follow with the frames.
        for name in DEFORMING_PROPERTIES {
            if let Some(Content::Attribute { value, .. }) =
                shape.prim.property(name).map(|p| &mut p.content)
            {
                *value = None;
            }
        }
        put_extras(&mut shape.prim, &piece.extras);
        file.store(&mut shape.prim)
            .map_err(|e| frames.write_error(e))?;
        self.moving.push(Moving {
            prim: shape.prim,
            motion: PrimMotion::Deforming {
                piece: number,
                normals: shape.normals,
                tracks: Default::default(),
            },
        });
        Ok(())
    }

    /// Adds a mesh that moves rigidly, in the coordinates of its joint.
    fn add_rigid(
        &mut self,
        rigid: &RigidMesh,
        stage: &mut Stage,
        frames: &Frames,
        file: &mut CrateWriter,
    ) -> Result<(), FilmError> {
        let rest = self.film.joints[rigid.joint as usize].rest;
        let local = rigid.mesh.transformed(&(rest.inverse() * rigid.at_rest));
        let Some(shape) = stage.mesh(&local, rigid.name, frames.file())? else {
            return Ok(());
        };
        let mut prim = shape.prim;
        prim.set_transform(vec![
            TransformOp {
                name: "translate",
                kind: "double3",
                value: Value::Double3([0.0; 3]),
            },
            TransformOp {
                name: "orient",
                kind: "quatf",
                value: Value::Quaternion([0.0, 0.0, 0.0, 1.0]),
            },
        ]);
        put_extras(&mut prim, rigid.extras);
        file.store(&mut prim).map_err(|e| frames.write_error(e))?;
        self.moving.push(Moving {
            prim,
            motion: PrimMotion::Rigid {
                joint: rigid.joint,
                last: None,
                tracks: Default::default(),
            },
        });
        Ok(())
    }

    /// Writes the values of all frames.
    fn write_frames(
        &mut self,
        frames: &mut Frames,
        file: &mut CrateWriter,
        context: &Context,
    ) -> Result<(), FilmError> {
        let count = frames.count();
        let mut maps = Vec::new();
        for frame in 0..count {
            context.report(frame as f64 / count as f64)?;
            let poses = frames.poses(frame)?;
            self.film.joint_maps(poses, &mut maps);
            let rigid: Vec<[Value; 2]> = self
                .moving
                .iter_mut()
                .filter_map(|moving| match &mut moving.motion {
                    PrimMotion::Rigid { joint, last, .. } => {
                        Some(pose_values(&poses[*joint as usize], last))
                    }
                    PrimMotion::Deforming { .. } => None,
                })
                .collect();
            let mut rigid = rigid.into_iter();
            for Moving { motion, .. } in &mut self.moving {
                match motion {
                    PrimMotion::Deforming {
                        piece,
                        normals,
                        tracks,
                    } => {
                        let deformed =
                            Deformed::new(self.film, frame, *piece, &maps, normals, frames.file())?;
                        deformed
                            .push_to(tracks, file)
                            .map_err(|e| frames.write_error(e))?;
                    }
                    PrimMotion::Rigid { tracks, .. } => {
                        for (track, value) in
                            tracks.iter_mut().zip(rigid.next().into_iter().flatten())
                        {
                            track.push(value, file).map_err(|e| frames.write_error(e))?;
                        }
                    }
                }
            }
        }
        Ok(())
    }
}

/// The vertices of a deforming piece in a frame.
struct Deformed {
    points: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
}

impl Deformed {
    /// Computes the vertices; `at_rest` are the normals at rest.
    fn new(
        film: &Film,
        frame: usize,
        piece: usize,
        maps: &[DAffine3],
        at_rest: &[[f32; 3]],
        file: InFile,
    ) -> Result<Self, FormatError> {
        let mut vectors: Vec<DVec3> = Vec::new();
        film.deform_positions_at(frame, piece, maps, &mut vectors);
        let points = vectors.iter().map(|&p| to_f32(p, file));
        let points = points.collect::<Result<Vec<_>, _>>()?;
        film.deform_directions_at(frame, piece, maps, at_rest, &mut vectors);
        let normals = vectors.iter().map(|n| n.as_vec3().to_array()).collect();
        Ok(Deformed { points, normals })
    }

    /// Writes the values of [`DEFORMING_PROPERTIES`].
    fn push_to(self, tracks: &mut [Track; 3], file: &mut CrateWriter) -> IoResult<()> {
        let [points, extents, normals] = tracks;
        let bounds = extent(&self.points);
        points.push(Value::Float3s(self.points), file)?;
        extents.push(Value::Float3s(bounds), file)?;
        if self.normals.is_empty() {
            return Ok(());
        }
        normals.push(Value::Float3s(self.normals), file)
    }
}

/// The values of [`RIGID_PROPERTIES`] for a pose. Of the two signs of its rotation, that closer to the last frame is chosen.
fn pose_values(pose: &Pose, last: &mut Option<DQuat>) -> [Value; 2] {
    let mut rotation = pose.rotation.normalize();
    if last.is_some_and(|l| l.dot(rotation) < 0.0) {
        rotation = -rotation;
    }
    *last = Some(rotation);
    [
        Value::Double3(pose.translation.to_array()),
        Value::Quaternion(rotation.as_quat().to_array()),
    ]
}

/// Rounds a time code to an integer if it is one up to rounding errors.
fn time_code(time: f64) -> f64 {
    let whole = time.round();
    if (time - whole).abs() < 1e-6 {
        whole
    } else {
        time
    }
}

/// Adds further properties in the namespace for users.
fn put_extras(prim: &mut Prim, extras: &BTreeMap<String, Extra>) {
    let mut names = Names::default();
    for (key, extra) in extras {
        let (kind, value) = match extra {
            Extra::Flag(v) => ("bool", Value::Bool(*v)),
            Extra::Integer(v) => ("int64", Value::Int64(*v)),
            Extra::Number(v) => ("double", Value::Double(*v)),
            Extra::Numbers(v) => ("double[]", Value::Doubles(v.clone())),
            Extra::Text(v) => ("string", Value::Text(v.clone())),
        };
        let name = format!("userProperties:{}", names.unique(key, "extra"));
        prim.properties.push(Property::custom(name, kind, value));
    }
}
