//! Bonds with a strength and an energy of fracture: cohesive zones.
//!
//! A bond's traction grows with its opening and slip up to the strength, (⟨σ⟩/f_t90)² + (τ/f_v)² = 1, and then falls linearly,
//! so that the work to the end is the energy of fracture. Opening and slip together have that of Benzeggagh and Kenane (1996),
//! G = G_I + (G_II − G_I) (W_II/W)^η, by the shares of elastic work. The bond's stiffness falls by a damage that never heals;
//! pressure across it passes in full (Camanho and Dávila, NASA/TM-2002-211737).
//!
//! With φ = ((⟨σ⟩/f_t90)² + (τ/f_v)²)^½ of the undamaged bond, which grows in proportion to opening and slip, softening begins at
//! φ₀ = 1 and ends at φ_f = G/(w φ₀), where w is the elastic energy at φ = 1. Bonds so long that φ_f would come too near φ₀ lose
//! strength and retain their energy of fracture: φ₀ = (G/(R w))^½ with R = [`MIN_SOFTENING_RATIO`] (Bažant and Oh 1983, the
//! crack band's strength limit).

use crate::energy::bond::{self, BondSpring, BondTangent};
use crate::rod_bundle::RodBundle;
use crate::state::State;

/// Exponent η of mixed modes: 2 is usual for wood and for composites.
const MODE_EXPONENT: i32 = 2;
/// Least ratio of the opening at the end of softening to that at its onset.
const MIN_SOFTENING_RATIO: f64 = 2.0;
/// A bond with this damage has failed: the rest is rounding.
pub(crate) const FAILED: f64 = 1.0 - 1e-6;

/// How far a cohesive bond is along its softening.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Softening {
    /// φ: opening and slip over those at the strength.
    pub strain: f64,
    /// φ at which softening begins, and at which it ends.
    pub onset: f64,
    pub end: f64,
    /// Energy of fracture in this mode, J.
    pub fracture_energy: f64,
    /// The energy of opening and slip that the bond would store undamaged, J.
    pub undamaged_energy: f64,
    /// Share of slip in it, 0 to 1.
    pub slip_share: f64,
}

impl Softening {
    /// Returns that of a bond in a state.
    pub fn new(bundle: &RodBundle, state: &State, number: usize) -> Self {
        let b = &bundle.bonds;
        let spring = BondSpring::intact(bundle, number);
        let (e, d) = bond::vectors(bundle, state, number);
        let strain = spring.strain(e, d);
        let opening = strain.opening.max(0.0);
        let tension = spring.opening * opening / b.tension_strength[number];
        let shear = spring.slip * strain.slip / b.shear_strength[number];
        let works = [
            0.5 * spring.opening * opening * opening,
            0.5 * spring.slip * strain.slip * strain.slip,
        ];
        let undamaged_energy = works[0] + works[1];
        let strain = (tension * tension + shear * shear).sqrt();
        let share = (works[1] / undamaged_energy).max(0.0);
        let (first, second) = (b.fracture_energy[number], b.shear_fracture_energy[number]);
        let fracture_energy = first + (second - first) * share.powi(MODE_EXPONENT);
        let at_strength = undamaged_energy / (strain * strain);
        let onset = onset(fracture_energy, at_strength);
        Softening {
            strain,
            onset,
            end: fracture_energy / (at_strength * onset),
            fracture_energy,
            undamaged_energy,
            slip_share: share,
        }
    }

    /// Returns the damage of a bond that has come as far and no further.
    pub fn damage(&self) -> f64 {
        if self.strain <= self.onset || self.strain.is_nan() {
            0.0
        } else if self.strain >= self.end {
            1.0
        } else {
            self.end * (self.strain - self.onset) / (self.strain * (self.end - self.onset))
        }
    }

    /// Whether a bond that has come as far holds nothing any more.
    pub fn has_failed(&self) -> bool {
        self.damage() >= FAILED
    }

    /// Returns the energy that has been dissipated up to a damage, J: what is under the law up to where it softens further, less
    /// what the bond still stores there.
    pub fn dissipated(&self, damage: f64) -> f64 {
        self.fracture_energy * damage * self.threshold(damage) / self.end
    }

    /// Returns the derivative of the damage of a bond that softens with respect to φ.
    fn damage_rate(&self) -> f64 {
        if self.strain > self.onset && self.strain < self.end {
            self.end * self.onset / (self.strain * self.strain * (self.end - self.onset))
        } else {
            0.0
        }
    }

    /// Returns φ at which a bond of this damage softens further.
    pub fn threshold(&self, damage: f64) -> f64 {
        self.end * self.onset / (self.end - damage * (self.end - self.onset))
    }
}

/// Returns the tangent of a bond that softens in a state, so that its damage is that of [`Softening::damage`].
///
/// In opening and slip together the forces have no potential. The tangent is the symmetric part of their derivatives, with the
/// mode as it is.
pub(crate) fn softening_tangent(bundle: &RodBundle, state: &State, number: usize) -> BondTangent {
    let b = &bundle.bonds;
    let softening = Softening::new(bundle, state, number);
    let intact = BondSpring::intact(bundle, number);
    let (e, d) = bond::vectors(bundle, state, number);
    let strain = intact.strain(e, d);
    let tangent = BondTangent::elastic(&intact.damaged(softening.damage()), strain);
    let rate = softening.damage_rate();
    if rate == 0.0 {
        return tangent;
    }
    let forces = [
        intact.opening * strain.opening.max(0.0),
        intact.slip * strain.slip,
    ];
    let tension = intact.opening / b.tension_strength[number];
    let shear = intact.slip / b.shear_strength[number];
    let rates = [
        rate * tension * tension * strain.opening.max(0.0) / softening.strain,
        rate * shear * shear * strain.slip / softening.strain,
    ];
    BondTangent {
        opening: tangent.opening - forces[0] * rates[0],
        slip: tangent.slip - forces[1] * rates[1],
        mixed: -0.5 * (forces[0] * rates[1] + forces[1] * rates[0]),
        ..tangent
    }
}

/// Returns φ at which a bond begins to soften. `at_strength` is its elastic energy at φ = 1, J.
fn onset(fracture_energy: f64, at_strength: f64) -> f64 {
    let reduced = (fracture_energy / (MIN_SOFTENING_RATIO * at_strength)).sqrt();
    if reduced < 1.0 { reduced } else { 1.0 }
}

/// Returns the opening at which nothing of a bond is left, m, without slip.
pub(crate) fn opening_at_end(bundle: &RodBundle, number: usize) -> f64 {
    let b = &bundle.bonds;
    let (strength, stiffness) = (
        b.tension_strength[number],
        BondSpring::intact(bundle, number).opening,
    );
    let energy = b.fracture_energy[number];
    let at_strength = 0.5 * strength * strength / stiffness;
    energy / (at_strength * onset(energy, at_strength)) * strength / stiffness
}

/// Returns the least φ at which a bond begins to soften, in whichever mode.
pub(crate) fn least_onset(bundle: &RodBundle, number: usize) -> f64 {
    let b = &bundle.bonds;
    let spring = BondSpring::intact(bundle, number);
    let at_strength = |strength: f64, stiffness: f64| 0.5 * strength * strength / stiffness;
    let across = at_strength(b.tension_strength[number], spring.opening);
    let along = at_strength(b.shear_strength[number], spring.slip);
    let energy = b.fracture_energy[number].min(b.shear_fracture_energy[number]);
    onset(energy, across.max(along))
}
