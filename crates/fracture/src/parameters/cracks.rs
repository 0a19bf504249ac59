//! Parameters of drying cracks (Yang 2019, section 4), single ones and groups of them.
//!
//! Angles are degrees about the pith, ring coordinates run from 0 at the pith to 1 at the outside,
//! depths along the grain are ratios to the stem's radius. The opening is the shrinkage times the
//! range σ, so σ is a range of wood that gives way to the crack: in degrees for a radial crack, as
//! a part of the radius for a tangential one.

use greenstick_schema::Unit::{Degree, Fraction, Radius};
use greenstick_schema::{
    Field, ParameterError, ParameterInfo, Parameters, Scale, Value, choice, choices, count, number,
    parameters,
};
use serde::{Deserialize, Serialize};

choices! {
    /// Which end of the piece carries the cracks.
    pub enum CrackEnd {
        /// The broken face.
        Break = "break",
        /// The sawn end at the tip, as after pruning.
        Sawn = "sawn",
        /// The sawn end at the base, as of a log.
        Base = "base",
    }
}

fn ordered(pairs: &[(&str, f64, &str, f64)]) -> Result<(), ParameterError> {
    match pairs.iter().find(|(_, low, _, high)| low > high) {
        None => Ok(()),
        Some(&(lower, low, upper, high)) => Err(ParameterError::Order {
            lower: lower.to_owned(),
            low,
            upper: upper.to_owned(),
            high,
        }),
    }
}

parameters! {
    /// A crack along a ray (section 4.1).
    pub struct RadialCrack {
        "radial crack", "cut" {
            /// Direction of the crack about the pith.
            angle: f64 = 0.0, number(Degree, 0.0, 360.0).symbol("S_crack");
            /// Ring coordinate at which it begins.
            begin: f64 = 0.1, number(Fraction, 0.0, 1.0).symbol("R_begin");
            /// Ring coordinate at which it ends; at 1 it opens through the bark.
            end: f64 = 0.9, number(Fraction, 0.0, 1.0).symbol("R_end");
            /// Depth along the grain from the end face.
            depth: f64 = 1.0, number(Radius, 0.01, 40.0).symbol("D_crack");
            /// Angle to either side of the crack in which the wood gives way.
            range: f64 = 20.0, number(Degree, 0.1, 180.0).symbol("σ_crack");
            /// Shrinkage along the rings; "auto" takes the species' at its moisture.
            shrinkage: Option<f64> = None, number(Fraction, 0.0, 0.5).auto().symbol("ε_tangential");
        }
    }
    check |c| ordered(&[(
        "begin", c.begin, "end", c.end
    )]);
}

parameters! {
    /// A crack along a ring (section 4.2).
    pub struct TangentialCrack {
        "tangential crack", "cut" {
            /// Ring coordinate of the crack, which runs along the nearest boundary of two rings.
            ring: f64 = 0.6, number(Fraction, 0.0, 1.0).symbol("R_crack");
            /// Angle at which it begins.
            begin: f64 = 0.0, number(Degree, 0.0, 360.0).symbol("S_begin");
            /// Angle at which it ends, counted on from the beginning; below it the crack runs on
            /// past 360°.
            end: f64 = 90.0, number(Degree, 0.0, 360.0).symbol("S_end");
            /// Depth along the grain from the end face.
            depth: f64 = 1.0, number(Radius, 0.01, 40.0).symbol("D_crack");
            /// Part of the radius to either side of the crack in which the wood gives way.
            range: f64 = 0.15, number(Fraction, 0.001, 1.0).symbol("σ_crack");
            /// Shrinkage across the rings; "auto" takes the species' at its moisture.
            shrinkage: Option<f64> = None, number(Fraction, 0.0, 0.5).auto().symbol("ε_radial");
        }
    }
}

/// One crack.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Crack {
    /// Along a ray.
    Radial(RadialCrack),
    /// Along a ring.
    Tangential(TangentialCrack),
}

