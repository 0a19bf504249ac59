//! Units of length.

greenstick_schema::choices! {
    /// A unit of length in files that do not say it.
    ///
    /// ```
    /// use greenstick_formats::LengthUnit;
    ///
    /// assert_eq!("mm".parse(), Ok(LengthUnit::Millimetre));
    /// assert_eq!(LengthUnit::Centimetre.metres(), 0.01);
    /// ```
    pub enum LengthUnit {
        /// Millimetres.
        Millimetre = "mm",
        /// Centimetres.
        Centimetre = "cm",
        /// Metres.
        Metre = "m",
    }
}

#[expect(
    clippy::derivable_impls,
    reason = "the macro that declares it takes no attributes"
)]
impl Default for LengthUnit {
    fn default() -> Self {
        LengthUnit::Metre
    }
}

impl LengthUnit {
    /// The length of the unit, m.
    pub fn metres(self) -> f64 {
        match self {
            LengthUnit::Millimetre => 0.001,
            LengthUnit::Centimetre => 0.01,
            LengthUnit::Metre => 1.0,
        }
    }

    /// The number of units in a metre, which is exact, unlike the reciprocal of [`Self::metres`].
    pub(crate) fn per_metre(self) -> f64 {
        match self {
            LengthUnit::Millimetre => 1000.0,
            LengthUnit::Centimetre => 100.0,
            LengthUnit::Metre => 1.0,
        }
    }
}

impl std::fmt::Display for LengthUnit {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.word())
    }
}

/// The text is no known unit of length.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("`{0}` is not a known unit of length; expected mm, cm or m")]
pub struct UnknownUnit(pub String);

impl std::str::FromStr for LengthUnit {
    type Err = UnknownUnit;

    fn from_str(text: &str) -> Result<Self, UnknownUnit> {
        match text {
            "mm" => Ok(LengthUnit::Millimetre),
            "cm" => Ok(LengthUnit::Centimetre),
            "m" => Ok(LengthUnit::Metre),
            _ => Err(UnknownUnit(text.to_owned())),
        }
    }
}
