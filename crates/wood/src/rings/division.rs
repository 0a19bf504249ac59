//! How the years divide the radius of a stem, and the rings that everything about it shows.

use super::concentric::ConcentricRings;
use super::field::RingField;
use super::series::{RingError, RingSeries};
use super::source::RingSource;
use crate::tissue::Proportions;
use greenstick_schema::{Kind, ParameterError, Unit, length, list, number, parameters};
use std::fmt;
use std::ops::Deref;
use std::sync::Arc;

/// Largest radius or width of a ring in a request, m.
const MAX_RADIUS: f64 = 100.0;
/// Most rings in a request's list: no tree has more.
const MAX_LISTED: usize = 10_000;

/// A length in a list of rings.
const RING_LENGTH: Kind = length(0.0, MAX_RADIUS).above().kind;
/// A share in a list of rings.
const RING_SHARE: Kind = number(Unit::Fraction, 0.0, 1.0).above().kind;

parameters! {
    /// The rings of a section that were measured, by one of three lists. They are rings of the section at the location:
    /// elsewhere along the stem they keep their share of the radius.
    pub struct RingSeriesParameters {
        "Annual rings", "layout" {
            /// Mean radii of the rings about the pith, from the pith outwards.
            ring_radii: Option<Vec<f64>> = None, list(&RING_LENGTH, 1, MAX_LISTED).auto();
            /// Mean widths of the rings, from the pith outwards, as a climate series has them. What remains of the radius
            /// lies outside the last one.
            ring_widths: Option<Vec<f64>> = None, list(&RING_LENGTH, 1, MAX_LISTED).auto();
            /// Mean radii of the rings as shares of the section's, from the pith outwards: the rings of another section.
            ring_shares: Option<Vec<f64>> = None, list(&RING_SHARE, 1, MAX_LISTED).auto();
        }
    }
    check |p| {
        let given = [
            ("ring_radii", p.ring_radii.is_some()),
            ("ring_widths", p.ring_widths.is_some()),
            ("ring_shares", p.ring_shares.is_some()),
        ];
        let mut given = given.into_iter().filter(|g| g.1).map(|g| g.0);
        match (given.next(), given.next()) {
            (Some(first), Some(second)) => Err(ParameterError::Conflict(format!(
                "{first} and {second} are both given; expected one of them"
            ))),
            _ => Ok(()),
        }
    };
}

impl RingSeriesParameters {
    /// The series that is given, if any.
    pub fn series(&self) -> Option<RingSeries> {
        let radii = self.ring_radii.clone().map(RingSeries::Radii);
        let widths = self.ring_widths.clone().map(RingSeries::Widths);
        let shares = self.ring_shares.clone().map(RingSeries::Shares);
        radii.or(widths).or(shares)
    }
}

/// How the years divide the ring coordinate.
#[derive(Debug, Clone, PartialEq)]
pub enum RingDivision {
    /// As many rings, wider near the pith and different from year to year, as the seed has it.
    Grown {
        /// Number of rings, at least one.
        count: u16,
        /// Seed of the widths.
        seed: u64,
    },
    /// As many rings of even width, at least one.
    Even(u16),
    /// Measured rings.
    Series(RingSeries),
}

impl RingDivision {
    /// The rings of a section with the ring field `field`, with tissues by their `proportions`; those of a board are all
    /// sapwood.
    ///
    /// # Errors
    /// [`RingError`] where a series does not fit into the section.
    pub fn rings(
        &self,
        field: &RingField,
        proportions: &Proportions,
        board: bool,
    ) -> Result<ConcentricRings, RingError> {
        let rings = match self {
            RingDivision::Even(count) => ConcentricRings::even(*count, proportions),
            RingDivision::Grown { count, seed } => {
                ConcentricRings::grown(*count, *seed, proportions)
            }
            RingDivision::Series(series) => {
                let mut edges = field.coordinates(series)?;
                let last = edges.last().copied().unwrap_or(0.0);
                // Outside the last ring lies bark no thicker than usual, and below it wood: a year that is not over, or
                // rings that were not measured.
                let bark = 1.0 - proportions.phloem;
                let unfinished = (last < bark).then_some(edges.len());
                edges.extend(unfinished.map(|_| bark));
                if last < 1.0 {
                    edges.push(1.0);
                }
                ConcentricRings::with_edges(edges, proportions).with_unfinished(unfinished)
            }
        };
        Ok(if board { rings.of_sapwood() } else { rings })
    }
}

