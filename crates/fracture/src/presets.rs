//! Presets: the columns of Table 2 of Yang 2019, the ways in which wood breaks, and the paper's
//! cracked sections.
//!
//! A preset is a list of settings that are read like those of a person, so that a preset out of
//! range cannot exist.

use crate::parameters::{BreakParameters, Crack, CrackKind, CrackParameters};
use greenstick_schema::{ParameterError, Parameters, Value, closest_names, did_you_mean};
use serde::Serialize;

/// A named set of parameters.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Preset {
    /// Name by which recipes and users refer to it.
    pub name: &'static str,
    /// One line on what it gives.
    pub summary: &'static str,
    #[serde(skip)]
    settings: Settings,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Settings {
    /// A column of [`TABLE_2`].
    Figure(usize),
    /// Settings of the broken face, over the defaults.
    Break(&'static [(&'static str, &'static str)]),
    /// Settings of the crack groups, then single cracks: kind and settings.
    Cracks(
        &'static [(&'static str, &'static str)],
        &'static [SingleCrack],
    ),
}

type SingleCrack = (CrackKind, &'static [(&'static str, f64)]);

/// A name that is no preset.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("unknown preset \"{name}\"{}", did_you_mean(nearest))]
pub struct UnknownPreset {
    /// The name found.
    pub name: String,
    /// Up to three names that are near it.
    pub nearest: Vec<String>,
}

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

