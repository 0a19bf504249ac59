//! A hand that pulls on the wood: where along a stem it can take hold, how far it can pull, and what that is in a scene.
//!
//! A hand is a short clamp with a key frame for each frame of its way, so that what is steered elsewhere while the run goes on has moved
//! as before until then. Pulled across, it holds the wood across the stem alone and slides along it: held
//! along as well, a bent stem would be stretched or crushed between the hand and what holds it. At a free end it is turned as the
//! end of a cantilever turns under a force there: by one and a half times the deflection over the length (Timoshenko and Goodier,
//! *Theory of Elasticity*, § 21).

use super::holds::{Hold, HoldPart, Moved, Steered};
use greenstick::fibre::scene::{
    ClampKeys, HeldAxes, KeyFrame, Scene as Setting, SolverChoice, StemChoice,
};

/// Half of the length of a hand, as a part of the stem: with less, a scene's longest edges may leave it without a vertex.
const HALF: f64 = 0.03;
/// Least length of free wood between a hand and a clamp, as a part of the stem.
const LEAST_LEVER: f64 = 0.1;
/// How far a hand pulls across, as a part of the wood between it and what holds the stem: farther, that wood would not reach.
const FARTHEST: f64 = 0.8;
/// How far it pulls along, as a part of the same wood: wood tears at a strain of one or two hundredths.
const FARTHEST_ALONG: f64 = 0.2;
/// The shortest time that a hand which is steered takes, as a part of the longest: what is moved sooner is hit.
const SHORTEST_WAY: f64 = 0.2;
/// The end of a cantilever turns by this, times its deflection over its length.
const CANTILEVER: f64 = 1.5;
/// Greatest angle by which a hand turns, rad.
const GREATEST_TURN: f64 = std::f64::consts::FRAC_PI_2;
/// Pulls less than this part of the stem's length are none: a click, or a hand that trembled.
pub const LEAST_PULL: f64 = 0.01;

/// The scene of wood that is pulled on by hand: a stem that is held at its base.
pub const BY_HAND: &str = r#"
about = "a stem that is held at its base is pulled on by hand"
duration = 1.0
frames_per_second = 25.0
for_length = "40 cm"
solver = "interactive"

[stem]
kind = "branch"
length = "40 cm"
diameter = "2 cm"

[failure]
every = 8

[rods]
number = 40
edge = ["10 mm", "14 mm"]
weibull = 12.0

[loads]
damping = 5.0

[[clamp]]
to = 0.08
"#;

/// A place along the stem where a hand takes hold.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Grip {
    /// Where it is, as a fraction of the stem.
    pub at: f64,
    /// The end of the wood that is held, on the side from which the hand bends it; none where no clamp holds any.
    pub root: Option<f64>,
    /// Whether the stem is free beyond the hand.
    pub is_free: bool,
}

impl Grip {
    /// The wood between the hand and what holds the stem, as a part of the stem.
    fn lever(&self) -> f64 {
        self.root.map_or(0.5, |root| (self.at - root).abs())
    }

    /// How far the hand pulls where it is dragged this far, in parts of the stem's length along the axes of the scene: along the stem or
    /// across it, whichever is more, and no farther than wood reaches.
    pub fn pull(&self, dragged: [f64; 3]) -> [f64; 3] {
        let [x, y, z] = dragged;
        let across = y.hypot(z);
        if x.abs() > across {
            let most = FARTHEST_ALONG * self.lever();
            return [round(x.clamp(-most, most)), 0.0, 0.0];
        }
        let most = FARTHEST * self.lever();
        let factor = if across > most { most / across } else { 1.0 };
        [0.0, round(y * factor), round(z * factor)]
    }

