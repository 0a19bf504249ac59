//! Whole trees made by chance: a trunk that tapers and leans, perhaps forked, under a crown of twigs and leaves.

use super::*;

/// A tree that is to be scanned.
struct Tree {
    seed: u64,
    /// Points of the bark for each m².
    density: f64,
    /// Standard deviation of the scanner, m.
    noise: f64,
    /// Horizontal metres for each vertical one.
    lean: f64,
    /// Whether the stem parts in two at half its height.
    forked: bool,
}

const HEIGHT: f64 = 9.0;
const BASE: f64 = 0.16;

impl Tree {
    fn chance(&self, what: u64, i: i64, k: i64) -> f64 {
        noise::unit(self.seed * 100 + what, i, k, 0)
    }

    fn axis(&self, z: f64, side: f64) -> DVec3 {
        let spread = if self.forked {
            0.35 * (z - 0.5 * HEIGHT).max(0.0)
        } else {
            0.0
        };
        DVec3::new(self.lean * z + side * spread, 0.1 * libm::sin(z), z)
    }

    fn radius(&self, z: f64) -> f64 {
        let whole = BASE * (1.0 - 0.6 * z / HEIGHT);
        if self.forked && z > 0.5 * HEIGHT {
            0.75 * whole
        } else {
            whole
        }
    }

    fn cloud(&self) -> PointCloud {
        let mut points = Vec::new();
        let bark = (self.density * std::f64::consts::TAU * 0.7 * BASE * HEIGHT) as i64;
        for i in 0..bark {
            let z = HEIGHT * self.chance(1, i, 0);
            let angle = std::f64::consts::TAU * self.chance(1, i, 1);
            let side = if i % 2 == 0 { 1.0 } else { -1.0 };
            let jitter =
                self.noise * (0..12).map(|k| self.chance(2, i, k)).sum::<f64>() - 6.0 * self.noise;
            let radius = self.radius(z) + jitter;
            points.push(
                self.axis(z, side) + DVec3::new(libm::cos(angle), libm::sin(angle), 0.0) * radius,
            );
        }
        // Twigs of 40 points in a wide crown, as many points as the bark has and half as many again; leaves between.
        for twig in 0..bark / 27 {
            let unit = |k: i64| 2.0 * self.chance(3, twig, k) - 1.0;
            let z = HEIGHT * (0.72 + 0.25 * unit(0));
            let from = self.axis(z, unit(1).signum()) + DVec3::new(unit(2), unit(3), 0.0) * 1.6;
            let to = from + DVec3::new(unit(4), unit(5), unit(6)) * 0.5;
            points.extend((0..40).map(|k| {
                let off = DVec3::new(unit(10 + 3 * k), unit(11 + 3 * k), unit(12 + 3 * k));
                from.lerp(to, self.chance(4, twig, k)) + off * 0.01
            }));
        }
        // The ground.
        for i in 0..bark / 10 {
            let unit = |k: i64| 2.0 * self.chance(5, i, k) - 1.0;
            points.push(DVec3::new(unit(0), unit(1), 0.03 * unit(2)));
        }
        PointCloud {
            points,
            ..PointCloud::default()
        }
    }
}

#[test]
fn the_stem_of_a_tree_is_distinguished_from_its_crown() {
    for (seed, density, scatter, lean, forked) in [
        (1, 4_000.0, 0.006, 0.0, true),
        (2, 3_000.0, 0.004, 0.25, false),
        (3, 1_500.0, 0.005, 0.1, false),
    ] {
        let tree = Tree {
            seed,
            density,
            noise: scatter,
            lean,
            forked,
        };
        let what = format!(
            "density {density}, noise {scatter}, lean {lean}, forked {forked}, seed {seed}"
        );
        let bark = reconstruct(&tree.cloud(), "1.5m", &ScanOptions::default());
        let bark = bark.unwrap_or_else(|e| panic!("{what}: {e}"));
        let below: Vec<&DVec3> = bark
            .centreline
            .iter()
            .filter(|p| (0.3..4.0).contains(&p.z))
            .collect();
        assert!(below.len() > 10, "{what}: {:?}", bark.report);
        for p in below {
            let off = p.truncate().distance(tree.axis(p.z, 0.0).truncate());
            assert!(off < 0.15 * BASE, "{what}: {off} off the axis at {p}");
        }
        let StemLocation::Point(at) = bark.location else {
            panic!("{what}: {}", bark.location)
        };
        let radius = at.truncate().distance(tree.axis(at.z, 0.0).truncate());
        let expected = tree.radius(at.z);
        assert!(
            (radius / expected - 1.0).abs() < 0.15,
            "{what}: {radius} for {expected}"
        );
    }
}

#[test]
fn a_crown_alone_is_no_stem() {
    for seed in 1..5 {
        let tree = Tree {
            seed,
            density: 5_000.0,
            noise: 0.004,
            lean: 0.0,
            forked: false,
        };
        let mut cloud = tree.cloud();
        // Neither the ground nor bark: what is left is farther from the axis than that.
        cloud.points.retain(|p| {
            p.z > 3.0 && p.truncate().distance(tree.axis(p.z, 0.0).truncate()) > 1.3 * BASE
        });
        let found = reconstruct(&cloud, "0.5", &ScanOptions::default());
        assert!(
            matches!(found, Err(ScanError::NoStem { .. })),
            "seed {seed}: {:?}",
            found.map(|b| b.report)
        );
    }
}
