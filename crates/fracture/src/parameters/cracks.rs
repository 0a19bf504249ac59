//! Parameters of drying cracks (Yang 2019, section 4), single ones and groups of them.
//!
//! Angles are degrees about the pith, ring coordinates run from 0 at the pith to 1 at the outside,
//! depths along the grain are ratios to the stem's radius. The opening is the shrinkage times the
//! range σ, so σ is a range of wood that gives way to the crack: in degrees for a radial crack, as
//! a part of the radius for a tangential one.

use super::Unit::{Degree, Fraction, Radius};
use super::declare::{auto, choice, choices, count, number, parameters, parameters_hold};
use super::{ParameterError, ParameterInfo, Parameters, Value};
use serde::{Deserialize, Serialize};

choices! {
    /// Which end of the piece carries the cracks.
    pub enum CrackEnd {
        /// The broken face.
        Break = "break",
        /// A sawn end, as after pruning.
        Sawn = "sawn",
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
        "radial crack" {
            /// Direction of the crack about the pith.
            angle: f64 = 0.0, "S_crack", number(Degree, 0.0, 360.0);
            /// Ring coordinate at which it begins.
            begin: f64 = 0.1, "R_begin", number(Fraction, 0.0, 1.0);
            /// Ring coordinate at which it ends; at 1 it opens through the bark.
            end: f64 = 0.9, "R_end", number(Fraction, 0.0, 1.0);
            /// Depth along the grain from the end face.
            depth: f64 = 1.0, "D_crack", number(Radius, 0.01, 40.0);
            /// Angle to either side of the crack in which the wood gives way.
            range: f64 = 20.0, "σ_crack", number(Degree, 0.1, 180.0);
            /// Shrinkage along the rings; "auto" takes the species' at its moisture.
            shrinkage: Option<f64> = None, "ε_tangential", auto(Fraction, 0.0, 0.5);
        }
    }
    groups {}
}
parameters_hold!(RadialCrack, |c| ordered(&[(
    "begin", c.begin, "end", c.end
)]));

parameters! {
    /// A crack along a ring (section 4.2).
    pub struct TangentialCrack {
        "tangential crack" {
            /// Ring coordinate of the crack, which runs along the nearest boundary of two rings.
            ring: f64 = 0.6, "R_crack", number(Fraction, 0.0, 1.0);
            /// Angle at which it begins.
            begin: f64 = 0.0, "S_begin", number(Degree, 0.0, 360.0);
            /// Angle at which it ends, counted on from the beginning; below it the crack runs on
            /// past 360°.
            end: f64 = 90.0, "S_end", number(Degree, 0.0, 360.0);
            /// Depth along the grain from the end face.
            depth: f64 = 1.0, "D_crack", number(Radius, 0.01, 40.0);
            /// Part of the radius to either side of the crack in which the wood gives way.
            range: f64 = 0.15, "σ_crack", number(Fraction, 0.001, 1.0);
            /// Shrinkage across the rings; "auto" takes the species' at its moisture.
            shrinkage: Option<f64> = None, "ε_radial", auto(Fraction, 0.0, 0.5);
        }
    }
    groups {}
}
parameters_hold!(TangentialCrack);

/// One crack.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Crack {
    /// Along a ray.
    Radial(RadialCrack),
    /// Along a ring.
    Tangential(TangentialCrack),
}

impl Crack {
    /// The words for the kinds.
    pub const KINDS: &'static [&'static str] = &["radial", "tangential"];

    /// A crack of a kind with its defaults.
    ///
    /// # Errors
    /// A word that is no kind.
    pub fn of_kind(word: &str) -> Result<Crack, ParameterError> {
        match word {
            "radial" => Ok(Crack::Radial(RadialCrack::default())),
            "tangential" => Ok(Crack::Tangential(TangentialCrack::default())),
            _ => Err(ParameterError::Choice {
                key: "kind".to_owned(),
                found: word.to_owned(),
                options: Crack::KINDS.join(", "),
            }),
        }
    }

    /// The word for its kind.
    pub fn kind(&self) -> &'static str {
        match self {
            Crack::Radial(_) => "radial",
            Crack::Tangential(_) => "tangential",
        }
    }

    /// Every parameter with its present value.
    pub fn list(&self) -> Vec<ParameterInfo> {
        match self {
            Crack::Radial(c) => c.list(),
            Crack::Tangential(c) => c.list(),
        }
    }

    /// Sets one parameter.
    ///
    /// # Errors
    /// As [`Parameters::set`].
    pub fn set(&mut self, key: &str, value: &Value) -> Result<(), ParameterError> {
        match self {
            Crack::Radial(c) => c.set(key, value),
            Crack::Tangential(c) => c.set(key, value),
        }
    }

    /// Checks ranges and order.
    ///
    /// # Errors
    /// As [`Parameters::check`].
    pub fn check(&self) -> Result<(), ParameterError> {
        match self {
            Crack::Radial(c) => c.check(),
            Crack::Tangential(c) => c.check(),
        }
    }
}

