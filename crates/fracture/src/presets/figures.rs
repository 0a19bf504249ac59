//! The paper's figures as presets: the columns of Table 2, the steps of Fig. 2, the grid of Fig. 14, and the cracked
//! sections.

use super::preset::{Preset, Settings, SingleCrack};
use crate::parameters::{BreakParameters, CrackKind};
use greenstick_schema::{ParameterError, Parameters};

/// Table 2 of Yang 2019 by its rows; the columns are figures 2(g), 15, 16, 17, 18 and 19.
pub const TABLE_2: [(&str, [f64; 6]); 26] = [
    ("diameter", [3.0, 1.0, 1.0, 1.0, 1.0, 1.0]),
    ("rings", [40.0, 100.0, 40.0, 100.0, 100.0, 40.0]),
    ("sectors", [40.0, 100.0, 40.0, 100.0, 100.0, 40.0]),
    ("inclination", [65.0, 0.0, 0.0, 0.0, 0.0, 45.0]),
    ("pith_proportion", [0.05, 0.05, 0.05, 0.05, 0.05, 0.05]),
    ("heartwood_proportion", [0.05, 0.45, 0.75, 0.0, 0.0, 0.3]),
    ("phloem_proportion", [0.05, 0.125, 0.05, 0.05, 0.05, 0.1]),
    (
        "phloem.perlin_amplitude",
        [0.2, 0.06, 0.02, 0.07, 0.05, 1.0],
    ),
    (
        "phloem.perlin_frequency",
        [460.0, 2000.0, 460.0, 200.0, 100.0, 200.0],
    ),
    (
        "sapwood.perlin_amplitude",
        [0.2, 0.02, 0.02, 0.07, 1.0, 1.0],
    ),
    (
        "sapwood.perlin_frequency",
        [460.0, 400.0, 460.0, 200.0, 5000.0, 200.0],
    ),
    (
        "heartwood.perlin_amplitude",
        [0.2, 0.02, 0.02, 0.07, 1.0, 1.0],
    ),
    (
        "heartwood.perlin_frequency",
        [460.0, 200.0, 460.0, 200.0, 5000.0, 200.0],
    ),
    ("high.height", [1.0, 0.0, 0.5, 1.8, 3.0, 0.0]),
    ("high.direction", [10.0, 0.0, 0.0, 0.0, 0.0, 0.0]),
    ("high.angle", [60.0, 0.0, 180.0, 150.0, 60.0, 0.0]),
    ("high.rings", [1.0, 0.0, 1.0, 0.6, 0.2, 0.0]),
    ("low.height", [-1.0, 0.0, -0.3, 0.0, 0.0, -4.0]),
    ("low.direction", [170.0, 180.0, 135.0, 180.0, 180.0, 180.0]),
    ("low.angle", [60.0, 0.0, 30.0, 0.0, 0.0, 80.0]),
    ("low.rings", [1.0, 0.0, 0.2, 0.0, 0.0, 0.25]),
    ("ductile.thorn_length", [0.0, 0.2, 0.0, 5.0, 0.0, 0.0]),
    ("ductile.thorn_probability", [0.0, 0.35, 0.0, 0.1, 0.0, 0.0]),
    ("ductile.direction", [0.0, 0.0, 0.0, 0.0, 0.0, 0.0]),
    ("ductile.angle", [0.0, 150.0, 0.0, 150.0, 0.0, 0.0]),
    ("ductile.rings", [0.0, 0.5, 0.0, 0.6, 0.0, 0.0]),
];

/// Rows of Table 2 that [`table_2_column`] reads as 0 in the steps of Fig. 2 before they are set, by what they set.
const NO_INCLINATION: &[&str] = &["inclination"];
const NO_TISSUES: &[&str] = &[
    "pith_proportion",
    "heartwood_proportion",
    "phloem_proportion",
];
const NO_LAYERS: &[&str] = &["high.height", "low.height"];
const NO_PERLIN_NOISE: &[&str] = &[
    "pith.perlin_amplitude",
    "heartwood.perlin_amplitude",
    "sapwood.perlin_amplitude",
    "phloem.perlin_amplitude",
    "bark.perlin_amplitude",
];
const NO_WHITE_NOISE: &[&str] = &[
    "pith.white_noise_amplitude",
    "heartwood.white_noise_amplitude",
    "sapwood.white_noise_amplitude",
    "phloem.white_noise_amplitude",
    "bark.white_noise_amplitude",
];

