//! Standard fracture tests return the energy that went into the bonds, in two ways that do not use it.

use greenstick_fibre::fracture_test::{
    FractureError, FractureParameters, FractureRequest, FractureTest, FractureTestKind, fracture,
};
use greenstick_geometry::{Context, ErrorKind};

/// A coarse specimen, quick to test.
fn coarse(test: FractureTestKind) -> FractureTest {
    let (length, crack) = match test {
        FractureTestKind::DoubleCantileverBeam => (0.13, 0.06),
        FractureTestKind::EndNotchedFlexure => (0.4, 0.14),
    };
    let parameters = FractureParameters {
        test,
        length: Some(length),
        crack: Some(crack),
        growth: Some(0.02),
        spacing: Some(0.005),
        edge: Some(0.005),
        ..FractureParameters::default()
    };
    parameters.test()
}

fn request(test: FractureTest) -> FractureRequest {
    FractureRequest {
        test,
        ..FractureRequest::new("Norway spruce")
    }
}

#[test]
fn tests_return_the_energy_that_went_in() {
    for kind in [
        FractureTestKind::DoubleCantileverBeam,
        FractureTestKind::EndNotchedFlexure,
    ] {
        let tested = fracture(&request(coarse(kind)), &Context::quiet()).unwrap();
        let report = &tested.report;
        // Larsen and Gustafsson's line at 470 kg/m³, and three times as much in sliding.
        let modes = match kind {
            FractureTestKind::DoubleCantileverBeam => 1.0,
            FractureTestKind::EndNotchedFlexure => 3.0,
        };
        let expected = modes * (1.04 * 470.0 - 146.0);
        assert!((report.put_in_j_per_m2 / expected - 1.0).abs() < 1e-9);
        for (what, beside, within) in [
            ("work", report.by_work, 0.06),
            ("compliance", report.by_compliance, 0.06),
            ("equivalent crack", report.by_equivalent_crack, 0.06),
            ("stiffness", report.compliance_m_per_n, 0.06),
        ] {
            let error = beside.ratio - 1.0;
            assert!(error.abs() < within, "{kind:?}, {what}: {beside:?}");
        }
        // A process zone makes the largest load less than that of a sharp crack.
        let load = report.maximum_load_n.ratio;
        assert!((0.85..1.0).contains(&load), "{kind:?}: {load}");
        assert!(report.energy_balance.abs() < 0.01, "{report}");
        assert_eq!(report.dissipated_beside, 0.0);
        // The columns agree: dissipated work is work less what is stored.
        let table = tested.load_table();
        assert_eq!(table.lines().count(), tested.outcome.points.len() + 1);
        let last: Vec<f64> = (table.lines().last().unwrap().split(','))
            .map(|cell| cell.parse().unwrap())
            .collect();
        assert!((last[5] - last[6] - last[7]).abs() < 1e-9 * last[5]);
    }
}

#[test]
fn specimens_that_show_nothing_are_refused() {
    let test = coarse(FractureTestKind::EndNotchedFlexure);
    let unstable = FractureTest {
        crack: 0.6 * 0.5 * test.length,
        ..test
    };
    let beyond = FractureTest {
        growth: 0.1,
        ..test
    };
    let rods = FractureTest {
        spacing: test.height,
        ..test
    };
    for (test, word) in [
        (unstable, "runs by itself"),
        (beyond, "before the load in the middle"),
        (rods, "half the height"),
    ] {
        let error = fracture(&request(test), &Context::quiet()).unwrap_err();
        assert_eq!(error.kind(), ErrorKind::Request);
        assert!(error.to_string().contains(word), "{error}");
    }
    let unknown = FractureRequest::new("no such tree");
    let error = fracture(&unknown, &Context::quiet()).unwrap_err();
    assert!(matches!(error, FractureError::Species(_)));
}
