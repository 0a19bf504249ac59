//! Rings that are dragged to where they truly are: the edges of all rings follow, and become part of the request.

use super::input::InputContent;
use super::project::Project;
use super::section_book::StemSection;
use glam::{DVec2, DVec3};
use greenstick::RequestFile;
use greenstick::wood::anatomy::RingMethodChoice;
use greenstick::wood::rings::{ONSET_RANGE, RingSeriesParameters};
use greenstick::wood::stem::PithPosition;
use std::collections::BTreeSet;

/// Least width of a ring between dragged ones, in mean widths.
const LEAST_WIDTH: f64 = 0.15;
/// To which part of a metre, or of the radius, the numbers of a request are rounded: finer than wood is measured.
const ROUNDED: f64 = 1e7;
/// Part of a metre to which the pith is rounded, and parts of the radius to which the onset is.
const PITH_PART: f64 = 1e-6;
const ONSET_PARTS: f64 = 1e3;

/// Edges of rings of which one was dragged.
///
/// `edges` are the outer edges of the rings in ring coordinates, the last of which stays. `number` is the dragged one, from 0, and
/// `to` where it is dragged. Edges between it and the next that is `pinned`, the pith, or the last follow in proportion.
pub fn dragged(edges: &[f64], number: usize, to: f64, pinned: &BTreeSet<usize>) -> Vec<f64> {
    let mut moved = edges.to_vec();
    if number + 1 >= edges.len() {
        return moved;
    }
    let below = pinned.range(..number).next_back().copied();
    let above = pinned.range(number + 1..).next().copied();
    let above = above.unwrap_or(edges.len()).min(edges.len() - 1);
    let first = below.map_or(0, |b| b + 1);
    let (low, high, was) = (below.map_or(0.0, |b| edges[b]), edges[above], edges[number]);
    let least = LEAST_WIDTH * edges[edges.len() - 1] / edges.len() as f64;
    let nearest = low + least * (number - first + 1) as f64;
    let farthest = high - least * (above - number) as f64;
    if nearest > farthest || was <= low || was >= high {
        return moved;
    }
    let to = to.clamp(nearest, farthest);
    for edge in &mut moved[first..number] {
        *edge = low + (*edge - low) * (to - low) / (was - low);
    }
    for edge in &mut moved[number + 1..above] {
        *edge = high - (high - *edge) * (high - to) / (high - was);
    }
    moved[number] = to;
    moved
}

/// The series of a request whose rings have these outer edges, in the form of the series that it has; `mean_radius` is that of a ring
/// coordinate in the section of the break. Where there is no series yet, it is one of radii, or, where the request has `several`
/// breaks in sections of different size, of shares.
pub fn series(
    edges: &[f64],
    mean_radius: impl Fn(f64) -> f64,
    like: &RingSeriesParameters,
    several: bool,
) -> RingSeriesParameters {
    let outer = mean_radius(1.0);
    // A last ring that reached the bark would leave a sliver, were it rounded down.
    let rounded = |x: f64, is_outer: bool| match is_outer {
        true => (x * ROUNDED).ceil() / ROUNDED,
        false => (x * ROUNDED).round() / ROUNDED,
    };
    let radii = edges.iter().map(|e| (mean_radius(*e), *e >= 1.0));
    let mut out = RingSeriesParameters::default();
    if like.ring_widths.is_some() {
        let mut before = 0.0;
        let widths = radii.map(|(radius, is_outer)| {
            let width = rounded(radius - before, is_outer);
            before += width;
            width
        });
        out.ring_widths = Some(widths.collect());
    } else if like.ring_shares.is_some() || (several && like.ring_radii.is_none()) {
        let shares = radii.map(|(radius, last)| rounded(radius / outer, last).min(1.0));
        out.ring_shares = Some(shares.collect());
    } else {
        out.ring_radii = Some(radii.map(|(radius, last)| rounded(radius, last)).collect());
    }
    out
}

/// What of a stem's rings is dragged beside their edges.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PithPart {
    /// The pith.
    Pith,
    /// The ring at which an eccentric stem began to lean.
    Onset,
}

