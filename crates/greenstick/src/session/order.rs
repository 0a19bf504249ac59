//! The order in which several breaks of one stem are made: from the farthest from the base to the nearest, so that each
//! breaks what the one before left at the base.

use crate::Error;
use crate::request::{Break, BreakRequest};
use greenstick_geometry::{Context, Scene};
use greenstick_skin::stages::order_from_tip;
use greenstick_wood::stem::{FoundStem, StemLocation, StemOptions, find_stem};
use std::sync::Arc;

/// A break at its location in the world.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct PlacedBreak {
    /// Its index in the request.
    pub number: usize,
    /// The break; if the request has several, its location is a point.
    pub requested: Break,
}

/// The error of a request without breaks.
pub(super) fn no_breaks() -> Error {
    Error::Amount("no breaks; expected at least 1".into())
}

/// The locations of the breaks of the last request.
#[derive(Debug, Clone, Default)]
pub(super) struct BreakOrder {
    located: Vec<((StemLocation, StemOptions), Arc<FoundStem>)>,
}

impl BreakOrder {
    /// Returns the breaks of a request in the order in which they are made.
    ///
    /// # Errors
    /// [`Error`] if there is no break, no stem at a location, or the breaks are on different stems.
    pub fn resolve(
        &mut self,
        scene: &Scene,
        request: &BreakRequest,
        context: &Context,
    ) -> Result<Vec<PlacedBreak>, Error> {
        if let [only] = &request.breaks[..] {
            return Ok(vec![PlacedBreak {
                number: 0,
                requested: only.clone(),
            }]);
        }
        let found = self.locate(scene, request, context)?;
        if found.is_empty() {
            return Err(no_breaks());
        }
        let order = order_from_tip(&found).map_err(|error| Error::Amount(error.to_string()))?;
        let placed = order.into_iter().map(|number| {
            let stem = &found[number].stem;
            let point = stem.grain.axis().frame(stem.location).origin;
            PlacedBreak {
                number,
                requested: Break {
                    place: StemLocation::Point(point),
                    ..request.breaks[number].clone()
                },
            }
        });
        Ok(placed.collect())
    }

    /// Finds the stem at the location of each break.
    fn locate(
        &mut self,
        scene: &Scene,
        request: &BreakRequest,
        context: &Context,
    ) -> Result<Vec<Arc<FoundStem>>, Error> {
        let mut meshes = None;
        let mut located = Vec::new();
        for (number, requested) in request.breaks.iter().enumerate() {
            let key = (requested.place, request.stem.clone());
            let found = match self.located.iter().find(|k| k.0 == key) {
                Some(known) => known.1.clone(),
                None => {
                    let meshes = meshes.get_or_insert_with(|| scene.world_meshes());
                    let context = context.item(number, request.breaks.len());
                    Arc::new(find_stem(
                        meshes,
                        &requested.place,
                        &request.stem,
                        &context,
                    )?)
                }
            };
            located.push((key, found));
        }
        self.located = located;
        Ok(self.located.iter().map(|k| k.1.clone()).collect())
    }
}