/// A preset of a column of Table 2.
const fn column(name: &'static str, summary: &'static str, column: usize) -> Preset {
    step(name, summary, column, &[])
}

/// A preset of a column of Table 2 with some of its rows still at 0.
const fn step(
    name: &'static str,
    summary: &'static str,
    column: usize,
    unset: &'static [&'static [&'static str]],
) -> Preset {
    Preset {
        name,
        summary,
        settings: Settings::Column { column, unset },
    }
}

/// A face of Fig. 14.
const fn roughness(name: &'static str, summary: &'static str, lambda: f64, beta: f64) -> Preset {
    Preset {
        name,
        summary,
        settings: Settings::Roughness { lambda, beta },
    }
}

/// The presets of broken faces.
pub(super) const FACES: [Preset; 20] = [
    step(
        "fig2b",
        "Fig. 2(b): the branch before anything is set, cut straight across",
        0,
        &[
            NO_INCLINATION,
            NO_TISSUES,
            NO_LAYERS,
            NO_PERLIN_NOISE,
            NO_WHITE_NOISE,
        ],
    ),
    step(
        "fig2c",
        "Fig. 2(c): then the angle of inclination",
        0,
        &[NO_TISSUES, NO_LAYERS, NO_PERLIN_NOISE, NO_WHITE_NOISE],
    ),
    step(
        "fig2d",
        "Fig. 2(d): then the proportions of phloem and pith",
        0,
        &[NO_LAYERS, NO_PERLIN_NOISE, NO_WHITE_NOISE],
    ),
    step(
        "fig2e",
        "Fig. 2(e): then the high and the low layer",
        0,
        &[NO_PERLIN_NOISE, NO_WHITE_NOISE],
    ),
    step(
        "fig2f",
        "Fig. 2(f): then Perlin noise",
        0,
        &[NO_WHITE_NOISE],
    ),
    column(
        "fig2g",
        "Table 2, Fig. 2(g): a steep break of a 3 cm branch, one side high, one low",
        0,
    ),
    roughness(
        "fig14a",
        "Fig. 14, row 1, column 1: roughness λ = 0.05, β = 400, a soft wave",
        0.05,
        400.0,
    ),
    roughness(
        "fig14b",
        "Fig. 14, row 1, column 2: roughness λ = 0.05, β = 800",
        0.05,
        800.0,
    ),
    roughness(
        "fig14c",
        "Fig. 14, row 1, column 3: roughness λ = 0.05, β = 2000",
        0.05,
        2000.0,
    ),
    roughness(
        "fig14d",
        "Fig. 14, row 2, column 1: roughness λ = 0.15, β = 400",
        0.15,
        400.0,
    ),
    roughness(
        "fig14e",
        "Fig. 14, row 2, column 2: roughness λ = 0.15, β = 800",
        0.15,
        800.0,
    ),
    roughness(
        "fig14f",
        "Fig. 14, row 2, column 3: roughness λ = 0.15, β = 2000",
        0.15,
        2000.0,
    ),
    roughness(
        "fig14g",
        "Fig. 14, row 3, column 1: roughness λ = 0.5, β = 400",
        0.5,
        400.0,
    ),
    roughness(
        "fig14h",
        "Fig. 14, row 3, column 2: roughness λ = 0.5, β = 800",
        0.5,
        800.0,
    ),
    roughness(
        "fig14i",
        "Fig. 14, row 3, column 3: roughness λ = 0.5, β = 2000, dense thorns",
        0.5,
        2000.0,
    ),
    column(
        "fig15",
        "Table 2, Fig. 15: nearly flat (tree-of-heaven), one side rougher, the phloem more uneven",
        1,
    ),
    column(
        "fig16",
        "Table 2, Fig. 16: high, middle and low sectors, each smooth",
        2,
    ),
    column(
        "fig17",
        "Table 2, Fig. 17: a tension side with long thorns, a blunt compression side",
        3,
    ),
    column(
        "fig18",
        "Table 2, Fig. 18: fresh and full of fibre spines, which come from high, dense noise (no thorns set)",
        4,
    ),
    column(
        "fig19",
        "Table 2, Fig. 19: a break at 45° on the tree with a deep notch on one side",
        5,
    ),
];

/// The presets of cracked sections.
pub(super) const SECTIONS: [Preset; 3] = [
    Preset {
        name: "fig20",
        summary: "Fig. 20: a few large radial cracks and one along a ring, their course distorted, on a sawn end",
        settings: Settings::Cracks(&[("end", "sawn"), ("distortion", "0.03")], FIG_20),
    },
    Preset {
        name: "fig20b",
        summary: "Fig. 20(b): the same cracks without random displacement",
        settings: Settings::Cracks(&[("end", "sawn"), ("distortion", "0")], FIG_20),
    },
    Preset {
        name: "fig21",
        summary: "Fig. 21: many radial cracks in three groups, large, medium and small, on a sawn end",
        settings: Settings::Cracks(
            &[
                ("end", "sawn"),
                ("distortion", "0.03"),
                ("large.count", "4"),
                ("large.spacing", "90"),
                ("large.begin_min", "0.02"),
                ("large.begin_max", "0.1"),
                ("large.length_min", "0.75"),
                ("large.length_max", "0.95"),
                ("large.depth_min", "1"),
                ("large.depth_max", "2"),
                ("large.range_min", "60"),
                ("large.range_max", "90"),
                ("medium.count", "9"),
                ("medium.direction", "20"),
                ("medium.spacing", "40"),
                ("medium.begin_min", "0.2"),
                ("medium.begin_max", "0.45"),
                ("medium.length_min", "0.3"),
                ("medium.length_max", "0.5"),
                ("medium.depth_min", "0.4"),
                ("medium.depth_max", "0.9"),
                ("medium.range_min", "20"),
                ("medium.range_max", "35"),
                ("small.count", "24"),
                ("small.direction", "7"),
                ("small.spacing", "15"),
                ("small.jitter", "0.6"),
                ("small.begin_min", "0.4"),
                ("small.begin_max", "0.8"),
                ("small.length_min", "0.08"),
                ("small.length_max", "0.2"),
                ("small.depth_min", "0.1"),
                ("small.depth_max", "0.3"),
                ("small.range_min", "6"),
                ("small.range_max", "12"),
            ],
            &[],
        ),
    },
];

/// The cracks of Fig. 20.
const FIG_20: &[SingleCrack] = &[
    (
        CrackKind::Radial,
        &[
            ("angle", 80.0),
            ("begin", 0.0),
            ("end", 0.95),
            ("range", 120.0),
        ],
    ),
    (
        CrackKind::Radial,
        &[
            ("angle", 205.0),
            ("begin", 0.05),
            ("end", 0.8),
            ("range", 110.0),
        ],
    ),
    (
        CrackKind::Radial,
        &[
            ("angle", 320.0),
            ("begin", 0.1),
            ("end", 0.7),
            ("range", 100.0),
        ],
    ),
    (
        CrackKind::Tangential,
        &[
            ("ring", 0.55),
            ("begin", 225.0),
            ("end", 300.0),
            ("range", 0.5),
        ],
    ),
];

/// Faces of the grid of Fig. 14 have as many rings and sectors as those of Fig. 15.
const FINE_GRID: u32 = 100;

/// Returns a face of Fig. 14: Perlin noise of amplitude `lambda` (radii) and frequency `beta` (per metre) in all tissues.
pub(super) fn rough_face(
    lambda: f64,
    beta: f64,
    seed: u64,
) -> Result<BreakParameters, ParameterError> {
    let mut face = BreakParameters {
        seed,
        rings: FINE_GRID,
        sectors: FINE_GRID,
        ..BreakParameters::default()
    };
    face.set_text("surface", "smooth")?;
    for tissue in ["pith", "heartwood", "sapwood", "phloem", "bark"] {
        for (key, value) in [("perlin_amplitude", lambda), ("perlin_frequency", beta)] {
            face.set_text(&format!("{tissue}.{key}"), &value.to_string())?;
        }
    }
    Ok(face)
}

/// A column of Table 2, as a smooth face as in the paper. Where the paper says nothing: pith is as
/// heartwood, bark as phloem, and white noise is left at its small default. Rows in `unset` are 0.
pub(super) fn table_2_column(
    column: usize,
    unset: &[&[&str]],
    seed: u64,
) -> Result<BreakParameters, ParameterError> {
    let mut face = BreakParameters {
        seed,
        ..BreakParameters::default()
    };
    face.set_text("surface", "smooth")?;
    for (key, row) in TABLE_2 {
        // Counts are whole in the table; text is what both kinds are read from.
        face.set_text(key, &row[column].to_string())?;
    }
    face.pith = face.heartwood.clone();
    face.bark = face.phloem.clone();
    for key in unset.iter().copied().flatten() {
        face.set_text(key, "0")?;
    }
    Ok(face)
}