impl Project {
    /// Says where the pith is: at a point of a section, m.
    ///
    /// # Errors
    /// As [`Project::change`]; and for a section beside the break of a scan, whose bark has coordinates of its own.
    pub fn set_pith(
        &mut self,
        section: &StemSection,
        is_at_break: bool,
        at: DVec2,
    ) -> Result<bool, String> {
        let part = |x: f64| (x / PITH_PART).round() * PITH_PART;
        let is_scan =
            self.file.scan.as_scan || matches!(&*self.input.content, InputContent::Cloud(_));
        let pith = if is_at_break && self.break_count() == 1 {
            PithPosition::Section(DVec2::new(part(at.x), part(at.y)))
        } else if is_scan {
            return Err(
                "The pith of a scan is dragged in the section at its only break.".to_owned(),
            );
        } else {
            let p = section.world(at);
            PithPosition::World(DVec3::new(part(p.x), part(p.y), part(p.z)))
        };
        self.change("pith", true, |file| {
            file.stem.pith = Some(pith);
            Ok::<(), String>(())
        })
    }

    /// Says from which ring coordinate on the stem is eccentric. Returns the one that was set, and whether anything changed.
    ///
    /// # Errors
    /// As [`Project::change`].
    pub fn set_onset(&mut self, onset: f64) -> Result<(f64, bool), String> {
        let onset = onset.clamp(*ONSET_RANGE.start(), *ONSET_RANGE.end());
        let onset = (onset * ONSET_PARTS).round() / ONSET_PARTS;
        let changed = self.change("onset of eccentricity", true, |file| {
            file.stem.eccentricity_onset = Some(onset);
            Ok::<(), String>(())
        })?;
        Ok((onset, changed))
    }

    /// Leaves the pith or the onset to the program again.
    ///
    /// # Errors
    /// As [`Project::change`].
    pub fn free_pith(&mut self, part: PithPart) -> Result<bool, String> {
        self.change("worked out", false, |file| {
            match part {
                PithPart::Pith => file.stem.pith = None,
                PithPart::Onset => file.stem.eccentricity_onset = None,
            }
            Ok::<(), String>(())
        })
    }

    /// Number of rings that the request lists; none where it lists none.
    pub fn listed_rings(&self) -> Option<usize> {
        let series = &self.file.rings.series;
        let lists = [&series.ring_radii, &series.ring_widths, &series.ring_shares];
        lists.into_iter().flatten().map(Vec::len).next()
    }

    /// Rings, from 0, that stay while others are dragged; none where the request lists no rings.
    pub fn pins(&self) -> BTreeSet<usize> {
        let listed = self.listed_rings().unwrap_or(0);
        self.pinned
            .iter()
            .copied()
            .filter(|p| *p < listed)
            .collect()
    }

    /// Number of edges that can be dragged of rings with these outer edges.
    pub fn movable_edges(&self, edges: &[f64]) -> usize {
        let inner = edges.len().saturating_sub(1);
        self.listed_rings().map_or(inner, |n| n.min(inner))
    }

    /// Makes rings with these outer edges part of the request; `number` is the one that was dragged, which is pinned.
    ///
    /// # Errors
    /// As [`Project::change`].
    pub fn set_ring_edges(
        &mut self,
        edges: &[f64],
        number: usize,
        mean_radius: impl Fn(f64) -> f64,
    ) -> Result<bool, String> {
        let listed = self.listed_rings().unwrap_or(edges.len()).min(edges.len());
        let several = self.break_count() > 1 || self.file.every.is_some();
        let mut pinned = self.pins();
        pinned.insert(number);
        let label = format!("ring {}", number + 1);
        let changed = self.change(&label, true, |file| {
            let rings = &mut file.rings;
            rings.series = series(&edges[..listed], mean_radius, &rings.series, several);
            rings.annual_rings = None;
            Ok::<(), String>(())
        })?;
        self.pinned = pinned;
        Ok(changed)
    }

    /// Leaves the rings to the program again.
    ///
    /// # Errors
    /// As [`Project::change`].
    pub fn free_rings(&mut self) -> Result<bool, String> {
        let freed = self.change("rings worked out", false, |file| {
            file.rings.series = RingSeriesParameters::default();
            Ok::<(), String>(())
        })?;
        self.pinned.clear();
        Ok(freed)
    }
}

