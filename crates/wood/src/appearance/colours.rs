//! Colours of wood and bark that are given, where those of the species are not wanted.

use super::wood::WoodAppearance;
use crate::colour::linear_from_srgb;
use greenstick_schema::{Unit, number, parameters, text, text_field};
use std::str::FromStr;

/// A colour as sRGB bytes, written `#d8ba90`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SrgbColour(pub [u8; 3]);

/// A text that is no colour.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0:?} is no colour; a colour is # and six hexadecimal digits, such as #d8ba90")]
pub struct SrgbColourError(String);

impl FromStr for SrgbColour {
    type Err = SrgbColourError;

    /// Parses `#d8ba90` or `d8ba90`.
    ///
    /// ```
    /// use greenstick_wood::appearance::SrgbColour;
    ///
    /// assert_eq!("#d8ba90".parse(), Ok(SrgbColour([0xd8, 0xba, 0x90])));
    /// assert!("beige".parse::<SrgbColour>().is_err());
    /// ```
    fn from_str(text: &str) -> Result<Self, SrgbColourError> {
        let error = || SrgbColourError(text.to_owned());
        let trimmed = text.trim();
        let digits = trimmed.strip_prefix('#').unwrap_or(trimmed);
        if digits.len() != 6 || !digits.bytes().all(|b| b.is_ascii_hexdigit()) {
            return Err(error());
        }
        let number = u32::from_str_radix(digits, 16).map_err(|_| error())?;
        let [_, r, g, b] = number.to_be_bytes();
        Ok(SrgbColour([r, g, b]))
    }
}

text_field! {
    SrgbColour, "COLOUR", |colour| {
        let [r, g, b] = colour.0;
        format!("#{r:02x}{g:02x}{b:02x}")
    };
    /// A colour of sRGB bytes.
    pub const COLOUR
}

parameters! {
    /// Colours of wood and bark. Those that are not given follow the species.
    pub struct WoodColours {
        "colours", "finish" {
            /// Colour of the earlywood of the sapwood, as a photograph shows it: `#e0c296`.
            sapwood_color: Option<SrgbColour> = None, text(COLOUR).auto();
            /// Colour of the earlywood of the heartwood.
            heartwood_color: Option<SrgbColour> = None, text(COLOUR).auto();
            /// Colour of the ridges of the bark; furrows and torn bark are darker shades of it. Bark that the input shows
            /// keeps its own.
            bark_color: Option<SrgbColour> = None, text(COLOUR).auto();
            /// How much darker latewood is than earlywood: 0 not at all, 1 as dark as in pine.
            latewood_contrast: Option<f64> = None, number(Unit::One, 0.0, 1.0).auto();
        }
    }
}

/// How much darker bark is where it is torn.
const TORN_BARK: f64 = 0.7;

impl WoodColours {
    /// Puts the colours that are given over those of the species.
    pub fn apply(&self, wood: &mut WoodAppearance) {
        let linear = |colour: Option<SrgbColour>| colour.map(|c| linear_from_srgb(c.0));
        if let Some(color) = linear(self.sapwood_color) {
            // Latewood stays as much darker as it was.
            for (k, late) in wood.latewood_color.iter_mut().enumerate() {
                *late *= color[k] / wood.sapwood_color[k].max(1e-3);
            }
            wood.sapwood_color = color;
        }
        if let Some(color) = linear(self.heartwood_color) {
            wood.heartwood_color = color;
        }
        if let Some(color) = linear(self.bark_color) {
            wood.bark_color = Some(color);
            wood.cork_color = color.map(|c| c * TORN_BARK);
        }
        if let Some(contrast) = self.latewood_contrast {
            wood.latewood_contrast = contrast;
        }
    }
}
