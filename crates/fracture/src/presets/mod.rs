//! Presets: the figures of Yang 2019, and the ways in which wood breaks.
//!
//! A preset is a list of settings that are read like those of a person, so that a preset out of
//! range cannot exist.

mod figures;
mod modes;
mod preset;

pub use figures::TABLE_2;
pub use preset::Preset;

use crate::parameters::{BreakParameters, Crack, CrackParameters};
use figures::{FACES, SECTIONS, rough_face, table_2_column};
use greenstick_schema::{ParameterError, Parameters, Value, closest_names, did_you_mean};
use modes::MODES;
use preset::Settings;

/// A name that is no preset.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("unknown preset \"{name}\"{}", did_you_mean(nearest))]
pub struct UnknownPreset {
    /// The name found.
    pub name: String,
    /// Up to three names that are near it.
    pub nearest: Vec<String>,
}

/// All presets, in the order they are listed.
pub const PRESETS: &[Preset] = &ALL;

const COUNT: usize = FACES.len() + MODES.len() + SECTIONS.len();
const ALL: [Preset; COUNT] = join();

const fn join() -> [Preset; COUNT] {
    let mut all = [FACES[0]; COUNT];
    let lists: [&[Preset]; 3] = [&FACES, &MODES, &SECTIONS];
    let (mut next, mut list) = (0, 0);
    while list < lists.len() {
        let mut i = 0;
        while i < lists[list].len() {
            all[next] = lists[list][i];
            (next, i) = (next + 1, i + 1);
        }
        list += 1;
    }
    all
}

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
            Settings::Column { column, unset } => {
                *face = table_2_column(column, unset, face.seed)?;
            }
            Settings::Roughness { lambda, beta } => {
                *face = rough_face(lambda, beta, face.seed)?;
            }
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

    /// What differs between two presets of a face, as keys.
    fn changed(a: &str, b: &str) -> Vec<String> {
        let (a, b) = (applied(a).0, applied(b).0);
        let values = |p: &BreakParameters| p.list().into_iter().map(|p| (p.key, p.value));
        let pairs = values(&a).zip(values(&b));
        pairs.filter(|(a, b)| a != b).map(|(a, _)| a.0).collect()
    }

    #[test]
    fn the_steps_of_figure_2_set_what_its_caption_says() {
        assert_eq!(changed("fig2b", "fig2c"), ["inclination"]);
        assert_eq!(
            changed("fig2c", "fig2d"),
            [
                "pith_proportion",
                "heartwood_proportion",
                "phloem_proportion"
            ]
        );
        assert_eq!(changed("fig2d", "fig2e"), ["high.height", "low.height"]);
        let only = |a, b, what: &str| {
            let keys = changed(a, b);
            assert!(
                keys.len() == 5 && keys.iter().all(|k| k.ends_with(what)),
                "{keys:?}"
            );
        };
        only("fig2e", "fig2f", ".perlin_amplitude");
        only("fig2f", "fig2g", ".white_noise_amplitude");
        assert_eq!(changed("fig14a", "fig14b").len(), 5);
        assert!(
            changed("fig14b", "fig14h")
                .iter()
                .all(|k| k.ends_with(".perlin_amplitude"))
        );
        let (drawn, straight) = (applied("fig20").1, applied("fig20b").1);
        assert_eq!(straight.settings.distortion, 0.0);
        assert_eq!(drawn.cracks, straight.cracks);
    }

    /// Every row of Table 2, read back from the preset; fig18's bark and phloem have no noise but the table's.
    #[test]
    fn presets_are_the_columns_of_table_2() {
        let names = ["fig2g", "fig15", "fig16", "fig17", "fig18", "fig19"];
        for (column, name) in names.into_iter().enumerate() {
            let face = applied(name).0;
            let values = face.list();
            for (key, row) in TABLE_2 {
                let value = &values.iter().find(|p| p.key == key).unwrap().value;
                let number = match value {
                    Value::Number(x) => *x,
                    Value::Integer(x) => *x as f64,
                    other => panic!("{key}: {other:?}"),
                };
                assert_eq!(number, row[column], "{name}: {key}");
            }
            assert_eq!(face.bark, face.phloem);
            let standard = BreakParameters::default();
            let white = |p: &BreakParameters| p.phloem.white_noise_amplitude;
            assert_eq!(white(&face), white(&standard));
        }
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
        assert!(splinter.split > 0.0);
        assert!(face("shear").inclination > 60.0 && splinter.inclination < 30.0);
        assert!(face("twist").spiral_angle != 0.0 && brash.spiral_angle == 0.0);
        assert!(face("compression-first").compression_shelf > splinter.compression_shelf);
    }
}
