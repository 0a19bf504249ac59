//! What beam theory says of the specimens.
//!
//! An arm is not clamped at the tip of the crack but turns and shears a little beyond it, as if it were longer by χ h (Hashemi,
//! Kinloch and Williams 1990, *Proceedings of the Royal Society A* 427; 0.42 χ h in end-notched flexure, Wang and Williams 1992,
//! *Composites Science and Technology* 43).
//!
//! The stress at the tip of a deep notch depends on the ligament c beside it alone, K = 3.975 M/(B c^(3/2)), within 0.1 % for notches
//! of half the height and more (Tada, Paris and Irwin, *The Stress Analysis of Cracks Handbook*). For a crack along the stiff
//! direction of an orthotropic body it is to be taken times Y(ρ) (Bao, Ho, Suo and Fan 1992, *International Journal of Solids and
//! Structures* 29).

use super::specimen::{CrackSystem, FractureTest, FractureTestKind};
use crate::placement::WoodMaterial;

/// Root correction of end-notched flexure over that of the double cantilever beam.
const SLIDING_ROOT_RATIO: f64 = 0.42;
/// K B c^(3/2)/M of a deep notch.
const DEEP_NOTCH: f64 = 3.975;

/// Beam theory of a test.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct BeamTheory {
    kind: FractureTestKind,
    /// Half of the length from support to support, height of an arm, and width, m.
    half_span: f64,
    arm: f64,
    width: f64,
    /// Modulus along the grain and shear modulus, Pa.
    longitudinal: f64,
    shear: f64,
    /// Of a notched beam: its tip's modulus K²/G, with the factor of orthotropy of K, Pa.
    tip: f64,
    /// Modulus across the grain, Pa.
    across: f64,
    /// What is added to the crack, m.
    pub root: f64,
}

impl BeamTheory {
    pub fn new(test: &FractureTest, wood: &WoodMaterial) -> Self {
        let (across, shear) = match test.system {
            CrackSystem::Rl => (wood.radial, wood.shear_radial),
            CrackSystem::Tl => (wood.tangential, wood.shear_tangential),
        };
        let longitudinal = wood.longitudinal;
        let ratio = 1.18 * (longitudinal * across).sqrt() / shear;
        let part = ratio / (1.0 + ratio);
        let chi = (longitudinal / (11.0 * shear) * (3.0 - 2.0 * part * part)).sqrt();
        let root = match test.kind {
            FractureTestKind::DoubleCantileverBeam => chi,
            FractureTestKind::EndNotchedFlexure => SLIDING_ROOT_RATIO * chi,
            FractureTestKind::SingleEdgeNotchedBeam => 0.0,
        };
        BeamTheory {
            kind: test.kind,
            half_span: 0.5 * test.length,
            arm: test.arm(),
            width: test.width,
            longitudinal,
            shear,
            tip: tip_modulus(longitudinal, across, shear),
            across,
            root: root * test.arm(),
        }
    }

    /// Returns the compliance with a crack of a length (m), m/N.
    pub fn compliance(&self, crack: f64) -> f64 {
        let cube = (crack + self.root).powi(3);
        let stiffness = self.longitudinal * self.width * self.arm.powi(3);
        match self.kind {
            FractureTestKind::DoubleCantileverBeam => 8.0 * cube / stiffness,
            FractureTestKind::EndNotchedFlexure => {
                let span = self.half_span;
                (2.0 * span.powi(3) + 3.0 * cube) / (8.0 * stiffness)
                    + 3.0 * span / (10.0 * self.shear * self.width * self.arm)
            }
            FractureTestKind::SingleEdgeNotchedBeam => self.notched_compliance(crack),
        }
    }

    /// Returns the compliance of a notched beam with stiff arms, m/N: the notch's turn 4 σ V/E' (Tada, Paris and Irwin, part 2), and
    /// bending and shear of the block.
    fn notched_compliance(&self, crack: f64) -> f64 {
        let (height, lever) = (2.0 * self.arm, 0.5 * self.half_span);
        let a = crack / height;
        let v = (a / (1.0 - a)).powi(2)
            * (5.93 - 19.69 * a + 37.14 * a * a - 35.84 * a.powi(3) + 13.12 * a.powi(4));
        let turn = 24.0 * v / (self.tip * self.width * height * height);
        let bending = 12.0 / (self.across * self.width * height * height);
        lever * lever * (turn + bending) + 0.3 / (self.shear * self.width)
    }

    /// Returns the energy release rate under a load (N) with a crack of a length (m), J/m².
    pub fn energy_release_rate(&self, load: f64, crack: f64) -> f64 {
        if self.kind == FractureTestKind::SingleEdgeNotchedBeam {
            let ligament = 2.0 * self.arm - crack;
            let moment = 0.5 * load * self.half_span;
            let intensity = DEEP_NOTCH * moment / self.width;
            return intensity * intensity / (ligament.powi(3) * self.tip);
        }
        let moment = load * (crack + self.root);
        let stiffness = self.longitudinal * self.width * self.width * self.arm.powi(3);
        let factor = match self.kind {
            FractureTestKind::EndNotchedFlexure => 9.0 / 16.0,
            _ => 12.0,
        };
        factor * moment * moment / stiffness
    }

    /// Returns the crack, with its correction of the root, that a compliance (m/N) tells (de Moura, Morais and Dourado 2008,
    /// *Engineering Fracture Mechanics* 75): with the process zone before it, which is softer than whole wood.
    fn equivalent_crack(&self, compliance: f64) -> f64 {
        let stiffness = self.longitudinal * self.width * self.arm.powi(3);
        let cube = match self.kind {
            FractureTestKind::EndNotchedFlexure => {
                let whole = self.compliance(-self.root);
                (compliance - whole) * 8.0 * stiffness / 3.0
            }
            _ => compliance * stiffness / 8.0,
        };
        cube.cbrt()
    }

    /// Returns the energy release rate under a load (N) with the crack that the compliance (m/N) tells, J/m².
    pub fn energy_release_rate_by_compliance(&self, load: f64, compliance: f64) -> f64 {
        self.energy_release_rate(load, self.equivalent_crack(compliance) - self.root)
    }

    /// Returns the load at which a crack of a length (m) has an energy release rate (J/m²), N.
    pub fn load(&self, rate: f64, crack: f64) -> f64 {
        (rate / self.energy_release_rate(1.0, crack)).sqrt()
    }
}

/// Returns the modulus K²/G (Pa) of a crack along the stiff direction of an orthotropic body without lateral contraction, of which
/// rods have none (Sih, Paris and Irwin 1965), over the square of the factor of orthotropy of K.
fn tip_modulus(along: f64, across: f64, shear: f64) -> f64 {
    let rho = (along * across).sqrt() / (2.0 * shear);
    let d = rho - 1.0;
    let factor = (1.0 + d * (0.1 + d * (-0.016 + d * 0.002))) / (0.5 + 0.5 * rho).sqrt().sqrt();
    let modulus = along.powf(0.25) * across.powf(0.75) / (0.5 + 0.5 * rho).sqrt();
    modulus / (factor * factor)
}