/// All presets, in the order they are listed.
pub const PRESETS: &[Preset] = &[
    Preset {
        name: "fig2g",
        summary: "Table 2, Fig. 2(g): a steep break of a 3 cm branch, one side high, one low",
        settings: Settings::Figure(0),
    },
    Preset {
        name: "fig15",
        summary: "Table 2, Fig. 15: nearly flat (tree-of-heaven), one side rougher, the phloem more uneven",
        settings: Settings::Figure(1),
    },
    Preset {
        name: "fig16",
        summary: "Table 2, Fig. 16: high, middle and low sectors, each smooth",
        settings: Settings::Figure(2),
    },
    Preset {
        name: "fig17",
        summary: "Table 2, Fig. 17: a tension side with long thorns, a blunt compression side",
        settings: Settings::Figure(3),
    },
    Preset {
        name: "fig18",
        summary: "Table 2, Fig. 18: fresh and full of fibre spines, which come from high, dense noise (no thorns set)",
        settings: Settings::Figure(4),
    },
    Preset {
        name: "fig19",
        summary: "Table 2, Fig. 19: a break at 45° on the tree with a deep notch on one side",
        settings: Settings::Figure(5),
    },
    Preset {
        name: "splintering-tension",
        summary: "dry, tough wood, bent: long splinters on the tension side, a blunt shelf opposite, a split between",
        settings: Settings::Break(&[
            ("sectors", "110"),
            ("slab_count", "9"),
            ("slab_height", "1.5"),
            ("sliver_count", "130"),
            ("sliver_height", "1.7"),
            ("bundle_aspect", "5"),
            ("fibre_height", "0.14"),
            ("step_height", "0.2"),
            ("split", "1"),
            ("compression_shelf", "0.36"),
            ("compression_height", "0.07"),
            ("bark_offset", "0.1"),
            ("bark_height", "0.9"),
            ("high.height", "0.3"),
            ("high.angle", "170"),
            ("high.rings", "0.8"),
            ("ductile.thorn_length", "1.8"),
            ("ductile.thorn_probability", "0.03"),
            ("ductile.angle", "190"),
            ("ductile.rings", "0.8"),
        ]),
    },
    Preset {
        name: "simple-tension",
        summary: "a shorter, regular tear: splinters of a few widths",
        settings: Settings::Break(&[
            ("slab_count", "6"),
            ("slab_height", "0.65"),
            ("sliver_count", "80"),
            ("sliver_height", "0.8"),
            ("fibre_height", "0.06"),
            ("step_height", "0.12"),
            ("compression_shelf", "0.25"),
            ("compression_height", "0.05"),
            ("bark_height", "0.35"),
            ("ductile.thorn_length", "0.8"),
            ("ductile.thorn_probability", "0.02"),
            ("ductile.angle", "180"),
            ("ductile.rings", "0.7"),
        ]),
    },
    Preset {
        name: "brash",
        summary: "brittle, decayed or dense dry wood: nearly flat across, small steps along the grain, matt",
        settings: Settings::Break(&[
            ("slab_count", "7"),
            ("slab_height", "0.1"),
            ("sliver_count", "140"),
            ("sliver_height", "0.1"),
            ("bundle_aspect", "2.5"),
            ("fibre_height", "0.012"),
            ("step_height", "0.06"),
            ("compression_shelf", "0"),
            ("bark_offset", "0.02"),
            ("bark_height", "0.07"),
            ("inclination", "6"),
        ]),
    },
    Preset {
        name: "compression-first",
        summary: "green or light wood: half the section crushed to a low shelf, the other half torn",
        settings: Settings::Break(&[
            ("sectors", "110"),
            ("slab_count", "6"),
            ("slab_height", "0.9"),
            ("sliver_count", "110"),
            ("sliver_height", "1.2"),
            ("fibre_height", "0.16"),
            ("step_height", "0.12"),
            ("compression_shelf", "0.52"),
            ("compression_height", "0.12"),
            ("bark_offset", "0.1"),
            ("bark_height", "0.6"),
            ("bark_strips", "10"),
            ("ductile.thorn_length", "1"),
            ("ductile.thorn_probability", "0.03"),
            ("ductile.angle", "140"),
            ("ductile.rings", "0.6"),
        ]),
    },
    Preset {
        name: "green-stick",
        summary: "fresh, tough wood, bent: one side torn into strings, the other bent but whole, so that the piece hangs on",
        settings: Settings::Break(&[
            ("sectors", "110"),
            ("slab_count", "8"),
            ("slab_height", "1.6"),
            ("sliver_count", "150"),
            ("sliver_height", "2.6"),
            ("bundle_aspect", "4"),
            ("fibre_height", "0.22"),
            ("step_height", "0.15"),
            ("compression_shelf", "0.22"),
            ("compression_height", "0.04"),
            ("bark_offset", "0.2"),
            ("bark_height", "1"),
            ("bark_strips", "9"),
            ("high.height", "0.9"),
            ("high.angle", "190"),
            ("high.rings", "0.7"),
            ("ductile.thorn_length", "2.6"),
            ("ductile.thorn_probability", "0.06"),
            ("ductile.angle", "170"),
            ("ductile.rings", "0.7"),
            ("hang", "68"),
        ]),
    },
    Preset {
        name: "shear",
        summary: "horizontal shear: split along the middle into two beams, one ending far above the other",
        settings: Settings::Break(&[
            ("slab_count", "4"),
            ("slab_height", "0.5"),
            ("sliver_count", "90"),
            ("sliver_height", "0.9"),
            ("bundle_aspect", "5"),
            ("fibre_height", "0.08"),
            ("step_height", "0.2"),
            ("split", "2.5"),
            ("compression_shelf", "0.5"),
            ("compression_height", "0.1"),
            ("bark_height", "0.5"),
            ("high.height", "5"),
            ("high.angle", "180"),
            ("high.rings", "1"),
        ]),
    },
    Preset {
        name: "twist",
        summary: "twisted off: splinters spiral, gaps between bundles run along the grain",
        settings: Settings::Break(&[
            ("sectors", "64"),
            ("slab_count", "12"),
            ("slab_height", "1.5"),
            ("sliver_count", "120"),
            ("sliver_height", "1.5"),
            ("bundle_aspect", "5"),
            ("fibre_height", "0.16"),
            ("step_height", "0.2"),
            ("spiral_angle", "25"),
            ("compression_shelf", "0"),
            ("bark_offset", "-0.2"),
            ("bark_height", "0.8"),
            ("ductile.thorn_length", "2"),
            ("ductile.thorn_probability", "0.04"),
            ("ductile.angle", "360"),
            ("ductile.rings", "1"),
        ]),
    },
    Preset {
        name: "fig20",
        summary: "Fig. 20: a few large radial cracks and one along a ring, their course distorted, on a sawn end",
        settings: Settings::Cracks(
            &[("end", "sawn"), ("distortion", "0.03")],
            &[
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
            ],
        ),
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

impl Preset {
    /// The preset of a name, case and the difference of hyphen and underscore ignored.
    ///
    /// # Errors
    /// [`UnknownPreset`] with names that are near.
    pub fn find(name: &str) -> Result<&'static Preset, UnknownPreset> {
        let wanted = name.trim().to_lowercase().replace(['_', ' '], "-");
        PRESETS
            .iter()
            .find(|p| p.name == wanted)
            .ok_or_else(|| UnknownPreset {
                name: name.to_owned(),
                nearest: closest_names(name, PRESETS.iter().map(|p| p.name)),
            })
    }

    /// Whether it sets cracks; otherwise it sets the broken face.
    pub fn is_cracks(&self) -> bool {
        matches!(self.settings, Settings::Cracks(..))
    }

    /// Puts the preset in place of what it is about: the whole broken face, or all cracks. The
    /// other is left alone, and so is the face's seed.
    ///
    /// # Errors
    /// None for the presets that are listed; a setting that is out of range would be reported.
    pub fn apply(
        &self,
        face: &mut BreakParameters,
        cracks: &mut CrackParameters,
    ) -> Result<(), ParameterError> {
        match self.settings {
            Settings::Figure(column) => *face = figure(column, face.seed)?,
            Settings::Break(settings) => {
                let mut new = BreakParameters {
                    seed: face.seed,
                    ..BreakParameters::default()
                };
                settings
                    .iter()
                    .try_for_each(|(key, text)| new.set_text(key, text))?;
                *face = new;
            }
            Settings::Cracks(settings, single) => {
                let mut new = CrackParameters::default();
                settings
                    .iter()
                    .try_for_each(|(key, text)| new.settings.set_text(key, text))?;
                for (kind, settings) in single {
                    let mut crack = Crack::new(*kind);
                    for (key, value) in *settings {
                        crack.set(key, &Value::Number(*value))?;
                    }
                    new.cracks.push(crack);
                }
                *cracks = new;
            }
        }
        Ok(())
    }
}

/// White noise of the phloem and Perlin noise of the bark, as parts of what the sapwood's noise has over the phloem's.
const STRINGS: f64 = 0.2;
const FLAPS: f64 = 0.6;
/// Cells of that noise per metre of the noise diameter: about twenty around a branch of 1 cm.
const FLAP_FREQUENCY: f64 = 700.0;

/// A column of Table 2, as a smooth face as in the paper. Where the paper says nothing: pith is as
/// heartwood, bark as phloem, and white noise is left at its small default but where the wood is
/// rougher than the phloem.
fn figure(column: usize, seed: u64) -> Result<BreakParameters, ParameterError> {
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
    // Where the wood is far rougher than the table's phloem, bark and inner bark as even as that look like a pipe.
    let rougher = (face.sapwood.perlin_amplitude - face.phloem.perlin_amplitude).max(0.0);
    face.phloem.white_noise_amplitude += STRINGS * rougher;
    face.bark = face.phloem.clone();
    face.bark.perlin_amplitude += FLAPS * rougher;
    if rougher > 0.0 {
        (face.bark.perlin_frequency, face.bark.perlin_octaves) = (FLAP_FREQUENCY, 3);
    }
    Ok(face)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameters::SurfaceStyle;

    fn applied(name: &str) -> (BreakParameters, CrackParameters) {
        let (mut face, mut cracks) = Default::default();
        Preset::find(name)
            .unwrap()
            .apply(&mut face, &mut cracks)
            .unwrap();
        (face, cracks)
    }

    #[test]
    fn every_preset_is_in_range_and_changes_only_its_own_part() {
        for preset in PRESETS {
            let (face, cracks) = applied(preset.name);
            face.check()
                .unwrap_or_else(|e| panic!("{}: {e}", preset.name));
            cracks
                .check()
                .unwrap_or_else(|e| panic!("{}: {e}", preset.name));
            assert_eq!(cracks.is_empty(), !preset.is_cracks(), "{}", preset.name);
            assert_eq!(
                face == BreakParameters::default(),
                preset.is_cracks(),
                "{}",
                preset.name
            );
            assert!(!preset.summary.is_empty() && !preset.summary.contains('\n'));
        }
    }

    #[test]
    fn figures_have_what_their_captions_say() {
        let layers = applied("fig16").0;
        assert_eq!((layers.high.angle, layers.low.angle), (180.0, 30.0));
        let ductile = applied("fig17").0.ductile;
        assert_eq!(
            (ductile.thorn_length, ductile.thorn_probability),
            (5.0, 0.1)
        );
        // Fig. 15: the phloem is more uneven than the xylem. Fig. 18: spines without thorns.
        let flat = applied("fig15").0;
        assert!(flat.phloem.perlin_amplitude > flat.sapwood.perlin_amplitude);
        let spines = applied("fig18").0;
        assert_eq!(
            (spines.sapwood.perlin_frequency, spines.ductile.thorn_length),
            (5000.0, 0.0)
        );
        assert_eq!((spines.rings, spines.surface), (100, SurfaceStyle::Smooth));
        let notch = applied("fig19").0;
        assert_eq!((notch.low.height, notch.inclination), (-4.0, 45.0));
    }

    #[test]
    fn names_are_found_loosely_and_suggested() {
        assert_eq!(
            Preset::find("Splintering_Tension").unwrap().name,
            "splintering-tension"
        );
        assert_eq!(Preset::find("fig22").unwrap_err().nearest.len(), 3);
        let message = Preset::find("brasch").unwrap_err().to_string();
        assert_eq!(
            message,
            "unknown preset \"brasch\"; did you mean \"brash\"?"
        );
    }

    #[test]
    fn modes_differ_in_the_way_they_are_known_for() {
        let face = |name| applied(name).0;
        let reach = |p: &BreakParameters| p.slab_height + p.sliver_height + p.step_height;
        let (splinter, simple, brash) = (
            face("splintering-tension"),
            face("simple-tension"),
            face("brash"),
        );
        assert!(reach(&splinter) > 2.0 * reach(&simple) && reach(&simple) > 4.0 * reach(&brash));
        assert!(splinter.split > 0.0 && face("shear").split > splinter.split);
        assert!(face("twist").spiral_angle != 0.0 && brash.spiral_angle == 0.0);
        assert!(face("compression-first").compression_shelf > splinter.compression_shelf);
    }
}
