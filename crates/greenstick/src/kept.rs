//! What of a break stays while its parameters change.

use crate::Prepared;
use glam::{DAffine3, DVec2};
use greenstick_fracture::cut::{Ground, Skin, Solid};
use greenstick_fracture::layout::{self, Bundles, LayoutOptions};
use greenstick_wood::stem::{FoundStem, LayeredGrain};
use std::sync::{Arc, Mutex};

/// Made once for a prepared stem.
#[derive(Debug, Default)]
pub(crate) struct Kept {
    /// The sorted skin.
    pub skin: Skin,
    /// Its triangles in that order.
    pub triangles: Vec<[u32; 3]>,
    /// A vertex of each point.
    pub vertices: Vec<u32>,
    /// Grain space to the node's coordinates.
    pub chart: LayeredGrain,
    /// Levels of the grain, m.
    pub levels: Vec<f64>,
    /// Middle and side (m) of the square of the section that holds the limb's skin.
    pub square: (DVec2, f64),
    /// The layout that was used last.
    last: Mutex<Option<Arc<Laid>>>,
}

/// A layout on the skin.
#[derive(Debug)]
pub(crate) struct Laid {
    smooth: bool,
    options: LayoutOptions,
    pub bundles: Arc<Bundles>,
    pub ground: Ground,
}

impl Kept {
    /// Makes what is kept for a mesh, its vertices' points, and their grain coordinates.
    pub fn new(
        found: &FoundStem,
        layers: &LayeredGrain,
        solid: &Solid,
        triangles: &[[u32; 3]],
        points: &[u32],
        transform: &DAffine3,
    ) -> Self {
        let stem = &found.stem;
        let skin = Skin::new(solid, stem.usable);
        let mut vertices = vec![0; solid.points.len()];
        for (vertex, &point) in points.iter().enumerate() {
            vertices[point as usize] = vertex as u32;
        }
        let corners = solid.limb.iter().flat_map(|&t| solid.triangles[t as usize]);
        let (low, high) = corners
            .map(|p| solid.points[p as usize].truncate())
            .fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), p| {
                (low.min(p), high.max(p))
            });
        Kept {
            triangles: skin.order.iter().map(|&t| triangles[t as usize]).collect(),
            skin,
            vertices,
            chart: layers.transformed(&transform.inverse()),
            levels: layers.levels().collect(),
            square: ((low + high) / 2.0, (high - low).max_element() * 1.02),
            last: Mutex::default(),
        }
    }

    /// The layout of `options`, anew only where they have changed.
    pub fn laid(&self, prepared: &Prepared, options: &LayoutOptions, smooth: bool) -> Arc<Laid> {
        let mut options = options.clone();
        if smooth {
            // The published grid is regular.
            options.seed = 0;
        }
        // A lock poisoned by a panic elsewhere holds a whole layout or none all the same.
        let mut last = self.last.lock().unwrap_or_else(|e| e.into_inner());
        if let Some(laid) = last.as_ref()
            && laid.smooth == smooth
            && laid.options == options
        {
            return laid.clone();
        }
        let rings = &prepared.found.stem.rings;
        let bundles = if smooth {
            layout::smooth(rings, &options)
        } else {
            layout::fibrous(rings, &options)
        };
        let laid = Arc::new(Laid {
            smooth,
            options,
            ground: Ground::new(&self.skin, &bundles.layout),
            bundles: Arc::new(bundles),
        });
        *last = Some(laid.clone());
        laid
    }
}

impl Prepared {
    /// The mesh as it is cut.
    pub(crate) fn solid(&self) -> Solid<'_> {
        Solid {
            triangles: &self.corners,
            points: &self.grain,
            shell: &self.found.shell,
            limb: &self.found.limb,
        }
    }
}