/// The annual rings of a stem: the one source that its broken faces, its textures and its pictures show.
#[derive(Clone)]
pub struct StemRings(Arc<dyn RingSource + Send + Sync>);

impl StemRings {
    /// Takes a source.
    pub fn new(source: impl RingSource + Send + Sync + 'static) -> Self {
        StemRings(Arc::new(source))
    }
}

impl Deref for StemRings {
    type Target = dyn RingSource + Send + Sync;

    fn deref(&self) -> &Self::Target {
        &*self.0
    }
}

impl PartialEq for StemRings {
    /// Whether they are the same source, not one that is alike.
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

impl fmt::Debug for StemRings {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "StemRings({} rings)", self.ring_count())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tissue::Zone;
    use glam::DVec2;

    const TISSUE: Proportions = Proportions {
        pith: 0.05,
        heartwood: 0.3,
        phloem: 0.1,
    };

    fn field() -> RingField {
        let outline: Vec<DVec2> = (0..180)
            .map(|i| DVec2::from_angle(f64::from(i) * 2f64.to_radians()) * 0.03)
            .collect();
        RingField::from_outline(&outline, DVec2::ZERO).unwrap()
    }

    #[test]
    fn grown_rings_fill_the_radius_and_differ() {
        for (count, seed) in [(1, 0), (2, 7), (14, 1), (300, 5)] {
            let division = RingDivision::Grown { count, seed };
            let rings = division.rings(&field(), &TISSUE, false).unwrap();
            assert_eq!(rings.ring_count(), usize::from(count));
            assert_eq!(rings.edges().last(), Some(&1.0));
            let mut inner = 0.0;
            let mut widths = Vec::new();
            for &edge in rings.edges() {
                widths.push((edge - inner) * f64::from(count));
                inner = edge;
            }
            let (low, high) = widths
                .iter()
                .fold((f64::INFINITY, 0.0f64), |(a, b), &w| (a.min(w), b.max(w)));
            assert!(low > 0.2 && high < 2.0, "{count}: {low} to {high}");
            assert!(count < 10 || high > 1.3 * low);
        }
    }

    #[test]
    fn measured_rings_lie_where_they_were_measured() {
        let field = field();
        let given = [
            RingSeriesParameters {
                ring_radii: Some(vec![0.006, 0.015]),
                ..RingSeriesParameters::default()
            },
            RingSeriesParameters {
                ring_widths: Some(vec![0.006, 0.009]),
                ..RingSeriesParameters::default()
            },
            RingSeriesParameters {
                ring_shares: Some(vec![0.2, 0.5]),
                ..RingSeriesParameters::default()
            },
        ];
        for parameters in given {
            let series = parameters.series().unwrap();
            let rings = RingDivision::Series(series).rings(&field, &TISSUE, false);
            let rings = rings.unwrap();
            // The wood that nobody measured, up to bark of a tenth of the radius, is no annual ring.
            assert_eq!((rings.edges().len(), rings.unfinished()), (4, Some(2)));
            for (edge, radius) in rings.edges().iter().zip([0.006, 0.015, 0.027, 0.03]) {
                let off = field.mean_radius(*edge) - radius;
                assert!(off.abs() < 1e-5, "{edge}: {off}");
            }
            let bark = rings.tissues().iter().filter(|&&t| t > Zone::Sapwood);
            assert_eq!(bark.count(), 1);
        }
        let both = RingSeriesParameters {
            ring_radii: Some(vec![0.006]),
            ring_shares: Some(vec![0.2]),
            ..RingSeriesParameters::default()
        };
        assert!(greenstick_schema::Parameters::check(&both).is_err());
        let large = RingDivision::Series(RingSeries::Radii(vec![0.01, 0.04]));
        assert!(matches!(
            large.rings(&field, &TISSUE, false),
            Err(RingError::TooLarge { number: 2, .. })
        ));
    }
}
