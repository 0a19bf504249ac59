//! What is asked of a picture.

use crate::{CameraPlacement, Ground, MAX_SAMPLES, MAX_SIDE, PictureOptions, View};
use glam::DVec3;
use greenstick_schema::{Unit, choice, count, flag, number, parameters, text, text_field};
use std::str::FromStr;

/// Width and height of a picture, pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PictureSize {
    /// Pixels per row.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

/// A text that is no size of a picture.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "\"{0}\" is no size; expected WIDTHxHEIGHT in pixels, each from 1 to {MAX_SIDE}, such as 1200x900"
)]
pub struct PictureSizeError(String);

impl FromStr for PictureSize {
    type Err = PictureSizeError;

    fn from_str(text: &str) -> Result<Self, PictureSizeError> {
        let side = |t: &str| t.trim().parse().ok().filter(|n| (1..=MAX_SIDE).contains(n));
        let sides = text.split_once(['x', '×']).and_then(|(width, height)| {
            Some(PictureSize {
                width: side(width)?,
                height: side(height)?,
            })
        });
        sides.ok_or_else(|| PictureSizeError(text.to_owned()))
    }
}

text_field! {
    PictureSize, "WIDTHxHEIGHT", |size| format!("{}x{}", size.width, size.height);
    /// A size in pixels.
    pub const SIZE
}

/// A direction that a picture is taken from, degrees.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ViewDirection {
    /// Angle about the upward direction.
    pub azimuth: f64,
    /// Angle above the horizon, −90 to 90.
    pub elevation: f64,
}

/// A text that is no direction.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "\"{0}\" is no direction; expected AZIMUTH,ELEVATION in degrees, the second from -90 to 90, such as 30,15"
)]
pub struct ViewDirectionError(String);

impl FromStr for ViewDirection {
    type Err = ViewDirectionError;

    fn from_str(text: &str) -> Result<Self, ViewDirectionError> {
        let number = |t: &str| t.trim().parse::<f64>().ok().filter(|x| x.is_finite());
        let direction = text.split_once(',').and_then(|(azimuth, elevation)| {
            Some(ViewDirection {
                azimuth: number(azimuth)?,
                elevation: number(elevation).filter(|x| x.abs() <= 90.0)?,
            })
        });
        direction.ok_or_else(|| ViewDirectionError(text.to_owned()))
    }
}

text_field! {
    ViewDirection, "AZIMUTH,ELEVATION", |view| format!("{},{}", view.azimuth, view.elevation);
    /// A direction, in degrees.
    pub const VIEW
}

/// A text that places no camera.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "\"{0}\" places no camera; expected X,Y,Z,X,Y,Z, its place and where it looks, another point, in metres, and if need be ,ANGLE, its field of view from 1 to 150 degrees, such as 1,0.5,2,0,0,0,25"
)]
pub struct CameraPlacementError(String);

impl FromStr for CameraPlacement {
    type Err = CameraPlacementError;

    fn from_str(text: &str) -> Result<Self, CameraPlacementError> {
        let numbers: Option<Vec<f64>> = (text.split(','))
            .map(|t| t.trim().parse().ok().filter(|x: &f64| x.is_finite()))
            .collect();
        let placement = numbers.and_then(|n| {
            let (six, field_of_view) = match n[..] {
                [ref six @ .., angle] if six.len() == 6 => (six, angle.to_radians()),
                _ => (&n[..], CameraPlacement::FIELD_OF_VIEW),
            };
            let [x, y, z, u, v, w] = *six else {
                return None;
            };
            let placement = CameraPlacement {
                place: DVec3::new(x, y, z),
                target: DVec3::new(u, v, w),
                field_of_view,
            };
            placement.is_valid().then_some(placement)
        });
        placement.ok_or_else(|| CameraPlacementError(text.to_owned()))
    }
}

text_field! {
    CameraPlacement, "X,Y,Z,X,Y,Z[,ANGLE]", |camera| {
        let [p, t] = [camera.place, camera.target];
        // In ten digits, in which degrees come back as they were written.
        let angle = (camera.field_of_view.to_degrees() * 1e10).round() / 1e10;
        format!("{},{},{},{},{},{},{angle}", p.x, p.y, p.z, t.x, t.y, t.z)
    };
    /// Where a camera is, and where it looks.
    pub const CAMERA
}

