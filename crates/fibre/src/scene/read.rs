//! Reads a scene's TOML; errors have the line of what is wrong.

use super::arc;
use super::declare::{Declared, KeyInfo};
use super::error::SceneError;
use super::keys::{MotionChoice, Scene, SolverChoice};
use greenstick_schema::closest_names;
use toml::de::{DeTable, DeValue};

fn line(text: &str, at: usize) -> usize {
    text.get(..at).unwrap_or(text).matches('\n').count() + 1
}

impl Scene {
    /// Reads a scene. Keys that it does not have are as in [`Scene::default`].
    ///
    /// # Errors
    /// [`SceneError`] with the line of what is wrong.
    pub fn read(text: &str) -> Result<Scene, SceneError> {
        let document = DeTable::parse(text).map_err(|e| SceneError::Syntax {
            line: line(text, e.span().unwrap_or(0..0).start),
            message: e.message().replace('\n', ", "),
        })?;
        let keys = Scene::reference();
        check_keys(text, document.get_ref(), "", &keys)?;
        let scene: Scene = toml::from_str(text).map_err(|e| SceneError::Syntax {
            line: line(text, e.span().unwrap_or(0..0).start),
            message: e.message().replace('\n', ", "),
        })?;
        scene.check()?;
        Ok(scene)
    }

    /// Returns the scene as TOML, with all keys.
    pub fn to_toml(&self) -> String {
        toml::to_string(self).unwrap_or_default()
    }

    /// Checks that the scene's solver can run the scene.
    fn check_solver(&self) -> Result<(), SceneError> {
        let refuse = |problem: String, right| {
            let solver = self.solver.name();
            Err(SceneError::Solver {
                solver,
                problem,
                right,
            })
        };
        let free = self
            .body
            .iter()
            .position(|b| b.motion == MotionChoice::Free);
        if let (Some(body), true) = (free, self.solver != SolverChoice::Explicit) {
            let problem = format!(
                "body {body} moves freely, and its impacts need steps as short as the impacts"
            );
            return refuse(problem, "explicit");
        }
        if self.solver != SolverChoice::QuasiStatic {
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

    /// Checks every range, and the relations between keys.
    ///
    /// # Errors
    /// [`SceneError::Value`] for the first value that is wrong, [`SceneError::Solver`] where the solver cannot run the scene.
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
        arc::check(&self.clamp)?;
        self.check_solver()
    }
}

/// Refuses keys that do not exist.
fn check_keys(text: &str, table: &DeTable, name: &str, keys: &[KeyInfo]) -> Result<(), SceneError> {
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
            DeValue::Table(t) => check_keys(text, t, &inside, keys)?,
            DeValue::Array(entries) => {
                for entry in entries {
                    if let DeValue::Table(t) = entry.get_ref() {
                        check_keys(text, t, &inside, keys)?;
                    }
                }
            }
            // The TOML reader reports what is wrong with it.
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
