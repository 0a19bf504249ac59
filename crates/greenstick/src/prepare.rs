//! From a scene and a place to a stem that is ready to be broken, again and again, with changing parameters.

use crate::Error;
use crate::kept::Kept;
use crate::outwards::{turn_outwards, unmirror};
use crate::refine::Refined;
use glam::{DAffine3, DVec2, DVec3};
use greenstick_fracture::cut::Solid;
use greenstick_fracture::parameters::{BreakParameters, Surface};
use greenstick_geometry::{Context, Mesh, Node, Scene};
use greenstick_wood::stem::{
    FoundStem, LayeredGrain, StemKind, StemLocation, StemOptions, find_stem,
};
use std::sync::Arc;

/// A scene with the stem found in it.
#[derive(Debug, Clone)]
pub struct Prepared {
    /// The scene as it was read, but for the node that is cut, whose long edges may be halved near the break.
    pub scene: Scene,
    /// The stem, and which triangles of which node it is made of.
    pub found: FoundStem,
    /// The map between the world and grain space that the stem is cut in.
    pub layers: LayeredGrain,
    /// Point of every vertex of the cut node's mesh.
    pub points: Vec<u32>,
    /// Grain coordinates of every point of that mesh; NaN off the limb.
    pub grain: Vec<DVec3>,
    /// Point numbers of the corners of its triangles.
    pub corners: Vec<[u32; 3]>,
    /// What the limb's skin spans about the pith.
    pub extent: Extent,
    /// Triangles of the skin that were parted because the stem is bent there.
    pub parted: usize,
    /// What breaks share.
    pub(crate) kept: Arc<Kept>,
}

/// Finds the stem at `place` and takes it to grain space.
///
/// # Errors
/// [`Error::Stem`] where there is no stem that can be broken.
pub fn prepare(
    mut scene: Scene,
    place: &StemLocation,
    options: &StemOptions,
    context: &Context,
) -> Result<Prepared, Error> {
    scene.nodes.iter_mut().for_each(unmirror);
    let mut found = find_stem(&in_world(&scene), place, options, context)?;
    let (layers, free) = LayeredGrain::from_stem(&found.stem);
    found.stem.usable = free;
    Ok(laid(scene, found, layers))
}

/// The meshes of a scene in world metres, one per node, without attributes.
pub(crate) fn in_world(scene: &Scene) -> Vec<Mesh> {
    let world = |n: &Node| Mesh {
        positions: (n.mesh.positions.iter())
            .map(|&p| n.transform.transform_point3(p))
            .collect(),
        triangles: n.mesh.triangles.clone(),
        ..Mesh::default()
    };
    scene.nodes.iter().map(world).collect()
}

/// Takes a found stem to grain space.
pub(crate) fn laid(mut scene: Scene, mut found: FoundStem, layers: LayeredGrain) -> Prepared {
    let transform = scene.nodes[found.node].transform;
    let mut mesh = Arc::unwrap_or_clone(std::mem::take(&mut scene.nodes[found.node].mesh));
    let (points, count) = mesh.points();
    let mut grain = vec![DVec3::NAN; count];
    for &t in &found.limb {
        for v in mesh.triangles[t as usize] {
            let p = points[v as usize] as usize;
            if grain[p].is_nan() {
                grain[p] = layers.to_grain(transform.transform_point3(mesh.positions[v as usize]));
            }
        }
    }
    turn_outwards(&mut mesh, &points, &grain, &mut found);
    let mut refined = Refined {
        mesh,
        points,
        grain,
        limb: std::mem::take(&mut found.limb),
        parted: 0,
    };
    let made = refined.part(&layers, &transform, (&found.shell, found.stem.radius));
    found.limb = std::mem::take(&mut refined.limb);
    found.shell.extend(made);
    let corners: Vec<[u32; 3]> = refined
        .mesh
        .triangles
        .iter()
        .map(|t| t.map(|v| refined.points[v as usize]))
        .collect();
    let extent = extent(&found, &corners, &refined.grain);
    let kept = {
        let solid = Solid {
            triangles: &corners,
            points: &refined.grain,
            shell: &found.shell,
            limb: &found.limb,
        };
        Kept::new(
            &found,
            &layers,
            &solid,
            &refined.mesh.triangles,
            &refined.points,
            &transform,
        )
    };
    scene.nodes[found.node].mesh = refined.mesh.into();
    Prepared {
        scene,
        found,
        layers,
        points: refined.points,
        grain: refined.grain,
        corners,
        extent,
        parted: refined.parted,
        kept: Arc::new(kept),
    }
}

