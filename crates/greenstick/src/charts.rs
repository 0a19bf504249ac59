//! Charts of runs and of tests.

use greenstick_fibre::Curve;
use greenstick_fibre::bend_test::{Bent, MeasuredSpecimens, SpecimensReport};
use greenstick_fibre::fracture_test::FractureTested;
use greenstick_fibre::simulate::{LoadCurves, energy_curves};
use greenstick_fibre::store::{EnergyRow, ForceRow};
use greenstick_picture::{Chart, Picture, Series, SeriesStyle};

/// Size of a run's charts, pixels.
const RUN_SIZE: [u32; 2] = [1600, 800];
/// Size of the chart of a bending or fracture test, pixels.
const BEND_SIZE: [u32; 2] = [1600, 900];
/// Size of a chart of specimens, pixels.
const SCATTER_SIZE: [u32; 2] = [1600, 1000];

/// Draws the energies of a run over time.
pub fn energy_chart(rows: &[EnergyRow]) -> Picture {
    let axes = ["time (s)", "energy (J)"];
    draw("Energies", axes, energy_curves(rows), RUN_SIZE)
}

/// Draws the load over the deflection of everything that moves: force over displacement, or, where nothing is displaced,
/// moment over angle. Returns `None` where nothing moves.
pub fn load_chart(rows: &[ForceRow]) -> Option<Picture> {
    let LoadCurves { axes, curves } = LoadCurves::from_rows(rows);
    (!curves.is_empty()).then(|| draw("Load", axes, curves, RUN_SIZE))
}

/// Draws the load of a bending test over its deflection, with where the table has stiffness and largest load.
pub fn bend_chart(bent: &Bent) -> Picture {
    let report = &bent.report;
    let title = format!("{}, {} % moisture", report.species, report.moisture_percent);
    let axes = ["deflection (mm)", "load (kN)"];
    draw(&title, axes, bent.load_curves(), BEND_SIZE)
}

/// Draws the load of a fracture test over its deflection, beside that of a sharp crack in beam theory.
pub fn fracture_chart(tested: &FractureTested) -> Picture {
    let report = &tested.report;
    let (species, moisture) = (&report.species, report.moisture_percent);
    let title = format!("{species}, {moisture} % moisture, {}", report.test.word());
    let axes = ["deflection (mm)", "load (N)"];
    draw(&title, axes, tested.load_curves(), BEND_SIZE)
}

/// Draws the modulus of rupture of specimens over their density, each with its regression line, beside measured ones.
pub fn scatter_chart(report: &SpecimensReport, measured: Option<&MeasuredSpecimens>) -> Picture {
    // Measured ones below, so that they do not hide what was simulated.
    let clouds = measured.map(MeasuredSpecimens::scatter).into_iter();
    let clouds: Vec<Curve> = clouds.chain([report.scatter()]).collect();
    let lines: Vec<Curve> = clouds.iter().filter_map(Curve::regression_line).collect();
    let series = |style| {
        move |Curve { name, points }| Series {
            name,
            points,
            style,
        }
    };
    let clouds = clouds.into_iter().map(series(SeriesStyle::Points));
    let lines = lines.into_iter().map(series(SeriesStyle::Line));
    let [width, height] = SCATTER_SIZE;
    Chart {
        title: format!("{}, {} % moisture", report.species, report.moisture_percent),
        axes: ["density (kg/m3)", "modulus of rupture (MPa)"].map(str::to_owned),
        series: clouds.chain(lines).collect(),
    }
    .draw(width, height)
}

fn draw(title: &str, axes: [&str; 2], curves: Vec<Curve>, [width, height]: [u32; 2]) -> Picture {
    let line = |Curve { name, points }| Series {
        name,
        points,
        style: SeriesStyle::Line,
    };
    Chart {
        title: title.to_owned(),
        axes: axes.map(str::to_owned),
        series: curves.into_iter().map(line).collect(),
    }
    .draw(width, height)
}
