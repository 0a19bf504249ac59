//! The shape of a stem's sections and the address of a point in one: an angle in turns and a radius.
//!
//! Round sections are addressed from their middle; those of squared timber from a core, a line as long as they are wider
//! than thick, so that equal steps of the angle are equal lengths of the girth, a flat side has one radius, and corners
//! stay where they are.

use glam::DVec2;
use std::f64::consts::TAU;

/// The shape of sections.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum SectionShape {
    /// Addressed from one middle.
    Round,
    /// A rectangle: half its thickness, and half its width less that, along the first axis.
    Squared {
        /// Half the thickness, m.
        half: f64,
        /// Half the length of the core, m.
        core: f64,
    },
}

impl SectionShape {
    /// Angle in turns, 0 to 1, and radius of a point.
    pub fn address(&self, p: DVec2) -> (f64, f64) {
        match *self {
            SectionShape::Round => {
                let turn = libm::atan2(p.y, p.x) / TAU;
                (turn - turn.floor(), p.length())
            }
            SectionShape::Squared { half, core } => {
                let from = p.x.clamp(-core, core);
                let d = DVec2::new(p.x - from, p.y);
                let radius = d.x.abs().max(d.y.abs());
                if radius <= 0.0 {
                    return (0.0, 0.0);
                }
                let on = DVec2::new(from, 0.0) + d * (half / radius);
                (turn_of_girth_point(on, half, core), radius)
            }
        }
    }

    /// The point at an angle in turns and a radius.
    pub fn point(&self, turn: f64, radius: f64) -> DVec2 {
        match *self {
            SectionShape::Round => {
                let angle = TAU * turn;
                DVec2::new(libm::cos(angle), libm::sin(angle)) * radius
            }
            SectionShape::Squared { half, core } => {
                let on = girth_point(turn, half, core);
                let from = on.x.clamp(-core, core);
                DVec2::new(from, 0.0) + DVec2::new(on.x - from, on.y) * (radius / half)
            }
        }
    }

    /// Girth at a mean radius, m.
    pub fn girth(&self, radius: f64) -> f64 {
        match *self {
            SectionShape::Round => TAU * radius,
            SectionShape::Squared { core, .. } => 8.0 * radius + 4.0 * core,
        }
    }

    /// Radius of the circle of the same area, m, at a mean radius.
    pub fn equal_radius(&self, radius: f64) -> f64 {
        match *self {
            SectionShape::Round => radius,
            SectionShape::Squared { core, .. } => {
                (4.0 * radius * (radius + core) / std::f64::consts::PI).sqrt()
            }
        }
    }

    /// Angles of the corners, in turns, ascending.
    pub fn corners(&self) -> Vec<f64> {
        match *self {
            SectionShape::Round => Vec::new(),
            SectionShape::Squared { half, core } => {
                let wide = core + half;
                [(wide, half), (-wide, half), (-wide, -half), (wide, -half)]
                    .map(|(x, y)| turn_of_girth_point(DVec2::new(x, y), half, core))
                    .to_vec()
            }
        }
    }
}

/// Position along the girth of a rectangle, in turns from the middle of its first narrow side.
fn turn_of_girth_point(p: DVec2, half: f64, core: f64) -> f64 {
    let wide = core + half;
    let along = if p.x >= wide * (1.0 - 1e-12) {
        if p.y >= 0.0 {
            p.y
        } else {
            8.0 * half + 4.0 * core + p.y
        }
    } else if p.x <= -wide * (1.0 - 1e-12) {
        half + 2.0 * wide + (half - p.y)
    } else if p.y > 0.0 {
        half + (wide - p.x)
    } else {
        3.0 * half + 2.0 * wide + (p.x + wide)
    };
    let turn = along / (8.0 * half + 4.0 * core);
    turn - turn.floor()
}

/// The point of a rectangle's girth at `turn`.
fn girth_point(turn: f64, half: f64, core: f64) -> DVec2 {
    let wide = core + half;
    let along = (turn - turn.floor()) * (8.0 * half + 4.0 * core);
    let sides = [
        half,
        half + 2.0 * wide,
        3.0 * half + 2.0 * wide,
        3.0 * half + 4.0 * wide,
    ];
    if along <= sides[0] {
        DVec2::new(wide, along)
    } else if along <= sides[1] {
        DVec2::new(wide - (along - sides[0]), half)
    } else if along <= sides[2] {
        DVec2::new(-wide, half - (along - sides[1]))
    } else if along <= sides[3] {
        DVec2::new(along - sides[2] - wide, -half)
    } else {
        DVec2::new(wide, along - sides[3] - half)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_lead_back_and_corners_are_corners() {
        for shape in [
            SectionShape::Round,
            SectionShape::Squared {
                half: 0.07,
                core: 0.03,
            },
            SectionShape::Squared {
                half: 0.01,
                core: 0.0,
            },
        ] {
            for k in 0..1000 {
                let turn = f64::from(k) / 1000.0;
                for radius in [0.02, 0.1] {
                    let (t, r) = shape.address(shape.point(turn, radius));
                    let off = (t - turn + 0.5).rem_euclid(1.0) - 0.5;
                    assert!(off.abs() < 1e-9 && (r - radius).abs() < 1e-12, "{turn} {t}");
                }
            }
        }
        let shape = SectionShape::Squared {
            half: 0.07,
            core: 0.03,
        };
        let corners = shape.corners();
        assert!(corners.is_sorted());
        let expected = [(0.1, 0.07), (-0.1, 0.07), (-0.1, -0.07), (0.1, -0.07)];
        for (turn, (x, y)) in corners.into_iter().zip(expected) {
            assert!(shape.point(turn, 0.07).distance(DVec2::new(x, y)) < 1e-12);
        }
        assert!((shape.girth(0.07) - 0.68).abs() < 1e-12);
    }
}
