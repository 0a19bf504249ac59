//! Writing a film as one GLB: pieces with skins (§3.7.3), nodes that move (§3.11), the still rest as the still writer
//! does it. The frames are walked through twice, or three times where joints have to be merged.

mod channels;
mod merge;
mod skin;

use super::write::{Builder, write_mesh, write_nodes};
use super::{container, write_material};
use crate::assemble::Surfaces;
use crate::error::FormatError;
use crate::film::{FilmError, FilmReport, GlbOptions, Reel, Sink};
use channels::Channels;
use glam::DAffine3;
use greenstick_geometry::{Context, Extra, Film, Mesh, Pose, RigidBody, SkinnedMesh};
use serde_json::{Map, Value, json};
use skin::{Bound, Follow, Limits, Skin};
use std::collections::BTreeMap;

/// Frames by which joints are compared.
const SAMPLES: usize = 16;

/// Writes the film.
pub(crate) fn write_film(
    film: &Film,
    reel: &mut Reel,
    options: &GlbOptions,
    out: &mut dyn Sink,
    context: &Context,
) -> Result<FilmReport, FilmError> {
    let limits = limits(options, reel)?;
    let mut bound = bind(film, reel, limits)?;
    let mut channels = survey(film, reel, &mut bound, &context.part(0.0, 0.5))?;
    let still = channels.leave_out_still(&of_skins(film, &bound));
    let mut builder = Builder::default();
    let mut nodes = Nodes::write(film, &bound, &still, reel, &mut builder)?;
    builder.push("scenes", json!({ "nodes": nodes.roots }));
    write_material::write(Surfaces::of_film(film), &mut builder, None);
    let plan = channels.plan(&reel.times, &nodes.moving, &mut builder);
    let further = plan.length();
    let finished = builder.finish(None, further);
    let head = container::head(finished.json, finished.binary.len() + further, reel.file())?;
    let bytes = plan.write(reel, &head, &finished.binary, out, &context.part(0.5, 1.0))?;
    nodes.report.bytes = bytes;
    nodes.report.frames = reel.frames();
    (nodes.report.channels, nodes.report.constant) = plan.counts();
    let reductions = bound.into_iter().filter_map(|(_, b)| b.reduction);
    nodes.report.reductions = reductions.collect();
    Ok(nodes.report)
}

fn limits(options: &GlbOptions, reel: &Reel) -> Result<Limits, FormatError> {
    let joints = options.max_joints.unwrap_or(usize::MAX);
    if joints == 0 || !(1..=8).contains(&options.max_influences) {
        let found = format!(
            "{joints} joints for a skin and {} for a vertex at most",
            options.max_influences
        );
        let right = "at least one joint for a skin, and 1 to 8 for a vertex";
        return Err(reel.file().unwritable(found, right));
    }
    Ok(Limits {
        // Vertices name joints by 16 bits.
        joints: joints.min(usize::from(u16::MAX)),
        influences: options.max_influences,
    })
}

/// Binds the pieces that have triangles; gives them with their numbers.
fn bind(film: &Film, reel: &mut Reel, limits: Limits) -> Result<Vec<(usize, Bound)>, FilmError> {
    let shown = |p: &usize| !film.pieces[*p].mesh.triangles.is_empty();
    let pieces: Vec<usize> = (0..film.pieces.len()).filter(shown).collect();
    let mut samples = Vec::new();
    let many = |&p: &usize| film.pieces[p].binding.used_joints().len() > limits.joints;
    if pieces.iter().any(many) {
        let (frames, count) = (reel.frames(), reel.frames().min(SAMPLES));
        for sample in 0..count {
            // The last frame is always among them.
            let frame = (sample + 1) * frames / count - 1;
            let mut maps = Vec::new();
            film.joint_maps(reel.at(frame)?, &mut maps);
            samples.push(maps);
        }
    }
    let bind = |p| (p, skin::bind(film, p, limits, &samples));
    Ok(pieces.into_iter().map(bind).collect())
}

/// Walks through all frames: which joints move, and how far reduced pieces are from what they should be.
fn survey(
    film: &Film,
    reel: &mut Reel,
    bound: &mut [(usize, Bound)],
    context: &Context,
) -> Result<Channels, FilmError> {
    let mut used = vec![false; film.joints.len()];
    for (_, bound) in bound.iter() {
        match &bound.follow {
            Follow::One(joint) => used[*joint as usize] = true,
            Follow::Skin(skin) => skin.joints.iter().for_each(|&j| used[j as usize] = true),
        }
    }
    let bodies = film.bodies.iter();
    let shown = bodies.filter(|body| !body.node.mesh.triangles.is_empty());
    shown.for_each(|body| used[body.joint as usize] = true);
    let joints = (0..used.len() as u32).filter(|&j| used[j as usize]);
    let mut channels = Channels::new(joints.collect());
    let frames = reel.frames();
    let reduced = bound.iter().any(|(_, b)| b.reduction.is_some());
    let mut maps: Vec<DAffine3> = Vec::new();
    for frame in 0..frames {
        context.report(frame as f64 / frames as f64)?;
        let poses = reel.at(frame)?;
        channels.look(frame, poses);
        if reduced {
            film.joint_maps(poses, &mut maps);
            for (_, bound) in bound.iter_mut() {
                skin::measure(film, bound, &maps, frame);
            }
        }
    }
    Ok(channels)
}

