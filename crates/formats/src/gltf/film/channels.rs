//! The animation (§3.11): the translations and the rotations of each joint over all frames, each as one contiguous array
//! in the file. As frames are available one by one, blocks of frames are written at the right positions of these arrays.

use crate::film::{FilmError, Frames};
use crate::gltf::builder::Builder;
use crate::sink::Sink;
use glam::{Quat, Vec3};
use greenstick_geometry::{Context, Pose};
use serde_json::json;
use std::collections::BTreeMap;
use std::io::SeekFrom;

/// Bytes of poses in memory at a time.
const BLOCK_SIZE: usize = 8 << 20;

/// Components of a pose.
const WIDTH: usize = 7;
/// First component of the rotation.
const ROTATION: usize = 3;

/// A pose in single precision: translation and rotation.
type Components = [f32; WIDTH];

/// A node that follows a joint.
pub(super) struct AnimatedNode {
    pub node: usize,
    pub joint: u32,
}

/// The joints that move.
pub(super) struct Channels {
    /// Joints of the film, ascending.
    joints: Vec<u32>,
    /// Their poses in the first frame.
    first: Vec<Components>,
    /// For each joint, whether its translation and its rotation change.
    moves: Vec<[bool; 2]>,
}

/// Converts a pose to single precision. Of the two signs of its rotation, that closer to `before` is chosen.
fn components(pose: &Pose, before: Option<&Components>) -> Components {
    let p = pose.translation.as_vec3();
    let mut q = pose.rotation.normalize().as_quat();
    if before.is_some_and(|b| q.dot(Quat::from_slice(&b[ROTATION..])) < 0.0) {
        q = -q;
    }
    [p.x, p.y, p.z, q.x, q.y, q.z, q.w]
}

impl Channels {
    /// Starts without any frame.
    pub fn new(joints: Vec<u32>) -> Self {
        Channels {
            first: vec![[0.0; WIDTH]; joints.len()],
            moves: vec![[false; 2]; joints.len()],
            joints,
        }
    }

    /// Takes a frame into account. Frame 0 must be the first.
    pub fn observe(&mut self, frame: usize, poses: &[Pose]) {
        for (k, &j) in self.joints.iter().enumerate() {
            let pose = &poses[j as usize];
            if frame == 0 {
                self.first[k] = components(pose, None);
                continue;
            }
            let first = &self.first[k];
            let now = components(pose, Some(first));
            self.moves[k][0] |= now[..ROTATION] != first[..ROTATION];
            self.moves[k][1] |= now[ROTATION..] != first[ROTATION..];
        }
    }

    /// Removes the joints that never move, except those of skins. Returns their poses.
    pub fn remove_constant(&mut self, of_skins: &[bool]) -> BTreeMap<u32, Pose> {
        let constant: Vec<bool> = (self.joints.iter().zip(&self.moves))
            .map(|(&joint, moves)| *moves == [false; 2] && !of_skins[joint as usize])
            .collect();
        let pose = |n: &Components| Pose {
            translation: Vec3::from_slice(n).as_dvec3(),
            rotation: Quat::from_slice(&n[ROTATION..]).as_dquat().normalize(),
        };
        let all = self.joints.iter().zip(&self.first).zip(&constant);
        let out = all.filter(|(_, s)| **s).map(|((&j, n), _)| (j, pose(n)));
        let out = out.collect();
        let mut keep = constant.iter().map(|s| !s).cycle();
        self.joints.retain(|_| keep.next().unwrap_or(true));
        self.first.retain(|_| keep.next().unwrap_or(true));
        self.moves.retain(|_| keep.next().unwrap_or(true));
        out
    }

    /// Lays out the animation of `nodes`, whose data follow the binary data of the builder, and describes it.
    pub fn lay_out(
        self,
        times: &[f64],
        nodes: &[AnimatedNode],
        builder: &mut Builder,
    ) -> Animation {
        let frames = times.len();
        let mut animation = Animation {
            offsets: Vec::with_capacity(self.joints.len()),
            channels: self,
            times: times.iter().map(|&t| t as f32).collect(),
            length: 4 * frames,
        };
        for moves in &animation.channels.moves {
            let mut offsets = [0; 2];
            for part in 0..2 {
                let keys = if moves[part] { frames } else { 1 };
                offsets[part] = animation.length;
                animation.length += 4 * keys * [ROTATION, WIDTH - ROTATION][part];
            }
            animation.offsets.push(offsets);
        }
        if nodes.is_empty() {
            animation.length = 0;
            return animation;
        }
        animation.describe(nodes, builder);
        animation
    }
}

/// The layout of the animation. Offsets are relative to the end of the static data.
pub(super) struct Animation {
    channels: Channels,
    times: Vec<f32>,
    /// Offsets of the translations and of the rotations of each joint.
    offsets: Vec<[usize; 2]>,
    length: usize,
}

impl Animation {
    /// Bytes of the animation.
    pub fn length(&self) -> usize {
        self.length
    }

    /// The number of values over time, and the number of those that never change.
    pub fn counts(&self) -> (usize, usize) {
        let moves = self.channels.moves.as_flattened();
        (moves.len(), moves.iter().filter(|m| !**m).count())
    }

