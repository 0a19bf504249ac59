//! The unit in which the window shows lengths. Files keep metres.

/// A unit of length.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ShownUnit {
    /// Millimetres.
    Millimetre,
    /// Centimetres.
    #[default]
    Centimetre,
    /// Metres.
    Metre,
    /// Inches.
    Inch,
}

impl ShownUnit {
    /// All of them.
    pub const ALL: [ShownUnit; 4] = [
        ShownUnit::Millimetre,
        ShownUnit::Centimetre,
        ShownUnit::Metre,
        ShownUnit::Inch,
    ];

    /// As it stands behind numbers.
    pub fn symbol(self) -> &'static str {
        match self {
            ShownUnit::Millimetre => "mm",
            ShownUnit::Centimetre => "cm",
            ShownUnit::Metre => "m",
            ShownUnit::Inch => "in",
        }
    }

    /// The unit of a symbol.
    pub fn from_symbol(symbol: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|u| u.symbol() == symbol)
    }

    /// How many of it are a metre.
    pub fn per_metre(self) -> f64 {
        match self {
            ShownUnit::Millimetre => 1e3,
            ShownUnit::Centimetre => 1e2,
            ShownUnit::Metre => 1.0,
            ShownUnit::Inch => 1.0 / 0.0254,
        }
    }

    /// The unit of the widths of rings, which are told in millimetres or inches.
    pub fn of_rings(self) -> Self {
        match self {
            ShownUnit::Inch => ShownUnit::Inch,
            _ => ShownUnit::Millimetre,
        }
    }

    /// A length (m) with three digits and the unit.
    pub fn text(self, metres: f64) -> String {
        let x = metres * self.per_metre();
        let digits = match x.abs() {
            x if x > 0.0 => (2 - x.log10().floor() as i32).clamp(0, 5) as usize,
            _ => 0,
        };
        format!("{x:.digits$} {}", self.symbol())
    }
}

/// The largest length (m) up to `most` that is 1, 2 or 5 times a power of ten of the unit.
pub fn round_length(most: f64, unit: ShownUnit) -> f64 {
    let x = (most * unit.per_metre()).max(1e-12);
    let power = 10f64.powf(x.log10().floor());
    let first = [5.0, 2.0, 1.0]
        .into_iter()
        .find(|f| f * power <= x * (1.0 + 1e-9));
    first.unwrap_or(1.0) * power / unit.per_metre()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_are_shown_in_every_unit_and_scale_bars_are_round() {
        let shown = ShownUnit::ALL.map(|u| u.text(0.0508));
        assert_eq!(shown, ["50.8 mm", "5.08 cm", "0.0508 m", "2.00 in"]);
        assert_eq!(ShownUnit::Centimetre.text(0.0), "0 cm");
        for (most, unit, round) in [
            (0.0123, ShownUnit::Millimetre, 0.01),
            (0.05, ShownUnit::Centimetre, 0.05),
            (0.13, ShownUnit::Inch, 0.127),
        ] {
            assert!((round_length(most, unit) - round).abs() < 1e-12);
        }
        for unit in ShownUnit::ALL {
            assert_eq!(ShownUnit::from_symbol(unit.symbol()), Some(unit));
        }
    }
}
