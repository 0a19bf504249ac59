//! What a picture of wood in pieces shows.

use glam::{DVec2, DVec3};
use greenstick_geometry::{Node, Scene};

/// Pieces of less than this share of the wood are splinters, which may fly far: a picture need not show them.
pub(super) const SPLINTER_SHARE: f64 = 0.01;

fn is_wood(node: &Node) -> bool {
    node.mesh.attributes.contains_key("_GRAIN")
}

/// Returns what a picture of wood in pieces shows: all but splinters.
fn without_splinters(scene: &Scene) -> impl Iterator<Item = &Node> {
    let wood = scene.nodes.iter().filter(|n| is_wood(n));
    let whole: f64 = wood.map(|n| n.mesh.volume()).sum();
    (scene.nodes.iter())
        .filter(move |node| !is_wood(node) || node.mesh.volume() >= SPLINTER_SHARE * whole)
}

/// Returns the outermost points (m) of what a picture of wood in pieces shows, all but splinters: of each piece those in the directions of
/// the neighbours of a cell in a grid.
pub(super) fn outermost_without_splinters(scene: &Scene) -> Vec<DVec3> {
    let steps = || [-1.0, 0.0, 1.0].into_iter();
    let directions: Vec<DVec3> = steps()
        .flat_map(|x| steps().flat_map(move |y| steps().map(move |z| DVec3::new(x, y, z))))
        .filter(|&direction| direction != DVec3::ZERO)
        .collect();
    let outermost = |node: &Node| {
        let mut farthest = vec![(f64::NEG_INFINITY, DVec3::ZERO); directions.len()];
        for &p in &node.mesh.positions {
            let p = node.transform.transform_point3(p);
            for (far, direction) in farthest.iter_mut().zip(&directions) {
                let way = p.dot(*direction);
                if way > far.0 {
                    *far = (way, p);
                }
            }
        }
        let met = farthest.into_iter().filter(|far| far.0 > f64::NEG_INFINITY);
        met.map(|far| far.1).collect::<Vec<_>>()
    };
    without_splinters(scene).flat_map(outermost).collect()
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
