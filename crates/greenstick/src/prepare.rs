//! From a scene and a place to a stem that is ready to be broken, again and again, with changing parameters.

use crate::Error;
use crate::kept::Kept;
use crate::refine::Refined;
use glam::{DAffine3, DVec2, DVec3};
use greenstick_fracture::cut::Solid;
use greenstick_geometry::{Context, Mesh, Scene};
use greenstick_wood::stem::{Found, Place, StemKind, StemOptions, find};
use std::sync::Arc;

/// A scene with the stem found in it.
#[derive(Debug, Clone)]
pub struct Prepared {
    /// The scene as it was read, but for the node that is cut, whose long edges may be halved near the break.
    pub scene: Scene,
    /// The stem, and which triangles of which node it is made of.
    pub found: Found,
    /// Point of every vertex of the cut node's mesh.
    pub points: Vec<u32>,
    /// Grain coordinates of every point of that mesh; NaN off the limb.
    pub grain: Vec<DVec3>,
    /// Point numbers of the corners of its triangles.
    pub corners: Vec<[u32; 3]>,
    /// Ring coordinates between which all of the limb's skin lies.
    pub reach: (f64, f64),
    /// Least ring coordinate of the limb's skin.
    pub bark: f64,
    /// Angles (rad) about the pith between which the skin lies, where the pith is outside of it.
    pub arc: Option<(f64, f64)>,
    /// Triangles of the skin that were parted because the stem is bent there.
    pub parted: usize,
    /// What breaks share.
    pub(crate) kept: Arc<Kept>,
}

/// Part of the radius by which the skin may lie off its place in grain space.
const TOLERANCE: f64 = 2e-3;

/// Part of the radius within which two points have about the same length along the axis.
const NEARBY: f64 = 0.1;

/// Finds the stem at `place` and takes it to grain space. `turns` twists the grain by so many rad per m.
///
/// # Errors
/// [`Error::Stem`] where there is no stem that can be broken.
pub fn prepare(
    mut scene: Scene,
    place: &Place,
    options: &StemOptions,
    spiral: f64,
    context: &Context,
) -> Result<Prepared, Error> {
    let world: Vec<Mesh> = scene
        .nodes
        .iter()
        .map(|n| Mesh {
            positions: n
                .mesh
                .positions
                .iter()
                .map(|&p| n.transform.transform_point3(p))
                .collect(),
            triangles: n.mesh.triangles.clone(),
            ..Mesh::default()
        })
        .collect();
    let mut found = find(&world, place, options, context)?;
    if spiral != 0.0 {
        let turn = spiral / found.stem.radius;
        found.stem.grain = found.stem.grain.clone().with_spiral(turn, found.stem.place);
    }
    let node = found.node;
    let mesh = std::mem::take(&mut scene.nodes[node].mesh);
    let (points, count) = mesh.points();
    let mut grain = vec![DVec3::NAN; count];
    for &t in &found.limb {
        let corners = mesh.triangles[t as usize];
        for v in corners {
            let p = points[v as usize] as usize;
            if !grain[p].is_nan() {
                continue;
            }
            let at = world[node].positions[v as usize];
            // A corner close by that is known already spares the search along the axis.
            let near = corners.iter().find(|&&n| {
                !grain[points[n as usize] as usize].is_nan()
                    && world[node].positions[n as usize].distance(at) < NEARBY * found.stem.radius
            });
            grain[p] = match near {
                Some(&n) => {
                    let guess = grain[points[n as usize] as usize].z;
                    found.stem.grain.to_grain_near(at, guess)
                }
                None => found.stem.grain.to_grain(at),
            };
        }
    }
    drop(world);
    let transform = scene.nodes[node].transform;
    let first_new = mesh.triangles.len() as u32;
    let mut refined = Refined {
        mesh,
        points,
        grain,
        limb: std::mem::take(&mut found.limb),
        parted: 0,
        short: 0.0,
    };
    let space = found.stem.grain.clone();
    let radius = found.stem.radius;
    refined.refine(TOLERANCE * radius, radius, &|_, p, s| {
        space.to_grain_near(transform.transform_point3(p), s)
    });
    found.limb = refined.limb;
    found
        .shell
        .extend(first_new..refined.mesh.triangles.len() as u32);
    let corners: Vec<[u32; 3]> = refined
        .mesh
        .triangles
        .iter()
        .map(|t| t.map(|v| refined.points[v as usize]))
        .collect();
    let (reach, bark, arc) = extent(&found, &corners, &refined.grain);
    let kept = {
        let solid = Solid {
            triangles: &corners,
            points: &refined.grain,
            shell: &found.shell,
            limb: &found.limb,
        };
        let mesh = &refined.mesh;
        Kept::new(&found, &solid, &mesh.triangles, &refined.points, &transform)
    };
    scene.nodes[node].mesh = refined.mesh;
    Ok(Prepared {
        scene,
        found,
        points: refined.points,
        grain: refined.grain,
        corners,
        reach,
        bark,
        arc,
        parted: refined.parted,
        kept: Arc::new(kept),
    })
}

/// Ring coordinates and angles that the limb's skin spans.
fn extent(
    found: &Found,
    corners: &[[u32; 3]],
    grain: &[DVec3],
) -> ((f64, f64), f64, Option<(f64, f64)>) {
    let rings = &found.stem.rings;
    let pith = rings.pith();
    let (mut least, mut most) = (f64::INFINITY, 0.0f64);
    let mut angles = Vec::new();
    let mean: DVec2 = {
        let points = found
            .limb
            .iter()
            .flat_map(|&t| corners[t as usize])
            .map(|p| grain[p as usize].truncate());
        let (sum, n) = points.fold((DVec2::ZERO, 0.0), |(s, n), p| (s + p, n + 1.0));
        sum / f64::max(n, 1.0)
    };
    let forward = mean - pith;
    for &t in &found.limb {
        let c = corners[t as usize].map(|p| grain[p as usize]);
        for k in 0..3 {
            let (rho, _) = rings.address(c[k].truncate());
            most = most.max(rho);
            angles.push(libm::atan2(
                forward.perp_dot(c[k].truncate() - pith),
                forward.dot(c[k].truncate() - pith),
            ));
            // End faces run through the middle and say nothing of the bark.
            let slope = (c[(k + 1) % 3] - c[k]).normalize_or_zero();
            if found.stem.kind == StemKind::Board || slope.z.abs() > 0.3 {
                let (a, b) = (c[k].truncate(), c[(k + 1) % 3].truncate());
                let along =
                    ((pith - a).dot(b - a) / (b - a).length_squared().max(1e-300)).clamp(0.0, 1.0);
                least = least.min(rings.address(a.lerp(b, along)).0);
            }
        }
    }
    let board = found.stem.kind == StemKind::Board;
    let low = angles.iter().copied().fold(f64::INFINITY, f64::min);
    let high = angles.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if board && high - low < 3.0 {
        let (base, margin) = (libm::atan2(forward.y, forward.x), 0.03 * (high - low));
        return (
            (0.98 * least, 1.02 * most),
            1.0,
            Some((base + low - margin, base + high + margin)),
        );
    }
    ((0.0, 1.03 * most.max(1.0)), least.clamp(0.5, 1.0), None)
}

impl Prepared {
    /// The transform of the node that is cut.
    pub fn transform(&self) -> &DAffine3 {
        &self.scene.nodes[self.found.node].transform
    }
}
