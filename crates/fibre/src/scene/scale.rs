//! Scenes on stems of another length than they were written for.

use super::choices::MotionChoice;
use super::keys::{KeyFrame, Scene};

impl Scene {
    /// Returns the scene scaled to a stem of `length` (m), as the key `for_length` documents. A scene without that key stays as it
    /// is.
    pub fn for_stem(&self, length: f64) -> Scene {
        let mut scene = self.clone();
        let Some(written) = self.for_length else {
            return scene;
        };
        let factor = length / written;
        let scale = |l: &mut f64| *l *= factor;
        let scale_vector = |v: &mut [f64; 3]| v.iter_mut().for_each(|x| *x *= factor);
        let scale_keys = |keys: &mut Vec<KeyFrame>| {
            let displacements = keys.iter_mut().map(|k| &mut k.move_by);
            displacements.for_each(scale_vector);
        };
        scene.rods.edge.iter_mut().for_each(scale);
        scene.rods.spacing.iter_mut().for_each(scale);
        for clamp in &mut scene.clamp {
            scale_vector(&mut clamp.velocity);
            scale_keys(&mut clamp.key);
        }
        for body in &mut scene.body {
            scale_vector(&mut body.size);
            scale_vector(&mut body.place);
            scale(&mut body.diameter);
            scale(&mut body.gap);
            scale_keys(&mut body.key);
            // The velocity of a free body stays as given.
            if body.motion == MotionChoice::Given {
                scale_vector(&mut body.velocity);
            }
        }
        // Scaling the result to the same stem changes nothing.
        scene.for_length = Some(length);
        scene
    }
}
