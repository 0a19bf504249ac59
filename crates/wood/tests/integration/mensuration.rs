//! Measures of stems whose size is known: an elliptic frustum, and what a scan's errors make of them.

use glam::DVec3;
use greenstick_geometry::{Context, Mesh, Table, Values};
use greenstick_wood::anatomy::{
    Anatomy, AnatomyOptions, MeasurementErrors, MensurationParameters, StemElements, StemMeasures,
    WoodMass, core_table,
};
use greenstick_wood::appearance::WoodAppearance;
use greenstick_wood::rings::RingDivision;
use greenstick_wood::scan::{Coverage, PlaceMeasures, ScanReport};
use greenstick_wood::species::Species;
use greenstick_wood::stem::{FoundStem, StemOptions, find_stem};
use greenstick_wood::tissue::Zone;
use std::f64::consts::{PI, TAU};

const LENGTH: f64 = 4.0;
/// Half axes of the butt; those of the top are half as long.
const AXES: [f64; 2] = [0.15, 0.12];

/// An elliptic frustum along z.
fn frustum() -> Mesh {
    let (rows, around) = (24_u32, 128_u32);
    let mut mesh = Mesh::default();
    for i in 0..=rows {
        let z = LENGTH * f64::from(i) / f64::from(rows);
        let scale = 1.0 - 0.5 * z / LENGTH;
        for j in 0..around {
            let (sin, cos) = (TAU * f64::from(j) / f64::from(around)).sin_cos();
            let point = DVec3::new(AXES[0] * scale * cos, AXES[1] * scale * sin, z);
            mesh.positions.push(point);
        }
    }
    let at = |i: u32, j: u32| i * around + j % around;
    for i in 0..rows {
        for j in 0..around {
            let [a, b, c, d] = [at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)];
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    for (row, flip) in [(0, true), (rows, false)] {
        let middle = mesh.positions.len() as u32;
        let z = LENGTH * f64::from(row) / f64::from(rows);
        mesh.positions.push(DVec3::Z * z);
        for j in 0..around {
            let (a, b) = (at(row, j), at(row, j + 1));
            let triangle = if flip { [middle, b, a] } else { [middle, a, b] };
            mesh.triangles.push(triangle);
        }
    }
    mesh
}

fn find(mesh: &Mesh) -> FoundStem {
    let meshes = std::slice::from_ref(mesh);
    let place = "0.5".parse().unwrap();
    find_stem(meshes, &place, &StemOptions::default(), &Context::quiet()).unwrap()
}

/// The inside with twenty rings.
fn inside<'a>(mesh: &Mesh, found: &'a FoundStem) -> Anatomy<'a> {
    let options = AnatomyOptions {
        resolution: 64,
        division: RingDivision::Even(20),
        ..AnatomyOptions::default()
    };
    let wood = WoodAppearance::softwood();
    Anatomy::new(found, mesh, &options, wood, &Context::quiet()).unwrap()
}

fn measure(mesh: &Mesh, found: &FoundStem, errors: Option<MeasurementErrors>) -> StemMeasures {
    let context = Context::quiet();
    let anatomy = inside(mesh, found);
    let parameters = MensurationParameters {
        log_length: 1.0,
        ..MensurationParameters::default()
    };
    StemMeasures::new(&anatomy, &parameters, errors, true, &context).unwrap()
}

fn column<'a>(table: &'a Table, name: &str) -> &'a [f64] {
    match table.column(name).map(|c| &c.values) {
        Some(Values::F64(values)) => values,
        other => panic!("{name}: {other:?}"),
    }
}

fn near(found: f64, expected: f64, within: f64) {
    let off = (found / expected - 1.0).abs();
    assert!(off < within, "{found} for {expected}");
}