    /// How far the hand turns with a pull: a rotation vector along the axes of the scene, rad.
    pub fn turn(&self, [_, y, z]: [f64; 3]) -> [f64; 3] {
        let (Some(root), true) = (self.root, self.is_free) else {
            return [0.0; 3];
        };
        let across = y.hypot(z);
        if across == 0.0 {
            return [0.0; 3];
        }
        let angle = (CANTILEVER * across / self.lever()).min(GREATEST_TURN);
        let angle = angle * (self.at - root).signum();
        // x × (0, y, z), of unit length.
        [0.0, -z / across * angle, y / across * angle]
    }

    /// How far along the way of the hand the wood at `at` goes, as a cantilever's does; none beyond the wood that is bent.
    pub fn share(&self, at: f64) -> Option<f64> {
        let root = self.root?;
        let s = (at - root) / (self.at - root);
        (0.0..=1.0).contains(&s).then_some(0.5 * s * s * (3.0 - s))
    }
}

/// Nobody drags more exactly than to this part of the stem's length.
fn round(x: f64) -> f64 {
    // −0 becomes 0.
    (x * 1e4).round() / 1e4 + 0.0
}

/// Nine digits: finer than any step of a solver needs, and files can be read.
fn fine(x: f64) -> f64 {
    (x * 1e9).round() / 1e9 + 0.0
}

/// Where a hand takes hold near a fraction of a stem that clamps hold from one fraction to another.
///
/// # Errors
/// Why it cannot, and what to do.
fn grip(clamps: &[[f64; 2]], at: f64) -> Result<Grip, String> {
    let at = (at.clamp(HALF, 1.0 - HALF) * 1e3).round() / 1e3;
    let lever = |c: &[f64; 2]| (c[0] - at).max(at - c[1]);
    if clamps.iter().any(|c| lever(c) < LEAST_LEVER) {
        return Err("The wood is held here: take hold of it farther from the clamp.".to_owned());
    }
    let below = clamps.iter().map(|c| c[1]).filter(|to| *to < at);
    let below = below.max_by(f64::total_cmp);
    let above = clamps.iter().map(|c| c[0]).filter(|from| *from > at);
    let above = above.min_by(f64::total_cmp);
    let root = match (below, above) {
        (Some(b), Some(a)) if a - at < at - b => Some(a),
        (below, above) => below.or(above),
    };
    let is_free = below.is_some() != above.is_some();
    Ok(Grip { at, root, is_free })
}

/// Where a hand takes hold near a fraction of a stem with these holds.
///
/// # Errors
/// Why it cannot, and what to do.
pub fn grip_at(holds: &[Hold], at: f64) -> Result<Grip, String> {
    let end = |part| holds.iter().find(|h| h.part == part).map(|h| h.at);
    let range = |h: &Hold| match h.part {
        HoldPart::ClampFrom(i) => Some([h.at, end(HoldPart::ClampTo(i))?]),
        _ => None,
    };
    let clamps: Vec<[f64; 2]> = holds.iter().filter_map(range).collect();
    grip(&clamps, at)
}

/// Whether a hand can pull on the wood of a scene.
///
/// # Errors
/// Why it cannot, and what to do.
pub fn can_pull(setting: &Setting) -> Result<(), String> {
    let instead = "Choose another scene, or Pull on the wood in the File menu with a mesh open.";
    if setting.clamp.iter().any(|c| c.arc) {
        return Err(format!(
            "Both ends of this scene are turned on an arc, which leaves no wood for a hand to pull on. {instead}"
        ));
    }
    if setting.solver == SolverChoice::Explicit {
        return Err(format!(
            "This scene lasts {} s, too short for a hand. {instead}",
            setting.duration
        ));
    }
    if setting.for_length.is_none() && setting.stem.kind == StemChoice::Input {
        return Err(
            "The lengths of this scene are for no stem in particular: set for_length in its file."
                .to_owned(),
        );
    }
    Ok(())
}

/// The place of a hand at a time (s): how far it has pulled, in parts of the stem's length along the axes of the scene.
pub type HandPlace = (f64, [f64; 3]);