/// Whether each joint is one of a skin.
fn of_skins(film: &Film, bound: &[(usize, Bound)]) -> Vec<bool> {
    let mut used = vec![false; film.joints.len()];
    for (_, bound) in bound {
        if let Follow::Skin(skin) = &bound.follow {
            skin.joints.iter().for_each(|&j| used[j as usize] = true);
        }
    }
    used
}

/// The nodes of the document.
struct Nodes {
    roots: Vec<usize>,
    /// Nodes that move, with the joint that they follow.
    moving: Vec<(usize, u32)>,
    report: FilmReport,
}

impl Nodes {
    fn write(
        film: &Film,
        bound: &[(usize, Bound)],
        still: &BTreeMap<u32, Pose>,
        reel: &Reel,
        builder: &mut Builder,
    ) -> Result<Self, FormatError> {
        let mut nodes = Nodes {
            roots: write_nodes(&film.fixed, &film.materials, builder, reel.file())?,
            moving: Vec::new(),
            report: FilmReport::default(),
        };
        let skins = bound.iter().filter_map(|(p, b)| match &b.follow {
            Follow::Skin(skin) => Some((&film.pieces[*p], skin)),
            Follow::One(_) => None,
        });
        let skins: Vec<(&SkinnedMesh, &Skin)> = skins.collect();
        let joint_nodes = nodes.write_joints(film, &skins, builder);
        for (piece, skin) in skins {
            let index = write_skin(film, skin, &joint_nodes, builder);
            let mesh = write_skinned(film, piece, skin, builder, reel)?;
            let mut out = named(&piece.name);
            out.insert("mesh".to_owned(), json!(mesh));
            out.insert("skin".to_owned(), json!(index));
            put_extras(&mut out, &piece.extras);
            nodes.roots.push(builder.push("nodes", Value::Object(out)));
            nodes.report.skinned += 1;
            nodes.report.joints += skin.joints.len();
        }
        let none = BTreeMap::new();
        for (p, bound) in bound {
            if let Follow::One(joint) = bound.follow {
                let piece = &film.pieces[*p];
                let body = (piece.name.as_str(), &piece.mesh, DAffine3::IDENTITY);
                nodes.write_body(film, body, (joint, still), &piece.extras, builder, reel)?;
            }
        }
        for RigidBody { node, joint } in &film.bodies {
            if !node.mesh.triangles.is_empty() {
                let body = (node.name.as_str(), &*node.mesh, node.transform);
                nodes.write_body(film, body, (*joint, still), &none, builder, reel)?;
            }
        }
        Ok(nodes)
    }

    /// Nodes of the joints that skins name, all below one that stands still (skins need a common root, §3.7.3.2).
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
            let mut out = named(&joint.name);
            put_pose(&mut out, &joint.rest);
            *node = builder.push("nodes", Value::Object(out));
            self.moving.push((*node, j));
        }
        if !joints.is_empty() {
            let children: Vec<usize> = joints.values().copied().collect();
            let root = builder.push("nodes", json!({ "name": "joints", "children": children }));
            self.roots.push(root);
        }
        joints
    }

    /// A mesh that moves as a whole: (name, mesh, its place at rest), its joint and where joints stand that never move. It is
    /// written as its joint sees it.
    fn write_body(
        &mut self,
        film: &Film,
        (name, mesh, place): (&str, &Mesh, DAffine3),
        (joint, still): (u32, &BTreeMap<u32, Pose>),
        extras: &BTreeMap<String, Extra>,
        builder: &mut Builder,
        reel: &Reel,
    ) -> Result<(), FormatError> {
        let rest = &film.joints[joint as usize].rest;
        let seen = mesh.transformed(&(rest.inverse() * place));
        let materials = &film.materials;
        let index = write_mesh(
            &seen,
            name,
            materials,
            builder,
            reel.file(),
            &mut |_, _, _| {},
        )?;
        let mut out = named(name);
        out.insert("mesh".to_owned(), json!(index));
        put_pose(&mut out, still.get(&joint).unwrap_or(rest));
        put_extras(&mut out, extras);
        let node = builder.push("nodes", Value::Object(out));
        self.roots.push(node);
        if !still.contains_key(&joint) {
            self.moving.push((node, joint));
        }
        self.report.rigid += 1;
        Ok(())
    }
}

fn named(name: &str) -> Map<String, Value> {
    let mut out = Map::new();
    if !name.is_empty() {
        out.insert("name".to_owned(), json!(name));
    }
    out
}

/// What is said besides; numbers that are not finite are no JSON and become null.
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

fn put_pose(out: &mut Map<String, Value>, pose: &Pose) {
    out.insert("translation".to_owned(), json!(pose.translation.to_array()));
    out.insert(
        "rotation".to_owned(),
        json!(pose.rotation.normalize().to_array()),
    );
}

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

fn write_skinned(
    film: &Film,
    piece: &SkinnedMesh,
    skin: &Skin,
    builder: &mut Builder,
    reel: &Reel,
) -> Result<usize, FormatError> {
    let sets = skin.influences.div_ceil(4);
    let mut decorate =
        |builder: &mut Builder, used: &[u32], attributes: &mut Map<String, Value>| {
            for set in 0..sets {
                let mut slots = vec![[0_u16; 4]; used.len()];
                let mut weights = vec![[0.0_f32; 4]; used.len()];
                for (new, &old) in used.iter().enumerate() {
                    let own = skin.of(old as usize).skip(4 * set).take(4);
                    for (k, (slot, weight)) in own.enumerate() {
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
    write_mesh(
        &piece.mesh,
        name,
        materials,
        builder,
        reel.file(),
        &mut decorate,
    )
}
