//! Sweeps: which variants there are. Every variant follows from its number alone.

use crate::axis::Axis;
use crate::error::SweepError;
use crate::forest::{Forest, ForestRequest};
use crate::sobol;
use crate::variant::Variant;
use greenstick::formats::LengthUnit;
use greenstick::fracture::recipe::RecipeError;
use greenstick::schema::{
    FILE_NAME, Format, ParameterError, Parameters, Unit, Value, choice, choices, content_hash,
    count, flag, number, parameters, read_table, syntax_error, text, write_toml,
};
use greenstick::wood::noise;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use toml::de::{DeTable, DeValue};

/// Most variants of a sweep: those that are done are kept in memory, a bit each.
pub const MAX_VARIANTS: u64 = 1 << 30;
/// The tables of a sweep that no recipe has.
const SWEEP: &str = "sweep";
const VARY: &str = "vary";
/// Names of nodes, as patterns.
const NAMES: Format = Format {
    name: "NAMES",
    check: |names| match names.split(',').all(|name| name.trim().is_empty()) {
        true => Err("it has no name; expected names such as \"Tree_*\"".to_owned()),
        false => Ok(()),
    },
};
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
        /// Breaks of the trees of one scene, each of which is a variant: they are those of a recipe.
        Forest = "forest",
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
            /// The mesh that is simulated in place of the scene's stem, or the scene whose trees break.
            input: Option<String> = None, text(FILE_NAME).auto();
            /// Unit of length in it, where its format has none.
            unit: Option<LengthUnit> = None, choice(LengthUnit::CHOICES).auto();
            /// Names of the nodes of a forest that are trees: `*` stands for any letters, `?` for one, and commas between several;
            /// "auto" is `Tree_*`. What a node carries belongs to its tree.
            nodes: Option<String> = None, text(NAMES).auto();
            /// Names, likewise, of the trees of a forest that may break; "auto" is all.
            only: Option<String> = None, text(NAMES).auto();
            /// Share of these that break, drawn by the seed below; "auto" is 1.
            share: Option<f64> = None, number(Unit::Fraction, 0.0, 1.0).auto();
            /// How values between two bounds are drawn.
            sampling: Sampling = Sampling::Sobol, choice(Sampling::CHOICES);
            /// Samples of the drawn values, for each combination of the others. Each tree of a forest is a sample.
            samples: u32 = 1, count(1, u32::MAX as i128).logarithmic();
            /// Seed of the drawn values.
            seed: u64 = 1, count(0, i64::MAX as i128);
            /// Format of the pieces of a break, or of what the last frame of a simulation shows; "auto" is glb for breaks, and
            /// none for simulations. Bending tests have no pieces. Of a forest, format of the scene: glb, gltf or none.
            file: Option<PieceFormat> = None, choice(PieceFormat::CHOICES).auto();
            /// Whether the wood inside gets textures. Where no file is written it gets none.
            textures: bool = true, flag();
            /// Variants that are shown on the contact sheet, evenly spread over all; 0 for none.
            sheet: u32 = 24, count(0, 400);
        }
    }
    check |p| {
        check_kind(p)
    };
}

/// Checks that nothing belongs to another kind of sweep.
fn check_kind(p: &SweepSettings) -> Result<(), ParameterError> {
    use SweepKind::{Forest, Scene};
    let forest = "forests, but kind is \"{}\"; expected kind = \"forest\" with it";
    let both = "simulations and forests, but kind is \"{}\"; expected kind = \"scene\" or \"forest\" with it";
    let scene = "simulations, but kind is \"{}\"; expected kind = \"scene\" with it";
    let belonging: [(&str, bool, &[SweepKind], &str); 6] = [
        ("scene", p.scene.is_some(), &[Scene], scene),
        ("input", p.input.is_some(), &[Scene, Forest], both),
        ("unit", p.unit.is_some(), &[Scene, Forest], both),
        ("nodes", p.nodes.is_some(), &[Forest], forest),
        ("only", p.only.is_some(), &[Forest], forest),
        ("share", p.share.is_some(), &[Forest], forest),
    ];
    for (key, given, kinds, what) in belonging {
        if given && !kinds.contains(&p.kind) {
            let what = what.replace("{}", p.kind.word());
            return Err(ParameterError::Conflict(format!("{key} belongs to {what}")));
        }
    }
    if p.kind == Forest && p.samples != 1 {
        return Err(ParameterError::Conflict(format!(
            "samples is {}, but every tree of a forest is a sample; expected no samples with kind = \"forest\"",
            p.samples
        )));
    }
    let found = p.file.map_or("", PieceFormat::word);
    match (p.kind, p.file) {
        (SweepKind::BendTest, Some(file)) if file != PieceFormat::None => {
            Err(ParameterError::Conflict(format!(
                "file is \"{found}\", but bending tests have no pieces; expected \"none\""
            )))
        }
        (Forest, Some(_)) if !["glb", "gltf", "none"].contains(&found) => {
            Err(ParameterError::Conflict(format!(
                "file is \"{found}\", which keeps no instances; expected \"glb\", \"gltf\" or \"none\" for a forest"
            )))
        }
        _ => Ok(()),
    }
}

impl SweepSettings {
    /// The format of the files of variants.
    pub fn piece_format(&self) -> PieceFormat {
        match (self.kind, self.file) {
            (_, Some(PieceFormat::None)) => PieceFormat::None,
            // Pieces of trees wait in it for the scene that they become part of.
            (SweepKind::Forest, _) => PieceFormat::Glb,
            (SweepKind::Break, None) => PieceFormat::Glb,
            (SweepKind::Scene | SweepKind::BendTest, None) => PieceFormat::None,
            (_, Some(format)) => format,
        }
    }

