//! Drying cracks that are placed by hand: what a drag over the wood means, and where a crack lies on it.

pub use super::crack_face::{CrackFace, Polar};
use super::project::Project;
use greenstick::RequestFile;
use greenstick::fracture::parameters::{
    Crack, CrackEnd, CrackParameters, RadialCrack, TangentialCrack,
};

/// Ring coordinate from which on a point is on the bark: a crack that reaches it opens there.
pub const BARK: f32 = 0.96;
/// Least length of a crack, as a ring coordinate, and of a ring shake, degrees.
const SHORTEST: f32 = 0.08;
const NARROWEST: f32 = 8.0;
/// How much farther around the pith than outwards a drag goes that follows a ring.
const AROUND: f32 = 1.5;
/// Ring coordinates inwards and outwards of a click that a crack takes.
const INWARDS: f32 = 0.45;
const OUTWARDS: f32 = 0.35;
/// Range of depths, radii.
const DEPTHS: (f64, f64) = (0.01, 40.0);
/// Points along a course.
const POINTS: usize = 25;

/// The part of a crack that is held.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CrackEndPoint {
    /// Where it begins.
    Begin,
    /// Where it ends.
    End,
    /// How deep it is.
    Depth,
}

/// The whole turn in which an angle lies, degrees from 0 to 360.
fn degrees(angle: f32) -> f64 {
    f64::from(angle).to_degrees().rem_euclid(360.0)
}

/// The crack that a drag from one place to another means: along a ray, or, where it goes around the pith, along a ring. A click is a
/// drag to where it began.
pub fn crack_of_drag(from: Polar, to: Polar) -> Crack {
    let turn = (to.1 - from.1 + std::f32::consts::PI).rem_euclid(std::f32::consts::TAU)
        - std::f32::consts::PI;
    let (around, outwards) = (turn.abs() * from.0.min(1.0), (to.0 - from.0).abs());
    if around > AROUND * outwards && around > SHORTEST && from.0 < BARK {
        let (first, last) = if turn > 0.0 {
            (from.1, to.1)
        } else {
            (to.1, from.1)
        };
        return Crack::Tangential(TangentialCrack {
            ring: f64::from(from.0.clamp(0.05, 0.95)),
            begin: degrees(first),
            end: degrees(last),
            ..TangentialCrack::default()
        });
    }
    let (low, high) = if from.0 >= BARK {
        (to.0.min(1.0 - INWARDS), 1.0)
    } else if outwards < SHORTEST {
        (from.0 - INWARDS, from.0 + OUTWARDS)
    } else {
        (from.0.min(to.0), from.0.max(to.0))
    };
    let mut crack = RadialCrack {
        angle: degrees(from.1),
        ..RadialCrack::default()
    };
    (crack.begin, crack.end) = between(low, high);
    Crack::Radial(crack)
}

/// Ring coordinates that a radial crack may have; what nearly reaches the bark does.
fn between(low: f32, high: f32) -> (f64, f64) {
    let end = if high >= BARK {
        1.0
    } else {
        high.max(2.0 * SHORTEST)
    };
    let begin = low.clamp(0.0, end - SHORTEST);
    (f64::from(begin), f64::from(end))
}

/// A crack of which a part is dragged to a place.
pub fn dragged_to(crack: &Crack, part: CrackEndPoint, to: Polar) -> Crack {
    let mut crack = crack.clone();
    match (&mut crack, part) {
        (Crack::Radial(c), CrackEndPoint::Begin) => {
            c.begin = f64::from(to.0.max(0.0))
                .min(c.end - f64::from(SHORTEST))
                .max(0.0);
            c.angle = degrees(to.1);
        }
        (Crack::Radial(c), CrackEndPoint::End) => {
            (_, c.end) = between(c.begin as f32, to.0.max(c.begin as f32 + SHORTEST));
            c.angle = degrees(to.1);
        }
        (Crack::Tangential(c), CrackEndPoint::Begin) => c.begin = degrees(to.1),
        (Crack::Tangential(c), CrackEndPoint::End) => {
            c.end = degrees(to.1);
            c.ring = f64::from(to.0.clamp(0.05, 0.95));
        }
        (_, CrackEndPoint::Depth) => {}
    }
    if let Crack::Tangential(c) = &mut crack
        && (c.end - c.begin).rem_euclid(360.0) < f64::from(NARROWEST)
    {
        c.end = (c.begin + f64::from(NARROWEST)).rem_euclid(360.0);
    }
    crack
}

