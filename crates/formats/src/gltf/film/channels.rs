//! The animation (§3.11): for each joint its translations and rotations over all frames, each in one run of the file. The
//! frames come one by one, so that blocks of them are put where they belong.

use crate::film::{FilmError, Reel, Sink};
use crate::gltf::write::Builder;
use glam::{Quat, Vec3};
use greenstick_geometry::{Context, Pose};
use serde_json::json;
use std::collections::BTreeMap;
use std::io::SeekFrom;

/// Bytes of poses that are held at a time.
const BLOCK: usize = 8 << 20;

/// Numbers of a pose, and where its rotation begins.
const WIDTH: usize = 7;
const TURN: usize = 3;

type Numbers = [f32; WIDTH];

/// Which joints move.
pub struct Channels {
    /// Joints of the film, ascending.
    joints: Vec<u32>,
    /// Their poses in the first frame.
    first: Vec<Numbers>,
    moves: Vec<[bool; 2]>,
}

/// A pose in 32 bits, with that one of the two signs of its rotation that is nearer to `before`.
fn narrow(pose: &Pose, before: Option<&Numbers>) -> Numbers {
    let p = pose.translation.as_vec3();
    let mut q = pose.rotation.normalize().as_quat();
    if before.is_some_and(|b| q.dot(Quat::from_slice(&b[TURN..])) < 0.0) {
        q = -q;
    }
    [p.x, p.y, p.z, q.x, q.y, q.z, q.w]
}

impl Channels {
    pub fn new(joints: Vec<u32>) -> Self {
        Channels {
            first: vec![[0.0; WIDTH]; joints.len()],
            moves: vec![[false; 2]; joints.len()],
            joints,
        }
    }

    /// Takes a frame into account; the first one has to come first.
    pub fn look(&mut self, frame: usize, poses: &[Pose]) {
        for (k, &j) in self.joints.iter().enumerate() {
            let pose = &poses[j as usize];
            if frame == 0 {
                self.first[k] = narrow(pose, None);
                continue;
            }
            let first = &self.first[k];
            let now = narrow(pose, Some(first));
            self.moves[k][0] |= now[..TURN] != first[..TURN];
            self.moves[k][1] |= now[TURN..] != first[TURN..];
        }
    }

    /// Leaves out the joints that never move, but for those of skins; gives where they stand.
    pub fn leave_out_still(&mut self, of_skins: &[bool]) -> BTreeMap<u32, Pose> {
        let still: Vec<bool> = (self.joints.iter().zip(&self.moves))
            .map(|(&joint, moves)| *moves == [false; 2] && !of_skins[joint as usize])
            .collect();
        let pose = |n: &Numbers| Pose {
            translation: Vec3::from_slice(n).as_dvec3(),
            rotation: Quat::from_slice(&n[TURN..]).as_dquat().normalize(),
        };
        let all = self.joints.iter().zip(&self.first).zip(&still);
        let out = all.filter(|(_, s)| **s).map(|((&j, n), _)| (j, pose(n)));
        let out = out.collect();
        let mut keep = still.iter().map(|s| !s).cycle();
        self.joints.retain(|_| keep.next().unwrap_or(true));
        self.first.retain(|_| keep.next().unwrap_or(true));
        self.moves.retain(|_| keep.next().unwrap_or(true));
        out
    }

    /// Describes the animation of `nodes` (each with the joint it follows), whose data come after what the builder holds.
    pub fn plan(self, times: &[f64], nodes: &[(usize, u32)], builder: &mut Builder) -> Plan {
        let frames = times.len();
        let mut plan = Plan {
            runs: Vec::with_capacity(self.joints.len()),
            channels: self,
            times: times.iter().map(|&t| t as f32).collect(),
            length: 4 * frames,
        };
        for moves in &plan.channels.moves {
            let mut run = [0; 2];
            for part in 0..2 {
                let keys = if moves[part] { frames } else { 1 };
                run[part] = plan.length;
                plan.length += 4 * keys * [TURN, WIDTH - TURN][part];
            }
            plan.runs.push(run);
        }
        if nodes.is_empty() {
            plan.length = 0;
            return plan;
        }
        plan.describe(nodes, builder);
        plan
    }
}

/// Where the animation's numbers lie, from the end of the still data.
pub struct Plan {
    channels: Channels,
    times: Vec<f32>,
    /// For each joint where its translations and its rotations begin.
    runs: Vec<[usize; 2]>,
    length: usize,
}

impl Plan {
    /// Bytes of the animation.
    pub fn length(&self) -> usize {
        self.length
    }

    /// How many values over time there are, and how many of them never change.
    pub fn counts(&self) -> (usize, usize) {
        let moves = self.channels.moves.as_flattened();
        (moves.len(), moves.iter().filter(|m| !**m).count())
    }

