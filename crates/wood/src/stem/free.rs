//! Where along a stem a break is free: between forks, ends and what is stuck in it; and the refusal where it is not.

use super::StemLocation;
use super::body::{Body, Stretch};
use super::build::section_at;
use super::error::StemError;
use super::parts::Parts;
use super::surface::Surface;
use super::trace::TraceEnd;
use super::tube::{Tube, merge_ranges};
use glam::{DVec2, DVec3};
use greenstick_geometry::{Cancelled, Context};

/// Free space kept from ends, forks and other limbs, in radii.
pub(super) const MARGIN_RADII: f64 = 0.08;

/// A range of the axis where another shell is in the way.
pub(super) struct Obstruction {
    /// Lengths, m.
    pub range: (f64, f64),
    pub reason: String,
}

/// Where other shells come inside the stem of shell number `cut`. `held` are the shells that hold its base and its tip.
///
/// # Errors
/// [`Cancelled`].
pub(super) fn obstructions(
    parts: &Parts,
    cut: usize,
    tube: &Tube,
    held: [Option<usize>; 2],
    length: f64,
    context: &Context,
) -> Result<Vec<Obstruction>, Cancelled> {
    let mut obstructions = Vec::new();
    for (i, shell) in parts.shells.iter().enumerate() {
        if i == cut {
            continue;
        }
        let mut ranges = tube.contact_ranges(&parts.meshes[shell.node], shell, context)?;
        // What lies deeper than where the stem comes out of the wood that holds it is hidden.
        if held[0] == Some(i)
            && let Some(first) = ranges.first_mut()
        {
            first.0 = 0.0;
        }
        if held[1] == Some(i)
            && let Some(last) = ranges.last_mut()
        {
            last.1 = length;
        }
        let reason = || {
            if held.contains(&Some(i)) {
                "it grows out of other wood".to_owned()
            } else {
                let triangles = shell.triangles.len();
                format!("another part of {triangles} triangles is stuck in it")
            }
        };
        obstructions.extend(ranges.into_iter().map(|range| Obstruction {
            range,
            reason: reason(),
        }));
    }
    obstructions.sort_by(|a, b| {
        let (a, b) = (a.range, b.range);
        a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1))
    });
    Ok(obstructions)
}

/// Ranges (m) free for a break: free stretches of the axis without the obstructions, less a margin.
pub(super) fn free_ranges(body: &Body, obstructions: &[Obstruction]) -> Vec<(f64, f64)> {
    let mut free = Vec::new();
    let blocked = merge_ranges(obstructions.iter().map(|o| o.range).collect(), 0.0);
    for run in body.free_runs() {
        let mut start = run.0;
        for block in blocked.iter().chain([&(run.1, run.1)]) {
            if block.1 < start {
                continue;
            }
            let end = block.0.min(run.1);
            let (a, b) = (
                start + MARGIN_RADII * body.radius(start),
                end - MARGIN_RADII * body.radius(end),
            );
            if b > a {
                free.push((a, b));
            }
            start = start.max(block.1);
            if start >= run.1 {
                break;
            }
        }
    }
    free
}

/// Whether between the limit `s` (m) of the usable range and the axis's end on that side (0: base, 1: tip) there is
/// nothing but the stem's own end.
pub(super) fn reaches_end(body: &Body, obstructions: &[Obstruction], s: f64, side: usize) -> bool {
    let beyond = |at: f64| if side == 0 { at < s } else { at > s };
    let plain = |stretch: Stretch| matches!(stretch, Stretch::Free | Stretch::End);
    let lengths = body.axis.lengths();
    body.ends[side] == TraceEnd::Real
        && !obstructions
            .iter()
            .any(|o| beyond(o.range.0) || beyond(o.range.1))
        && lengths
            .iter()
            .zip(&body.stations)
            .all(|(&l, station)| !beyond(l) || plain(station.stretch))
}

/// A location at which a break is not free.
pub(super) struct Blocked<'a> {
    pub body: &'a Body,
    pub surface: &'a Surface<'a>,
    pub obstructions: &'a [Obstruction],
    /// Ranges (m) that are free.
    pub free: &'a [(f64, f64)],
    pub requested: StemLocation,
    /// The requested location as length along the axis, m.
    pub at: f64,
}

impl Blocked<'_> {
    /// The refusal, with the nearest location that works.
    pub fn refusal(&self) -> StemError {
        let (length, at) = (self.body.axis.length(), self.at);
        let requested = self.requested;
        let found = self.reason();
        let nearest = self
            .free
            .iter()
            .map(|r| {
                let inset = 0.05 * (r.1 - r.0);
                at.clamp(r.0 + inset, r.1 - inset)
            })
            .min_by(|a, b| (a - at).abs().total_cmp(&(b - at).abs()));
        let Some(s) = nearest else {
            return StemError::NowhereFree { requested, found };
        };
        let nearest = match requested {
            StemLocation::Fraction(_) => StemLocation::Fraction(s / length),
            StemLocation::Length(_) => StemLocation::Length(s),
            StemLocation::Point(p) => StemLocation::Point(self.point_of_section(s, p)),
        };
        let is_point = matches!(requested, StemLocation::Point(_));
        if !is_point && (at < 0.0 || at > length * (1.0 + 1e-9)) {
            return StemError::OffStem {
                requested,
                length,
                nearest,
            };
        }
        StemError::Unusable {
            requested,
            found,
            nearest,
        }
    }

    fn reason(&self) -> String {
        let at = self.at;
        let margin = MARGIN_RADII * self.body.radius(at);
        let obstruction = self
            .obstructions
            .iter()
            .find(|o| at >= o.range.0 - margin && at <= o.range.1 + margin);
        if let Some(obstruction) = obstruction {
            return obstruction.reason.clone();
        }
        let lengths = self.body.axis.lengths();
        let k = lengths.partition_point(|&l| l < at).min(lengths.len() - 1);
        let stretches = [k.saturating_sub(1), k].map(|i| self.body.stations[i].stretch);
        let reason = if stretches.contains(&Stretch::Fork) {
            "the stem forks"
        } else if stretches.contains(&Stretch::Broken) {
            "the section is not one plain closed loop (a fork, a hole or a gap)"
        } else {
            "the stem ends"
        };
        reason.to_owned()
    }

    /// The point of the section at `s` (m) that is nearest to `p`.
    fn point_of_section(&self, s: f64, p: DVec3) -> DVec3 {
        let frame = self.body.axis.frame(s);
        let found = section_at(self.surface, &self.body.axis, s, f64::INFINITY);
        let world = |q: &DVec2| frame.origin + frame.x * q.x + frame.y * q.y;
        let contour = found.map_or(Vec::new(), |found| found.section.contour);
        let nearest = contour
            .iter()
            .map(world)
            .min_by(|a, b| a.distance_squared(p).total_cmp(&b.distance_squared(p)));
        nearest.unwrap_or(frame.origin)
    }
}
