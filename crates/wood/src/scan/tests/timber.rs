//! Squared timber: what comes out has the sides, edges and corners of the body that was scanned.

use super::*;
use glam::DQuat;
use greenstick_geometry::Bvh;

/// A box that was scanned: half its width, thickness and length, m, and where it lies.
struct Piece {
    half: DVec3,
    turned: DQuat,
    at: DVec3,
    noise: f64,
}

impl Piece {
    fn new(width: f64, thickness: f64, length: f64, noise: f64) -> Self {
        Piece {
            half: 0.5 * DVec3::new(width, thickness, length),
            turned: DQuat::from_euler(glam::EulerRot::XYZ, 0.4, -1.1, 2.0),
            at: DVec3::new(5.0, -3.0, 2.0),
            noise,
        }
    }

    /// Points on the four sides and both ends, as many to the m² everywhere; `gap` leaves a patch of a side unseen.
    fn cloud(&self, count: i64, gap: bool) -> PointCloud {
        let h = self.half;
        let areas = [h.y * h.z, h.x * h.z, h.x * h.y];
        let total: f64 = areas.iter().sum();
        let mut points = Vec::new();
        for i in 0..count {
            let chance = total * noise::unit(31, i, 0, 0);
            let side = usize::from(chance > areas[0]) + usize::from(chance > areas[0] + areas[1]);
            let unit = |k: i64| 2.0 * noise::unit(32, i, k, 0) - 1.0;
            let mut p = h * DVec3::new(unit(0), unit(1), unit(2));
            p[side] = unit(3).signum() * h[side] + self.noise * normal(33, i);
            if gap && side == 1 && p.y > 0.0 && p.x.abs() < 0.6 * h.x && p.z.abs() < 0.2 * h.z {
                continue;
            }
            points.push(self.at + self.turned * p);
        }
        PointCloud {
            points,
            ..PointCloud::default()
        }
    }

    /// A point in the piece's own directions.
    fn own(&self, p: DVec3) -> DVec3 {
        self.turned.inverse() * (p - self.at)
    }

    /// Distance from the endless piece's sides, negative inside.
    fn off(&self, p: DVec3) -> f64 {
        let q = self.own(p).truncate().abs() - self.half.truncate();
        q.max(glam::DVec2::ZERO).length() + q.max_element().min(0.0)
    }
}

#[test]
fn squared_timber_keeps_its_sides_and_its_corners() {
    for (width, thickness, length, noise, gap) in [
        (0.20, 0.14, 2.0, 0.002, false),
        (0.10, 0.10, 0.8, 0.002, true),
        (0.30, 0.03, 1.5, 0.001, false),
    ] {
        let what = format!("{width} x {thickness} x {length}, noise {noise}");
        let piece = Piece::new(width, thickness, length, noise);
        let cloud = piece.cloud(30_000, gap);
        let bark = reconstruct(&cloud, "0.5", &ScanOptions::default());
        let bark = bark.unwrap_or_else(|e| panic!("{what}: {e}"));
        let report = &bark.report;
        assert!(report.notes[0].contains("squared timber"), "{report:?}");
        assert!(report.noise_m < 1.2 * noise, "{what}: {report:?}");
        let check = bark.mesh.check();
        assert!(check.is_solid(), "{what}: {check}");
        // The surface's vertices against the true sides.
        let (mut sum, mut most) = (0.0, 0.0f64);
        for p in &bark.mesh.positions {
            let off = piece.off(*p);
            (sum, most) = (sum + off.abs(), most.max(off.abs()));
        }
        let mean = sum / bark.mesh.positions.len() as f64;
        assert!(mean < 0.7 * noise, "{what}: {mean} off the sides");
        // A cell may hold one point, and the largest of ten thousand normal numbers is near four.
        assert!(most < 4.5 * noise, "{what}: {most} off a side");
        // The true edges against the surface: a rounded corner would be far from them.
        let bvh = Bvh::from_mesh(&bark.mesh);
        let mut edges = 0.0;
        for k in 0..400 {
            let [x, y] = [k & 1, k >> 1 & 1].map(|b| 2.0 * f64::from(b) - 1.0);
            let z = 0.9 * (f64::from(k) / 200.0 - 1.0);
            let edge = piece.at + piece.turned * (piece.half * DVec3::new(x, y, z));
            let near = bvh.nearest_on_mesh(&bark.mesh, edge, f64::INFINITY);
            edges += near.map_or(f64::INFINITY, |n| n.point.distance(edge)) / 400.0;
        }
        assert!(edges < noise, "{what}: {edges} off the edges");
        // Its volume within the noise at both ends of each dimension.
        let volume = bark.mesh.volume();
        let expected = width * thickness * length;
        assert!(
            (volume / expected - 1.0).abs() < 0.04,
            "{what}: {volume} for {expected}"
        );
        let equal = (width * thickness / std::f64::consts::PI).sqrt();
        assert!(
            (report.radius_m / equal - 1.0).abs() < 0.02,
            "{what}: {report:?}"
        );
    }
}

#[test]
fn a_log_with_one_flat_side_is_no_squared_timber() {
    let (mut cloud, base, along) = cylinder(30_000, 1.0);
    let (x, _) = along.any_orthonormal_pair();
    for p in &mut cloud.points {
        let off = (*p - base).dot(x) - 0.7 * RADIUS;
        if off > 0.0 {
            *p -= x * off;
        }
    }
    let bark = reconstruct(&cloud, "0.5", &ScanOptions::default()).unwrap();
    assert!(
        !bark.report.notes[0].contains("squared"),
        "{:?}",
        bark.report
    );
}
