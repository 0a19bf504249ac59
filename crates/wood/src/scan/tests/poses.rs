//! A log is the same however its cloud is turned, mirrored, shifted or thinned.

use super::*;
use glam::DMat3;

#[test]
fn a_log_is_the_same_in_all_poses_within_its_standard_errors() {
    let (cloud, base, along) = cylinder(12_000, 0.8);
    let options = ScanOptions::default();
    let at = |cloud: &PointCloud, p: DVec3| {
        let at = StemLocation::Point(p);
        reconstruct_bark(cloud, &at, &options, &Context::quiet())
            .unwrap()
            .report
    };
    let middle = base + along * 1.5;
    let first = at(&cloud, middle);
    assert!((first.stem_length_m - 3.0).abs() < 0.03, "{first:?}");
    let posed = |turn: DMat3, shift: DVec3| {
        let points = cloud.points.iter().map(|p| turn * *p + shift).collect();
        let other = PointCloud {
            points,
            ..PointCloud::default()
        };
        (other, turn * middle + shift)
    };
    let laid = DMat3::from_rotation_z(0.65) * DMat3::from_rotation_x(1.4);
    let mirror = DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0));
    let half: Vec<u32> = (0..12_000)
        .filter(|&i| noise::unit(71, i64::from(i), 0, 0) < 0.5)
        .collect();
    for (what, (other, middle)) in [
        (
            "turned by 37°",
            posed(DMat3::from_rotation_z(0.65), DVec3::ZERO),
        ),
        ("laid down", posed(laid, DVec3::ZERO)),
        ("mirrored", posed(mirror, DVec3::ZERO)),
        (
            "shifted",
            posed(DMat3::IDENTITY, DVec3::new(5e5, 5.4e6, 300.0)),
        ),
        ("thinned", (cloud.select(&half), middle)),
    ] {
        let second = at(&other, middle);
        let (a, b) = (first.place.unwrap(), second.place.unwrap());
        let errors = [a, b].map(|p| [p.diameter_error_m, p.girth_error_m]);
        for (quantity, a, b, error) in [
            (
                "length",
                first.stem_length_m,
                second.stem_length_m,
                first.stem_length_error_m.max(second.stem_length_error_m),
            ),
            (
                "diameter",
                a.diameter_m,
                b.diameter_m,
                errors[0][0].max(errors[1][0]),
            ),
            (
                "girth",
                a.girth_m,
                b.girth_m,
                errors[0][1].max(errors[1][1]),
            ),
            (
                "tape girth",
                a.tape_girth_m,
                b.tape_girth_m,
                errors[0][1].max(errors[1][1]),
            ),
        ] {
            let off = (a - b).abs();
            assert!(
                off <= (0.01 * a).max(2.0 * error),
                "{what}: {quantity} {a} and {b} ± {error}"
            );
        }
        let off = (b.diameter_m / (2.0 * RADIUS) - 1.0).abs();
        assert!(off < 0.01, "{what}: {b:?}");
        assert!(b.tape_girth_m <= b.girth_m * (1.0 + 1e-9), "{what}: {b:?}");
    }
}
