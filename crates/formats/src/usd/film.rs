//! A film as a binary layer: points, normals and extents of pieces over time, places of what moves as a whole.

use super::binary::Crate;
use super::layer::{Content, Layer, Prim, Property, Samples, Stored, Value};
use super::mesh::extent;
use super::{Stage, UsdFormat, pack, place};
use crate::assemble::{Surfaces, narrow};
use crate::film::{FilmError, FilmReport, Reel, Sink};
use crate::{Encoded, stem};
use glam::{DAffine3, DQuat, DVec3};
use greenstick_geometry::{Context, Extra, Film, Mesh, Pose, RigidBody, SkinnedMesh};
use std::collections::BTreeMap;
use std::io::{Error, Result as Written};

/// Writes the film; gives the files of its textures too, where they are not in it.
pub(crate) fn write_film(
    format: UsdFormat,
    film: &Film,
    reel: &mut Reel,
    out: &mut dyn Sink,
    context: &Context,
) -> Result<(FilmReport, Vec<Encoded>), FilmError> {
    let archive = format == UsdFormat::Usdz;
    if format == UsdFormat::Usda {
        let right = "a .usdc or .usdz, since text over time would be huge";
        return Err(reel.file().unwritable("a film as .usda text", right).into());
    }
    let pieces = film.pieces.iter().map(|p| &p.mesh);
    let nodes = film.bodies.iter().map(|b| &b.node).chain(&film.fixed);
    let meshes = pieces.chain(nodes.map(|n| &*n.mesh));
    let mut stage = Stage::new(Surfaces::of_film(film), meshes, reel.name, archive);
    let files = std::mem::take(&mut stage.looks.files);
    let mut report = FilmReport {
        frames: reel.frames(),
        ..FilmReport::default()
    };
    let name = reel.name;
    // What the film itself does wrong passes through the archive, which knows only what files do wrong.
    let mut fault = None;
    let mut stage = Some(stage);
    let mut fill = |out: &mut dyn Sink| -> Written<(u64, u32)> {
        let Some(stage) = stage.take() else {
            return Err(Error::other("a layer is written once"));
        };
        Recording::write(film, stage, reel, out, context, &mut report).map_err(|e| {
            fault = Some(e);
            Error::other("the film cannot be written")
        })
    };
    let done = if archive {
        pack(out, &format!("{}.usdc", stem(name)), &mut fill, &files)
    } else {
        fill(out).and_then(|(length, _)| out.flush().map(|()| length))
    };
    match (done, fault) {
        (Ok(bytes), _) => {
            report.bytes = bytes;
            Ok((report, if archive { Vec::new() } else { files }))
        }
        (Err(_), Some(fault)) => Err(fault),
        (Err(source), None) => Err(reel.failed(source)),
    }
}

/// A value over time as it goes to the file.
#[derive(Default)]
struct Track {
    values: Vec<Stored>,
    /// The last value, in whose place the next one lies where it is the same.
    last: Option<Value>,
}

impl Track {
    fn put(&mut self, value: Value, file: &mut Crate) -> Written<()> {
        match (&self.last, self.values.last()) {
            (Some(last), Some(&place)) if *last == value => self.values.push(place),
            _ => {
                self.values.push(file.value(&value)?);
                self.last = Some(value);
            }
        }
        Ok(())
    }

    /// Gives the property its values; whether they change.
    fn give(self, property: Option<&mut Property>, times: Stored) -> bool {
        let moves = self.values.windows(2).any(|w| w[0] != w[1]);
        if let Some(Content::Attribute { value, samples, .. }) = property.map(|p| &mut p.content) {
            if moves {
                *value = None;
                *samples = Some(Samples {
                    times,
                    values: self.values,
                });
            } else {
                *value = self.values.first().map(|&s| Value::Stored(s));
            }
        }
        moves
    }
}

/// What moves: the prim, and its values over time.
enum Mover {
    /// A piece, by its number; its normals at rest; points, extent, normals.
    Piece(usize, Vec<[f32; 3]>, [Track; 3]),
    /// A whole, by its joint; its place and turn, the latter with the sign that is nearer to the last.
    Whole(u32, Option<DQuat>, [Track; 2]),
}

