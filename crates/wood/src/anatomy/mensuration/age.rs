//! How many years a section has grown.
//!
//! A tree grows taller year by year: a section higher up lacks the first years. Rings are counted from the bark inwards, as
//! wide as those of the butt, for as long as the section's wood lasts. That is exact for a cone whose rings are equally wide
//! all along it, and does not ask for the height that the tree had in any year.

/// A part of a ring below this is rounding, not a year.
const MIN_PART: f64 = 1e-6;

/// Years in a section whose wood has the radius `wood_radius` (m). `ring_radii` are those of the outer edges of the butt's
/// rings from the pith, m.
pub(super) fn years(ring_radii: &[f64], wood_radius: f64) -> u32 {
    let Some(&outer) = ring_radii.last() else {
        return 0;
    };
    // A ring is there where what has grown since leaves room for it.
    let since = ring_radii.iter().map(|radius| outer - radius);
    since
        .filter(|depth| wood_radius - depth > MIN_PART * outer)
        .count() as u32
}

/// Years in sections from the butt on: no section is older than one below it.
pub(super) fn years_along(ring_radii: &[f64], wood_radii: impl Iterator<Item = f64>) -> Vec<u32> {
    let mut youngest = ring_radii.len() as u32;
    wood_radii
        .map(|radius| {
            youngest = youngest.min(years(ring_radii, radius));
            youngest
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cone_loses_a_year_with_every_years_height() {
        // Twenty rings of 5 mm at the butt of a cone of 10 m: half a metre a year.
        let rings: Vec<f64> = (1..=20).map(|k| 0.005 * f64::from(k)).collect();
        let radii = (0..20).map(|k| 0.1 * (1.0 - (0.5 * f64::from(k) + 0.25) / 10.0));
        let years = years_along(&rings, radii);
        let expected: Vec<u32> = (1..=20).rev().collect();
        assert_eq!(years, expected);
        assert_eq!(
            years_along(&rings, [0.1, 0.05, 0.07].into_iter()),
            [20, 10, 10]
        );
        assert_eq!(super::years(&[], 0.1), 0);
    }
}
