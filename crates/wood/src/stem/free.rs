//! Where along a stem a break is free: between forks, ends and what is stuck in it; and what is said where it is not.

use super::Place;
use super::attach::{self, Tube};
use super::build::{self, Body, MARGIN, Stretch};
use super::error::StemError;
use super::find::Search;
use glam::DVec2;

/// Why part of the axis is not free.
pub(super) struct Zone {
    pub range: (f64, f64),
    pub why: String,
}

impl Search<'_> {
    /// Where other shells come inside the stem.
    pub(super) fn zones(&self, body: &Body, tube: &Tube, held: [Option<usize>; 2]) -> Vec<Zone> {
        let mut zones = Vec::new();
        for (i, shell) in self.parts.shells.iter().enumerate() {
            if i == self.cut {
                continue;
            }
            let mut ranges = tube.touched_by(&self.parts.points[shell.node], shell);
            // What lies deeper than where the stem comes out of the wood that holds it is hidden.
            if held[0] == Some(i)
                && let Some(first) = ranges.first_mut()
            {
                first.0 = 0.0;
            }
            if held[1] == Some(i)
                && let Some(last) = ranges.last_mut()
            {
                last.1 = body.axis.length();
            }
            for range in ranges {
                let why = if held.contains(&Some(i)) {
                    "it grows out of other wood".to_owned()
                } else {
                    format!(
                        "another part of {} triangles is stuck in it",
                        shell.triangles.len()
                    )
                };
                zones.push(Zone { range, why });
            }
        }
        zones.sort_by(|a, b| {
            a.range
                .0
                .total_cmp(&b.range.0)
                .then(a.range.1.total_cmp(&b.range.1))
        });
        zones
    }

    /// The refusal of the place at `asked` (m), with the nearest that works.
    pub(super) fn refusal(
        &self,
        body: &Body,
        zones: &[Zone],
        free: &[(f64, f64)],
        asked: f64,
    ) -> StemError {
        let length = body.axis.length();
        let margin = MARGIN * body.radius(asked);
        let zone = zones
            .iter()
            .find(|z| asked >= z.range.0 - margin && asked <= z.range.1 + margin);
        let lengths = body.axis.lengths();
        let k = lengths
            .partition_point(|&l| l < asked)
            .min(lengths.len() - 1);
        let states = [body.stations[k.saturating_sub(1)].0, body.stations[k].0];
        let found = if let Some(zone) = zone {
            zone.why.clone()
        } else if states.contains(&Stretch::Fork) {
            "the stem forks".to_owned()
        } else if states.contains(&Stretch::Broken) {
            "the section is not one plain closed loop (a fork, a hole or a gap)".to_owned()
        } else {
            "the stem ends".to_owned()
        };
        let nearest = free
            .iter()
            .map(|r| {
                let inset = 0.05 * (r.1 - r.0);
                asked.clamp(r.0 + inset, r.1 - inset)
            })
            .min_by(|a, b| (a - asked).abs().total_cmp(&(b - asked).abs()));
        let Some(s) = nearest else {
            return StemError::NowhereFree {
                asked: *self.place,
                found,
            };
        };
        let nearest = match self.place {
            Place::Fraction(_) => Place::Fraction(s / length),
            Place::Length(_) => Place::Length(s),
            Place::Point(p) => {
                let frame = body.axis.frame(s);
                let outline = build::section_at(self.surface, &body.axis, s, f64::INFINITY);
                let world = |q: &DVec2| frame.origin + frame.x * q.x + frame.y * q.y;
                let points = outline.map_or(Vec::new(), |o| o.contour);
                let side = points
                    .iter()
                    .map(world)
                    .min_by(|a, b| a.distance_squared(*p).total_cmp(&b.distance_squared(*p)));
                Place::Point(side.unwrap_or(frame.origin))
            }
        };
        let point = matches!(self.place, Place::Point(_));
        if !point && (asked < 0.0 || asked > length * (1.0 + 1e-9)) {
            return StemError::OffStem {
                asked: *self.place,
                length,
                nearest,
            };
        }
        StemError::Unusable {
            asked: *self.place,
            found,
            nearest,
        }
    }
}

/// Whether between the limit `s` (m) of the usable range and the axis's end on that side there is nothing but the
/// stem's own end.
pub(super) fn reaches_end(body: &Body, zones: &[Zone], s: f64, side: usize) -> bool {
    let beyond = |at: f64| if side == 0 { at < s } else { at > s };
    let plain = |state: Stretch| matches!(state, Stretch::Free | Stretch::End);
    let lengths = body.axis.lengths();
    body.ends[side] == super::trace::End::Real
        && !zones.iter().any(|z| beyond(z.range.0) || beyond(z.range.1))
        && lengths
            .iter()
            .zip(&body.stations)
            .all(|(&l, (state, _))| !beyond(l) || plain(*state))
}

/// Ranges (m) free for a break: free stretches of the axis without the zones, less a margin.
pub(super) fn free_ranges(body: &Body, zones: &[Zone]) -> Vec<(f64, f64)> {
    let mut free = Vec::new();
    let blocked = attach::merged(zones.iter().map(|z| z.range).collect(), 0.0);
    for run in body.free() {
        let mut start = run.0;
        for zone in blocked.iter().chain([&(run.1, run.1)]) {
            if zone.1 < start {
                continue;
            }
            let end = zone.0.min(run.1);
            let (a, b) = (
                start + MARGIN * body.radius(start),
                end - MARGIN * body.radius(end),
            );
            if b > a {
                free.push((a, b));
            }
            start = start.max(zone.1);
            if start >= run.1 {
                break;
            }
        }
    }
    free
}
