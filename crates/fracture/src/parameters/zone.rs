//! Parameters that stand more than once: those of a tissue, of the layers, and of the ductile and
//! brittle zones.

use greenstick_schema::Unit::{Degree, Fraction, PerMetre, Radius};
use greenstick_schema::{count, number, parameters};
use greenstick_wood::tissue::Zone;

parameters! {
    /// Roughness and thorns of one tissue (Yang 2019, sections 3.2 and 3.5).
    pub struct ZoneParameters {
        "", "heights" {
            /// Height that Perlin noise adds at most (Eq. 1).
            perlin_amplitude: f64 = 0.05, number(Radius, 0.0, 5.0).symbol("λ");
            /// Perlin noise cells per metre of the noise diameter.
            perlin_frequency: f64 = 460.0, number(PerMetre, 1.0, 10000.0).symbol("β");
            /// Perlin noises added up, each of twice the frequency and half the height of the one
            /// before. The paper uses 2 to 3.
            perlin_octaves: u32 = 2, count(1, 4);
            /// Height that white noise, one value per cell, adds at most.
            white_noise_amplitude: f64 = 0.01, number(Radius, 0.0, 5.0);
            /// White noises added up, each of half the height of the one before. The paper uses 3
            /// to 4.
            white_noise_octaves: u32 = 3, count(1, 4);
            /// Height of the longest thorn (Eq. 8).
            thorn_length: f64 = 0.0, number(Radius, 0.0, 40.0).symbol("L");
            /// Probability that a cell carries a thorn (Eq. 8, where the sign is the wrong way
            /// round in print).
            thorn_probability: f64 = 0.0, number(Fraction, 0.0, 1.0).symbol("P");
        }
    }
}

impl ZoneParameters {
    /// The defaults of a tissue. Pith is soft and smooth; phloem and bark tear finer and rougher
    /// than wood.
    pub fn of(zone: Zone) -> ZoneParameters {
        let standard = ZoneParameters::default();
        match zone {
            Zone::Pith => ZoneParameters {
                perlin_amplitude: 0.02,
                ..standard
            },
            Zone::Heartwood | Zone::Sapwood => standard,
            Zone::Phloem | Zone::Bark => ZoneParameters {
                perlin_amplitude: 0.08,
                perlin_frequency: 1000.0,
                ..standard
            },
        }
    }
}

parameters! {
    /// A fan of the section that stands higher than the rest (section 3.3).
    pub struct HighLayer {
        "", "heights" {
            /// Height over the middle layer.
            height: f64 = 0.0, number(Radius, 0.0, 20.0).symbol("h");
            /// Direction of the fan's middle.
            direction: f64 = 0.0, number(Degree, 0.0, 360.0).symbol("α");
            /// Angle the fan takes.
            angle: f64 = 0.0, number(Degree, 0.0, 360.0).symbol("θ");
            /// Part of the rings the fan takes, from the outside.
            rings: f64 = 0.0, number(Fraction, 0.0, 1.0).symbol("μ");
        }
    }
}

parameters! {
    /// A fan of the section that stands lower than the rest (section 3.3).
    pub struct LowLayer {
        "", "heights" {
            /// Height against the middle layer, below zero.
            height: f64 = 0.0, number(Radius, -20.0, 0.0).symbol("h");
            /// Direction of the fan's middle.
            direction: f64 = 180.0, number(Degree, 0.0, 360.0).symbol("α");
            /// Angle the fan takes.
            angle: f64 = 0.0, number(Degree, 0.0, 360.0).symbol("θ");
            /// Part of the rings the fan takes, from the outside.
            rings: f64 = 0.0, number(Fraction, 0.0, 1.0).symbol("μ");
        }
    }
}

parameters! {
    /// The ductile fracture zone, on the tension side (section 3.4).
    pub struct DuctileZone {
        "", "heights" {
            /// Height of the longest thorn in the zone.
            thorn_length: f64 = 0.0, number(Radius, 0.0, 40.0).symbol("L_D");
            /// Probability that a cell of the zone carries a thorn.
            thorn_probability: f64 = 0.0, number(Fraction, 0.0, 1.0).symbol("P_D");
            /// Direction of the zone's middle: the side that was in tension. The compression side
            /// is opposite. A board bends flat: of its two faces, the one nearer to this direction was
            /// in tension.
            direction: f64 = 0.0, number(Degree, 0.0, 360.0).symbol("α");
            /// Angle the zone takes.
            angle: f64 = 150.0, number(Degree, 0.0, 360.0).symbol("θ");
            /// Part of the rings the zone takes, from the outside.
            rings: f64 = 0.6, number(Fraction, 0.0, 1.0).symbol("μ");
        }
    }
}

parameters! {
    /// The brittle fracture zone: all of the section that is not ductile (sections 3.4 and 3.5).
    pub struct BrittleZone {
        "", "heights" {
            /// Height of the longest thorn in the zone.
            thorn_length: f64 = 0.0, number(Radius, 0.0, 40.0).symbol("L");
            /// Probability that a cell of the zone carries a thorn.
            thorn_probability: f64 = 0.0, number(Fraction, 0.0, 1.0).symbol("P");
        }
    }
}

