//! Moving the pieces of a break apart, as one would pull them: along the grain while their splinters lie between each other,
//! then straight on, until neither lies in the other.

use super::way::{Half, Way};
use crate::report::BreakNote;
use crate::stages::BreakStages;
use glam::DAffine3;
use greenstick_geometry::{Context, Mesh};

/// How far the pieces of a break are to be moved apart.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Separation {
    /// The way, m.
    pub way: f64,
    /// Whether they are moved farther where they would lie in each other.
    pub until_clear: bool,
}

impl Separation {
    /// A way (m) and whether pieces are moved farther where they would lie in each other.
    pub fn new(way: f64, until_clear: bool) -> Self {
        Separation { way, until_clear }
    }
}

/// The way of the upper piece of a break.
pub(super) struct Parting<'a> {
    stages: &'a BreakStages,
    way: Way<'a>,
    context: &'a Context,
}

/// How far pieces are moved apart.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Parted {
    /// The way, m.
    pub way: f64,
    /// What is to be said of it.
    pub note: Option<BreakNote>,
}

impl<'a> Parting<'a> {
    pub fn new(stages: &'a BreakStages, context: &'a Context) -> Self {
        Parting {
            stages,
            way: Way::off(stages),
            context,
        }
    }

    /// Returns the motion of the upper piece over a way (m).
    pub fn after(&self, way: f64) -> DAffine3 {
        self.way.after(way)
    }

    /// Returns the way of a break. A piece that hangs on stays where it is.
    pub fn way(&self, asked: Separation, pieces: [&Mesh; 2]) -> Parted {
        let stem = &self.stages.stem;
        if stem.face.hang > 0.0 {
            let requested_m = asked.way;
            return Parted {
                way: 0.0,
                note: (requested_m > 0.0).then_some(BreakNote::HangsOn { requested_m }),
            };
        }
        let half = |mesh| Half {
            mesh,
            transform: *stem.stem().transform(),
            inner: stem.inner_material,
        };
        let [lower, upper] = pieces.map(half);
        Parted::of(&self.way, asked, [&lower, &upper], self.context)
    }
}

impl<'a> Way<'a> {
    /// Returns the way off the lower piece of a break.
    fn off(stages: &'a BreakStages) -> Self {
        let prepared = stages.stem.stem();
        let stem = &prepared.found.stem;
        let (low, high) = stages.heights.heights.range;
        let range = (stem.location + low, stem.location + high);
        Way::new(stem, range, &|p| prepared.layers.to_world(p))
    }
}

impl BreakStages {
    /// Returns the motion of the upper piece over a way (m) off the lower one, in the coordinates of the scene.
    pub fn motion_apart(&self, way: f64) -> DAffine3 {
        Way::off(self).after(way)
    }
}

impl Parted {
    /// Returns the way that is requested or, if pieces are to be clear, the shortest beyond it on which they do not lie in each
    /// other. Any way, where the caller cancels.
    pub fn of(way: &Way, asked: Separation, halves: [&Half; 2], context: &Context) -> Parted {
        let as_asked = Parted {
            way: asked.way,
            note: None,
        };
        if !asked.until_clear || asked.way == 0.0 {
            return as_asked;
        }
        let shared = way.shared(halves);
        let at_first = shared(asked.way);
        if at_first == 0.0 {
            return as_asked;
        }
        match way.clear_beyond(asked.way, |way| {
            context.check().is_err() || shared(way) == 0.0
        }) {
            Some(way) => Parted {
                way,
                note: Some(BreakNote::PartedFarther {
                    way_m: way,
                    requested_m: asked.way,
                }),
            },
            None => Parted {
                note: Some(BreakNote::PartsOverlap {
                    shared_m3: at_first,
                }),
                ..as_asked
            },
        }
    }
}
