//! Cylinders with known noise, whole and seen in part.

mod poses;
mod timber;
mod trees;

use super::*;
use crate::noise;

const RADIUS: f64 = 0.15;
const NOISE: f64 = 0.003;

/// A number with mean 0 and variance 1 that is nearly normal.
fn normal(purpose: u64, i: i64) -> f64 {
    (0..12).map(|k| noise::unit(purpose, i, k, 1)).sum::<f64>() - 6.0
}

/// A leaning cylinder of 3 m, `count` points on the turns 0 to `seen`; its base and direction.
fn cylinder(count: i64, seen: f64) -> (PointCloud, DVec3, DVec3) {
    let base = DVec3::new(4.0, -2.0, 1.0);
    let along = DVec3::new(0.3, -0.2, 1.0).normalize();
    let (x, y) = along.any_orthonormal_pair();
    let points = (0..count)
        .map(|i| {
            let angle = std::f64::consts::TAU * seen * noise::unit(1, i, 0, 0);
            let radius = RADIUS + NOISE * normal(3, i);
            let out = x * libm::cos(angle) + y * libm::sin(angle);
            base + along * (3.0 * noise::unit(2, i, 0, 0)) + out * radius
        })
        .collect();
    let cloud = PointCloud {
        points,
        ..PointCloud::default()
    };
    (cloud, base, along)
}

fn reconstruct(
    cloud: &PointCloud,
    location: &str,
    options: &ScanOptions,
) -> Result<ScannedBark, ScanError> {
    reconstruct_bark(
        cloud,
        &location.parse().unwrap(),
        options,
        &Context::quiet(),
    )
}

#[test]
fn a_cylinder_gives_back_its_radius_its_axis_and_lies_within_its_noise() {
    let (cloud, base, along) = cylinder(40_000, 1.0);
    let bark = reconstruct(&cloud, "0.5", &ScanOptions::default()).unwrap();
    let report = &bark.report;
    assert!((report.radius_m - RADIUS).abs() < 0.2 * NOISE, "{report:?}");
    assert!((report.noise_m / NOISE - 1.0).abs() < 0.15, "{report:?}");
    assert!(
        report.mean_coverage > 0.97 && report.stem_length_m > 2.8,
        "{report:?}"
    );
    assert_eq!(report.foreign_points, 0);
    for p in &bark.centreline {
        let off = (*p - base).reject_from_normalized(along).length();
        assert!(off < NOISE, "{off} off the axis at {p}");
    }
    let check = bark.mesh.check();
    assert!(check.is_solid(), "{check}");
    // One-sided distances both ways: of the points to the surface about the noise, of the vertices to the true surface less.
    let bvh = greenstick_geometry::Bvh::from_mesh(&bark.mesh);
    let inner = |p: &&DVec3| {
        let s = (**p - base).dot(along);
        (0.2..2.8).contains(&s)
    };
    let chosen: Vec<&DVec3> = cloud.points.iter().filter(inner).step_by(7).collect();
    let mean = chosen
        .iter()
        .map(|p| {
            let near = bvh.nearest_on_mesh(&bark.mesh, **p, f64::INFINITY);
            near.map_or(f64::INFINITY, |n| n.point.distance(**p))
        })
        .sum::<f64>()
        / chosen.len() as f64;
    // The mean of |x| for normal x is 0.8 standard deviations.
    assert!(mean < NOISE && mean > 0.6 * NOISE, "{mean}");
    let vertices: Vec<&DVec3> = bark.mesh.positions.iter().filter(inner).collect();
    let off = vertices
        .iter()
        .map(|p| ((**p - base).reject_from_normalized(along).length() - RADIUS).abs())
        .sum::<f64>()
        / vertices.len() as f64;
    assert!(off < 0.7 * NOISE, "{off}");
}

