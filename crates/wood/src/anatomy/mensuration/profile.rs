//! The areas of a stem's sections along it, over and under bark, and the volumes that they add up to.

use super::super::sections::StemSections;
use super::section_size::share_within;
use greenstick_geometry::{Cancelled, Context};
use rayon::prelude::*;
use std::f64::consts::PI;

/// Areas in the middles of slices of equal length.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct StemProfile {
    /// Thickness of a slice, m.
    step: f64,
    /// Of each [`Part`].
    parts: [PartProfile; 3],
    /// Between which lengths (m) sections are whole, not cut by a slanted or torn end.
    whole: (f64, f64),
}

/// A part of the sections.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Part {
    /// Everything.
    OverBark,
    /// The wood.
    UnderBark,
    /// Heartwood with the pith.
    Heartwood,
}

/// One part along the stem.
#[derive(Debug, Clone, PartialEq)]
struct PartProfile {
    /// Areas, m²; 0 where the plane misses the stem.
    areas: Vec<f64>,
    /// Volume below the lower face of each slice, and that of all of them, m³.
    below: Vec<f64>,
}

/// Ring coordinates at which parts end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in super::super) struct PartEdges {
    /// Where the heartwood ends; 0 without any.
    pub heartwood: f64,
    /// Where the wood ends and the bark begins; 1 without bark.
    pub cambium: f64,
}

impl StemProfile {
    /// Cuts a stem into `slices`.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn new(
        sections: &StemSections,
        slices: usize,
        edges: PartEdges,
        context: &Context,
    ) -> Result<Self, Cancelled> {
        let step = sections.length() / slices as f64;
        let areas: Vec<[f64; 3]> = (0..slices)
            .into_par_iter()
            .map(|k| {
                context.check()?;
                let section = sections.section(step * (k as f64 + 0.5));
                Ok(section.map_or([0.0; 3], |s| {
                    let within = |ring| s.outline.area * share_within(&s, ring);
                    [
                        s.outline.area,
                        within(edges.cambium),
                        within(edges.heartwood),
                    ]
                }))
            })
            .collect::<Result<_, Cancelled>>()?;
        let part = |k: usize| areas.iter().map(|a| a[k]).collect();
        let mut profile = StemProfile::from_areas(step, [part(0), part(1), part(2)]);
        profile.whole = sections.whole;
        Ok(profile)
    }

    /// The profile of slices of the thickness `step` (m) with these areas of each part, m².
    pub fn from_areas(step: f64, areas: [Vec<f64>; 3]) -> Self {
        StemProfile {
            step,
            whole: (0.0, step * areas[0].len() as f64),
            parts: areas.map(|areas| PartProfile {
                below: volumes_below(&areas, step),
                areas,
            }),
        }
    }

    /// Length of the stem, m.
    pub fn length(&self) -> f64 {
        self.step * self.parts[0].areas.len() as f64
    }

    /// Volume of a part from the butt to a length (m), m³.
    pub fn volume(&self, length: f64, part: Part) -> f64 {
        let PartProfile { areas, below } = &self.parts[part as usize];
        let at = (length / self.step).max(0.0);
        let slice = at as usize;
        match areas.get(slice) {
            Some(area) => below[slice] + area * (at - slice as f64) * self.step,
            None => below[below.len() - 1],
        }
    }

    /// Area of a part at a length (m), m²: between the middles of slices diameters change evenly.
    pub fn area(&self, length: f64, part: Part) -> f64 {
        let areas = &self.parts[part as usize].areas;
        let at = (length / self.step - 0.5).clamp(0.0, (areas.len() - 1) as f64);
        let k = (at as usize).min(areas.len().saturating_sub(2));
        let t = at - k as f64;
        let (a, b) = (areas[k], areas[(k + 1).min(areas.len() - 1)]);
        let root = a.sqrt() + (b.sqrt() - a.sqrt()) * t;
        root * root
    }

    /// Area of a part at the end of a log at a length (m), m²: where an end of the stem cuts the section off, that of the nearest
    /// whole one.
    pub fn end_area(&self, length: f64, part: Part) -> f64 {
        let (low, high) = self.whole;
        self.area(length.max(low).min(high), part)
    }

    /// The greatest length at which the diameter over bark is at least `diameter`, m; `None` where it nowhere is.
    pub fn length_to_diameter(&self, diameter: f64) -> Option<f64> {
        let areas = self.parts[Part::OverBark as usize].areas.iter();
        let diameters: Vec<f64> = areas.map(|a| 2.0 * (a / PI).sqrt()).collect();
        let last = diameters.iter().rposition(|&d| d >= diameter)?;
        let middle = (last as f64 + 0.5) * self.step;
        Some(match diameters.get(last + 1) {
            Some(&next) => {
                middle + self.step * (diameters[last] - diameter) / (diameters[last] - next)
            }
            None => self.length(),
        })
    }
}

/// Volume below each slice, and that of all.
fn volumes_below(areas: &[f64], step: f64) -> Vec<f64> {
    let mut sum = 0.0;
    std::iter::once(0.0)
        .chain(areas.iter().map(|area| {
            sum += area * step;
            sum
        }))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_log_ends_with_a_whole_section_where_the_stem_ends_in_a_slant() {
        let mut areas = vec![2.0; 100];
        (areas[0], areas[99]) = (0.4, 0.1);
        let mut profile = StemProfile::from_areas(0.1, [areas.clone(), areas.clone(), areas]);
        assert!(profile.end_area(0.0, Part::OverBark) < 0.5);
        profile.whole = (0.2, 9.8);
        for length in [0.0, 0.2, 5.0, 9.9, 10.0] {
            assert!((profile.end_area(length, Part::OverBark) - 2.0).abs() < 1e-12);
        }
    }

    /// A cone of 10 m with a butt of 0.2 m radius, whose wood has 0.9 of the radius.
    fn cone() -> StemProfile {
        let slices = 400;
        let step = 10.0 / f64::from(slices);
        let over: Vec<f64> = (0..slices)
            .map(|k| 0.2 * (1.0 - (f64::from(k) + 0.5) * step / 10.0))
            .map(|r| PI * r * r)
            .collect();
        let part = |share: f64| over.iter().map(|a| share * a).collect();
        StemProfile::from_areas(step, [part(1.0), part(0.81), part(0.25)])
    }

    #[test]
    fn a_cone_has_the_volume_area_and_lengths_of_a_cone() {
        let cone = cone();
        let whole = PI * 0.04 * 10.0 / 3.0;
        for (length, part) in [(10.0, 1.0), (5.0, 0.875), (2.0, 1.0 - 0.512)] {
            let volume = cone.volume(length, Part::OverBark);
            assert!((volume / (part * whole) - 1.0).abs() < 1e-5, "{length}");
            let wood = cone.volume(length, Part::UnderBark);
            assert!((wood / volume - 0.81).abs() < 1e-12);
            let heartwood = cone.volume(length, Part::Heartwood);
            assert!((heartwood / volume - 0.25).abs() < 1e-12);
        }
        let radius = (cone.area(5.0, Part::OverBark) / PI).sqrt();
        assert!((radius - 0.1).abs() < 1e-12, "{radius}");
        let length = cone.length_to_diameter(0.1).unwrap();
        assert!((length - 7.5).abs() < 1e-9, "{length}");
        assert_eq!(cone.length_to_diameter(0.5), None);
    }
}
