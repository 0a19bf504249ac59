//! Writing a film as one GLB: pieces with skins (§3.7.3), animated nodes (§3.11), and static nodes. The frames are
//! requested twice, or three times where joints have to be merged.

mod channels;
mod merge;
mod skin;

use super::builder::Builder;
use super::write_mesh::{write_decorated_mesh, write_mesh};
use super::write_node::write_nodes;
use super::{container, write_material};
use crate::check::Surfaces;
use crate::error::FormatError;
use crate::film::{FilmError, FilmReport, Frames, GlbOptions};
use crate::sink::Sink;
use channels::{AnimatedNode, Channels};
use glam::DAffine3;
use greenstick_geometry::{Context, Extra, Film, Mesh, Pose, RigidBody, SkinnedMesh};
use serde_json::{Map, Value, json};
use skin::{BoundPiece, Limits, Skin, Target};
use std::collections::BTreeMap;

/// Frames in which the motion of joints is compared.
const SAMPLE_FRAMES: usize = 16;

/// Writes the film.
pub(crate) fn write_film(
    film: &Film,
    frames: &mut Frames,
    options: &GlbOptions,
    out: &mut dyn Sink,
    context: &Context,
) -> Result<FilmReport, FilmError> {
    let limits = limits(options, frames)?;
    let mut bound = bind(film, frames, limits)?;
    let mut channels = find_motion(film, frames, &mut bound, &context.part(0.0, 0.5))?;
    let constant = channels.remove_constant(&joints_of_skins(film, &bound));
    let mut builder = Builder::with_metadata(film.metadata.clone());
    let mut nodes = Nodes::write(film, &bound, &constant, frames, &mut builder)?;
    builder.push("scenes", json!({ "nodes": nodes.roots }));
    write_material::write(Surfaces::from_film(film), &mut builder, None);
    let animation = channels.lay_out(&frames.times, &nodes.animated, &mut builder);
    let further = animation.length();
    let finished = builder.finish(None, further);
    let head = container::head(
        finished.json,
        finished.binary.len() + further,
        frames.file(),
    )?;
    let bytes = animation.write(
        frames,
        &head,
        &finished.binary,
        out,
        &context.part(0.5, 1.0),
    )?;
    nodes.report.bytes = bytes;
    nodes.report.frames = frames.count();
    (nodes.report.channels, nodes.report.constant) = animation.counts();
    let reductions = bound.into_iter().filter_map(|b| b.reduction);
    nodes.report.reductions = reductions.collect();
    Ok(nodes.report)
}

/// The limits of skins, if the options are valid.
fn limits(options: &GlbOptions, frames: &Frames) -> Result<Limits, FormatError> {
    let joints = options.max_joints.unwrap_or(usize::MAX);
    if joints == 0 || !(1..=8).contains(&options.max_influences) {
        let found = format!(
            "at most {joints} joints for a skin and {} for a vertex",
            options.max_influences
        );
        let right = "at least one joint for a skin, and 1 to 8 for a vertex";
        return Err(frames.file().unwritable(found, right));
    }
    Ok(Limits {
        // Vertices refer to joints by 16 bits.
        joints: joints.min(usize::from(u16::MAX)),
        influences: options.max_influences,
    })
}

/// Binds the pieces that have triangles.
fn bind(film: &Film, frames: &mut Frames, limits: Limits) -> Result<Vec<BoundPiece>, FilmError> {
    let is_visible = |p: &usize| !film.pieces[*p].mesh.triangles.is_empty();
    let pieces: Vec<usize> = (0..film.pieces.len()).filter(is_visible).collect();
    let mut samples = Vec::new();
    let exceeds = |&p: &usize| film.pieces[p].binding.used_joints().len() > limits.joints;
    if pieces.iter().any(exceeds) {
        let count = frames.count().min(SAMPLE_FRAMES);
        for sample in 0..count {
            // The last frame is always among them.
            let frame = (sample + 1) * frames.count() / count - 1;
            let mut maps = Vec::new();
            film.joint_maps(frames.poses(frame)?, &mut maps);
            samples.push(maps);
        }
    }
    let bind = |p| skin::bind(film, p, limits, &samples);
    Ok(pieces.into_iter().map(bind).collect())
}

