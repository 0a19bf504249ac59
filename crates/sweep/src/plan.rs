//! Sweeps: which variants there are. Every variant follows from its number alone.

use crate::axis::Axis;
use crate::error::SweepError;
use crate::sobol;
use crate::variant::Variant;
use greenstick::formats::LengthUnit;
use greenstick::fracture::recipe::RecipeError;
use greenstick::schema::{
    FILE_NAME, ParameterError, Parameters, Value, choice, choices, content_hash, count, flag,
    parameters, read_table, syntax_error, text, write_toml,
};
use greenstick::wood::noise;
use std::path::{Path, PathBuf};
use toml::de::{DeTable, DeValue};

/// Most variants of a sweep: those that are done are kept in memory, a bit each.
pub const MAX_VARIANTS: u64 = 1 << 30;
/// The tables of a sweep that no recipe has.
const SWEEP: &str = "sweep";
const VARY: &str = "vary";
/// What random samples are drawn for, in the hash that draws them.
const DRAW: i64 = 0x5357;

choices! {
    /// What is made again and again.
    pub enum SweepKind {
        /// Breaks: the keys beside this table are those of a recipe.
        Break = "break",
        /// Simulations: they are those of a scene.
        Scene = "scene",
        /// Bending tests: they are those of `bend-test`, and `species`.
        BendTest = "bend-test",
    }
    /// How values between two bounds are drawn.
    pub enum Sampling {
        /// Each independently of all others.
        Random = "random",
        /// As Sobol' points, which fill the space between the bounds evenly.
        Sobol = "sobol",
    }
    /// What is written of each variant.
    pub enum PieceFormat {
        /// Binary glTF.
        Glb = "glb",
        /// glTF.
        Gltf = "gltf",
        /// Wavefront OBJ.
        Obj = "obj",
        /// PLY.
        Ply = "ply",
        /// STL.
        Stl = "stl",
        /// OFF.
        Off = "off",
        /// Nothing: the table only.
        None = "none",
    }
}

parameters! {
    /// What a sweep makes, how it draws and what it writes: the table `[sweep]`.
    pub struct SweepSettings {
        "Sweep", "sweep" {
            /// What is made of each variant.
            kind: SweepKind = SweepKind::Break, choice(SweepKind::CHOICES);
            /// The scene whose keys vary: one that comes with the program, or a file (.toml).
            scene: Option<String> = None, text(FILE_NAME).auto();
            /// The mesh that is simulated in place of the scene's stem.
            input: Option<String> = None, text(FILE_NAME).auto();
            /// Unit of length in that mesh, where its format has none.
            unit: Option<LengthUnit> = None, choice(LengthUnit::CHOICES).auto();
            /// How values between two bounds are drawn.
            sampling: Sampling = Sampling::Sobol, choice(Sampling::CHOICES);
            /// Samples of the drawn values, for each combination of the others.
            samples: u32 = 1, count(1, u32::MAX as i128).logarithmic();
            /// Seed of the drawn values.
            seed: u64 = 1, count(0, i64::MAX as i128);
            /// Format of the pieces of a break, or of what the last frame of a simulation shows; "auto" is glb for breaks, and
            /// none for simulations. Bending tests have no pieces.
            file: Option<PieceFormat> = None, choice(PieceFormat::CHOICES).auto();
            /// Whether the wood inside gets textures.
            textures: bool = true, flag();
            /// Variants that are shown on the contact sheet, evenly spread over all; 0 for none.
            sheet: u32 = 24, count(0, 400);
        }
    }
    check |p| {
        let scene_only = [
            ("scene", p.scene.is_some()),
            ("input", p.input.is_some()),
            ("unit", p.unit.is_some()),
        ];
        if let (Some((key, _)), true) = (scene_only.iter().find(|g| g.1), p.kind != SweepKind::Scene) {
            return Err(ParameterError::Conflict(format!(
                "{key} belongs to simulations, but kind is \"{}\"; expected kind = \"scene\" with it", p.kind.word()
            )));
        }
        match (p.kind, p.file) {
            (SweepKind::BendTest, Some(file)) if file != PieceFormat::None => {
                Err(ParameterError::Conflict(format!(
                    "file is \"{}\", but bending tests have no pieces; expected \"none\"", file.word()
                )))
            }
            _ => Ok(()),
        }
    };
}