#[test]
fn a_deeply_fluted_log_is_found_and_keeps_its_flutes() {
    let (base, along) = (
        DVec3::new(1.0, 2.0, 0.5),
        DVec3::new(0.1, 0.2, 1.0).normalize(),
    );
    let (x, y) = along.any_orthonormal_pair();
    let form = |a: f64| RADIUS * (1.0 + 0.12 * libm::cos(5.0 * a) + 0.06 * libm::cos(9.0 * a));
    let points = (0..60_000)
        .map(|i| {
            let a = std::f64::consts::TAU * noise::unit(51, i, 0, 0);
            let radius = form(a) + NOISE * normal(52, i);
            let out = x * libm::cos(a) + y * libm::sin(a);
            base + along * (2.0 * noise::unit(53, i, 0, 0)) + out * radius
        })
        .collect();
    let cloud = PointCloud {
        points,
        ..PointCloud::default()
    };
    let bark = reconstruct(&cloud, "0.5", &ScanOptions::default()).unwrap();
    let report = &bark.report;
    assert!(
        report.stem_length_m > 1.8 && report.foreign_points < 60,
        "{report:?}"
    );
    assert!(report.noise_m < 1.5 * NOISE, "{report:?}");
    let check = bark.mesh.check();
    assert!(check.is_solid(), "{check}");
    // The integral of r² / 2 over the girth.
    let area = std::f64::consts::PI * RADIUS * RADIUS * (1.0 + (0.0144 + 0.0036) / 2.0);
    let volume = bark.mesh.volume() / report.stem_length_m;
    assert!((volume / area - 1.0).abs() < 0.01, "{volume} {area}");
    for p in &bark.mesh.positions {
        let d = *p - base;
        let off = d.reject_from_normalized(along);
        let expected = form(libm::atan2(off.dot(y), off.dot(x)));
        let cap = off.length() < 0.5 * RADIUS;
        assert!(cap || (off.length() - expected).abs() < 4.0 * NOISE, "{p}");
    }
}

#[test]
fn half_a_cylinder_is_completed_and_reported_or_refused() {
    let (cloud, base, along) = cylinder(20_000, 0.5);
    let bark = reconstruct(&cloud, "0.5", &ScanOptions::default()).unwrap();
    assert!(
        (bark.report.mean_coverage - 0.5).abs() < 0.04,
        "{:?}",
        bark.report
    );
    assert!(bark.mesh.check().is_solid());
    // The half that was not seen is where it would be on a round stem.
    for p in &bark.mesh.positions {
        let s = (*p - base).dot(along);
        let r = (*p - base).reject_from_normalized(along).length();
        let cap = r < 0.5 * RADIUS;
        assert!(
            cap || !(0.3..2.7).contains(&s) || (r / RADIUS - 1.0).abs() < 0.1,
            "{r} at {s}"
        );
    }
    let strict = ScanOptions {
        min_coverage: 0.6,
        ..ScanOptions::default()
    };
    let error = reconstruct(&cloud, "0.5", &strict).unwrap_err();
    let text = error.to_string();
    assert!(text.contains("of the girth; at least 60 %"), "{text}");
    assert!(
        matches!(error, ScanError::LowCoverage { coverage, .. } if (coverage.share - 0.5).abs() < 0.05)
    );
}

#[test]
fn the_fracture_surface_is_cut_off() {
    // A broken end: points on a rough face across the cylinder's upper end.
    let (mut cloud, base, along) = cylinder(30_000, 1.0);
    let (x, y) = along.any_orthonormal_pair();
    let face = 6000;
    for i in 0..face {
        let angle = std::f64::consts::TAU * noise::unit(21, i, 0, 0);
        let r = 0.8 * RADIUS * noise::unit(22, i, 0, 0).sqrt();
        let out = (x * libm::cos(angle) + y * libm::sin(angle)) * r;
        let height = 2.7 + 0.01 * normal(23, i);
        cloud.points.push(base + along * height + out);
    }
    let options = ScanOptions {
        bark_only: true,
        ..ScanOptions::default()
    };
    let bark = reconstruct(&cloud, "0.3", &options).unwrap();
    let report = &bark.report;
    let gone = report.fracture_points + report.foreign_points;
    assert!(gone as i64 >= face * 9 / 10, "{report:?}");
    assert!(report.points > 27_000, "{report:?}");
    assert!((report.radius_m - RADIUS).abs() < 0.5 * NOISE, "{report:?}");
}