/// The way of a hand on a scene without it, frame by frame. It takes as long as the scene lasts to where it pulls first; where it is
/// steered elsewhere, as long as its way is in parts of the longest, and for the rest of the time it rests.
///
/// The places until it is steered follow from what was before alone.
pub fn hand_way(setting: &Setting, hand: &Moved) -> Vec<HandPlace> {
    let clamps: Vec<[f64; 2]> = setting.clamp.iter().map(|c| [c.from, c.to]).collect();
    let lever = grip(&clamps, hand.at).map_or(1.0, |g| g.lever());
    let rate = setting.frames_per_second;
    let whole = ((setting.duration * rate).round() as u32).max(1);
    let ends = hand.before.iter().map(|s| (s.frame, s.by));
    let mut way = vec![[0.0; 3]];
    for (until, to) in ends.chain([(u32::MAX, hand.by)]) {
        let (start, from) = (way.len() as u32 - 1, way[way.len() - 1]);
        let frames = match start {
            0 => whole,
            _ => frames_of(from, to, lever, whole),
        };
        let last = match until {
            u32::MAX => (start + frames).max(whole),
            until => until,
        };
        for frame in start + 1..=last {
            let part = f64::from((frame - start).min(frames)) / f64::from(frames);
            way.push([0, 1, 2].map(|i| fine(from[i] + (to[i] - from[i]) * part)));
        }
    }
    let time = |frame: usize| frame as f64 / rate;
    let places = way.into_iter().enumerate();
    places.map(|(frame, by)| (time(frame), by)).collect()
}

/// Frames that a hand takes from one place to another, where the longest way takes `whole`.
fn frames_of(from: [f64; 3], to: [f64; 3], lever: f64, whole: u32) -> u32 {
    let by = [0, 1, 2].map(|i| to[i] - from[i]);
    let along = (by[0].abs() / (FARTHEST_ALONG * lever)).min(2.0);
    let across = (by[1].hypot(by[2]) / (FARTHEST * lever)).min(2.0);
    let part = along.max(across).max(SHORTEST_WAY);
    ((part * f64::from(whole)).ceil() as u32).max(1)
}

/// A hand on a scene without it that is steered from the first of its frames on which is not before `time` (s) to another place.
pub fn steered(setting: &Setting, hand: &Moved, time: f64, by: [f64; 3]) -> Moved {
    steered_on_way(&hand_way(setting, hand), hand, time, by)
}

/// The frame of a hand's way that is the first not before a time, s.
fn frame_of(way: &[HandPlace], time: f64) -> u32 {
    let frame = way.partition_point(|place| place.0 < time);
    frame.min(way.len().saturating_sub(1)) as u32
}

/// Where a hand that moves on a way was to pull to at a time, s.
pub fn pulled_to(way: &[HandPlace], hand: &Moved, time: f64) -> [f64; 3] {
    let frame = frame_of(way, time);
    let given_up = hand.before.iter().find(|s| s.frame > frame);
    given_up.map_or(hand.by, |s| s.by)
}

/// A hand that moves on a way, and is steered from the first of its frames on which is not before `time` (s) to another place.
/// Where it was steered later is forgotten.
pub fn steered_on_way(way: &[HandPlace], hand: &Moved, time: f64, by: [f64; 3]) -> Moved {
    let frame = frame_of(way, time);
    let given_up = pulled_to(way, hand, time);
    let mut next = hand.clone();
    next.before.retain(|s| s.frame <= frame && frame > 0);
    if frame > 0 && next.before.last().is_none_or(|s| s.frame < frame) {
        next.before.push(Steered {
            frame,
            by: given_up,
        });
    }
    next.by = by;
    next
}

