//! Logs of a stem: their volume by Smalian's rule beside the volume that is there.
//!
//! Smalian's rule takes the mean of the areas of both ends times the length (Husch, Beers and Kershaw 2003, *Forest
//! Mensuration*, chapter 6). It is exact for cylinders and paraboloids, too much for cones and neiloids.

use super::profile::{Part, StemProfile};
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// A rest shorter than this part of a log is no log.
const MIN_LOG: f64 = 1e-6;

/// How a stem is cut into logs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LogOptions {
    /// Length of logs, m; the last one may be shorter.
    pub log_length: f64,
    /// Diameter over bark at which the last one ends, m.
    pub top_diameter: f64,
}

impl LogOptions {
    /// Logs of 4 m to the 7 cm at which merchantable timber ends in central Europe.
    pub const DEFAULT: LogOptions = LogOptions {
        log_length: 4.0,
        top_diameter: 0.07,
    };
}

/// A log.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Log {
    /// Where it begins, m from the butt.
    pub from_m: f64,
    /// Where it ends, m from the butt.
    pub to_m: f64,
    /// Diameter over bark of its lower end, m.
    pub lower_diameter_m: f64,
    /// Diameter over bark of its upper end, m.
    pub upper_diameter_m: f64,
    /// Volume over bark by Smalian's rule, m³.
    pub smalian_m3: f64,
    /// Its standard error, m³; `None` of a mesh.
    pub smalian_error_m3: Option<f64>,
    /// Volume over bark, m³.
    pub volume_m3: f64,
    /// Volume under bark, m³.
    pub volume_under_bark_m3: f64,
}

/// The logs of a stem.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LogReport {
    /// Length of a log, m.
    pub log_length_m: f64,
    /// Diameter over bark at which the last log ends, m.
    pub top_diameter_m: f64,
    /// Where the stem has that diameter, or its end, m from the butt.
    pub merchantable_length_m: f64,
    /// The logs from the butt.
    pub logs: Vec<Log>,
    /// Their volume over bark by Smalian's rule, m³.
    pub smalian_m3: f64,
    /// Its standard error, m³; `None` of a mesh.
    pub smalian_error_m3: Option<f64>,
    /// Their volume over bark, m³.
    pub volume_m3: f64,
    /// Their volume under bark, m³.
    pub volume_under_bark_m3: f64,
}

/// Cuts a stem into logs. `relative_error` is the standard error of the diameter at a length (m) as a share of it.
pub(super) fn cut_into_logs(
    profile: &StemProfile,
    options: &LogOptions,
    relative_error: &dyn Fn(f64) -> Option<f64>,
) -> LogReport {
    let end = profile
        .length_to_diameter(options.top_diameter)
        .unwrap_or(0.0)
        .min(profile.length());
    let count = (end / options.log_length - MIN_LOG).ceil().max(0.0) as usize;
    let logs: Vec<Log> = (0..count)
        .map(|k| {
            let from = k as f64 * options.log_length;
            let to = (from + options.log_length).min(end);
            log(profile, from, to, relative_error)
        })
        .collect();
    let sum = |of: fn(&Log) -> f64| logs.iter().map(of).sum();
    LogReport {
        log_length_m: options.log_length,
        top_diameter_m: options.top_diameter,
        merchantable_length_m: end,
        smalian_m3: sum(|l| l.smalian_m3),
        // Errors are alike along the stem, which has the same side unseen.
        smalian_error_m3: logs.iter().map(|l| l.smalian_error_m3).sum(),
        volume_m3: sum(|l| l.volume_m3),
        volume_under_bark_m3: sum(|l| l.volume_under_bark_m3),
        logs,
    }
}

fn log(
    profile: &StemProfile,
    from: f64,
    to: f64,
    relative_error: &dyn Fn(f64) -> Option<f64>,
) -> Log {
    let ends = [from, to].map(|length| profile.end_area(length, Part::OverBark));
    let [lower, upper] = ends.map(|area| 2.0 * (area / PI).sqrt());
    let half = 0.5 * (to - from);
    let volume = |part| profile.volume(to, part) - profile.volume(from, part);
    let end_error = |length, area| Some(2.0 * half * area * relative_error(length)?);
    let errors = end_error(from, ends[0]).zip(end_error(to, ends[1]));
    Log {
        from_m: from,
        to_m: to,
        lower_diameter_m: lower,
        upper_diameter_m: upper,
        smalian_m3: half * (ends[0] + ends[1]),
        smalian_error_m3: errors.map(|(a, b)| a + b),
        volume_m3: volume(Part::OverBark),
        volume_under_bark_m3: volume(Part::UnderBark),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn profile(radius: impl Fn(f64) -> f64) -> StemProfile {
        let slices = 1000;
        let step = 10.0 / f64::from(slices);
        let over: Vec<f64> = (0..slices)
            .map(|k| PI * radius((f64::from(k) + 0.5) * step).powi(2))
            .collect();
        StemProfile::from_areas(step, [over.clone(), over.clone(), over])
    }

    #[test]
    fn smalian_is_exact_for_a_cylinder_and_a_paraboloid_and_half_too_much_for_a_cone() {
        let options = LogOptions {
            log_length: 10.0,
            top_diameter: 0.0,
        };
        let none = |_: f64| None;
        let cylinder = cut_into_logs(&profile(|_| 0.2), &options, &none);
        assert!((cylinder.smalian_m3 / (PI * 0.04 * 10.0) - 1.0).abs() < 1e-12);
        assert_eq!(cylinder.smalian_error_m3, None);
        let paraboloid = profile(|s| 0.2 * (1.0 - s / 10.0).sqrt());
        let paraboloid = cut_into_logs(&paraboloid, &options, &none);
        assert!((paraboloid.smalian_m3 / paraboloid.volume_m3 - 1.0).abs() < 3e-3);
        let cone = cut_into_logs(&profile(|s| 0.2 * (1.0 - s / 10.0)), &options, &none);
        assert!((cone.smalian_m3 / cone.volume_m3 - 1.5).abs() < 3e-3);
    }

    #[test]
    fn logs_end_at_the_top_diameter_and_their_errors_add_up() {
        let options = LogOptions {
            log_length: 3.0,
            top_diameter: 0.1,
        };
        let cone = cut_into_logs(&profile(|s| 0.2 * (1.0 - s / 10.0)), &options, &|_| {
            Some(0.01)
        });
        let ends: Vec<f64> = cone.logs.iter().map(|l| l.to_m).collect();
        assert_eq!(cone.logs.len(), 3);
        assert!((ends[0] - 3.0).abs() < 1e-12 && (ends[2] - 7.5).abs() < 1e-9);
        let volume = PI * 0.04 * 10.0 / 3.0 * (1.0 - 0.25_f64.powi(3));
        assert!((cone.volume_m3 / volume - 1.0).abs() < 1e-5);
        // A per cent of the diameter is two of the area.
        let error = cone.smalian_error_m3.unwrap();
        assert!((error / cone.smalian_m3 - 0.02).abs() < 1e-9, "{error}");
        let thin = cut_into_logs(&profile(|_| 0.04), &options, &|_| None);
        assert!(thin.logs.is_empty() && thin.merchantable_length_m == 0.0);
    }
}