/// Finds the joints that move in any frame, and measures the errors of pieces that were reduced.
fn find_motion(
    film: &Film,
    frames: &mut Frames,
    bound: &mut [BoundPiece],
    context: &Context,
) -> Result<Channels, FilmError> {
    let mut used = vec![false; film.joints.len()];
    for piece in bound.iter() {
        match &piece.target {
            Target::Joint(joint) => used[*joint as usize] = true,
            Target::Skin(skin) => skin.joints.iter().for_each(|&j| used[j as usize] = true),
        }
    }
    let bodies = film.bodies.iter();
    let visible = bodies.filter(|body| !body.node.mesh.triangles.is_empty());
    visible.for_each(|body| used[body.joint as usize] = true);
    let joints = (0..used.len() as u32).filter(|&j| used[j as usize]);
    let mut channels = Channels::new(joints.collect());
    let count = frames.count();
    let is_reduced = bound.iter().any(|b| b.reduction.is_some());
    let mut maps: Vec<DAffine3> = Vec::new();
    for frame in 0..count {
        context.report(frame as f64 / count as f64)?;
        let poses = frames.poses(frame)?;
        channels.observe(frame, poses);
        if is_reduced {
            film.joint_maps(poses, &mut maps);
            for piece in bound.iter_mut() {
                skin::measure(film, piece, &maps, frame);
            }
        }
    }
    Ok(channels)
}

/// For each joint, whether a skin refers to it.
fn joints_of_skins(film: &Film, bound: &[BoundPiece]) -> Vec<bool> {
    let mut used = vec![false; film.joints.len()];
    for piece in bound {
        if let Target::Skin(skin) = &piece.target {
            skin.joints.iter().for_each(|&j| used[j as usize] = true);
        }
    }
    used
}

/// A mesh that moves rigidly.
struct RigidMesh<'a> {
    name: &'a str,
    mesh: &'a Mesh,
    /// Its transform to the world when its joint is at rest.
    at_rest: DAffine3,
    joint: u32,
    extras: &'a BTreeMap<String, Extra>,
}

/// The nodes of the document.
struct Nodes {
    roots: Vec<usize>,
    animated: Vec<AnimatedNode>,
    report: FilmReport,
}

impl Nodes {
    /// Writes all nodes; `constant` are the poses of joints that never move.
    fn write(
        film: &Film,
        bound: &[BoundPiece],
        constant: &BTreeMap<u32, Pose>,
        frames: &Frames,
        builder: &mut Builder,
    ) -> Result<Self, FormatError> {
        let mut nodes = Nodes {
            roots: write_nodes(&film.fixed, &film.materials, builder, frames.file())?,
            animated: Vec::new(),
            report: FilmReport::default(),
        };
        let skins = bound.iter().filter_map(|b| match &b.target {
            Target::Skin(skin) => Some((&film.pieces[b.piece], skin)),
            Target::Joint(_) => None,
        });
        let skins: Vec<(&SkinnedMesh, &Skin)> = skins.collect();
        let joint_nodes = nodes.write_joints(film, &skins, builder);
        for (piece, skin) in skins {
            let index = write_skin(film, skin, &joint_nodes, builder);
            let mesh = write_skinned_mesh(film, piece, skin, builder, frames)?;
            let mut out = named_node(&piece.name);
            out.insert("mesh".to_owned(), json!(mesh));
            out.insert("skin".to_owned(), json!(index));
            put_extras(&mut out, &piece.extras);
            nodes.roots.push(builder.push("nodes", Value::Object(out)));
            nodes.report.skinned += 1;
            nodes.report.joints += skin.joints.len();
        }
        let no_extras = BTreeMap::new();
        let rigid_pieces = bound.iter().filter_map(|b| match b.target {
            Target::Joint(joint) => {
                let piece = &film.pieces[b.piece];
                Some(RigidMesh {
                    name: &piece.name,
                    mesh: &piece.mesh,
                    at_rest: DAffine3::IDENTITY,
                    joint,
                    extras: &piece.extras,
                })
            }
            Target::Skin(_) => None,
        });
        let bodies = film
            .bodies
            .iter()
            .map(|RigidBody { node, joint }| RigidMesh {
                name: &node.name,
                mesh: &node.mesh,
                at_rest: node.transform,
                joint: *joint,
                extras: &no_extras,
            });
        let visible = bodies.filter(|body| !body.mesh.triangles.is_empty());
        for mesh in rigid_pieces.chain(visible) {
            nodes.write_rigid(film, &mesh, constant, builder, frames)?;
        }
        Ok(nodes)
    }

    /// Writes the nodes of the joints that skins refer to. All have one parent, because skins need a common root (§3.7.3.2).
    fn write_joints(
        &mut self,
        film: &Film,
        skins: &[(&SkinnedMesh, &Skin)],
        builder: &mut Builder,
    ) -> BTreeMap<u32, usize> {
        let mut joints: BTreeMap<u32, usize> = BTreeMap::new();
        for (_, skin) in skins {
            joints.extend(skin.joints.iter().map(|&j| (j, 0)));
        }
        for (&j, node) in &mut joints {
            let joint = &film.joints[j as usize];
            let mut out = named_node(&joint.name);
            put_pose(&mut out, &joint.rest);
            *node = builder.push("nodes", Value::Object(out));
            self.animated.push(AnimatedNode {
                node: *node,
                joint: j,
            });
        }
        if !joints.is_empty() {
            let children: Vec<usize> = joints.values().copied().collect();
            let root = builder.push("nodes", json!({ "name": "joints", "children": children }));
            self.roots.push(root);
        }
        joints
    }