/// The depth of a crack, radii.
pub fn depth(crack: &Crack) -> f64 {
    match crack {
        Crack::Radial(c) => c.depth,
        Crack::Tangential(c) => c.depth,
    }
}

/// A crack with another depth, radii.
pub fn with_depth(crack: &Crack, depth: f32) -> Crack {
    let mut crack = crack.clone();
    let depth = f64::from(depth).clamp(DEPTHS.0, DEPTHS.1);
    match &mut crack {
        Crack::Radial(c) => c.depth = depth,
        Crack::Tangential(c) => c.depth = depth,
    }
    crack
}

/// The places of a crack's course, from its beginning to its end.
pub fn course(crack: &Crack) -> Vec<Polar> {
    let steps = (0..POINTS).map(|k| k as f64 / (POINTS - 1) as f64);
    let place = |t: f64| match crack {
        Crack::Radial(c) => (c.begin + (c.end - c.begin) * t, c.angle.to_radians()),
        Crack::Tangential(c) => {
            let turn = if c.end < c.begin { 360.0 } else { 0.0 };
            (
                c.ring,
                (c.begin + (c.end + turn - c.begin) * t).to_radians(),
            )
        }
    };
    steps
        .map(place)
        .map(|(r, a)| (r as f32, a as f32))
        .collect()
}

/// What a crack is, in words.
pub fn describe(crack: &Crack) -> String {
    match crack {
        Crack::Radial(c) => format!(
            "crack at {:.0}°, rings {:.2} to {:.2}, {:.2} radii deep",
            c.angle, c.begin, c.end, c.depth
        ),
        Crack::Tangential(c) => format!(
            "ring shake at {:.2}, {:.0}° to {:.0}°, {:.2} radii deep",
            c.ring, c.begin, c.end, c.depth
        ),
    }
}

impl Project {
    /// The cracks that are placed one by one at the selected break, or the first.
    pub fn placed_cracks(&self) -> &[Crack] {
        &self.cracks().cracks
    }

    fn cracks(&self) -> &CrackParameters {
        let number = self.selected().unwrap_or(0);
        let one = self.file.breaks.get(number).unwrap_or(&self.file.common);
        &one.recipe.cracks
    }

    /// Where the cracks of that break are; none where it has none.
    pub fn crack_end(&self) -> Option<CrackEnd> {
        let cracks = self.cracks();
        (!cracks.is_empty()).then_some(cracks.settings.end)
    }

