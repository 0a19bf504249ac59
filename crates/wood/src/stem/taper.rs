//! The taper of a stem: how the size of its sections changes along it, smoothed.

use super::body::Body;
use super::grain::TaperPoint;

/// Half width of the smoothing window, radii.
const WINDOW_RADII: f64 = 3.0;
/// Range of the scale: a stem that tapers further is no stem.
const SCALE_RANGE: (f64, f64) = (0.1, 10.0);

/// Sizes of the sections of the free run that contains `location` (m), relative to that of a section of `area` (m²) there:
/// a local linear fit, 1 at the location. Empty for sawn wood, whose outline cuts through rings and fibres of the tree that it
/// was sawn from: a dowel that tapers does not carry them with it.
pub(crate) fn taper(body: &Body, run: (f64, f64), location: f64, area: f64) -> Vec<TaperPoint> {
    if body.kind.is_sawn() {
        return Vec::new();
    }
    let sizes: Vec<TaperPoint> = body
        .stations
        .iter()
        .filter_map(|station| station.section.as_ref())
        .filter(|s| s.length >= run.0 && s.length <= run.1)
        .map(|s| TaperPoint {
            length: s.length,
            scale: (s.area / area).sqrt(),
        })
        .collect();
    if sizes.len() < 2 {
        return Vec::new();
    }
    let window = WINDOW_RADII * body.radius(location);
    let here = local_fit(&sizes, location, window);
    let mut taper: Vec<TaperPoint> = sizes
        .iter()
        .filter(|p| (p.length - location).abs() > 1e-9 * window)
        .map(|p| {
            let fitted = local_fit(&sizes, p.length, window);
            TaperPoint {
                length: p.length,
                scale: (fitted / here).clamp(SCALE_RANGE.0, SCALE_RANGE.1),
            }
        })
        .collect();
    let k = taper.partition_point(|p| p.length < location);
    let one = TaperPoint {
        length: location,
        scale: 1.0,
    };
    taper.insert(k, one);
    taper
}

/// The local linear fit of sizes at `s` (m), with biweights over the window.
fn local_fit(sizes: &[TaperPoint], s: f64, window: f64) -> f64 {
    let mut m = [0.0; 5];
    let from = sizes.partition_point(|p| p.length < s - window);
    for p in sizes[from..].iter().take_while(|p| p.length <= s + window) {
        let u = (p.length - s) / window;
        let w = (1.0 - u * u) * (1.0 - u * u) + 1e-9;
        m = [
            m[0] + w,
            m[1] + w * u,
            m[2] + w * u * u,
            m[3] + w * p.scale,
            m[4] + w * u * p.scale,
        ];
    }
    let det = m[0] * m[2] - m[1] * m[1];
    if det > 1e-9 * m[0] * m[0] {
        (m[3] * m[2] - m[4] * m[1]) / det
    } else {
        m[3] / m[0]
    }
}