    /// Writes a mesh that moves rigidly, in the coordinates of its joint; `constant` are the poses of joints that never
    /// move.
    fn write_rigid(
        &mut self,
        film: &Film,
        rigid: &RigidMesh,
        constant: &BTreeMap<u32, Pose>,
        builder: &mut Builder,
        frames: &Frames,
    ) -> Result<(), FormatError> {
        let joint = rigid.joint;
        let rest = &film.joints[joint as usize].rest;
        let local = rigid.mesh.transformed(&(rest.inverse() * rigid.at_rest));
        let mesh = write_mesh(&local, rigid.name, &film.materials, builder, frames.file())?;
        let mut out = named_node(rigid.name);
        out.insert("mesh".to_owned(), json!(mesh));
        put_pose(&mut out, constant.get(&joint).unwrap_or(rest));
        put_extras(&mut out, rigid.extras);
        let node = builder.push("nodes", Value::Object(out));
        self.roots.push(node);
        if !constant.contains_key(&joint) {
            self.animated.push(AnimatedNode { node, joint });
        }
        self.report.rigid += 1;
        Ok(())
    }
}

/// Starts the description of a node.
fn named_node(name: &str) -> Map<String, Value> {
    let mut out = Map::new();
    if !name.is_empty() {
        out.insert("name".to_owned(), json!(name));
    }
    out
}

/// Adds further properties. Numbers that are not finite become null, because JSON has none.
fn put_extras(out: &mut Map<String, Value>, extras: &BTreeMap<String, Extra>) {
    if extras.is_empty() {
        return;
    }
    let value = |extra: &Extra| match extra {
        Extra::Flag(v) => json!(v),
        Extra::Integer(v) => json!(v),
        Extra::Number(v) => json!(v),
        Extra::Numbers(v) => json!(v),
        Extra::Text(v) => json!(v),
    };
    let all: Map<String, Value> = extras.iter().map(|(k, v)| (k.clone(), value(v))).collect();
    out.insert("extras".to_owned(), Value::Object(all));
}

/// Adds the transform of a pose.
fn put_pose(out: &mut Map<String, Value>, pose: &Pose) {
    out.insert("translation".to_owned(), json!(pose.translation.to_array()));
    out.insert(
        "rotation".to_owned(),
        json!(pose.rotation.normalize().to_array()),
    );
}

/// Writes a skin. Returns its index.
fn write_skin(
    film: &Film,
    skin: &Skin,
    joint_nodes: &BTreeMap<u32, usize>,
    builder: &mut Builder,
) -> usize {
    let inverse = |&j: &u32| {
        let map = film.joints[j as usize].rest.inverse();
        glam::DMat4::from(map).as_mat4().to_cols_array()
    };
    let matrices: Vec<[f32; 16]> = skin.joints.iter().map(inverse).collect();
    let matrices = builder.matrices(&matrices);
    let joints: Vec<usize> = skin.joints.iter().map(|j| joint_nodes[j]).collect();
    builder.push(
        "skins",
        json!({ "inverseBindMatrices": matrices, "joints": joints }),
    )
}

/// Writes a mesh with the joints and weights of its skin. Returns its index.
fn write_skinned_mesh(
    film: &Film,
    piece: &SkinnedMesh,
    skin: &Skin,
    builder: &mut Builder,
    frames: &Frames,
) -> Result<usize, FormatError> {
    let sets = skin.max_influences.div_ceil(4);
    let mut decorate =
        |builder: &mut Builder, used: &[u32], attributes: &mut Map<String, Value>| {
            for set in 0..sets {
                let mut slots = vec![[0_u16; 4]; used.len()];
                let mut weights = vec![[0.0_f32; 4]; used.len()];
                for (new, &old) in used.iter().enumerate() {
                    let influences = skin.influences(old as usize).skip(4 * set).take(4);
                    for (k, (slot, weight)) in influences.enumerate() {
                        (slots[new][k], weights[new][k]) = (slot, weight);
                    }
                }
                let slots = builder.joints(&slots);
                attributes.insert(format!("JOINTS_{set}"), json!(slots));
                let weights = builder.floats(weights.as_flattened(), 4);
                attributes.insert(format!("WEIGHTS_{set}"), json!(weights));
            }
        };
    let (name, materials) = (&piece.name, &film.materials);
    write_decorated_mesh(
        &piece.mesh,
        name,
        materials,
        builder,
        frames.file(),
        &mut decorate,
    )
}
