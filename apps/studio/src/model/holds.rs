//! Where a scene holds, pushes and pulls its stem, and other places for that: clamps, forces and bodies along the stem.

use greenstick::fibre::scene::Scene as Setting;
use serde::{Deserialize, Serialize};

/// Least length of a clamp, as a part of the stem.
const SHORTEST: f64 = 0.01;
/// Nobody drags more exactly than to this part of the stem.
const PARTS: f64 = 1000.0;

/// What stands somewhere along the stem, by its number among its kind.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum HoldPart {
    /// The end of a clamp that is nearer to the stem's base.
    ClampFrom(usize),
    /// The other end of a clamp.
    ClampTo(usize),
    /// A force or a moment.
    Force(usize),
    /// A body.
    Body(usize),
    /// The hand that pulls on the wood.
    Hand,
}

/// Something that holds, pushes or pulls the stem.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Hold {
    /// What it is.
    pub part: HoldPart,
    /// What it is called.
    pub name: String,
    /// Where it is, as a fraction of the stem.
    pub at: f64,
    /// How far a hand pulls, in parts of the stem's length along the axes of the scene; 0 for all else.
    pub by: [f64; 3],
    /// Where a hand pulled to before, and the frame in which it was steered elsewhere.
    pub before: Vec<Steered>,
}

/// A pull that was given up for another while the run went on.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Steered {
    /// The frame in which the hand was steered elsewhere.
    pub frame: u32,
    /// How far it was to pull, in parts of the stem's length along the axes of the scene.
    pub by: [f64; 3],
}

/// Where a part of a scene is put, and how far it pulls.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Moved {
    /// The part.
    pub part: HoldPart,
    /// Where, as a fraction of the stem.
    pub at: f64,
    /// How far a hand pulls, in parts of the stem's length along the axes of the scene.
    pub by: [f64; 3],
    /// Where a hand pulled to before.
    pub before: Vec<Steered>,
}

impl From<&Hold> for Moved {
    fn from(hold: &Hold) -> Self {
        Moved {
            part: hold.part,
            at: hold.at,
            by: hold.by,
            before: hold.before.clone(),
        }
    }
}

/// The hand among what was moved.
pub fn hand_of(moved: &[Moved]) -> Option<Moved> {
    moved.iter().find(|m| m.part == HoldPart::Hand).cloned()
}

/// A place that a drag gives a part among others: short, on the stem, and the ends of a clamp in their order.
pub fn dragged(holds: &[Hold], part: HoldPart, at: f64) -> f64 {
    let of = |part: HoldPart| holds.iter().find(|h| h.part == part).map(|h| h.at);
    let (low, high) = match part {
        HoldPart::ClampFrom(i) => (0.0, of(HoldPart::ClampTo(i)).unwrap_or(1.0) - SHORTEST),
        HoldPart::ClampTo(i) => (of(HoldPart::ClampFrom(i)).unwrap_or(0.0) + SHORTEST, 1.0),
        _ => (0.0, 1.0),
    };
    (at.max(low).min(high) * PARTS).round() / PARTS
}

/// What of a scene stands somewhere along its stem.
pub fn holds_of(setting: &Setting) -> Vec<Hold> {
    let mut holds = Vec::new();
    let mut hold = |part, name: String, at| {
        holds.push(Hold {
            part,
            name,
            at,
            by: [0.0; 3],
            before: Vec::new(),
        });
    };
    for (i, clamp) in setting.clamp.iter().enumerate() {
        let name = format!("clamp {}", i + 1);
        hold(HoldPart::ClampFrom(i), name.clone(), clamp.from);
        hold(HoldPart::ClampTo(i), name, clamp.to);
    }
    for (i, force) in setting.force.iter().enumerate() {
        hold(HoldPart::Force(i), format!("force {}", i + 1), force.at);
    }
    for (i, body) in setting.body.iter().enumerate() {
        let name = match &*body.name {
            "" => format!("body {}", i + 1),
            name => name.to_owned(),
        };
        hold(HoldPart::Body(i), name, body.at);
    }
    holds
}

/// Moves parts of a scene. The hand is no part of it yet.
pub fn move_holds(setting: &mut Setting, moved: &[Moved]) {
    for Moved { part, at, .. } in moved {
        let place = match *part {
            HoldPart::ClampFrom(i) => setting.clamp.get_mut(i).map(|c| &mut c.from),
            HoldPart::ClampTo(i) => setting.clamp.get_mut(i).map(|c| &mut c.to),
            HoldPart::Force(i) => setting.force.get_mut(i).map(|f| &mut f.at),
            HoldPart::Body(i) => setting.body.get_mut(i).map(|b| &mut b.at),
            HoldPart::Hand => None,
        };
        if let Some(place) = place {
            *place = *at;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use greenstick::fibre::scene::BUILT_IN;

    #[test]
    fn all_that_stands_along_a_stem_is_found_and_moved() {
        for built_in in BUILT_IN {
            let mut setting = built_in.scene().unwrap();
            let holds = holds_of(&setting);
            let moved: Vec<Moved> = holds
                .iter()
                .map(|h| Moved {
                    at: dragged(&holds, h.part, h.at + 0.0305),
                    ..Moved::from(h)
                })
                .collect();
            move_holds(&mut setting, &moved);
            let now: Vec<Moved> = holds_of(&setting).iter().map(Moved::from).collect();
            assert_eq!(now, moved, "{}", built_in.name);
            assert!(now.iter().all(|m| (0.0..=1.0).contains(&m.at)));
            let text = greenstick::schema::write_toml(&setting);
            assert_eq!(Setting::read(&text).unwrap(), setting, "{}", built_in.name);
        }
    }

    #[test]
    fn the_ends_of_a_clamp_do_not_pass_each_other() {
        let hold = |part, at| Hold {
            part,
            name: String::new(),
            at,
            by: [0.0; 3],
            before: Vec::new(),
        };
        let (from, to) = (HoldPart::ClampFrom(0), HoldPart::ClampTo(0));
        let holds = [hold(from, 0.2), hold(to, 0.3)];
        assert_eq!(dragged(&holds, from, 0.9), 0.29);
        assert_eq!(dragged(&holds, to, -4.0), 0.21);
        assert_eq!(dragged(&holds, from, 0.12345), 0.123);
        assert_eq!(dragged(&holds, HoldPart::Body(0), 7.0), 1.0);
    }
}