    /// Adds the animation to the document.
    fn describe(&self, nodes: &[AnimatedNode], builder: &mut Builder) {
        let view = builder.push(
            "bufferViews",
            json!({ "buffer": 0, "byteOffset": builder.binary_length(), "byteLength": self.length }),
        );
        let accessor = |offset: usize, count: usize, shape: &str| {
            json!({
                "bufferView": view, "byteOffset": offset, "componentType": 5126, "count": count, "type": shape
            })
        };
        let times = |count: usize, builder: &mut Builder| {
            let mut json = accessor(0, count, "SCALAR");
            json["min"] = json!([f64::from(self.times[0])]);
            json["max"] = json!([f64::from(self.times[count - 1])]);
            builder.push("accessors", json)
        };
        let frames = self.times.len();
        let moves = self.channels.moves.as_flattened();
        let all_times = moves.contains(&true).then(|| times(frames, builder));
        let first_time = moves.contains(&false).then(|| times(1, builder));
        let mut samplers = Vec::with_capacity(moves.len());
        for (offsets, moves) in self.offsets.iter().zip(&self.channels.moves) {
            for part in 0..2 {
                let count = if moves[part] { frames } else { 1 };
                let output = builder.push(
                    "accessors",
                    accessor(offsets[part], count, ["VEC3", "VEC4"][part]),
                );
                let input = if moves[part] { all_times } else { first_time };
                samplers.push(json!({ "input": input, "output": output }));
            }
        }
        let numbers: BTreeMap<u32, usize> = self.channels.joints.iter().copied().zip(0..).collect();
        let mut channels = Vec::with_capacity(2 * nodes.len());
        for AnimatedNode { node, joint } in nodes {
            for (part, path) in ["translation", "rotation"].iter().enumerate() {
                channels.push(json!({
                    "sampler": 2 * numbers[joint] + part, "target": { "node": node, "path": path }
                }));
            }
        }
        builder.push(
            "animations",
            json!({ "name": "film", "channels": channels, "samplers": samplers }),
        );
    }

    /// Writes the file: its head, the static data, and the animation. Returns its length.
    pub fn write(
        &self,
        frames: &mut Frames,
        head: &[u8],
        fixed: &[u8],
        out: &mut dyn Sink,
        context: &Context,
    ) -> Result<u64, FilmError> {
        let mut writer = Writer::new(out).map_err(|e| frames.write_error(e))?;
        let start = (head.len() + fixed.len()) as u64;
        let opening = [(0, head), (head.len() as u64, fixed)];
        for (at, bytes) in opening {
            writer.put(at, bytes).map_err(|e| frames.write_error(e))?;
        }
        if self.length == 0 {
            return Ok(start);
        }
        writer
            .put(start, &bytes_of(self.times.iter().copied()))
            .map_err(|e| frames.write_error(e))?;
        let joints = &self.channels.joints;
        let count = frames.count();
        let in_block = (BLOCK_SIZE / (4 * WIDTH * joints.len().max(1))).clamp(1, count);
        let mut before = self.channels.first.clone();
        let mut block: Vec<Components> = Vec::with_capacity(in_block * joints.len());
        for from in (0..count).step_by(in_block) {
            block.clear();
            for frame in from..count.min(from + in_block) {
                context.report(frame as f64 / count as f64)?;
                let poses = frames.poses(frame)?;
                for (k, &j) in joints.iter().enumerate() {
                    before[k] = components(&poses[j as usize], Some(&before[k]));
                    block.push(before[k]);
                }
            }
            self.put_block(&block, from, start, &mut writer)
                .map_err(|e| frames.write_error(e))?;
        }
        writer
            .finish(start + self.length as u64)
            .map_err(|e| frames.write_error(e))
    }

    /// Writes the poses of some frames, from frame `from` on.
    fn put_block(
        &self,
        block: &[Components],
        from: usize,
        start: u64,
        writer: &mut Writer,
    ) -> std::io::Result<()> {
        let joints = self.channels.joints.len();
        for (k, (offsets, moves)) in self.offsets.iter().zip(&self.channels.moves).enumerate() {
            for part in 0..2 {
                let range = [0..ROTATION, ROTATION..WIDTH][part].clone();
                let frames = block[k..].iter().step_by(joints);
                let frames = frames.take(if moves[part] { usize::MAX } else { 1 });
                if !moves[part] && from > 0 {
                    continue;
                }
                let offset = offsets[part] + 4 * from * range.len();
                let values = frames.flat_map(|n| n[range.clone()].iter().copied());
                writer.put(start + offset as u64, &bytes_of(values))?;
            }
        }
        Ok(())
    }
}

/// Little-endian bytes of numbers.
fn bytes_of(numbers: impl Iterator<Item = f32>) -> Vec<u8> {
    numbers.flat_map(f32::to_le_bytes).collect()
}

/// A file written piece by piece from the current position of its destination. It seeks only if necessary.
struct Writer<'a> {
    out: &'a mut dyn Sink,
    base: u64,
    at: u64,
}

impl<'a> Writer<'a> {
    fn new(out: &'a mut dyn Sink) -> std::io::Result<Self> {
        let base = out.stream_position()?;
        Ok(Writer { out, base, at: 0 })
    }

    /// Writes bytes at a position of the file.
    fn put(&mut self, at: u64, bytes: &[u8]) -> std::io::Result<()> {
        if at != self.at {
            self.out.seek(SeekFrom::Start(self.base + at))?;
        }
        self.out.write_all(bytes)?;
        self.at = at + bytes.len() as u64;
        Ok(())
    }

    /// Moves to the end of the file, which has the given length.
    fn finish(&mut self, length: u64) -> std::io::Result<u64> {
        self.put(length, &[])?;
        self.out.flush()?;
        Ok(length)
    }
}