struct Recording<'a> {
    movers: Vec<(Prim, Mover)>,
    film: &'a Film,
}

const PIECE: [&str; 3] = ["points", "extent", "normals"];
const WHOLE: [&str; 2] = ["xformOp:translate", "xformOp:orient"];

impl Recording<'_> {
    fn write(
        film: &Film,
        mut stage: Stage,
        reel: &mut Reel,
        out: &mut dyn Sink,
        context: &Context,
        report: &mut FilmReport,
    ) -> Result<(u64, u32), FilmError> {
        let mut file = Crate::new(out).map_err(|e| reel.failed(e))?;
        for node in &film.fixed {
            if let Some(mut prim) = stage.still(node, reel.file())? {
                file.store(&mut prim).map_err(|e| reel.failed(e))?;
                stage.root.children.push(prim);
            }
        }
        let mut recording = Recording {
            movers: Vec::new(),
            film,
        };
        recording.begin(&mut stage, reel, &mut file)?;
        for (_, mover) in &recording.movers {
            match mover {
                Mover::Piece(..) => report.skinned += 1,
                Mover::Whole(..) => report.rigid += 1,
            }
        }
        recording.frames(reel, &mut file, context)?;
        let rate = film.frames_per_second;
        let codes: Vec<f64> = reel.times.iter().map(|t| code(t * rate)).collect();
        let times = file.times(&codes).map_err(|e| reel.failed(e))?;
        for (mut prim, mover) in recording.movers {
            let (names, tracks): (&[&str], Vec<Track>) = match mover {
                Mover::Piece(_, _, tracks) => (&PIECE, tracks.into()),
                Mover::Whole(_, _, tracks) => (&WHOLE, tracks.into()),
            };
            for (name, track) in names.iter().zip(tracks) {
                if track.values.is_empty() {
                    continue;
                }
                let moves = track.give(prim.property(name), times);
                report.channels += 1;
                report.constant += usize::from(!moves);
            }
            stage.root.children.push(prim);
        }
        let (first, last) = (codes.first().copied(), codes.last().copied());
        let (layer, _): (Layer, _) = stage.finish(vec![
            ("framesPerSecond", Value::Double(rate)),
            ("timeCodesPerSecond", Value::Double(rate)),
            ("startTimeCode", Value::Double(first.unwrap_or(0.0))),
            ("endTimeCode", Value::Double(last.unwrap_or(0.0))),
        ]);
        file.finish(&layer).map_err(|e| reel.failed(e))
    }

    /// Prims of all that moves, their values that do not change in the file.
    fn begin(&mut self, stage: &mut Stage, reel: &Reel, file: &mut Crate) -> Result<(), FilmError> {
        let film = self.film;
        let none = BTreeMap::new();
        for (p, piece) in film.pieces.iter().enumerate() {
            match piece.binding.used_joints().as_slice() {
                [joint] if piece.earlier.count() == 0 => {
                    let body = (piece.name.as_str(), &piece.mesh, DAffine3::IDENTITY);
                    self.whole(body, *joint, &piece.extras, stage, reel, file)?;
                }
                _ => self.piece(p, piece, stage, reel, file)?,
            }
        }
        for RigidBody { node, joint } in &film.bodies {
            let body = (node.name.as_str(), &*node.mesh, node.transform);
            self.whole(body, *joint, &none, stage, reel, file)?;
        }
        Ok(())
    }

    fn piece(
        &mut self,
        number: usize,
        piece: &SkinnedMesh,
        stage: &mut Stage,
        reel: &Reel,
        file: &mut Crate,
    ) -> Result<(), FilmError> {
        let Some(mut shape) = stage.mesh(&piece.mesh, &piece.name, reel.file())? else {
            return Ok(());
        };
        // Their values come with the frames.
        for name in PIECE {
            if let Some(Content::Attribute { value, .. }) =
                shape.prim.property(name).map(|p| &mut p.content)
            {
                *value = None;
            }
        }
        put_extras(&mut shape.prim, &piece.extras);
        file.store(&mut shape.prim).map_err(|e| reel.failed(e))?;
        let tracks = Default::default();
        let mover = Mover::Piece(number, shape.normals, tracks);
        self.movers.push((shape.prim, mover));
        Ok(())
    }

    /// A mesh that moves as a whole, as its joint sees it: (name, mesh, its place at rest).
    fn whole(
        &mut self,
        (name, mesh, at_rest): (&str, &Mesh, DAffine3),
        joint: u32,
        extras: &BTreeMap<String, Extra>,
        stage: &mut Stage,
        reel: &Reel,
        file: &mut Crate,
    ) -> Result<(), FilmError> {
        let rest = self.film.joints[joint as usize].rest;
        let seen = mesh.transformed(&(rest.inverse() * at_rest));
        let Some(shape) = stage.mesh(&seen, name, reel.file())? else {
            return Ok(());
        };
        let mut prim = shape.prim;
        let nowhere = Value::Double3([0.0; 3]);
        let steps = vec![
            ("translate", "double3", nowhere),
            ("orient", "quatf", Value::Turn([0.0, 0.0, 0.0, 1.0])),
        ];
        place(&mut prim, steps);
        put_extras(&mut prim, extras);
        file.store(&mut prim).map_err(|e| reel.failed(e))?;
        let mover = Mover::Whole(joint, None, Default::default());
        self.movers.push((prim, mover));
        Ok(())
    }

    fn frames(
        &mut self,
        reel: &mut Reel,
        file: &mut Crate,
        context: &Context,
    ) -> Result<(), FilmError> {
        let film = self.film;
        let frames = reel.frames();
        let mut maps = Vec::new();
        let mut places: Vec<DVec3> = Vec::new();
        for frame in 0..frames {
            context.report(frame as f64 / frames as f64)?;
            let poses = reel.at(frame)?;
            film.joint_maps(poses, &mut maps);
            let mut wholes = Vec::new();
            for (_, mover) in &mut self.movers {
                if let Mover::Whole(joint, last, _) = mover {
                    wholes.push(whole_at(&poses[*joint as usize], last));
                }
            }
            let mut wholes = wholes.into_iter();
            for (_, mover) in &mut self.movers {
                let put = match mover {
                    Mover::Piece(number, normals, tracks) => {
                        film.deform_positions_at(frame, *number, &maps, &mut places);
                        let narrowed = places.iter().map(|&p| narrow(p, reel.file()));
                        let points = narrowed.collect::<Result<Vec<_>, _>>()?;
                        let extent = extent(&points);
                        film.deform_directions_at(frame, *number, &maps, normals, &mut places);
                        let normals = places.iter().map(|n| n.as_vec3().to_array()).collect();
                        put_piece(tracks, points, extent, normals, file)
                    }
                    Mover::Whole(_, _, [place, turn]) => match wholes.next() {
                        Some((at, facing)) => {
                            place.put(at, file).and_then(|()| turn.put(facing, file))
                        }
                        None => Ok(()),
                    },
                };
                put.map_err(|e| reel.failed(e))?;
            }
        }
        Ok(())
    }
}

fn put_piece(
    [places, extents, directions]: &mut [Track; 3],
    points: Vec<[f32; 3]>,
    extent: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    file: &mut Crate,
) -> Written<()> {
    places.put(Value::Float3s(points), file)?;
    extents.put(Value::Float3s(extent), file)?;
    if normals.is_empty() {
        return Ok(());
    }
    directions.put(Value::Float3s(normals), file)
}

/// A pose as values: its place, and its turn with the sign that is nearer to the last.
fn whole_at(pose: &Pose, last: &mut Option<DQuat>) -> (Value, Value) {
    let mut turn = pose.rotation.normalize();
    if last.is_some_and(|l| l.dot(turn) < 0.0) {
        turn = -turn;
    }
    *last = Some(turn);
    (
        Value::Double3(pose.translation.to_array()),
        Value::Turn(turn.as_quat().to_array()),
    )
}

/// A time code; what is a whole number but for rounding becomes one.
fn code(time: f64) -> f64 {
    let whole = time.round();
    if (time - whole).abs() < 1e-6 {
        whole
    } else {
        time
    }
}

/// What is said of a piece besides, where users look for it.
fn put_extras(prim: &mut Prim, extras: &BTreeMap<String, Extra>) {
    let mut names = super::Names::default();
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
