//! A scene on a stem of another length than it was written for.

use super::{KeyFrame, Length, Lengths, MotionWord, Scene};

impl Scene {
    /// The scene for a stem of `length` (m): what `for_length` says is as much longer as the stem is. A scene that does not say
    /// for which length it is stays as it is.
    pub fn for_stem(&self, length: f64) -> Scene {
        let mut scene = self.clone();
        let Some(Length(written)) = self.for_length else {
            return scene;
        };
        let by = length / written;
        let longer = |l: &mut Length| l.0 *= by;
        let all = |v: &mut [f64; 3]| v.iter_mut().for_each(|x| *x *= by);
        let keys = |keys: &mut Vec<KeyFrame>| {
            let ways = keys.iter_mut().map(|k| &mut k.move_by);
            ways.for_each(|Lengths(way)| all(way));
        };
        scene.rods.edge.iter_mut().for_each(longer);
        scene.rods.spacing.iter_mut().for_each(longer);
        for clamp in &mut scene.clamp {
            all(&mut clamp.velocity);
            keys(&mut clamp.key);
        }
        for body in &mut scene.body {
            all(&mut body.size.0);
            all(&mut body.place.0);
            longer(&mut body.diameter);
            longer(&mut body.gap);
            keys(&mut body.key);
            // What flies has the velocity that it was given.
            if body.motion == MotionWord::Given {
                all(&mut body.velocity);
            }
        }
        // So that it stays as it is on this stem.
        scene.for_length = Some(Length(length));
        scene
    }
}
