//! Keys of scenes of version 0.1.0 that have others in their place, so that scenes written then are still read.

use super::keys::Scene;
use greenstick_schema::{Unit, count, number, parameters};

parameters! {
    /// Keys of the rods that describe the wood.
    pub struct FormerRodKeys {
        "", "rods" {
            /// Rings, at whose boundaries bonds are weaker; 0: no boundary is weaker.
            rings: Option<u32> = None, count(0, 1000).auto();
            /// Rays, across which bonds are weaker; 0: none is.
            rays: Option<u32> = None, count(0, 1000).auto();
            /// Strength across a ring boundary over that elsewhere.
            ring_strength: Option<f64> = None, number(Unit::One, 1e-3, 1.0).auto();
            /// Strength across a ray over that elsewhere.
            ray_strength: Option<f64> = None, number(Unit::One, 1e-3, 1.0).auto();
        }
    }
}

parameters! {
    /// All former keys.
    pub struct FormerKeys {}
    tables {
        /// The rods.
        rods: FormerRodKeys = FormerRodKeys::default();
    }
}

impl FormerKeys {
    /// Translates what an older scene says to the keys of today, which win where both are given. The number of rays has no
    /// counterpart: every plane along the rays is as weak.
    pub(super) fn translate(&self, scene: &mut Scene) {
        let rods = &self.rods;
        let strength = |number: Option<u32>, strength: Option<f64>| match number {
            Some(0) => Some(1.0),
            _ => strength,
        };
        let wood = &mut scene.wood;
        let ring_strength = strength(rods.rings, rods.ring_strength);
        wood.ring_strength = wood.ring_strength.or(ring_strength);
        wood.ray_strength = wood.ray_strength.or(strength(rods.rays, rods.ray_strength));
        let rings = rods.rings.filter(|&n| n > 0);
        let own = &mut scene.rings.annual_rings;
        *own = own.or(rings.and_then(|n| u16::try_from(n).ok()));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scenes_of_version_0_1_are_read() {
        let text =
            "[rods]\nnumber = 7\nrings = 12\nring_strength = 0.6\nrays = 0\nray_strength = 0.8\n";
        let scene = Scene::read(text).unwrap();
        assert_eq!(scene.rods.number, 7);
        assert_eq!(scene.rings.annual_rings, Some(12));
        assert_eq!(scene.wood.ring_strength, Some(0.6));
        assert_eq!(scene.wood.ray_strength, Some(1.0));
        let saved = scene.to_toml();
        assert!(!saved.contains("rays ="), "{saved}");
        assert_eq!(Scene::read(&saved).unwrap().to_toml(), saved);
    }

    #[test]
    fn todays_keys_win_and_mistakes_have_their_line() {
        let text = "annual_rings = 5\n[wood]\nring_strength = 0.9\n[rods]\nrings = 12\nring_strength = 0.6\n";
        let scene = Scene::read(text).unwrap();
        assert_eq!(scene.rings.annual_rings, Some(5));
        assert_eq!(scene.wood.ring_strength, Some(0.9));
        let problem = Scene::read("[rods]\nnumber = 7\nring_strength = 7\n").unwrap_err();
        let text = problem.to_string();
        assert!(
            text.contains("line 3") && text.contains("rods.ring_strength"),
            "{text}"
        );
    }
}