#[test]
fn folded_bark_is_closed_where_it_is_and_left_out_elsewhere() {
    // Sheets of bark that hang loose on two fifths of the girth, on the last metre.
    let (mut cloud, base, along) = cylinder(40_000, 1.0);
    let (x, y) = along.any_orthonormal_pair();
    for i in 0..12_000i64 {
        let angle = std::f64::consts::TAU * 0.4 * noise::unit(41, i, 0, 0);
        let radius = RADIUS * [1.3, 1.6][(i % 2) as usize] + NOISE * normal(42, i);
        let out = x * libm::cos(angle) + y * libm::sin(angle);
        let s = 2.05 + 0.95 * noise::unit(43, i, 0, 0);
        cloud.points.push(base + along * s + out * radius);
    }
    let options = ScanOptions::default();
    let bark = reconstruct(&cloud, "2.5m", &options).unwrap();
    let note = &bark.report.notes[0];
    assert!(
        note.contains("from 2.00") && note.contains("Poisson"),
        "{note}"
    );
    let check = bark.mesh.check();
    assert!(
        check.closed && check.oriented && check.non_manifold_edges == 0,
        "{check}"
    );
    // Away from the sheets the bark is the cylinder's.
    let mut clean = 0;
    for p in &bark.mesh.positions {
        let (s, d) = (
            (*p - base).dot(along),
            (*p - base).reject_from_normalized(along),
        );
        let turn = libm::atan2(d.dot(y), d.dot(x)) / std::f64::consts::TAU;
        if (0.3..2.7).contains(&s) && (s < 1.8 || (-0.55..-0.05).contains(&turn)) {
            clean += 1;
            assert!(
                (d.length() - RADIUS).abs() < 6.0 * NOISE,
                "{} at {s}",
                d.length()
            );
        }
    }
    assert!(clean > 2000, "{clean}");
    // Seen from the pith there is bark beyond the stem's where the sheets are.
    let out = bark.mesh.positions.iter().filter(|p| {
        let d = (**p - base).reject_from_normalized(along);
        d.length() > 1.2 * RADIUS
    });
    assert!(out.count() > 500);
    let bark = reconstruct(&cloud, "1m", &options).unwrap();
    assert_eq!(bark.report.span_m, [0.0, 2.0], "{:?}", bark.report);
    assert!(bark.report.folded > 0.05 && bark.report.folded < 0.25);
}

#[test]
fn unsuitable_locations_and_clouds_are_refused() {
    let (cloud, base, _) = cylinder(20_000, 1.0);
    let options = ScanOptions::default();
    assert!(matches!(
        reconstruct(&cloud, "9m", &options),
        Err(ScanError::OffStem { .. })
    ));
    let p = base + DVec3::X;
    let far = StemLocation::Point(p);
    let error = reconstruct_bark(&cloud, &far, &options, &Context::quiet()).unwrap_err();
    assert!(matches!(error, ScanError::FarFromWood { .. }), "{error}");
    let flat = PointCloud {
        points: (0..5000i64)
            .map(|i| DVec3::new(noise::unit(5, i, 0, 0), noise::unit(6, i, 0, 0), 0.0))
            .collect(),
        ..PointCloud::default()
    };
    assert!(matches!(
        reconstruct(&flat, "0.5", &options),
        Err(ScanError::NoStem { .. })
    ));
    let wrong = ScanOptions {
        min_coverage: f64::NAN,
        ..options
    };
    assert!(matches!(
        reconstruct(&cloud, "0.5", &wrong),
        Err(ScanError::MinCoverage(_))
    ));
}