/// Adds a hand to a scene, which then lasts until it has pulled as far as it was steered. A scene by hand that nobody pulls in has one
/// frame.
pub fn add_hand(setting: &mut Setting, hand: &Moved) {
    let clamps: Vec<[f64; 2]> = setting.clamp.iter().map(|c| [c.from, c.to]).collect();
    let Ok(grip) = grip(&clamps, hand.at) else {
        return;
    };
    let stem = &setting.stem;
    let own = stem.length * (stem.part[1] - stem.part[0]);
    let length = setting.for_length.unwrap_or(own);
    let first = hand.before.first().map_or(hand.by, |s| s.by);
    let way = hand_way(setting, hand);
    let key = way.iter().map(|&(time, by)| KeyFrame {
        time,
        move_by: by.map(|x| fine(x * length)),
        turn: grip.turn(by).map(|x| fine(x.to_degrees())),
    });
    let key: Vec<KeyFrame> = key.collect();
    setting.duration = way[way.len() - 1].0.max(setting.duration);
    setting.clamp.push(ClampKeys {
        from: round(grip.at - HALF),
        to: round(grip.at + HALF),
        axes: HeldAxes([first[0] != 0.0, true, true]),
        key,
        ..ClampKeys::default()
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use greenstick::fibre::scene::BUILT_IN;

    fn pulling(at: f64, by: [f64; 3]) -> Moved {
        Moved {
            part: HoldPart::Hand,
            at,
            by,
            before: Vec::new(),
        }
    }

    #[test]
    fn a_hand_that_is_steered_has_moved_as_before_until_then() {
        let setting = Setting::read(BY_HAND).unwrap();
        let first = pulling(0.9, [0.0, 0.1, -0.3]);
        let old = hand_way(&setting, &first);
        assert_eq!((old.len(), old[0]), (26, (0.0, [0.0; 3])));
        assert_eq!(old[25], (1.0, first.by));
        // Its time lies between two frames: it is steered from the second on.
        let next = steered(&setting, &first, old[9].0 + 1e-12, [0.0, -0.2, 0.3]);
        assert_eq!(next.before[0].frame, 10);
        let way = hand_way(&setting, &next);
        assert_eq!(way[..=10], old[..=10]);
        assert_ne!(way[11], old[11]);
        assert_eq!(way.last().unwrap().1, next.by);
        // Again, to a place near by, and long before the end.
        let last = steered(&setting, &next, way[14].0, way[14].1);
        let rests = hand_way(&setting, &last);
        assert_eq!(rests[..=14], way[..=14]);
        assert!(rests[14..].iter().all(|p| p.1 == way[14].1) && rests.len() == 26);
        let mut scene = setting.clone();
        add_hand(&mut scene, &next);
        scene.check().unwrap();
        assert_eq!(scene.duration, way.last().unwrap().0);
        assert_eq!(scene.clamp[1].key.len(), way.len());
        let text = greenstick::schema::write_toml(&scene);
        assert_eq!(Setting::read(&text).unwrap(), scene);
        // Twice in one frame it is steered once.
        let again = steered(&setting, &next, old[10].0, [0.0, 0.0, 0.1]);
        assert_eq!((&again.before, again.by), (&next.before, [0.0, 0.0, 0.1]));
        // Back among what has been, it is steered away from where it was to pull to then, and all later steering is forgotten.
        assert_eq!(pulled_to(&rests, &last, old[12].0), next.by);
        assert_eq!(pulled_to(&rests, &last, old[4].0), first.by);
        let back = steered(&setting, &last, old[4].0, [0.0, 0.2, 0.0]);
        assert_eq!(back.before.len(), 1);
        assert_eq!((back.before[0].frame, back.before[0].by), (4, first.by));
        assert_eq!(hand_way(&setting, &back)[..=4], old[..=4]);
        // After the end it goes on from there.
        let end = steered(&setting, &next, 9.0, [0.0; 3]);
        let longer = hand_way(&setting, &end);
        assert_eq!(longer[..way.len()], way[..]);
        assert!(longer.len() > way.len() && longer.last().unwrap().1 == [0.0; 3]);
        // From the first frame on it is another pull.
        assert!(
            steered(&setting, &last, 0.0, [0.0, 0.1, 0.0])
                .before
                .is_empty()
        );
    }

    #[test]
    fn a_hand_takes_hold_of_free_wood_only() {
        let base = [[0.0, 0.08]];
        let tip = grip(&base, 0.9).unwrap();
        assert_eq!((tip.root, tip.is_free), (Some(0.08), true));
        assert!(grip(&base, 0.15).is_err() && grip(&base, 0.03).is_err());
        // The whole hand is on the stem.
        assert_eq!(grip(&base, 1.2).unwrap().at, 0.97);
        let both = [[0.0, 0.06], [0.94, 1.0]];
        let middle = grip(&both, 0.6).unwrap();
        assert_eq!((middle.root, middle.is_free), (Some(0.94), false));
        assert_eq!(middle.turn([0.0, 0.1, 0.0]), [0.0; 3]);
        assert_eq!(grip(&[], 0.5).unwrap().root, None);
    }

    #[test]
    fn a_pull_goes_across_or_along_and_no_farther_than_wood_reaches() {
        let grip = grip(&[[0.0, 0.1]], 0.9).unwrap();
        assert_eq!(grip.pull([0.05, 0.1, -0.1]), [0.0, 0.1, -0.1]);
        assert_eq!(grip.pull([-0.09, 0.01, 0.01]), [-0.09, 0.0, 0.0]);
        let [x, y, z] = grip.pull([0.0, 3.0, 4.0]);
        assert!(x == 0.0 && (y.hypot(z) - 0.64).abs() < 1e-3 && (y / z - 0.75).abs() < 1e-3);
        assert_eq!(grip.pull([9.0, 0.0, 0.0]), [0.16, 0.0, 0.0]);
    }

    #[test]
    fn a_free_end_turns_towards_where_it_is_pulled_as_that_of_a_cantilever() {
        // Down by 0.2 of the stem with a lever of 0.8: 1.5 × 0.25 rad about y, which takes x to −z.
        let tip = grip(&[[0.0, 0.1]], 0.9).unwrap();
        let turn = tip.turn([0.0, 0.0, -0.2]);
        assert!((turn[1] - 0.375).abs() < 1e-12 && turn[0] == 0.0 && turn[2] == 0.0);
        // Held at the tip, the base turns the other way.
        let base = grip(&[[0.9, 1.0]], 0.1).unwrap();
        assert!((base.turn([0.0, 0.0, -0.2])[1] + 0.375).abs() < 1e-12);
        // The slope of the curve that is drawn is the same.
        let slope = (tip.share(0.9).unwrap() - tip.share(0.8999).unwrap()) / 0.0001;
        assert!((slope * 0.2 - 0.375).abs() < 1e-3);
        assert_eq!((tip.share(0.1), tip.share(0.95)), (Some(0.0), None));
    }

    #[test]
    fn every_scene_takes_a_hand_or_says_why_not() {
        let by_hand = Setting::read(BY_HAND).unwrap();
        can_pull(&by_hand).unwrap();
        for built_in in BUILT_IN {
            let mut setting = built_in.scene().unwrap();
            let clamps: Vec<[f64; 2]> = setting.clamp.iter().map(|c| [c.from, c.to]).collect();
            match can_pull(&setting) {
                Ok(()) => {
                    let at = [0.5, 0.8].into_iter().find(|at| grip(&clamps, *at).is_ok());
                    let hand = pulling(at.unwrap(), [0.0, 0.0, -0.1]);
                    add_hand(&mut setting, &hand);
                    setting.check().unwrap();
                    assert_eq!(setting.clamp.len(), clamps.len() + 1, "{}", built_in.name);
                    let text = greenstick::schema::write_toml(&setting);
                    assert_eq!(Setting::read(&text).unwrap(), setting, "{}", built_in.name);
                }
                Err(problem) => assert!(problem.ends_with("open."), "{problem}"),
            }
        }
    }
}
