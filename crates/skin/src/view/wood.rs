//! What a picture of wood in pieces shows.

use glam::{DVec2, DVec3};
use greenstick_geometry::{Node, Scene};

/// Pieces of less than this share of the wood are splinters, which may fly far: a picture need not show them.
pub(super) const SPLINTER_SHARE: f64 = 0.01;

fn is_wood(node: &Node) -> bool {
    node.mesh.attributes.contains_key("_GRAIN")
}

/// Returns the points (m) that a picture of wood in pieces shows: all but those of splinters.
pub fn points_without_splinters(scene: &Scene) -> Vec<DVec3> {
    let wood = scene.nodes.iter().filter(|n| is_wood(n));
    let whole: f64 = wood.map(|n| n.mesh.volume()).sum();
    let is_shown = |node: &&Node| !is_wood(node) || node.mesh.volume() >= SPLINTER_SHARE * whole;
    let points = |node: &Node| {
        let transform = node.transform;
        let positions = node.mesh.positions.clone();
        positions
            .into_iter()
            .map(move |p| transform.transform_point3(p))
    };
    let shown = scene.nodes.iter().filter(is_shown);
    shown.flat_map(points).collect()
}

/// Returns centre and radius (m) of what a close-up of `diameters` diameters of a stem shows: a sphere about the faces of the
/// wood inside, whose materials are `inner`. Splinters do not count; there is none of wood without such faces.
pub fn close_up(scene: &Scene, inner: &[u32], diameters: f64) -> Option<(DVec3, f64)> {
    let wood = scene.nodes.iter().filter(|node| is_wood(node));
    let whole: f64 = wood.clone().map(|n| n.mesh.volume()).sum();
    let (mut sum, mut area) = (DVec3::ZERO, 0.0);
    let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
    for node in wood.filter(|n| n.mesh.volume() >= SPLINTER_SHARE * whole) {
        let mesh = &node.mesh;
        let grain = mesh.attributes.get("_GRAIN")?;
        for t in (0..mesh.triangles.len()).filter(|&t| inner.contains(&mesh.material(t))) {
            let [a, b, c] = mesh.corners(t).map(|p| node.transform.transform_point3(p));
            let own = (b - a).cross(c - a).length();
            sum += (a + b + c) * (own / 3.0);
            area += own;
            for corner in mesh.triangles[t] {
                let at = corner as usize * grain.width;
                let point = DVec2::new(grain.data[at].into(), grain.data[at + 1].into());
                (low, high) = (low.min(point), high.max(point));
            }
        }
    }
    let sides = high - low;
    let radius = 0.5 * diameters * (sides.x * sides.y).sqrt();
    (area > 0.0 && radius > 0.0).then(|| (sum / area, radius))
}
