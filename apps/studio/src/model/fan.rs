//! Fans of the section that have parameters of their own – the ductile zone, the high layer, the low layer –, and what a drag of
//! their edges means.

use super::project::Project;
use greenstick::fracture::parameters::BreakParameters;

/// Least angle that a dragged fan takes, degrees, and least part of the rings.
const NARROWEST: f64 = 2.0;
const THINNEST: f64 = 0.02;
/// Greatest height of a layer, radii.
const HIGHEST: f64 = 20.0;
/// What a layer that is not there yet begins with: its angle, its part of the rings, and its height, radii.
const FIRST_ANGLE: f64 = 70.0;
const FIRST_RINGS: f64 = 0.5;
const FIRST_HEIGHT: f64 = 0.7;
/// Nobody drags more exactly than to these parts of a degree and of a radius, and short numbers can be read.
const DEGREE: f64 = 10.0;
const RADIUS: f64 = 1000.0;

/// Which fan.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FanKind {
    /// The ductile zone: where long splinters stand.
    Ductile,
    /// The fan that stands higher.
    High,
    /// The fan that stands lower.
    Low,
}

/// A part of a fan that can be dragged.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FanPart {
    /// The edge at its least angle.
    Start,
    /// The edge at its greatest angle.
    End,
    /// Its middle: turns it and, for a layer, raises it.
    Middle,
    /// Its bound towards the pith.
    Inner,
}

impl FanPart {
    /// All parts.
    pub const ALL: [FanPart; 4] = [
        FanPart::Start,
        FanPart::End,
        FanPart::Middle,
        FanPart::Inner,
    ];
}

/// A fan of the section.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fan {
    /// Direction of its middle, degrees.
    pub direction: f64,
    /// The angle that it takes, degrees.
    pub angle: f64,
    /// The part of the rings that it takes, from the outside.
    pub rings: f64,
    /// Its height over the rest, radii; none for a zone, which has no height of its own.
    pub height: Option<f64>,
}

fn rounded(x: f64, parts: f64) -> f64 {
    (x * parts).round() / parts
}

fn turned(degrees: f64) -> f64 {
    // A direction that rounds to a whole turn is 0.
    rounded(degrees.rem_euclid(360.0), DEGREE) % 360.0
}

impl Fan {
    /// That of a face.
    pub fn of(face: &BreakParameters, kind: FanKind) -> Fan {
        let (sector, height) = match kind {
            FanKind::Ductile => (face.ductile.sector(), None),
            FanKind::High => (face.high.sector(), Some(face.high.height)),
            FanKind::Low => (face.low.sector(), Some(face.low.height)),
        };
        Fan {
            direction: sector.direction,
            angle: sector.angle,
            rings: sector.rings,
            height,
        }
    }

    /// Writes it into a face.
    fn put(self, face: &mut BreakParameters, kind: FanKind) {
        let Fan {
            direction,
            angle,
            rings,
            height,
        } = self;
        let height = height.unwrap_or(0.0);
        match kind {
            FanKind::Ductile => {
                let zone = &mut face.ductile;
                (zone.direction, zone.angle, zone.rings) = (direction, angle, rings);
            }
            FanKind::High => {
                let layer = &mut face.high;
                (layer.direction, layer.angle, layer.rings) = (direction, angle, rings);
                layer.height = height;
            }
            FanKind::Low => {
                let layer = &mut face.low;
                (layer.direction, layer.angle, layer.rings) = (direction, angle, rings);
                layer.height = height;
            }
        }
    }

    /// Whether there is such a fan.
    pub fn is_there(self) -> bool {
        self.angle > 0.0 && self.rings > 0.0 && self.height != Some(0.0)
    }

    /// The fan as it is drawn: where there is none, the one that a drag would begin with.
    pub fn or_first(self, kind: FanKind) -> Fan {
        let or = |value: f64, first: f64| if value == 0.0 { first } else { value };
        let first = match kind {
            FanKind::Low => -FIRST_HEIGHT,
            _ => FIRST_HEIGHT,
        };
        Fan {
            angle: or(self.angle, FIRST_ANGLE),
            rings: or(self.rings, FIRST_RINGS),
            height: self.height.map(|h| or(h, first)),
            ..self
        }
    }

    /// The angles of its edges, degrees, the first one first.
    pub fn edges(self) -> (f64, f64) {
        let half = 0.5 * self.angle;
        (self.direction - half, self.direction + half)
    }

    /// Ring coordinate of its bound towards the pith.
    pub fn inner(self) -> f64 {
        1.0 - self.rings
    }

