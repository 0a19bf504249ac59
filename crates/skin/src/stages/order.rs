//! Where a stem breaks that breaks at several places, and the order in which the breaks are made.

use crate::prepared::Neighbours;
use crate::report::BreakNote;
use glam::DVec3;
use greenstick_wood::stem::FoundStem;
use std::sync::Arc;

/// Most breaks of one stem: each is made in what the one before left, so that time grows with their number.
const MAX_BREAKS: usize = 100;
/// Least distance of two breaks, in radii of the stem there: nearer ones leave no room for splinters between them.
const MIN_DISTANCE_RADII: f64 = 1.0;

/// Why a stem cannot be broken at these places.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum PlacesError {
    /// There are no breaks.
    #[error("no breaks; expected at least 1")]
    None,
    /// There are too many breaks.
    #[error("{count} breaks; expected at most {MAX_BREAKS}")]
    TooMany {
        /// How many.
        count: usize,
    },
    /// Breaks are on different stems.
    #[error(
        "breaks on several stems: break 1 is at {first_m:.3} m of one, break {other} at {other_m:.3} m of another; expected all on one"
    )]
    SeveralStems {
        /// Where the first one is along its stem, m.
        first_m: f64,
        /// Number of a break on another stem, from 1.
        other: usize,
        /// Where it is along its stem, m.
        other_m: f64,
    },
    /// Two breaks are too close.
    #[error(
        "breaks {} and {} are at {:.4} and {:.4} m of the stem; expected at least {least_m:.4} m between them, its radius",
        numbers[0], numbers[1], at_m[0], at_m[1]
    )]
    TooClose {
        /// Their numbers, from 1.
        numbers: [usize; 2],
        /// Where they are along the stem, m.
        at_m: [f64; 2],
        /// The least distance, m.
        least_m: f64,
    },
    /// A distance between breaks, and breaks with places of their own.
    #[error(
        "a break every {every_m} m, and {breaks} breaks with places of their own; expected one or the other"
    )]
    Both {
        /// The distance, m.
        every_m: f64,
        /// How many.
        breaks: usize,
    },
    /// No place at such distances from the base can be broken.
    #[error(
        "no break every {every_m} m: the stem is {length_m:.3} m long, and none of {places} places is free"
    )]
    NonFree {
        /// The distance, m.
        every_m: f64,
        /// Length of the stem, m.
        length_m: f64,
        /// The number of places along it.
        places: usize,
    },
}

/// Checks the number of breaks.
///
/// # Errors
/// [`PlacesError::None`], [`PlacesError::TooMany`].
pub fn check_number(count: usize) -> Result<(), PlacesError> {
    match count {
        0 => Err(PlacesError::None),
        1..=MAX_BREAKS => Ok(()),
        count => Err(PlacesError::TooMany { count }),
    }
}

/// The place of one of several breaks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BreakPlace {
    /// The number of the break, from 0.
    pub number: usize,
    /// The index of its stem among those that were found.
    pub stem: usize,
    /// Length along the axis, m.
    pub length: f64,
    /// Point of the axis, m.
    pub point: DVec3,
    /// What it must know of the other breaks.
    pub neighbours: Neighbours,
}

/// The places of the breaks of a stem.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct BreakPlaces {
    /// From the farthest from the base to the nearest, the order in which they are made.
    pub from_tip: Vec<BreakPlace>,
    /// What is said of places at a regular distance that are left out, as the stem is not free there.
    pub left_out: Option<BreakNote>,
}

impl BreakPlaces {
    /// Returns the places of breaks, for each of which its stem was `found`. With `every` there is one stem, which breaks
    /// wherever it is free at a multiple of this length (m) from its base.
    ///
    /// # Errors
    /// [`PlacesError`].
    pub fn new(found: &[Arc<FoundStem>], every: Option<f64>) -> Result<Self, PlacesError> {
        let mut places = match (every, found) {
            (Some(every), [only]) => BreakPlaces::every(every, only)?,
            (Some(every_m), several) => {
                let breaks = several.len();
                return Err(PlacesError::Both { every_m, breaks });
            }
            (None, _) => BreakPlaces::of_each(found)?,
        };
        (places.from_tip)
            .sort_by(|a, b| b.length.total_cmp(&a.length).then(a.number.cmp(&b.number)));
        for pair in places.from_tip.windows(2) {
            let radius = pair.iter().map(|p| found[p.stem].stem.radius);
            let least_m = MIN_DISTANCE_RADII * radius.fold(0.0, f64::max);
            if pair[0].length - pair[1].length < least_m {
                let (a, b) = if pair[0].number < pair[1].number {
                    (pair[0], pair[1])
                } else {
                    (pair[1], pair[0])
                };
                return Err(PlacesError::TooClose {
                    numbers: [a, b].map(|p| p.number + 1),
                    at_m: [a, b].map(|p| p.length),
                    least_m,
                });
            }
        }
        places.set_neighbours(found);
        Ok(places)
    }

    fn set_neighbours(&mut self, found: &[Arc<FoundStem>]) {
        for i in 0..self.from_tip.len() {
            let place = &self.from_tip[i];
            let axis = found[place.stem].stem.grain.axis();
            let next = self.from_tip.get(i + 1);
            let halfway = next.map(|next| axis.frame(0.5 * (place.length + next.length)).origin);
            let along = axis.frame(place.length).tangent;
            self.from_tip[i].neighbours = Neighbours::new(along, halfway);
        }
    }

    fn of_each(found: &[Arc<FoundStem>]) -> Result<Self, PlacesError> {
        check_number(found.len())?;
        let shell = |number: usize| (found[number].node, found[number].shell.first().copied());
        let at = |number: usize| found[number].stem.location;
        if let Some(other) = (0..found.len()).find(|&number| shell(number) != shell(0)) {
            return Err(PlacesError::SeveralStems {
                first_m: at(0),
                other: other + 1,
                other_m: at(other),
            });
        }
        let from_tip =
            (0..found.len()).map(|number| place(number, number, &found[number], at(number)));
        Ok(BreakPlaces {
            from_tip: from_tip.collect(),
            left_out: None,
        })
    }

    fn every(every: f64, found: &FoundStem) -> Result<Self, PlacesError> {
        let length = found.stem.length;
        // Before the last one nothing is left to break off.
        let count = (length / every).ceil().max(1.0) as usize - 1;
        if count > MAX_BREAKS {
            return Err(PlacesError::TooMany { count });
        }
        let is_free = |at: &f64| found.free.iter().any(|r| r.0 <= *at && *at <= r.1);
        let all = (1..=count).map(|k| k as f64 * every);
        let (free, left_out): (Vec<f64>, Vec<f64>) = all.partition(is_free);
        if free.is_empty() {
            return Err(PlacesError::NonFree {
                every_m: every,
                length_m: length,
                places: count,
            });
        }
        let from_tip =
            (free.into_iter().enumerate()).map(|(number, at)| place(number, 0, found, at));
        Ok(BreakPlaces {
            from_tip: from_tip.collect(),
            left_out: (!left_out.is_empty()).then_some(BreakNote::PlacesLeftOut(left_out)),
        })
    }
}

fn place(number: usize, stem: usize, found: &FoundStem, length: f64) -> BreakPlace {
    BreakPlace {
        number,
        stem,
        length,
        point: found.stem.grain.axis().frame(length).origin,
        neighbours: Neighbours::default(),
    }
}