    fn describe(&self, nodes: &[(usize, u32)], builder: &mut Builder) {
        let view = builder.push(
            "bufferViews",
            json!({ "buffer": 0, "byteOffset": builder.length(), "byteLength": self.length }),
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
        let long = moves.contains(&true).then(|| times(frames, builder));
        let short = moves.contains(&false).then(|| times(1, builder));
        let mut samplers = Vec::with_capacity(moves.len());
        for (runs, moves) in self.runs.iter().zip(&self.channels.moves) {
            for part in 0..2 {
                let count = if moves[part] { frames } else { 1 };
                let output = builder.push(
                    "accessors",
                    accessor(runs[part], count, ["VEC3", "VEC4"][part]),
                );
                let input = if moves[part] { long } else { short };
                samplers.push(json!({ "input": input, "output": output }));
            }
        }
        let place: BTreeMap<u32, usize> = self.channels.joints.iter().copied().zip(0..).collect();
        let mut channels = Vec::with_capacity(2 * nodes.len());
        for (node, joint) in nodes {
            for (part, path) in ["translation", "rotation"].iter().enumerate() {
                channels.push(json!({
                    "sampler": 2 * place[joint] + part, "target": { "node": node, "path": path }
                }));
            }
        }
        builder.push(
            "animations",
            json!({ "name": "film", "channels": channels, "samplers": samplers }),
        );
    }

    /// Writes the whole file: its head, the still data, the animation. Gives its length.
    pub fn write(
        &self,
        reel: &mut Reel,
        head: &[u8],
        still: &[u8],
        out: &mut dyn Sink,
        context: &Context,
    ) -> Result<u64, FilmError> {
        let mut place = Place::of(out).map_err(|e| reel.failed(e))?;
        let start = (head.len() + still.len()) as u64;
        let opening = [(0, head), (head.len() as u64, still)];
        for (at, bytes) in opening {
            place.put(at, bytes).map_err(|e| reel.failed(e))?;
        }
        if self.length == 0 {
            return Ok(start);
        }
        place
            .put(start, &bytes_of(self.times.iter().copied()))
            .map_err(|e| reel.failed(e))?;
        let joints = &self.channels.joints;
        let frames = reel.frames();
        let in_block = (BLOCK / (4 * WIDTH * joints.len().max(1))).clamp(1, frames);
        let mut before = self.channels.first.clone();
        let mut block: Vec<Numbers> = Vec::with_capacity(in_block * joints.len());
        for from in (0..frames).step_by(in_block) {
            block.clear();
            for frame in from..frames.min(from + in_block) {
                context.report(frame as f64 / frames as f64)?;
                let poses = reel.at(frame)?;
                for (k, &j) in joints.iter().enumerate() {
                    before[k] = narrow(&poses[j as usize], Some(&before[k]));
                    block.push(before[k]);
                }
            }
            self.put_block(&block, from, start, &mut place)
                .map_err(|e| reel.failed(e))?;
        }
        place
            .end(start + self.length as u64)
            .map_err(|e| reel.failed(e))
    }

    fn put_block(
        &self,
        block: &[Numbers],
        from: usize,
        start: u64,
        place: &mut Place,
    ) -> std::io::Result<()> {
        let joints = self.channels.joints.len();
        for (k, (runs, moves)) in self.runs.iter().zip(&self.channels.moves).enumerate() {
            for part in 0..2 {
                let numbers = [0..TURN, TURN..WIDTH][part].clone();
                let frames = block[k..].iter().step_by(joints);
                let frames = frames.take(if moves[part] { usize::MAX } else { 1 });
                if !moves[part] && from > 0 {
                    continue;
                }
                let offset = runs[part] + 4 * from * numbers.len();
                let run = frames.flat_map(|n| n[numbers.clone()].iter().copied());
                place.put(start + offset as u64, &bytes_of(run))?;
            }
        }
        Ok(())
    }
}

fn bytes_of(numbers: impl Iterator<Item = f32>) -> Vec<u8> {
    numbers.flat_map(f32::to_le_bytes).collect()
}

/// A file that is written in pieces, from where it stood; seeks only where it has to.
struct Place<'a> {
    out: &'a mut dyn Sink,
    base: u64,
    at: u64,
}

impl<'a> Place<'a> {
    fn of(out: &'a mut dyn Sink) -> std::io::Result<Self> {
        let base = out.stream_position()?;
        Ok(Place { out, base, at: 0 })
    }

    fn put(&mut self, at: u64, bytes: &[u8]) -> std::io::Result<()> {
        if at != self.at {
            self.out.seek(SeekFrom::Start(self.base + at))?;
        }
        self.out.write_all(bytes)?;
        self.at = at + bytes.len() as u64;
        Ok(())
    }

    /// Stands at the end of the file of this length.
    fn end(&mut self, length: u64) -> std::io::Result<u64> {
        self.put(length, &[])?;
        self.out.flush()?;
        Ok(length)
    }
}