impl SweepSettings {
    /// The format of the files of variants.
    pub fn piece_format(&self) -> PieceFormat {
        self.file.unwrap_or(match self.kind {
            SweepKind::Break => PieceFormat::Glb,
            SweepKind::Scene | SweepKind::BendTest => PieceFormat::None,
        })
    }
}

/// Many breaks, simulations or bending tests with parameters that vary.
#[derive(Debug, Clone)]
pub struct Sweep {
    /// What all variants have in common.
    pub base: Variant,
    /// How values are drawn and what is written.
    pub settings: SweepSettings,
    /// What varies, in the order of keys: the values of the last one change fastest.
    pub axes: Vec<Axis>,
    /// The folder that a relative input starts from.
    pub folder: PathBuf,
    count: u64,
}

impl Sweep {
    /// Reads a sweep: a recipe, or the keys of a scene or of a bending test, with the tables `[sweep]` and `[vary]` beside it.
    ///
    /// ```
    /// use greenstick_sweep::Sweep;
    ///
    /// let text = "
    ///     preset = 'brash'
    ///     texture_size = 64
    ///     [sweep]
    ///     samples = 10
    ///     [vary]
    ///     species = ['white oak', 'Norway spruce']
    ///     seed = { from = 1, to = 3 }
    ///     high.height = { between = [0.5, 2] }
    /// ";
    /// let sweep = Sweep::read(text, "".as_ref())?;
    /// assert_eq!(sweep.count(), 2 * 3 * 10);
    /// let recipe = sweep.variant(59)?.unwrap().to_toml();
    /// assert!(recipe.contains("seed = 3"));
    /// # Ok::<(), greenstick_sweep::SweepError>(())
    /// ```
    ///
    /// # Errors
    /// [`SweepError`]: what is wrong, with its line or key.
    pub fn read(text: &str, folder: &Path) -> Result<Self, SweepError> {
        let document =
            DeTable::parse(text).map_err(|e| RecipeError::from(syntax_error(text, &e)))?;
        let table = document.get_ref();
        let mut settings = SweepSettings::default();
        if let Some(DeValue::Table(table)) = table.get(SWEEP).map(|v| v.get_ref()) {
            read_table(&mut settings, table, text, &[]).map_err(RecipeError::from)?;
        }
        settings.check().map_err(RecipeError::from)?;
        let base = Variant::read(&settings, (table, text), [SWEEP, VARY], folder)?;
        let axes = axes(base.parameters(), text)?;
        let drawn = axes.iter().filter(|axis| axis.is_drawn()).count();
        if drawn > sobol::MAX_DIMENSIONS && settings.sampling == Sampling::Sobol {
            return Err(SweepError::Vary {
                key: axes[axes.len() - 1].info.key.clone(),
                problem: format!(
                    "{drawn} keys are drawn as Sobol' points; expected {} at most, or sampling = \"random\"",
                    sobol::MAX_DIMENSIONS
                ),
            });
        }
        let samples = if drawn > 0 {
            u64::from(settings.samples)
        } else {
            1
        };
        let count = axes
            .iter()
            .try_fold(samples, |n, axis| n.checked_mul(axis.count()));
        let count = count
            .filter(|n| *n <= MAX_VARIANTS)
            .ok_or(SweepError::TooMany { most: MAX_VARIANTS })?;
        Ok(Sweep {
            base,
            settings,
            axes,
            folder: folder.to_owned(),
            count,
        })
    }

    /// The number of variants.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// Returns the values of a variant, those of each axis.
    pub fn values(&self, number: u64) -> Vec<Value> {
        let combined: u64 = self.axes.iter().map(Axis::count).product();
        let samples = (self.count / combined).max(1);
        let sample = number % samples;
        let mut place = number / samples;
        let mut places: Vec<u64> = Vec::new();
        for axis in self.axes.iter().rev() {
            places.push(place % axis.count());
            place /= axis.count();
        }
        let mut dimension = 0;
        let axes = self.axes.iter().zip(places.into_iter().rev());
        axes.map(|(axis, place)| {
            let drawn = self.drawn((number, sample), dimension);
            dimension += usize::from(axis.is_drawn());
            axis.value(place, drawn)
        })
        .collect()
    }

