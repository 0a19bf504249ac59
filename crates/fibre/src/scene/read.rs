//! Reads, writes and checks scenes.

use super::arc;
use super::choices::{MotionChoice, SolverChoice};
use super::error::SceneError;
use super::former_keys::FormerKeys;
use super::held_axes::HeldAxes;
use super::keys::Scene;
use greenstick_schema::{Parameters, read_toml_with_former_keys, write_toml};

impl Scene {
    /// Reads a scene. Keys that it does not have are as in [`Scene::default`]; those of version 0.1.0 are translated.
    ///
    /// # Errors
    /// [`SceneError`] with the line and column of what is wrong.
    pub fn read(text: &str) -> Result<Scene, SceneError> {
        let mut scene = Scene::default();
        let mut former = FormerKeys::default();
        read_toml_with_former_keys(&mut scene, &mut former, text)?;
        former.translate(&mut scene);
        scene.check_use()?;
        Ok(scene)
    }

    /// Returns the scene as TOML, with all keys.
    pub fn to_toml(&self) -> String {
        write_toml(self)
    }

    /// Checks every range, and the relations between keys.
    ///
    /// # Errors
    /// [`SceneError::Parameter`] for the first value that is wrong, [`SceneError::Arc`] for a clamp that cannot preserve the
    /// wood's length, [`SceneError::Solver`] where the solver cannot run the scene.
    pub fn check(&self) -> Result<(), SceneError> {
        Parameters::check(self)?;
        self.check_use()
    }

    /// Checks that clamps and solver can do what the scene asks of them.
    fn check_use(&self) -> Result<(), SceneError> {
        arc::check(&self.clamp)?;
        self.check_solver()
    }

    /// Checks that the scene's solver can run the scene.
    fn check_solver(&self) -> Result<(), SceneError> {
        let refuse = |problem: String, right| {
            let solver = self.solver.word();
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
        if !self.clamp.iter().any(|c| c.axes == HeldAxes::ALL) {
            let problem = "it has no inertia, and no clamp holds the wood in x, y and z";
            return refuse(problem.into(), others);
        }
        Ok(())
    }
}
