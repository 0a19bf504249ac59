//! A smooth axis through the centroids of a trace.
//!
//! Bark, knots and coarse polygons make centroids wander; grain does not. Each point of the axis is a local quadratic
//! fit with Gaussian weights (Savitzky and Golay 1964; Cleveland 1979), which keeps a steady bend in its place where
//! a plain average would cut the corner.

use glam::DVec3;

/// Standard deviation of the weights, in radii, at the first attempt.
const FIRST_WINDOW_RADII: f64 = 1.0;
/// Factor by which the window grows from one attempt to the next, and the number of attempts.
const WINDOW_GROWTH: f64 = 1.35;
const MAX_ATTEMPTS: usize = 14;
/// Attempts that fit parabolas. Further ones fit straight lines, which bend less.
const QUADRATIC_ATTEMPTS: usize = 3;
/// The tightest bend allowed: radius of curvature over the reach of the section. Below 1, grain space would fold.
const MIN_CURVATURE_RADIUS_OVER_REACH: f64 = 1.5;

/// A centroid to be smoothed.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Station {
    /// Length along the polygon of centroids, m.
    pub t: f64,
    pub centre: DVec3,
    /// Radius of the circle of equal area, m.
    pub radius: f64,
    /// Largest distance of the outline from the centroid, m.
    pub reach: f64,
}

/// A smooth curve: its points and the parameter t (m) of each.
#[derive(Debug, Clone, Default)]
pub(crate) struct SmoothCurve {
    pub points: Vec<DVec3>,
    pub parameters: Vec<f64>,
}

/// A range of the parameter t, m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ParameterRange {
    pub low: f64,
    pub high: f64,
}

/// Value and derivative of the local fit at `t`.
fn fit(stations: &[Station], t: f64, sigma: f64, quadratic: bool) -> (DVec3, DVec3) {
    let from = stations.partition_point(|s| s.t < t - 3.5 * sigma);
    let to = stations.partition_point(|s| s.t <= t + 3.5 * sigma);
    let mut m = [0.0; 5];
    let mut v = [DVec3::ZERO; 3];
    for s in &stations[from..to] {
        let u = (s.t - t) / sigma;
        // A rational bell instead of exp, the same on every machine.
        let bell = 1.0 / (1.0 + u * u * (0.125 + u * u * 0.03125));
        let weight = bell * bell * bell * bell;
        let mut power = weight;
        for (k, sum) in m.iter_mut().enumerate() {
            *sum += power;
            if k < 3 {
                v[k] += s.centre * power;
            }
            power *= u;
        }
    }
    let det = m[0] * (m[2] * m[4] - m[3] * m[3]) - m[1] * (m[1] * m[4] - m[2] * m[3])
        + m[2] * (m[1] * m[3] - m[2] * m[2]);
    if quadratic && to - from >= 5 && det > 1e-9 * m[0] * m[2] * m[4] {
        let (a, b, c) = (
            m[2] * m[4] - m[3] * m[3],
            m[2] * m[3] - m[1] * m[4],
            m[1] * m[3] - m[2] * m[2],
        );
        let value = (v[0] * a + v[1] * b + v[2] * c) / det;
        let (e, f) = (m[0] * m[4] - m[2] * m[2], m[1] * m[2] - m[0] * m[3]);
        let slope = (v[0] * b + v[1] * e + v[2] * f) / det;
        return (value, slope / sigma);
    }
    let det = m[0] * m[2] - m[1] * m[1];
    if to - from >= 2 && det > 1e-12 * m[0] * m[0] {
        let value = (v[0] * m[2] - v[1] * m[1]) / det;
        return (value, (v[1] * m[0] - v[0] * m[1]) / (det * sigma));
    }
    // Between stations that are too far apart, a straight line.
    let k = stations
        .partition_point(|s| s.t <= t)
        .clamp(1, stations.len() - 1);
    let (a, b) = (stations[k - 1], stations[k]);
    let slope = (b.centre - a.centre) / (b.t - a.t);
    (a.centre + slope * (t - a.t), slope)
}

/// Smooths the polygon of centroids over `range`, straight beyond the stations. Bends within `limited` are at least
/// [`MIN_CURVATURE_RADIUS_OVER_REACH`] reaches wide where [`MAX_ATTEMPTS`] suffice.
pub(crate) fn smooth(
    stations: &[Station],
    range: ParameterRange,
    limited: ParameterRange,
) -> SmoothCurve {
    let mut radii: Vec<f64> = stations.iter().map(|s| s.radius).collect();
    radii.sort_by(f64::total_cmp);
    let typical_radius = radii[radii.len() / 2];
    let mut window = Window {
        radii: FIRST_WINDOW_RADII,
        typical_radius,
        quadratic: true,
    };
    let mut curve = SmoothCurve::default();
    for attempt in 0..MAX_ATTEMPTS {
        window.quadratic = attempt < QUADRATIC_ATTEMPTS;
        curve = sample(stations, range, window);
        if !bends_too_tightly(&curve, stations, limited) {
            break;
        }
        window.radii *= WINDOW_GROWTH;
    }
    curve
}

/// How strongly one attempt smooths.
#[derive(Debug, Clone, Copy)]
struct Window {
    /// Standard deviation of the weights, in radii of the stem.
    radii: f64,
    /// Median radius of the stem, m.
    typical_radius: f64,
    /// Whether parabolas are fitted rather than straight lines.
    quadratic: bool,
}

fn sample(stations: &[Station], range: ParameterRange, window: Window) -> SmoothCurve {
    let (low, high) = (stations[0].t, stations[stations.len() - 1].t);
    let mut curve = SmoothCurve::default();
    let mut t = range.low;
    loop {
        let inside = t.clamp(low, high);
        // The window follows the thickness slowly: a thin tip is not smoothed like the base.
        let radius = radius_at(stations, inside).max(0.3 * window.typical_radius);
        let (value, slope) = fit(stations, inside, window.radii * radius, window.quadratic);
        curve.points.push(value + slope * (t - inside));
        curve.parameters.push(t);
        if t >= range.high {
            return curve;
        }
        let step = 0.25 * radius;
        t = if t + 1.5 * step > range.high {
            range.high
        } else {
            t + step
        };
    }
}

/// Interpolated radius at `t`.
fn radius_at(stations: &[Station], t: f64) -> f64 {
    let k = stations
        .partition_point(|s| s.t <= t)
        .clamp(1, stations.len() - 1);
    let (a, b) = (stations[k - 1], stations[k]);
    let u = ((t - a.t) / (b.t - a.t)).clamp(0.0, 1.0);
    a.radius + (b.radius - a.radius) * u
}

fn bends_too_tightly(curve: &SmoothCurve, stations: &[Station], limited: ParameterRange) -> bool {
    let (points, t) = (&curve.points, &curve.parameters);
    (1..points.len().saturating_sub(1)).any(|i| {
        if t[i] < limited.low || t[i] > limited.high {
            return false;
        }
        let (a, b) = (points[i] - points[i - 1], points[i + 1] - points[i]);
        // Curvature of the circle through three points.
        let chord = points[i + 1].distance(points[i - 1]);
        let curvature = 2.0 * a.cross(b).length() / (a.length() * b.length() * chord);
        let k = stations
            .partition_point(|s| s.t <= t[i])
            .clamp(1, stations.len() - 1);
        let reach = stations[k - 1].reach.max(stations[k].reach);
        curvature * MIN_CURVATURE_RADIUS_OVER_REACH * reach > 1.0
    })
}