choices! {
    /// Kinds of crack.
    pub enum CrackKind {
        /// Along a ray, from the pith outwards.
        Radial = "radial",
        /// Along a ring.
        Tangential = "tangential",
    }
}

/// Key of a crack's kind.
const KIND: &str = "kind";

impl Default for Crack {
    fn default() -> Self {
        Crack::new(CrackKind::Radial)
    }
}

impl Crack {
    /// A crack of a kind with its defaults.
    pub fn new(kind: CrackKind) -> Crack {
        match kind {
            CrackKind::Radial => Crack::Radial(RadialCrack::default()),
            CrackKind::Tangential => Crack::Tangential(TangentialCrack::default()),
        }
    }

    /// Its kind.
    pub fn kind(&self) -> CrackKind {
        match self {
            Crack::Radial(_) => CrackKind::Radial,
            Crack::Tangential(_) => CrackKind::Tangential,
        }
    }

    fn parameters(&self) -> &dyn Parameters {
        match self {
            Crack::Radial(c) => c,
            Crack::Tangential(c) => c,
        }
    }

    fn parameters_mut(&mut self) -> &mut dyn Parameters {
        match self {
            Crack::Radial(c) => c,
            Crack::Tangential(c) => c,
        }
    }
}

impl Parameters for Crack {
    fn describe(&self, prefix: &str, list: &mut Vec<ParameterInfo>) {
        let value = self.kind().to_value();
        list.push(ParameterInfo {
            key: greenstick_schema::macro_support::join(prefix, KIND),
            symbol: String::new(),
            group: "crack".to_owned(),
            doc: "Whether the crack runs along a ray or along a ring.".to_owned(),
            kind: choice(CrackKind::CHOICES).kind,
            auto: false,
            words: &[],
            scale: Scale::Linear,
            stage: "cut",
            default: value.clone(),
            value,
        });
        self.parameters().describe(prefix, list);
    }

    fn assign(&mut self, key: &str, value: &Value) -> bool {
        if key != KIND {
            return self.parameters_mut().assign(key, value);
        }
        match CrackKind::from_value(value) {
            Some(kind) if kind == self.kind() => true,
            Some(kind) => {
                *self = Crack::new(kind);
                true
            }
            None => false,
        }
    }

    fn consistent(&self) -> Result<(), ParameterError> {
        self.parameters().consistent()
    }

    fn tag(&self) -> Option<&'static str> {
        Some(KIND)
    }

    fn variants(&self) -> Vec<Box<dyn Parameters>> {
        [CrackKind::Radial, CrackKind::Tangential]
            .map(|kind| Box::new(Crack::new(kind)) as Box<dyn Parameters>)
            .into()
    }

    fn defaults(&self) -> Box<dyn Parameters> {
        Box::new(Crack::new(self.kind()))
    }
}

parameters! {
    /// Radial cracks of one size, drawn from what was measured of them on a section (section 5,
    /// Fig. 21).
    pub struct CrackGroup {
        "", "cut" {
            /// How many cracks.
            count: u32 = 0, count(0, 500);
            /// Direction of the first one.
            direction: f64 = 0.0, number(Degree, 0.0, 360.0);
            /// Mean angle from one crack to the next.
            spacing: f64 = 60.0, number(Degree, 0.0, 360.0);
            /// Part of the spacing by which an angle may be off.
            jitter: f64 = 0.3, number(Fraction, 0.0, 1.0);
            /// Least ring coordinate at which one begins.
            begin_min: f64 = 0.1, number(Fraction, 0.0, 1.0).symbol("R_begin");
            /// Greatest ring coordinate at which one begins.
            begin_max: f64 = 0.4, number(Fraction, 0.0, 1.0);
            /// Least length along the radius; an end beyond the outside opens through the bark.
            length_min: f64 = 0.3, number(Fraction, 0.0, 1.0);
            /// Greatest length along the radius.
            length_max: f64 = 0.6, number(Fraction, 0.0, 1.0);
            /// Least depth along the grain.
            depth_min: f64 = 0.5, number(Radius, 0.01, 40.0);
            /// Greatest depth along the grain.
            depth_max: f64 = 1.0, number(Radius, 0.01, 40.0);
            /// Least angle to either side in which the wood gives way.
            range_min: f64 = 10.0, number(Degree, 0.1, 180.0).symbol("σ_crack");
            /// Greatest angle to either side in which the wood gives way.
            range_max: f64 = 20.0, number(Degree, 0.1, 180.0);
            /// Shrinkage along the rings; "auto" takes the species' at its moisture.
            shrinkage: Option<f64> = None, number(Fraction, 0.0, 0.5).auto().symbol("ε_tangential");
        }
    }
    check |g| ordered(&[
        ("begin_min", g.begin_min, "begin_max", g.begin_max),
        ("length_min", g.length_min, "length_max", g.length_max),
        ("depth_min", g.depth_min, "depth_max", g.depth_max),
        ("range_min", g.range_min, "range_max", g.range_max),
    ]);
}

