//! The order in which several breaks of one stem are made: from the farthest from the base to the nearest, so that each
//! breaks what the one before left at the base.

use crate::Error;
use crate::request::{Break, BreakRequest};
use greenstick_geometry::{Context, Scene};
use greenstick_skin::report::BreakNote;
use greenstick_skin::stages::{BreakPlaces, Neighbours, WholeStem, check_number};
use greenstick_wood::stem::{FoundStem, StemLocation, StemOptions, find_stem};
use std::sync::Arc;

/// A break at its location in the world.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct PlacedBreak {
    /// Its index in the request.
    pub number: usize,
    /// Length along the stem, if the request has several, m.
    pub at_m: f64,
    /// The break; if the request has several, its location is a point.
    pub requested: Break,
    /// The stem before any break, if the request has several.
    pub whole: Option<WholeStem>,
    pub neighbours: Neighbours,
}

/// The locations of the breaks of the last request.
#[derive(Debug, Clone, Default)]
pub(super) struct BreakOrder {
    located: Vec<((StemLocation, StemOptions), Arc<FoundStem>)>,
}

impl BreakOrder {
    /// Returns the breaks of a request in the order in which they are made, and what is said of places that are left out.
    ///
    /// # Errors
    /// [`Error`] if there is no stem at a location, or a stem cannot be broken at all of them.
    pub fn resolve(
        &mut self,
        scene: &Scene,
        request: &BreakRequest,
        context: &Context,
    ) -> Result<(Vec<PlacedBreak>, Option<BreakNote>), Error> {
        if let ([only], None) = (&request.breaks[..], request.every) {
            let alone = PlacedBreak {
                number: 0,
                at_m: 0.0,
                requested: only.clone(),
                whole: None,
                neighbours: Neighbours::default(),
            };
            return Ok((vec![alone], None));
        }
        check_number(request.breaks.len())?;
        let found = self.locate(scene, request, context)?;
        let BreakPlaces { from_tip, left_out } = BreakPlaces::new(&found, request.every)?;
        let placed = from_tip.into_iter().map(|at| PlacedBreak {
            number: at.number,
            at_m: at.length,
            whole: Some(WholeStem::new(&found[at.stem])),
            neighbours: at.neighbours,
            requested: Break {
                place: StemLocation::Point(at.point),
                ..request.breaks[at.stem].clone()
            },
        });
        Ok((placed.collect(), left_out))
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
