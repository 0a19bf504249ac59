//! The look of wood at a point while tissues are blended over it.

use super::mix::{mix, mix_scalar};
use glam::DVec3;

/// Colour and roughness that tissues are blended into.
pub(super) struct TissueBlend {
    pub color: DVec3,
    pub roughness: f64,
    /// |normal · grain|.
    pub end: f64,
    /// Change of brightness by streaks.
    pub shade: f64,
    /// Tone of the slivers, −1 to 1.
    pub tone: f64,
    /// Cosine of the angle between the normal and the direction away from the pith, 0 where that is not known.
    pub outwards: f64,
}

impl TissueBlend {
    /// Blends a tissue in, whose brightness is changed by `speck`, by the part `inside` of the footprint that it takes.
    pub(super) fn blend(&mut self, color: [f64; 3], speck: f64, inside: f64) {
        const TISSUE_ROUGHNESS: f64 = 0.94;
        /// How much more than those of wood their fibres show.
        const TISSUE_FIBRES: f64 = 1.5;
        if inside > 0.0 {
            let shade = (1.0 + speck + TISSUE_FIBRES * self.shade) * (1.0 - 0.15 * self.end);
            self.color = mix(self.color, DVec3::from_array(color) * shade, inside);
            self.roughness = mix_scalar(self.roughness, TISSUE_ROUGHNESS, inside);
        }
    }
}
