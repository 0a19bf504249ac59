//! Bending tests of many specimens: what comes out scatters as the tables say, and small specimens are stronger than large ones.

use greenstick_fibre::bend_test::{SpecimensReport, SpecimensRequest, bend_specimens};
use greenstick_fibre::{BendSection, BendTest, RodCount};
use greenstick_geometry::Context;

/// Specimens of yellow birch with sides of `side` (m) and so many edges in a span of 14.2 sides.
fn specimens(count: u32, side: f64, edges: f64) -> SpecimensReport {
    let span = 14.2 * side;
    let test = BendTest {
        section: BendSection::Rectangle {
            width: side,
            height: side,
        },
        span,
        length: span + side,
        rods: RodCount::Number(4),
        edge: span / edges,
        end: 0.95,
        ..BendTest::default()
    };
    let request = SpecimensRequest {
        test,
        ..SpecimensRequest::new("yellow birch", count)
    };
    bend_specimens(&request, &Context::quiet()).unwrap()
}

#[test]
fn specimens_four_times_as_large_are_weaker_by_the_weakest_link() {
    // Both samples are of the same wood. Their flaws differ: another number of edges shifts all of them.
    let [small, large] = [(0.025, 8.0), (0.1, 10.0)].map(|(side, edges)| {
        let report = specimens(24, side, edges);
        assert!(report.rows.iter().all(|row| row.result.is_some()));
        let rupture = report.summary.modulus_of_rupture_pa.unwrap();
        println!(
            "{side} m: {rupture:?}, expected {}",
            report.expected.size_factor
        );
        (rupture.mean, report.expected.size_factor)
    });
    let (found, expected) = (large.0 / small.0, large.1 / small.1);
    assert!((expected - 16f64.powf(-1.0 / 18.0)).abs() < 1e-12);
    // Flaws scatter both means by 6.9 % over √24.
    println!("found {found}, expected {expected}");
    assert!((found - expected).abs() < 0.035, "{found} {expected}");
}

#[test]
fn what_comes_out_scatters_as_the_tables_say() {
    let report = specimens(24, 0.05, 8.0);
    let (summary, expected) = (&report.summary, report.expected.coefficients_of_variation);
    let within = |interval: Option<[f64; 2]>, value: f64| {
        let [low, high] = interval.unwrap();
        (low..=high).contains(&value)
    };
    let scatter = |s: Option<greenstick_fibre::bend_test::Statistics>| {
        s.unwrap().coefficient_of_variation_interval
    };
    assert!(within(scatter(summary.density_kg_per_m3), expected.density));
    assert!(within(
        scatter(summary.modulus_of_elasticity_pa),
        expected.modulus_of_elasticity
    ));
    assert!(within(
        scatter(summary.modulus_of_rupture_pa),
        expected.modulus_of_rupture
    ));
    let correlation = summary.rupture_with_density.unwrap();
    assert!(within(
        correlation.interval,
        report.expected.rupture_with_density
    ));
    println!("{report}");
}