parameters! {
    /// What holds for all cracks, and the three groups of them.
    pub struct CrackSettings {
        "cracks", "cut" {
            /// Which end carries the cracks: the broken face, the sawn end at the tip, or that at the base.
            end: CrackEnd = CrackEnd::Break, choice(CrackEnd::CHOICES).stage("stem");
            /// Random displacement of the cracks' course, radial and tangential (section 4.1, Fig.
            /// 12(b)).
            distortion: f64 = 0.02, number(Radius, 0.0, 0.5);
        }
    }
    tables {
        /// Large cracks.
        large: CrackGroup = CrackGroup::default();
        /// Cracks of middle size.
        medium: CrackGroup = CrackGroup::default();
        /// Small cracks.
        small: CrackGroup = CrackGroup::default();
    }
}

parameters! {
    /// All cracks of a piece.
    pub struct CrackParameters {}
    tables {
        /// Cracks drawn at random in groups, and what holds for all cracks.
        settings as "crack_groups": CrackSettings = CrackSettings::default();
    }
    lists {
        /// Cracks that are placed one by one.
        cracks as "crack": Crack;
    }
}

impl CrackParameters {
    /// Whether there are no cracks at all.
    pub fn is_empty(&self) -> bool {
        let s = &self.settings;
        self.cracks.is_empty() && [&s.large, &s.medium, &s.small].iter().all(|g| g.count == 0)
    }

    /// Brings every tangential crack to the nearest boundary between two of so many rings, which is where wood parts along
    /// them. Gives how many were moved.
    pub fn follow_rings(&mut self, rings: u32) -> usize {
        let count = f64::from(rings.max(2));
        let mut moved = 0;
        for crack in &mut self.cracks {
            if let Crack::Tangential(c) = crack {
                let boundary = (c.ring * count).round().clamp(1.0, count - 1.0) / count;
                moved += usize::from((boundary - c.ring).abs() > 1e-9);
                c.ring = boundary;
            }
        }
        moved
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cracks_that_end_before_they_begin_are_refused() {
        let mut crack = Crack::new(CrackKind::Radial);
        crack.set("begin", &Value::Number(0.95)).unwrap();
        let message = crack.check().unwrap_err().to_string();
        assert_eq!(
            message,
            "begin is 0.95 and end is 0.9, but the first must not be above the second"
        );
        let mut settings = CrackSettings::default();
        settings.set_text("medium.depth_min", "2").unwrap();
        assert!(
            settings
                .check()
                .unwrap_err()
                .to_string()
                .starts_with("medium.depth_min is 2")
        );
        let mut crack = Crack::default();
        let message = crack.set_text("kind", "spiral").unwrap_err().to_string();
        assert!(message.contains("radial, tangential"), "{message}");
    }

    #[test]
    fn shrinkage_is_a_number_or_auto() {
        let mut crack = RadialCrack::default();
        crack.set_text("shrinkage", "8 %").unwrap();
        assert_eq!(crack.shrinkage, Some(0.08));
        crack.set_text("shrinkage", "auto").unwrap();
        assert_eq!(crack.shrinkage, None);
        assert!(crack.set_text("depth", "auto").is_err());
    }
}