#[test]
fn an_elliptic_frustum_measures_what_it_is() {
    let mesh = frustum();
    let found = find(&mesh);
    let measures = measure(&mesh, &found, None);
    let table = measures.table();
    assert_eq!(table.fault(), None);
    let lengths = column(&table, "length");
    assert_eq!(lengths.len(), 19);
    // The end that counts as the base is the thicker one.
    let [a, b] = AXES;
    let h = ((a - b) / (a + b)).powi(2);
    let girth = PI * (a + b) * (1.0 + 3.0 * h / (10.0 + (4.0 - 3.0 * h).sqrt()));
    for (k, length) in lengths.iter().enumerate() {
        let scale = 1.0 - 0.5 * length / LENGTH;
        let at = |name| column(&table, name)[k];
        near(at("diameter_by_area"), 2.0 * scale * (a * b).sqrt(), 1e-3);
        near(at("diameter_by_girth"), scale * girth / PI, 1e-3);
        near(at("diameter_by_tape"), scale * girth / PI, 1e-3);
        near(at("ovality"), 1.0 - b / a, 5e-3);
        near(at("z"), *length, 1e-3);
        assert!(at("pith_offset") < 1e-3 && at("diameter_by_area_error").is_nan());
        let cone = |scale: f64| PI * a * b * 2.0 * LENGTH / 3.0 * scale.powi(3);
        near(at("volume_over_bark"), cone(1.0) - cone(scale), 2e-3);
        assert!(at("volume_under_bark_error").is_nan());
    }
    let report = measures.report();
    let breast = report.at_breast_height.unwrap();
    let scale = 1.0 - 0.5 * 1.3 / LENGTH;
    near(
        breast.diameter_by_area_m,
        2.0 * scale * (a * b).sqrt(),
        1e-3,
    );
    let volume = PI * a * b * LENGTH * 7.0 / 12.0;
    near(report.volume_over_bark_m3, volume, 2e-3);
    // Rings fade towards circles on their way in, whose mean radius is a little less than that of equal area.
    let wood = (1.0 - report.bark_share).powi(2);
    near(report.volume_under_bark_m3, wood * volume, 0.01);
    let logs = &report.logs;
    assert_eq!(logs.logs.len(), 4);
    near(logs.volume_m3, volume, 2e-3);
    // A frustum with half the diameter at its top, in four logs: Smalian's rule adds a sixth of (d1 − d2)² to each.
    let smalian: f64 = (0..4)
        .map(|k| [k, k + 1].map(|k| (1.0 - 0.125 * f64::from(k)).powi(2)))
        .map(|[low, high]| 0.5 * PI * a * b * (low + high))
        .sum();
    near(logs.smalian_m3, smalian, 3e-3);
    assert!(logs.smalian_m3 > logs.volume_m3);
    // Rings of even width: a tenth of the height takes as many years as it takes of the radius.
    let years = &measures.years;
    assert_eq!((years.len(), years[0]), (19, report.rings_at_butt.unwrap()));
    let wood_radius = |k: usize| column(&table, "diameter_under_bark")[k];
    let expected = f64::from(years[0]) * wood_radius(18) / wood_radius(0);
    assert!((f64::from(years[18]) - expected).abs() <= 1.0, "{years:?}");
    assert!(years.is_sorted_by(|a, b| a >= b));
    // Mass: all that is wood at the densities of heartwood and sapwood.
    let ash = WoodMass::new(Species::find("white ash").unwrap(), None).unwrap();
    let mass = measures.mass(&ash.unwrap());
    near(mass.dry_mass_kg, 550.0 * report.volume_under_bark_m3, 1e-9);
    near(
        mass.heartwood_m3 + mass.sapwood_m3,
        report.volume_under_bark_m3,
        1e-9,
    );
}

#[test]
fn hexahedra_fill_the_stem_and_know_its_grain() {
    let mesh = frustum();
    let found = find(&mesh);
    let anatomy = inside(&mesh, &found);
    let context = Context::quiet();
    let stem = StemElements::new(&anatomy, Some(0.04), &context).unwrap();
    let volume = PI * AXES[0] * AXES[1] * LENGTH * 7.0 / 12.0;
    near(stem.volume(|_| true), volume, 3e-3);
    let measures = measure(&mesh, &found, None);
    let wood = stem.volume(|e| e.tissue <= Zone::Sapwood);
    near(wood, measures.report().volume_under_bark_m3, 0.02);
    let upward = if stem.nodes[0].z < 1.0 { 1.0 } else { -1.0 };
    for element in &stem.elements {
        assert!(element.volume > 0.0, "{element:?}");
        let [l, r, t] = element.axes;
        for (a, b, dot) in [
            (l, l, 1.0),
            (r, r, 1.0),
            (l, r, 0.0),
            (r, t, 0.0),
            (l, t, 0.0),
        ] {
            assert!((a.dot(b) - dot).abs() < 1e-9, "{element:?}");
        }
        assert!(l.cross(r).dot(t) > 0.999);
        // The taper turns the grain by half the diameter's change over the length.
        assert!(l.z * upward > 0.999, "{l}");
        let middle = element
            .corners
            .iter()
            .map(|&c| stem.nodes[c as usize])
            .sum::<DVec3>()
            / 8.0;
        let outwards = middle.truncate().normalize_or_zero();
        assert!(
            r.truncate().dot(outwards) > 0.9 || outwards.length() == 0.0,
            "{r} {middle}"
        );
    }
    let coarse = StemElements::new(&anatomy, Some(1e-5), &context);
    assert!(coarse.unwrap_err().to_string().contains("at most 4000000"));
}