parameters! {
    /// What is asked of a picture.
    pub struct PictureParameters {
        "Picture", "picture" {
            /// Size of the picture, pixels.
            size as "picture_size": PictureSize = PictureSize { width: 1200, height: 900 }, text(SIZE);
            /// Most camera rays for a pixel of the picture; those without an edge or fine detail take fewer. Light takes an eighth as many.
            samples: u32 = 16, count(1, MAX_SAMPLES as i128).logarithmic();
            /// Renders a rough picture quickly: at a third of the width and height, with at most four camera rays for a pixel, enlarged, and without grain unless it is asked for.
            draft: bool = false, flag();
            /// Direction from which the picture is taken, degrees; "auto" chooses one that suits.
            view: Option<ViewDirection> = None, text(VIEW).auto();
            /// Where the camera is and where it looks, m in the coordinates of what is shown, and its field of view across the shorter side, degrees (25): it stays there over all frames of a film, whatever `view` and `close_up` say. "auto" places one that suits.
            camera: Option<CameraPlacement> = None, text(CAMERA).auto();
            /// How much is shown around the broken faces, of several breaks those of the first, in diameters of the stem; "auto" shows everything, or nine diameters of simulated wood in which the break would be too small to be seen.
            close_up: Option<f64> = None, number(Unit::One, 0.5, 1000.0).auto().logarithmic();
            /// What the wood stands on; "auto" puts broken and simulated wood on a floor of concrete, what is large on fallen leaves, and anything else before the plain backdrop.
            ground: Option<Ground> = None, choice(Ground::CHOICES).auto();
            /// How much what lies before and behind the focus is blurred: 0 not at all, 1 as by a lens from near; "auto" is that of an aperture of 24 mm on a ground, which blurs what is behind a branch and hardly anything behind a trunk, and nothing before the plain backdrop.
            depth_of_field: Option<f64> = None, number(Unit::One, 0.0, 1.0).auto();
            /// Grain of the picture, the noise of a sensor: 0 for none, 1 for that of very little light; "auto" is a little on a ground and none before the plain backdrop. Pictures less than 900 pixels high have less.
            film_grain: Option<f64> = None, number(Unit::One, 0.0, 1.0).auto();
            /// Softness of the lens: 0 for none, 1 for that of a poor one, which spreads each point by a pixel and a half and has a glow about what is bright; "auto" is a little on a ground and none before the plain backdrop. Pictures less than 900 pixels high are spread less.
            lens_softness: Option<f64> = None, number(Unit::One, 0.0, 1.0).auto();
            /// Lays a coin of one euro, 23 mm wide, in front of the wood, for scale.
            coin: bool = false, flag();
            /// Strews chips of torn wood about a break.
            chips: bool = true, flag();
        }
    }
}

impl PictureParameters {
    /// The options of a picture of everything in a scene.
    pub fn options(&self) -> PictureOptions {
        PictureOptions {
            width: self.size.width,
            height: self.size.height,
            samples: self.samples,
            draft: self.draft,
            view: self.view.map_or(View::Automatic, |view| View::Direction {
                azimuth: view.azimuth.to_radians(),
                elevation: view.elevation.to_radians(),
            }),
            camera: self.camera,
            close_up: self.close_up,
            ground: self.ground,
            depth_of_field: self.depth_of_field,
            film_grain: self.film_grain,
            lens_softness: self.lens_softness,
            coin: self.coin,
            chips: self.chips,
            ..PictureOptions::everything()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use greenstick_schema::Parameters;

    #[test]
    fn sizes_and_directions_are_read_and_refused() {
        let mut p = PictureParameters::default();
        p.set_text("picture_size", "640x480").unwrap();
        p.set_text("view", "180, -45").unwrap();
        let options = p.options();
        assert_eq!((options.width, options.height), (640, 480));
        let View::Direction { azimuth, elevation } = options.view else {
            panic!("no direction");
        };
        assert!((azimuth + 4.0 * elevation).abs() < 1e-15);
        for (key, wrong) in [
            ("picture_size", "0x5"),
            ("picture_size", "99999x5"),
            ("picture_size", "5"),
        ] {
            assert!(p.set_text(key, wrong).is_err(), "{wrong}");
        }
        for wrong in ["0,91", "NaN,0", "30"] {
            assert!(p.set_text("view", wrong).is_err(), "{wrong}");
        }
    }
    #[test]
    fn cameras_are_read_and_refused() {
        let mut p = PictureParameters::default();
        p.set_text("camera", "1, 0.5, 2, 0, 0, -3, 40").unwrap();
        let camera = p.options().camera.unwrap();
        assert_eq!(camera.place, DVec3::new(1.0, 0.5, 2.0));
        assert_eq!(camera.target, DVec3::new(0.0, 0.0, -3.0));
        assert!((camera.field_of_view - 40f64.to_radians()).abs() < 1e-15);
        p.set_text("camera", "1,0.5,2,0,0,-3").unwrap();
        let camera = p.options().camera.unwrap();
        assert_eq!(camera.field_of_view, CameraPlacement::FIELD_OF_VIEW);
        for wrong in [
            "1,2,3",
            "1,2,3,1,2,3",
            "1,2,3,0,0,0,0.5",
            "1,2,3,0,0,0,170",
            "1,2,3,0,0,inf",
            "1,2,3,0,0,0,25,1",
        ] {
            assert!(p.set_text("camera", wrong).is_err(), "{wrong}");
        }
    }
}