    /// Whether textures are baked: only where pieces are written to files.
    pub(crate) fn bakes_textures(&self) -> bool {
        self.textures && self.piece_format() != PieceFormat::None
    }

    /// The ending of the scene of a forest; `None` where none is written.
    pub(crate) fn scene_ending(&self) -> Option<&'static str> {
        let format = self.file.unwrap_or(PieceFormat::Glb);
        (self.kind == SweepKind::Forest && format != PieceFormat::None).then(|| format.word())
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
    /// The trees that are the variants of a forest.
    pub(crate) forest: Option<Arc<Forest>>,
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
        let is_forest = settings.kind == SweepKind::Forest;
        let drawn = axes.iter().filter(|axis| is_forest || axis.is_drawn());
        let drawn = drawn.count();
        if drawn > sobol::MAX_DIMENSIONS && settings.sampling == Sampling::Sobol {
            return Err(SweepError::Vary {
                key: axes[axes.len() - 1].info.key.clone(),
                problem: format!(
                    "{drawn} keys are drawn as Sobol' points; expected {} at most, or sampling = \"random\"",
                    sobol::MAX_DIMENSIONS
                ),
            });
        }
        let forest = match is_forest {
            true => Some(Arc::new(load_forest(&settings, folder)?)),
            false => None,
        };
        let count = match (&forest, drawn) {
            (Some(forest), _) => Some(forest.trees().len() as u64),
            (None, 0) => combinations(1, &axes),
            (None, _) => combinations(u64::from(settings.samples), &axes),
        };
        let count = count
            .filter(|n| *n <= MAX_VARIANTS)
            .ok_or(SweepError::TooMany { most: MAX_VARIANTS })?;
        Ok(Sweep {
            base,
            settings,
            axes,
            folder: folder.to_owned(),
            forest,
            count,
        })
    }

    /// The trees that are the variants of a forest.
    pub fn forest(&self) -> Option<&Forest> {
        self.forest.as_deref()
    }

    /// The number of variants.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// Returns the values of a variant, those of each axis.
    pub fn values(&self, number: u64) -> Vec<Value> {
        if self.forest.is_some() {
            return self.values_of_tree(number);
        }
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

    /// Returns the values of a tree: all are drawn, listed ones from their lists.
    fn values_of_tree(&self, number: u64) -> Vec<Value> {
        let axes = self.axes.iter().enumerate();
        axes.map(|(dimension, axis)| {
            let drawn = self.drawn((number, number), dimension);
            axis.value((drawn * axis.count() as f64) as u64, drawn)
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
        if let Some(forest) = &self.forest {
            let (key, base) = variant.seed();
            let seed = Value::Integer(forest.seed(base, number).into());
            if let Err(error) = variant.set(key, &seed) {
                return Ok(Err(error.to_string()));
            }
        }
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
        let (place, count) = match self.forest() {
            // Of a forest, trees that break.
            Some(forest) => match forest.place_among_breaking(number) {
                Some(place) => (place, forest.breaking()),
                None => return false,
            },
            None => (number, self.count),
        };
        let shown = u64::from(self.settings.sheet).min(count);
        // The first of each of as many equal parts.
        shown > 0 && (place * shown) % count < shown
    }

    /// The variants that the contact sheet shows, at most as many as are wanted, evenly spread over all.
    pub fn shown(&self) -> Vec<u64> {
        if self.forest.is_some() {
            return (0..self.count).filter(|n| self.is_shown(*n)).collect();
        }
        let shown = u64::from(self.settings.sheet).min(self.count);
        let first = |part: u64| (part * self.count).div_ceil(shown);
        (0..shown).map(first).collect()
    }

    /// Returns a hash of everything that decides the variants; not for security.
    pub fn hash(&self) -> String {
        let mut text = self.base.to_toml() + &write_toml(&self.settings);
        for axis in &self.axes {
            text += &format!("{} {:?}\n", axis.info.key, axis.values);
        }
        for tree in self.forest.iter().flat_map(|forest| forest.trees()) {
            text += &format!("{:?} {}\n", tree.name, tree.breaks);
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
            Variant::Break(_) if self.forest.is_some() => self.settings.input.as_ref(),
            Variant::Break(file) => file.input.as_ref(),
            Variant::Scene(_) => self.settings.input.as_ref(),
            Variant::Bend(_) => None,
        };
        name.map(|name| self.folder.join(name))
    }
}

/// Reads the forest that the settings name.
fn load_forest(settings: &SweepSettings, folder: &Path) -> Result<Forest, SweepError> {
    let Some(name) = &settings.input else {
        return Err(SweepError::Forest {
            path: None,
            problem: "no scene is named; expected input = \"forest.glb\" in [sweep]".to_owned(),
        });
    };
    Forest::load(&ForestRequest {
        path: &folder.join(name),
        unit: settings.unit,
        nodes: settings.nodes.as_deref(),
        only: settings.only.as_deref(),
        share: settings.share.unwrap_or(1.0),
        seed: settings.seed,
    })
}

/// How many combinations there are, each so often; `None` where 64 bits do not hold it.
fn combinations(each: u64, axes: &[Axis]) -> Option<u64> {
    let mut counts = axes.iter().map(Axis::count);
    counts.try_fold(each, |all, count| all.checked_mul(count))
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
