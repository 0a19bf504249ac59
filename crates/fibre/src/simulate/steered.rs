//! Whether a run can go on with other key frames of its clamps: from its last checkpoint on, and no earlier.

use super::prepare::hash;
use crate::scene::{AssembledScene, KeyFrame, Scene};
use crate::store::Checkpoint;

/// Whether `next` is the scene of a run (`before`, whose last checkpoint is given) but for what its clamps do after the checkpoint, and
/// for how long it lasts; `assembled` is the next scene at its start.
///
/// The motion between two key frames follows from these two alone, so that a run which goes on like this has the states of one
/// that had the key frames from the start, bit for bit.
pub(super) fn is_steered(
    checkpoint: &Checkpoint,
    before: &Scene,
    next: &Scene,
    assembled: &AssembledScene,
) -> bool {
    let time = checkpoint.world.state.time;
    hash(before, assembled) == checkpoint.hash && scenes_agree_until(before, next, time)
}

/// Whether two scenes are the same but for what their clamps do after a time, s, and for how long they last: a run of the one can then go
/// on from its checkpoint at that time as one of the other.
pub fn scenes_agree_until(before: &Scene, next: &Scene, time: f64) -> bool {
    let mut clamps = (before.clamp.iter()).zip(&next.clamp);
    // What moves on an arc moves otherwise from the start where any key frame does.
    if clamps.clone().any(|(b, _)| b.arc) {
        return false;
    }
    let mut same_keys = next.clone();
    same_keys.duration = before.duration;
    for (to, from) in same_keys.clamp.iter_mut().zip(&before.clamp) {
        to.key.clone_from(&from.key);
    }
    same_keys == *before && clamps.all(|(b, n)| keys_agree_until(&b.key, &n.key, time))
}

/// Whether two lists of key frames mean the same motion until a time, s, bit for bit.
fn keys_agree_until(a: &[KeyFrame], b: &[KeyFrame], time: f64) -> bool {
    if a.is_empty() || b.is_empty() {
        return a == b;
    }
    let [m, n] = [a, b].map(|keys| keys.partition_point(|key| key.time <= time));
    if a[..m] != b[..n] {
        return false;
    }
    let is_at_key = m > 0 && a[m - 1].time == time;
    is_at_key || a.get(m) == b.get(n)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_agree_until_the_end_of_the_interval_that_holds_the_time() {
        let key = |time: f64, x: f64| KeyFrame {
            time,
            move_by: [x, 0.0, 0.0],
            ..KeyFrame::default()
        };
        let old = [key(0.0, 0.0), key(0.1, 1.0), key(0.2, 2.0)];
        let new = [key(0.0, 0.0), key(0.1, 1.0), key(0.2, -2.0), key(0.4, 0.0)];
        let agree = |time| keys_agree_until(&old, &new, time);
        assert!(agree(0.0) && agree(0.05) && agree(0.1));
        // The interval to the third key has begun.
        assert!(!agree(0.11) && !agree(0.2) && !agree(0.3));
        assert!(keys_agree_until(&old, &old, 0.9));
        assert!(keys_agree_until(&old[..2], &old, 0.1));
        assert!(!keys_agree_until(&old[..2], &old, 0.15));
        assert!(keys_agree_until(&[], &[], 0.5) && !keys_agree_until(&[], &old, 0.0));
    }
}
