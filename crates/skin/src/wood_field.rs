//! Fields of the wood that its skin can show.

use glam::DVec3;
use greenstick_geometry::Scene;

/// Colours of a field, linear: strain from crushing by none to tearing, damage from whole to broken.
const CRUSHED: DVec3 = DVec3::new(0.03, 0.13, 0.55);
const UNLOADED: DVec3 = DVec3::new(0.75, 0.73, 0.68);
const TORN: DVec3 = DVec3::new(0.62, 0.03, 0.02);

/// A field of the wood.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WoodField {
    /// Strain along the grain over that at failure: 1 where it tears, −1 where it is crushed.
    Strain,
    /// Share of the bonds that are broken, 0 to 1; 1 where the rod is.
    Damage,
}

impl WoodField {
    /// Both fields.
    const ALL: [WoodField; 2] = [WoodField::Strain, WoodField::Damage];

    /// Returns the field that a scene's nodes hold.
    pub fn of(scene: &Scene) -> Option<Self> {
        let holds = |field: &WoodField| {
            let name = field.attribute();
            (scene.nodes.iter()).any(|node| node.mesh.attributes.contains_key(name))
        };
        Self::ALL.into_iter().find(holds)
    }

    /// Returns the linear colour that shows a value.
    pub fn color(self, value: f64) -> [f64; 3] {
        let end = match self {
            WoodField::Strain if value < 0.0 => CRUSHED,
            _ => TORN,
        };
        UNLOADED.lerp(end, value.abs().min(1.0)).to_array()
    }

    /// The name of the attribute that holds it.
    pub fn attribute(self) -> &'static str {
        match self {
            WoodField::Strain => "_STRAIN",
            WoodField::Damage => "_DAMAGE",
        }
    }
}