#[test]
fn cores_of_an_ellipse_are_as_long_as_it_is_wide() {
    let mesh = frustum();
    let found = find(&mesh);
    let anatomy = inside(&mesh, &found);
    let section = anatomy.sections().section(2.0).unwrap();
    let cores = anatomy.cores(&section, 4);
    let bark = measure(&mesh, &found, None).report().bark_share;
    let lengths: Vec<f64> = cores.iter().map(|c| c.widths.iter().sum()).collect();
    let (least, most) = (lengths[0].min(lengths[1]), lengths[0].max(lengths[1]));
    // Opposite radii are alike, and the long ones lie on the long axis.
    near(lengths[0], lengths[2], 1e-3);
    near(lengths[1], lengths[3], 1e-3);
    let expected = (1.0 - bark) * 0.75;
    assert!(most <= 1.01 * expected * AXES[0] && least >= 0.99 * expected * AXES[1]);
    let table = core_table(&cores, Some(2020));
    assert_eq!(table.fault(), None);
    assert_eq!(table.rows(), 4 * cores[0].widths.len());
    let years = column(&table, "year");
    assert_eq!(years[cores[0].widths.len() - 1], 2020.0);
    near(
        column(&table, "latewood_width")[0],
        0.3 * cores[0].widths[0],
        0.2,
    );
}

#[test]
fn errors_of_a_scan_reach_every_measure() {
    let mesh = frustum();
    let found = find(&mesh);
    let place = |z: f64| PlaceMeasures {
        at_m: z,
        centre_m: [0.0, 0.0, z],
        diameter_m: 0.25,
        diameter_error_m: 0.0025,
        girth_m: 0.8,
        girth_error_m: 0.01,
        tape_girth_m: 0.8,
        ovality: 0.2,
        ovality_error: 0.02,
    };
    let scan = ScanReport {
        along: vec![place(1.0), place(3.0)],
        coverage: vec![Coverage {
            from_m: 0.0,
            to_m: 4.0,
            share: 0.7,
        }],
        ..ScanReport::default()
    };
    let measures = measure(&mesh, &found, MeasurementErrors::from_scan(&scan));
    let table = measures.table();
    for (name, error) in [
        ("girth_seen", 0.7),
        ("diameter_by_area_error", 0.0025),
        ("diameter_by_tape_error", 0.01 / PI),
        ("ovality_error", 0.02),
    ] {
        column(&table, name)
            .iter()
            .for_each(|e| near(*e, error, 1e-12));
    }
    let report = measures.report();
    // A per cent of the diameter is two of the volume.
    let error = report.volume_over_bark_error_m3.unwrap();
    near(error, 0.02 * report.volume_over_bark_m3, 1e-9);
    let logs = &report.logs;
    near(logs.smalian_error_m3.unwrap(), 0.02 * logs.smalian_m3, 1e-9);
    let text = report.to_string();
    assert!(text.contains("± 0.25 cm by area"), "{text}");
    assert!(MeasurementErrors::from_scan(&ScanReport::default()).is_none());
}

#[test]
fn a_short_stem_has_no_breast_height() {
    let mut mesh = frustum();
    mesh.positions.iter_mut().for_each(|p| *p *= 0.2);
    let found = find(&mesh);
    let report = measure(&mesh, &found, None).report();
    assert_eq!(report.at_breast_height, None);
    assert!(report.to_string().contains("the stem is too short"));
    assert!(report.logs.logs.is_empty());
}
