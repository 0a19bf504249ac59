//! Reading a scene's TOML, with the line of whatever is wrong.

use super::{Declared, KeyInfo, MotionWord, Scene, SolverWord};
use crate::bodies::BodyError;
use crate::error::LoadError;
use greenstick_schema::{closest_names, did_you_mean};
use toml::de::{DeTable, DeValue};

/// Why a scene cannot be used.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SceneError {
    /// Not TOML, or a value of the wrong kind.
    #[error("line {line}: {message}")]
    Syntax {
        /// Line, from 1.
        line: usize,
        /// What is wrong.
        message: String,
    },
    /// A key that no scene has.
    #[error(
        "line {line}: unknown key \"{key}\"{}{}",
        in_table(table),
        did_you_mean(nearest)
    )]
    UnknownKey {
        /// Line, from 1.
        line: usize,
        /// The key.
        key: String,
        /// The table that it stands in.
        table: String,
        /// Keys that look like it.
        nearest: Vec<String>,
    },
    /// A number out of range.
    #[error("{key} is {value}, but it must be {right}")]
    Value {
        /// The key with its table.
        key: String,
        /// The value found.
        value: f64,
        /// What would be right.
        right: String,
    },
    /// No scene of this name.
    #[error("there is no scene \"{name}\"{}", did_you_mean(nearest))]
    UnknownScene {
        /// The name.
        name: String,
        /// Names that look like it.
        nearest: Vec<String>,
    },
    /// A clamp that holds nothing.
    #[error(
        "clamp {clamp} holds nothing: no vertex lies from {from} to {to} of the length; vertices are up to {apart} apart there"
    )]
    EmptyClamp {
        /// Number of the clamp, from 0.
        clamp: usize,
        /// From where.
        from: f64,
        /// To where.
        to: f64,
        /// Distance between vertices, of the length.
        apart: f64,
    },
    /// Key frames out of order.
    #[error("key frames of {what} must follow each other in time; {time} s does not")]
    Keys {
        /// Of what.
        what: String,
        /// The time that does not.
        time: f64,
    },
    /// A clamp that cannot keep the wood's length.
    #[error("clamp {clamp} has arc = true: {problem}")]
    Arc {
        /// Number of the clamp, from 0.
        clamp: usize,
        /// Why it cannot.
        problem: String,
    },
    /// A body that passes the stem by.
    #[error(
        "body {body} never touches the stem when it comes from ({x}, {y}, {z}); change `touch`, `at` or `place`"
    )]
    Misses {
        /// Number of the body.
        body: usize,
        /// Direction.
        x: f64,
        /// Direction.
        y: f64,
        /// Direction.
        z: f64,
    },
    /// A body whose mesh was not given.
    #[error("body {body} is a {shape}, which needs the name of a mesh file: file = \"block.stl\"")]
    NoMesh {
        /// Number of the body.
        body: usize,
        /// Which shape.
        shape: &'static str,
    },
    /// A word that is none of those that may stand there.
    #[error("{key} is \"{found}\", but it must be {right}")]
    Word {
        /// The key.
        key: String,
        /// What was found.
        found: String,
        /// What would be right.
        right: &'static str,
    },
    /// A solver that cannot do what the scene asks.
    #[error("the {solver} solver cannot be used here: {problem}; choose {right}")]
    Solver {
        /// The solver.
        solver: &'static str,
        /// Why not.
        problem: String,
        /// What would be right.
        right: &'static str,
    },
    /// A body does not fit.
    #[error(transparent)]
    Body(#[from] BodyError),
    /// A load does not fit.
    #[error(transparent)]
    Load(#[from] LoadError),
}

fn in_table(table: &str) -> String {
    if table.is_empty() {
        String::new()
    } else {
        format!(" in [{table}]")
    }
}

fn line(text: &str, at: usize) -> usize {
    text.get(..at).unwrap_or(text).matches('\n').count() + 1
}

impl Scene {
    /// Reads a scene; what it does not say is as in [`Scene::default`].
    ///
    /// # Errors
    /// [`SceneError`] with the line of what is wrong.
    pub fn read(text: &str) -> Result<Scene, SceneError> {
        let document = DeTable::parse(text).map_err(|e| SceneError::Syntax {
            line: line(text, e.span().unwrap_or(0..0).start),
            message: e.message().replace('\n', ", "),
        })?;
        let keys = Scene::reference();
        known(text, document.get_ref(), "", &keys)?;
        let scene: Scene = toml::from_str(text).map_err(|e| SceneError::Syntax {
            line: line(text, e.span().unwrap_or(0..0).start),
            message: e.message().replace('\n', ", "),
        })?;
        scene.check()?;
        Ok(scene)
    }

    /// The scene as TOML, all keys written out.
    pub fn to_toml(&self) -> String {
        toml::to_string(self).unwrap_or_default()
    }

    /// Whether the scene's solver can do what the scene asks.
    fn check_solver(&self) -> Result<(), SceneError> {
        let refuse = |problem: String, right| {
            let solver = self.solver.name();
            Err(SceneError::Solver {
                solver,
                problem,
                right,
            })
        };
        let free = self.body.iter().position(|b| b.motion == MotionWord::Free);
        if let (Some(body), true) = (free, self.solver != SolverWord::Explicit) {
            let problem = format!(
                "body {body} moves freely, and its impacts need steps as short as they are"
            );
            return refuse(problem, "explicit");
        }
        if self.solver != SolverWord::QuasiStatic {
            return Ok(());
        }
        let others = "explicit, implicit or interactive";
        if self.start.velocity != [0.0; 3] {
            return refuse(
                "it has no inertia, and start.velocity is not 0".into(),
                others,
            );
        }
        if !self
            .clamp
            .iter()
            .any(|c| "xyz".chars().all(|a| c.axes.contains(a)))
        {
            let problem = "it has no inertia, and no clamp holds the wood in x, y and z";
            return refuse(problem.into(), others);
        }
        Ok(())
    }

    /// Checks every range, and what holds between keys.
    ///
    /// # Errors
    /// [`SceneError::Value`] for the first that is wrong, [`SceneError::Solver`] where the solver cannot do it.
    pub fn check(&self) -> Result<(), SceneError> {
        if let Some((k, value)) = self.out_of_range("") {
            let right = match (k.range, k.unit) {
                ((a, b), "") => format!("from {a} to {b}"),
                ((a, b), unit) => format!("from {a} to {b} {unit}"),
            };
            let key = if k.table.is_empty() {
                k.key
            } else {
                format!("{}.{}", k.table, k.key)
            };
            return Err(SceneError::Value { key, value, right });
        }
        let ordered = [
            ("rods.edge", self.rods.edge.map(|l| l.0)),
            ("stem.part", self.stem.part),
        ];
        for (key, [from, to]) in ordered {
            if from > to || (key == "stem.part" && from == to) {
                return Err(SceneError::Value {
                    key: key.into(),
                    value: from,
                    right: format!("below the second number, {to}"),
                });
            }
        }
        super::arc::check(&self.clamp)?;
        self.check_solver()
    }
}

/// Refuses keys that are not in the reference.
fn known(text: &str, table: &DeTable, name: &str, keys: &[KeyInfo]) -> Result<(), SceneError> {
    let own = || keys.iter().filter(|k| k.table == name);
    let inner = |key: &str| {
        let list = format!("[{key}]");
        keys.iter()
            .map(|k| &k.table)
            .find(|t| *t == key || **t == list)
            .filter(|t| may_hold(name, t))
            .cloned()
    };
    for (key, value) in table {
        let word: &str = key.get_ref();
        if own().any(|k| k.key == word) {
            continue;
        }
        let Some(inside) = inner(word) else {
            let tables = keys
                .iter()
                .filter(|k| may_hold(name, &k.table))
                .map(|k| k.table.trim_matches(['[', ']']));
            let mut names: Vec<&str> = own().map(|k| k.key.as_str()).chain(tables).collect();
            names.dedup();
            return Err(SceneError::UnknownKey {
                line: line(text, key.span().start),
                key: word.to_owned(),
                table: name.trim_matches(['[', ']']).to_owned(),
                nearest: closest_names(word, names),
            });
        };
        match value.get_ref() {
            DeValue::Table(t) => known(text, t, &inside, keys)?,
            DeValue::Array(entries) => {
                for entry in entries {
                    if let DeValue::Table(t) = entry.get_ref() {
                        known(text, t, &inside, keys)?;
                    }
                }
            }
            // The reader says what is wrong with it.
            _ => {}
        }
    }
    Ok(())
}

/// Whether a table may stand in another: key frames in clamps and bodies, all others at the top.
fn may_hold(outer: &str, inner: &str) -> bool {
    match inner {
        "" => false,
        "[key]" => outer == "[clamp]" || outer == "[body]",
        _ => outer.is_empty(),
    }
}