/// What the limb's skin spans about the pith.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Extent {
    /// Ring coordinates between which all of it lies.
    pub reach: (f64, f64),
    /// Greatest distance from the pith, m.
    pub radius: f64,
    /// Ring coordinate at which the bark begins.
    pub bark: f64,
    /// Angles (rad) between which it lies, where the pith is outside of the section.
    pub arc: Option<(f64, f64)>,
}

/// Ring coordinates between which bark may begin: relief deeper than that cuts into the wood.
const BARK: (f64, f64) = (0.88, 0.96);
/// How far along the stem, in radii, the skin tells how deep the bark's furrows are.
const NEAR: f64 = 1.5;

fn extent(found: &FoundStem, corners: &[[u32; 3]], grain: &[DVec3]) -> Extent {
    let (rings, stem) = (&found.stem.rings, &found.stem);
    let pith = rings.pith();
    let board = stem.kind == StemKind::Board;
    let mut used = vec![false; grain.len()];
    let (mut least, mut most, mut radius) = (f64::INFINITY, 0.0f64, 0.0f64);
    let mut near = Vec::new();
    let forward = stem
        .sections
        .iter()
        .fold(DVec2::ZERO, |sum, s| sum + s.centroid)
        - pith;
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for &t in &found.limb {
        let c = corners[t as usize].map(|p| grain[p as usize]);
        for k in 0..3 {
            let point = c[k].truncate();
            if board {
                // The nearest wood may lie in the middle of an edge.
                let (a, b) = (point, c[(k + 1) % 3].truncate());
                let along =
                    ((pith - a).dot(b - a) / (b - a).length_squared().max(1e-300)).clamp(0.0, 1.0);
                least = least.min(rings.address(a.lerp(b, along)).0);
            }
            let number = corners[t as usize][k] as usize;
            if std::mem::replace(&mut used[number], true) {
                continue;
            }
            let (rho, _) = rings.address(point);
            most = most.max(rho);
            radius = radius.max(point.distance(pith));
            if (c[k].z - stem.location).abs() < NEAR * stem.radius {
                near.push(rho);
            }
            let angle = libm::atan2(forward.perp_dot(point - pith), forward.dot(point - pith));
            (low, high) = (low.min(angle), high.max(angle));
        }
    }
    if board && high - low < 3.0 {
        let (base, margin) = (libm::atan2(forward.y, forward.x), 0.03 * (high - low));
        let arc = Some((base + low - margin, base + high + margin));
        return Extent {
            reach: (0.98 * least, 1.02 * most),
            radius,
            bark: 1.0,
            arc,
        };
    }
    near.sort_by(f64::total_cmp);
    let furrows = near.get(near.len() / 10).copied().unwrap_or(BARK.1) - 0.02;
    Extent {
        reach: (0.0, most.max(1.0)),
        radius,
        bark: furrows.clamp(BARK.0, BARK.1),
        arc: None,
    }
}

/// How far beyond the break grain winds, radii.
const BEYOND: f64 = 0.5;

impl Prepared {
    /// The same stem with the winding grain that the parameters ask for, about their break and no farther: a fibrous
    /// face of a round stem has it. `relief` as for [`Prepared::model`].
    pub fn wound(&self, p: &BreakParameters, relief: f64) -> Prepared {
        let stem = &self.found.stem;
        let fibrous = p.surface == Surface::Fibrous;
        if p.spiral_angle == 0.0 || !fibrous || stem.kind == StemKind::Board {
            return self.clone();
        }
        let (_, heights) = self.heights(p, relief);
        let margin = BEYOND * stem.radius;
        let (low, high) = heights.range;
        let winds = (
            (stem.location + low - margin).max(stem.usable.0),
            (stem.location + high + margin).min(stem.usable.1),
        );
        let turn = p.spiral_angle.to_radians() / stem.radius;
        let layers = self.layers.clone().with_spiral(turn, winds);
        laid(self.scene.clone(), self.found.clone(), layers)
    }

    /// The transform of the node that is cut.
    pub fn transform(&self) -> &DAffine3 {
        &self.scene.nodes[self.found.node].transform
    }
}