    /// Changes the placed cracks of the selected break, or of all.
    ///
    /// # Errors
    /// As [`Project::change`].
    pub fn change_cracks(
        &mut self,
        label: &str,
        drag: bool,
        change: impl Fn(&mut CrackParameters),
    ) -> Result<bool, String> {
        let selected = self.selected();
        self.change(label, drag, |file: &mut RequestFile| {
            let breaks = file.breaks.iter_mut().enumerate();
            let own = breaks.filter(|(i, _)| selected.is_none_or(|s| s == *i));
            let common = selected.is_none().then_some(&mut file.common);
            for one in own.map(|(_, one)| one).chain(common) {
                change(&mut one.recipe.cracks);
            }
            Ok::<(), String>(())
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::engine::{Engine, Haste, Job};
    use crate::model::input::Input;
    use crate::model::meshes::DrawnScene;
    use glam::{Vec2, Vec3};
    use greenstick::geometry::Context;
    use greenstick::schema::Parameters;

    fn radial(crack: &Crack) -> (f64, f64, f64) {
        match crack {
            Crack::Radial(c) => (c.angle, c.begin, c.end),
            Crack::Tangential(_) => panic!("{crack:?}"),
        }
    }

    #[test]
    fn drags_mean_what_they_look_like() {
        let close = |a: f64, b: f64| (a - b).abs() < 1e-5;
        let (angle, begin, end) = radial(&crack_of_drag((0.2, 1.0), (0.7, 1.02)));
        assert!(close(angle, 1f64.to_degrees()) && close(begin, 0.2) && close(end, 0.7));
        // Inwards it is the same crack, and near the bark it opens through it.
        let (_, begin, end) = radial(&crack_of_drag((0.9, 1.0), (0.3, 1.0)));
        assert!(close(begin, 0.3) && close(end, 0.9));
        assert_eq!(radial(&crack_of_drag((0.5, -0.5), (0.99, -0.5))).2, 1.0);
        let Crack::Tangential(c) = crack_of_drag((0.6, 0.3), (0.62, -0.9)) else {
            panic!("a drag around the pith is a ring shake");
        };
        assert!(close(c.begin, degrees(-0.9)) && close(c.end, 0.3f64.to_degrees()));
        // Whatever is dragged, the schema takes it.
        let places = [0.0, 0.02, 0.3, 0.95, 1.0, 1.7];
        let angles = [-3.1, -0.2, 0.0, 1.5, 3.1];
        for from in places.map(|r| angles.map(|a| (r, a))).concat() {
            for to in places.map(|r| angles.map(|a| (r, a))).concat() {
                let crack = crack_of_drag(from, to);
                crack.check().unwrap();
                for part in [CrackEndPoint::Begin, CrackEndPoint::End] {
                    dragged_to(&crack, part, to).check().unwrap();
                }
                with_depth(&crack, to.0 - 0.5).check().unwrap();
            }
        }
    }

    fn drawn() -> DrawnScene {
        let job = Job {
            input: Input::built_in(),
            file: RequestFile::default(),
            haste: Haste::Whole,
            sections_of: None,
        };
        let shown = Engine::default().work(&job, &mut |_| {}, &Context::quiet());
        shown.unwrap().unwrap().drawn
    }

    #[test]
    fn a_ray_picks_the_place_that_is_drawn_under_it() {
        let drawn = drawn();
        let face = CrackFace::new(&drawn, 0).unwrap();
        for place in [(0.3, 0.4), (0.8, -2.0), (0.97, 3.0)] {
            let height = 0.2 * face.radius();
            let point = face.point(place, height);
            let direction = (Vec3::new(0.3, -0.2, 0.1) - face.along()).normalize();
            let origin = point - direction * 2.0;
            let (rho, angle) = face.met(origin, direction, height).unwrap();
            assert!((rho - place.0).abs() < 2e-3 && (angle - place.1).abs() < 2e-3);
            let side = face.along().any_orthonormal_vector();
            let met = face.height_met(point - side * 3.0, side, place).unwrap();
            assert!((met - height).abs() < 1e-4, "{met} {height}");
        }
    }

    #[test]
    fn a_drag_along_a_ray_is_a_radial_crack_whatever_the_heights_of_the_face_are() {
        let drawn = drawn();
        let face = CrackFace::new(&drawn, 0).unwrap();
        let close = |a: Polar, b: Polar| {
            let section = |p: Polar| Vec2::from_angle(p.1) * p.0;
            section(a).distance(section(b)) < 0.02
        };
        let mut seen = 0;
        for (lean, turn) in [
            (0.0f32, 0.0f32),
            (0.4, 0.0),
            (0.4, 2.0),
            (1.0, 4.0),
            (1.3, 1.0),
        ] {
            let side = face.at.across[0] * turn.cos() + face.at.across[1] * turn.sin();
            let direction = side * lean.sin() - face.along() * lean.cos();
            let under = |place: Polar| {
                let point = face.point(place, face.height(place));
                face.seen((point - direction * 60.0 * face.radius(), direction))
            };
            for angle in (0..12).map(|k| f32::from(k as u8) * 0.5) {
                let (from, to) = ((0.3, angle), (0.8, angle));
                let (Some(a), Some(b)) = (under(from), under(to)) else {
                    continue;
                };
                // What lies behind a higher part of the face cannot be dragged over.
                if !(close(a.0, from) && close(b.0, to)) {
                    assert!(lean > 0.0, "{a:?} {b:?} at {angle}");
                    continue;
                }
                seen += 1;
                let (_, begin, end) = radial(&crack_of_drag(a.0, b.0));
                assert!((begin - 0.3).abs() < 0.03 && (end - 0.8).abs() < 0.03);
            }
        }
        assert!(seen > 24, "{seen}");
    }
}