    /// A number from 0 to below 1 for a variant, its sample and a dimension.
    fn drawn(&self, (number, sample): (u64, u64), dimension: usize) -> f64 {
        let seed = self.settings.seed;
        match self.settings.sampling {
            Sampling::Random => noise::unit(seed, DRAW, number as i64, dimension as i64),
            Sampling::Sobol => {
                // A digital shift: other seeds have other points, as evenly spread.
                let shift = noise::hash(seed, DRAW, 0, dimension as i64) as u32;
                let bits = sobol::coordinate(sample as u32, dimension) ^ shift;
                f64::from(bits) / 2.0_f64.powi(32)
            }
        }
    }

    /// Returns what decides a variant, or what is wrong with its values.
    ///
    /// # Errors
    /// [`SweepError::NoVariant`].
    pub fn variant(&self, number: u64) -> Result<Result<Variant, String>, SweepError> {
        if number >= self.count {
            return Err(SweepError::NoVariant {
                found: number,
                last: self.count - 1,
            });
        }
        let mut variant = self.base.clone();
        let set = self.axes.iter().zip(self.values(number));
        let set = set.map(|(axis, value)| variant.set(&axis.info.key, &value));
        let whole = set
            .collect::<Result<(), _>>()
            .map_err(|e| e.to_string())
            .and_then(|()| variant.complete());
        Ok(whole.map(|()| variant))
    }

    /// Whether the contact sheet shows a variant.
    pub fn is_shown(&self, number: u64) -> bool {
        let shown = u64::from(self.settings.sheet).min(self.count);
        // The first of each of as many equal parts.
        shown > 0 && (number * shown) % self.count < shown
    }

    /// Returns a hash of everything that decides the variants; not for security.
    pub fn hash(&self) -> String {
        let mut text = self.base.to_toml() + &write_toml(&self.settings);
        for axis in &self.axes {
            text += &format!("{} {:?}\n", axis.info.key, axis.values);
        }
        content_hash(&text)
    }

    /// Returns the files that the sweep names relative to its own.
    pub fn relative_files(&self) -> Vec<&str> {
        let recipe = match &self.base {
            Variant::Break(file) => file.input.as_deref(),
            Variant::Scene(_) | Variant::Bend(_) => None,
        };
        let scene = self.settings.scene.as_deref();
        let scene = scene.filter(|name| name.ends_with(".toml"));
        let named = [recipe, scene, self.settings.input.as_deref()];
        let named = named.into_iter().flatten();
        named.filter(|name| Path::new(name).is_relative()).collect()
    }

    /// Returns the path of the input of a variant, relative to the working directory.
    pub fn input_path(&self, variant: &Variant) -> Option<PathBuf> {
        let name = match variant {
            Variant::Break(file) => file.input.as_ref(),
            Variant::Scene(_) => self.settings.input.as_ref(),
            Variant::Bend(_) => None,
        };
        name.map(|name| self.folder.join(name))
    }
}

/// Reads what varies.
fn axes(base: &dyn Parameters, text: &str) -> Result<Vec<Axis>, SweepError> {
    let Ok(document) = toml::from_str::<toml::Table>(text) else {
        // Its syntax has been checked.
        return Ok(Vec::new());
    };
    let mut axes = Vec::new();
    if let Some(toml::Value::Table(table)) = document.get(VARY) {
        collect(base, "", table, &mut axes)?;
    }
    if let Some(twice) = (1..axes.len()).find(|&k| {
        let key = |axis: &Axis| axis.info.key.clone();
        axes[..k].iter().any(|axis| key(axis) == key(&axes[k]))
    }) {
        return Err(SweepError::Vary {
            key: axes[twice].info.key.clone(),
            problem: "it varies twice; expected each key once".to_owned(),
        });
    }
    Ok(axes)
}

/// Reads the keys of a table: `high.height = […]` is a table in a table.
fn collect(
    base: &dyn Parameters,
    prefix: &str,
    table: &toml::Table,
    axes: &mut Vec<Axis>,
) -> Result<(), SweepError> {
    for (key, value) in table {
        let key = format!("{prefix}{key}");
        match value {
            toml::Value::Table(inner)
                if !inner.contains_key("from")
                    && !inner.contains_key("to")
                    && !inner.contains_key("between") =>
            {
                collect(base, &format!("{key}."), inner, axes)?;
            }
            _ => axes.push(Axis::read(base, &key, value)?),
        }
    }
    Ok(())
}