/// Whether the rings of a request come from an erosion, which cannot be dragged.
pub fn are_eroded(file: &RequestFile) -> bool {
    file.rings.ring_source.rings_by == RingMethodChoice::Erosion
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::input::Input;
    use greenstick::wood::rings::{RingDivision, RingField};
    use greenstick::wood::tissue::Proportions;

    const TISSUE: Proportions = Proportions {
        pith: 0.05,
        heartwood: 0.3,
        phloem: 0.1,
    };

    /// Rings of an oval about a pith that is not in its middle.
    fn field() -> RingField {
        let outline: Vec<DVec2> = (0..240)
            .map(|i| DVec2::from_angle(f64::from(i) * 1.5f64.to_radians()) * DVec2::new(0.04, 0.03))
            .collect();
        RingField::from_outline(&outline, DVec2::new(0.006, -0.002)).unwrap()
    }

    #[test]
    fn a_dragged_ring_has_the_radius_that_was_asked_for_in_every_form() {
        let field = field();
        let edges: Vec<f64> = (1..=12).map(|i| f64::from(i) / 12.0).collect();
        let mean = |rho: f64| field.mean_radius(rho);
        let wanted = 0.0137;
        let moved = dragged(
            &edges,
            4,
            field.ring_of_mean_radius(wanted),
            &BTreeSet::new(),
        );
        let list = Some(vec![0.1]);
        let forms = [
            RingSeriesParameters::default(),
            RingSeriesParameters {
                ring_widths: list.clone(),
                ..Default::default()
            },
            RingSeriesParameters {
                ring_shares: list,
                ..Default::default()
            },
        ];
        for like in forms {
            let series = series(&moved, mean, &like, false).series().unwrap();
            let rings = RingDivision::Series(series)
                .rings(&field, &TISSUE, false)
                .unwrap();
            assert_eq!(
                (rings.edges().len(), rings.edges()[11]),
                (12, 1.0),
                "{like:?}"
            );
            assert!((mean(rings.edges()[4]) - wanted).abs() < 2e-7, "{like:?}");
            for (edge, asked) in rings.edges().iter().zip(&moved) {
                assert!((mean(*edge) - mean(*asked)).abs() < 1e-6, "{like:?}");
            }
        }
    }

    #[test]
    fn rings_between_pins_follow_in_proportion_and_none_passes_another() {
        let edges = [0.1, 0.2, 0.4, 0.6, 0.8, 1.0];
        let pinned = BTreeSet::from([1]);
        let moved = dragged(&edges, 3, 0.4, &pinned);
        assert_eq!(moved[..2], edges[..2]);
        // What lay in the middle between the pin and the dragged ring lies there still, and so on the other side.
        assert!((moved[2] - 0.3).abs() < 1e-12 && (moved[4] - 0.7).abs() < 1e-12);
        assert_eq!((moved[3], moved[5]), (0.4, 1.0));
        for to in [-1.0, 0.0, 0.2, 1.0, 7.0] {
            let moved = dragged(&edges, 3, to, &pinned);
            assert!(moved.windows(2).all(|w| w[0] < w[1]), "{to}: {moved:?}");
        }
        // The bark stays.
        assert_eq!(dragged(&edges, 5, 0.5, &pinned), edges);
    }

    #[test]
    fn a_drag_of_a_ring_is_one_step_that_takes_its_pin_back_too() {
        let mut project = Project::new(Input::built_in(), RequestFile::default());
        project.file.rings.annual_rings = Some(4);
        let start = project.file.clone();
        for to in [0.3, 0.35, 0.4] {
            let edges = dragged(&[0.25, 0.5, 0.75, 1.0], 0, to, &project.pins());
            project.set_ring_edges(&edges, 0, |rho| 0.03 * rho).unwrap();
        }
        let radii = project.file.rings.series.ring_radii.clone().unwrap();
        assert_eq!((radii.len(), radii[0], radii[3]), (4, 0.012, 0.03));
        assert!(project.pinned.contains(&0) && project.file.rings.annual_rings.is_none());
        project.undo();
        assert!(project.file == start && project.pinned.is_empty());
        project.redo();
        assert!(project.pinned.contains(&0));
        project.free_rings().unwrap();
        assert!(project.pinned.is_empty() && project.listed_rings().is_none());
    }
}