    /// The fan with an edge at another angle, degrees; the other edge stays. An edge that is dragged past the other stops there.
    pub fn with_edge(self, part: FanPart, angle: f64) -> Fan {
        let (start, end) = self.edges();
        let width = match part {
            FanPart::Start => end - angle,
            _ => angle - start,
        };
        let width = width.rem_euclid(360.0);
        // A drag moves by less than half a turn from frame to frame: what is more has passed the other edge.
        let width = match width - self.angle {
            change if change > 180.0 => NARROWEST,
            change if change < -180.0 => 360.0,
            _ => width.max(NARROWEST),
        };
        let width = rounded(width, DEGREE);
        let direction = match part {
            FanPart::Start => end - 0.5 * width,
            _ => start + 0.5 * width,
        };
        Fan {
            direction: rounded(direction.rem_euclid(360.0), 2.0 * DEGREE) % 360.0,
            angle: width,
            ..self
        }
    }

    /// The fan turned to a direction, degrees, and, where it is a layer, at a height, radii.
    pub fn with_middle(self, kind: FanKind, direction: f64, height: f64) -> Fan {
        let (low, high) = match kind {
            FanKind::Low => (-HIGHEST, -1.0 / RADIUS),
            _ => (1.0 / RADIUS, HIGHEST),
        };
        Fan {
            direction: turned(direction),
            height: self
                .height
                .map(|_| rounded(height.clamp(low, high), RADIUS)),
            ..self
        }
    }

    /// The fan with its bound towards the pith at a ring coordinate.
    pub fn with_inner(self, rho: f64) -> Fan {
        Fan {
            rings: rounded((1.0 - rho).clamp(THINNEST, 1.0), RADIUS),
            ..self
        }
    }
}

impl FanKind {
    /// What steps back call a change of it, and what it is.
    pub fn label(self) -> &'static str {
        match self {
            FanKind::Ductile => "ductile zone",
            FanKind::High => "high layer",
            FanKind::Low => "low layer",
        }
    }
}

impl Project {
    /// The fan of a break.
    pub fn fan(&self, number: usize, kind: FanKind) -> Fan {
        let one = self.file.breaks.get(number).unwrap_or(&self.file.common);
        Fan::of(&one.recipe.face, kind)
    }

    /// Lays a fan of the selected break otherwise, or that of all.
    ///
    /// # Errors
    /// As [`Project::change`].
    pub fn lay_fan(&mut self, kind: FanKind, fan: Fan, drag: bool) -> Result<bool, String> {
        let selected = self.selected();
        self.change(kind.label(), drag, |file| {
            let breaks = file.breaks.iter_mut().enumerate();
            let own = breaks.filter(|(i, _)| selected.is_none_or(|s| s == *i));
            let common = selected.is_none().then_some(&mut file.common);
            for one in own.map(|(_, one)| one).chain(common) {
                fan.put(&mut one.recipe.face, kind);
            }
            Ok::<(), String>(())
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::input::Input;
    use greenstick::RequestFile;

    #[test]
    fn an_edge_moves_alone_and_stops_at_the_other() {
        let fan = Fan {
            direction: 350.0,
            angle: 60.0,
            rings: 0.6,
            height: None,
        };
        // Over the seam, in steps as a hand moves.
        let mut dragged = fan;
        for angle in [20.0, 40.0, 75.0] {
            dragged = dragged.with_edge(FanPart::End, angle);
            assert_eq!(dragged.edges().0.rem_euclid(360.0), 320.0, "{dragged:?}");
            assert_eq!(dragged.edges().1.rem_euclid(360.0), angle, "{dragged:?}");
        }
        let start = fan.with_edge(FanPart::Start, 300.0);
        assert_eq!((start.direction, start.angle), (340.0, 80.0));
        // Past the other edge it stays as narrow as can be, and around the stem the whole of it.
        let past = fan.with_edge(FanPart::End, 319.0);
        assert_eq!(past.angle, NARROWEST);
        let wide = Fan {
            angle: 350.0,
            ..fan
        }
        .with_edge(FanPart::End, 176.0);
        assert_eq!(wide.angle, 360.0);
        assert_eq!(fan.with_inner(-0.2).rings, 1.0);
        assert_eq!(fan.with_inner(0.75).rings, 0.25);
    }

    #[test]
    fn a_layer_begins_with_the_first_drag_and_is_one_step() {
        let mut project = Project::new(Input::built_in(), RequestFile::default());
        for kind in [FanKind::High, FanKind::Low] {
            let before = project.fan(0, kind);
            assert!(!before.is_there());
            let first = before.or_first(kind);
            assert!(first.is_there());
            let raised = first.with_middle(kind, -30.0, 3.0);
            assert_eq!(raised.direction, 330.0);
            assert_eq!(raised.height.unwrap() > 0.0, kind == FanKind::High);
            assert_eq!(project.lay_fan(kind, raised, true), Ok(true));
            assert_eq!(project.fan(0, kind), raised);
        }
        assert_eq!(project.undo().as_deref(), Some("low layer"));
        assert_eq!(project.undo().as_deref(), Some("high layer"));
        assert_eq!(project.file, RequestFile::default());
    }
}