parameters! {
    /// Radial cracks of one size, drawn from what was measured of them on a section (section 5,
    /// Fig. 21).
    pub struct CrackGroup {
        "" {
            /// How many cracks.
            count: u32 = 0, "", count(0, 500);
            /// Direction of the first one.
            direction: f64 = 0.0, "", number(Degree, 0.0, 360.0);
            /// Mean angle from one crack to the next.
            spacing: f64 = 60.0, "", number(Degree, 0.0, 360.0);
            /// Part of the spacing by which an angle may be off.
            jitter: f64 = 0.3, "", number(Fraction, 0.0, 1.0);
            /// Least ring coordinate at which one begins.
            begin_min: f64 = 0.1, "R_begin", number(Fraction, 0.0, 1.0);
            /// Greatest ring coordinate at which one begins.
            begin_max: f64 = 0.4, "", number(Fraction, 0.0, 1.0);
            /// Least length along the radius; an end beyond the outside opens through the bark.
            length_min: f64 = 0.3, "", number(Fraction, 0.0, 1.0);
            /// Greatest length along the radius.
            length_max: f64 = 0.6, "", number(Fraction, 0.0, 1.0);
            /// Least depth along the grain.
            depth_min: f64 = 0.5, "", number(Radius, 0.01, 40.0);
            /// Greatest depth along the grain.
            depth_max: f64 = 1.0, "", number(Radius, 0.01, 40.0);
            /// Least angle to either side in which the wood gives way.
            range_min: f64 = 10.0, "σ_crack", number(Degree, 0.1, 180.0);
            /// Greatest angle to either side in which the wood gives way.
            range_max: f64 = 20.0, "", number(Degree, 0.1, 180.0);
            /// Shrinkage along the rings; "auto" takes the species' at its moisture.
            shrinkage: Option<f64> = None, "ε_tangential", auto(Fraction, 0.0, 0.5);
        }
    }
    groups {}
}
parameters_hold!(CrackGroup, |g| ordered(&[
    ("begin_min", g.begin_min, "begin_max", g.begin_max),
    ("length_min", g.length_min, "length_max", g.length_max),
    ("depth_min", g.depth_min, "depth_max", g.depth_max),
    ("range_min", g.range_min, "range_max", g.range_max),
]));

parameters! {
    /// What holds for all cracks, and the three groups of them.
    pub struct CrackSettings {
        "cracks" {
            /// Which end carries the cracks: "break" or "sawn".
            end: CrackEnd = CrackEnd::Break, "", choice(CrackEnd::WORDS);
            /// Random displacement of the cracks' course, radial and tangential (section 4.1, Fig.
            /// 12(b)).
            distortion: f64 = 0.02, "", number(Radius, 0.0, 0.5);
        }
    }
    groups {
        /// Large cracks.
        large: CrackGroup = CrackGroup::default();
        /// Cracks of middle size.
        medium: CrackGroup = CrackGroup::default();
        /// Small cracks.
        small: CrackGroup = CrackGroup::default();
    }
}
parameters_hold!(CrackSettings, |s| {
    for (name, group) in [
        ("large", &s.large),
        ("medium", &s.medium),
        ("small", &s.small),
    ] {
        group.consistent().map_err(|e| match e {
            ParameterError::Order {
                lower,
                low,
                upper,
                high,
            } => ParameterError::Order {
                lower: format!("{name}.{lower}"),
                low,
                upper: format!("{name}.{upper}"),
                high,
            },
            other => other,
        })?;
    }
    Ok(())
});

/// All cracks of a piece.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CrackParameters {
    /// What holds for all, and the groups.
    pub settings: CrackSettings,
    /// Cracks that are placed one by one.
    pub cracks: Vec<Crack>,
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

    /// Checks every range and order.
    ///
    /// # Errors
    /// The first that does not hold.
    pub fn check(&self) -> Result<(), ParameterError> {
        self.settings.check()?;
        self.cracks.iter().try_for_each(Crack::check)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cracks_that_end_before_they_begin_are_refused() {
        let mut crack = Crack::of_kind("radial").unwrap();
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
        assert!(
            Crack::of_kind("spiral")
                .unwrap_err()
                .to_string()
                .contains("radial, tangential")
        );
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