/// A fan of the section: the test of Eqs. 2 to 7, which wraps around 360° here (as printed, a fan
/// about 0° loses half).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sector {
    /// Direction of the middle, degrees.
    pub direction: f64,
    /// Angle it takes, degrees.
    pub angle: f64,
    /// Part of the rings it takes, from the outside.
    pub rings: f64,
}

impl Sector {
    /// Whether the point at `angle` (degrees, any turn) and ring coordinate `rho` (0..=1) lies in
    /// the fan. A fan of no angle or of no rings holds nothing.
    pub fn contains(&self, angle: f64, rho: f64) -> bool {
        if self.angle.is_nan() || self.angle <= 0.0 || rho.is_nan() || rho <= 1.0 - self.rings {
            return false;
        }
        let turned = angle - self.direction + 180.0;
        // The same as the remainder, bit for bit, without the call that it is.
        let turned = match turned {
            t if (0.0..360.0).contains(&t) => t,
            t if (-360.0..0.0).contains(&t) => t + 360.0,
            t if (360.0..720.0).contains(&t) => t - 360.0,
            t => t.rem_euclid(360.0),
        };
        (turned - 180.0).abs() <= 0.5 * self.angle
    }
}

impl Sector {
    /// Distance (radii) of a point at `angle` (degrees) and ring coordinate `rho` from the border of the fan, below 0 outside of it.
    pub fn depth(&self, angle: f64, rho: f64) -> f64 {
        let turned = (angle - self.direction + 180.0).rem_euclid(360.0) - 180.0;
        let beside = (0.5 * self.angle - turned.abs()).clamp(-90.0, 90.0);
        let beside = match self.angle < 360.0 {
            true => rho * libm::sin(beside.to_radians()),
            false => f64::INFINITY,
        };
        let across = match self.rings < 1.0 {
            true => rho - (1.0 - self.rings),
            false => f64::INFINITY,
        };
        // A whole section has no border; so deep is deep enough.
        beside.min(across).min(1.0)
    }
}

impl HighLayer {
    /// The fan it takes.
    pub fn sector(&self) -> Sector {
        Sector {
            direction: self.direction,
            angle: self.angle,
            rings: self.rings,
        }
    }
}

impl LowLayer {
    /// The fan it takes.
    pub fn sector(&self) -> Sector {
        Sector {
            direction: self.direction,
            angle: self.angle,
            rings: self.rings,
        }
    }
}

impl DuctileZone {
    /// The fan it takes.
    pub fn sector(&self) -> Sector {
        Sector {
            direction: self.direction,
            angle: self.angle,
            rings: self.rings,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec2;

    #[test]
    fn the_depth_in_a_fan_is_the_distance_from_its_border() {
        let place = |angle: f64, rho: f64| rho * DVec2::from_angle(angle.to_radians());
        for n in 0..40u32 {
            let unit = |what: i64| greenstick_wood::noise::unit(7, i64::from(n), what, 0);
            let fan = Sector {
                direction: 720.0 * unit(0) - 360.0,
                angle: 350.0 * unit(1) + 5.0,
                rings: 0.05 + 0.9 * unit(2),
            };
            // The two straight sides and the inner arc, by points.
            let inner = 1.0 - fan.rings;
            let along = (0..=400).map(|i| f64::from(i) / 400.0);
            let border: Vec<DVec2> = along
                .flat_map(|t| {
                    let [a, b] = [-0.5, 0.5].map(|side| fan.direction + side * fan.angle);
                    let rho = inner + t * fan.rings;
                    [place(a, rho), place(b, rho), place(a + t * (b - a), inner)]
                })
                .collect();
            for i in 0..60 {
                let (angle, rho) = (360.0 * unit(10 + i), unit(100 + i));
                let depth = fan.depth(angle, rho);
                if depth.abs() < 1e-9 {
                    continue;
                }
                assert_eq!(
                    depth > 0.0,
                    fan.contains(angle, rho),
                    "{fan:?} {angle} {rho}"
                );
                let at = place(angle, rho);
                let nearest = border.iter().fold(1.0, |d: f64, b| d.min(b.distance(at)));
                // A straight side ends at the inner arc, which is nearer there; beyond a right angle the pith is.
                if depth > 0.0 {
                    assert!(
                        (depth - nearest).abs() < 0.01,
                        "{fan:?} {angle} {rho}: {depth} {nearest}"
                    );
                }
            }
        }
    }

    #[test]
    fn a_fan_about_zero_keeps_both_halves() {
        let fan = Sector {
            direction: 0.0,
            angle: 60.0,
            rings: 0.5,
        };
        let held = (0..360)
            .filter(|&a| fan.contains(f64::from(a), 1.0))
            .count();
        assert_eq!(held, 61);
        assert!(fan.contains(-30.0, 0.6) && fan.contains(690.0, 0.6));
        assert!(!fan.contains(31.0, 1.0) && !fan.contains(0.0, 0.5));
        let whole = Sector {
            direction: 123.0,
            angle: 360.0,
            rings: 1.0,
        };
        assert!((0..360).all(|a| whole.contains(f64::from(a), 0.01)));
        assert!(!Sector { angle: 0.0, ..fan }.contains(0.0, 1.0));
    }
}
