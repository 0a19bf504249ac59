//! Mean, scatter and correlation of samples, with their 95 % confidence intervals.
//!
//! The intervals are those of large samples: of the mean by the normal distribution; of the coefficient of variation c by its
//! logarithm, whose variance is 1/(2(n − 1)) + c²/n (delta method, for normal samples); of the correlation by Fisher's
//! transformation, artanh r ± 1.96/√(n − 3).

use serde::Serialize;

/// Standard deviations on both sides of the mean between which 95 % of a normal distribution lie.
const NORMAL_95: f64 = 1.959_963_984_540_054;

/// A sample in numbers, in the unit of its values.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Statistics {
    /// Number of values.
    pub count: usize,
    /// Mean.
    pub mean: f64,
    /// 95 % confidence interval of the mean; none of a single value.
    pub mean_interval: Option<[f64; 2]>,
    /// Standard deviation (of n − 1); none of a single value.
    pub standard_deviation: Option<f64>,
    /// Standard deviation over mean.
    pub coefficient_of_variation: Option<f64>,
    /// 95 % confidence interval of the coefficient of variation.
    pub coefficient_of_variation_interval: Option<[f64; 2]>,
}

impl Statistics {
    /// Returns the statistics of values; `None` of none.
    pub fn new(values: &[f64]) -> Option<Self> {
        let count = values.len();
        if count == 0 {
            return None;
        }
        let n = count as f64;
        let mean = values.iter().sum::<f64>() / n;
        let mut statistics = Statistics {
            count,
            mean,
            mean_interval: None,
            standard_deviation: None,
            coefficient_of_variation: None,
            coefficient_of_variation_interval: None,
        };
        if count > 1 {
            let squares: f64 = values.iter().map(|v| (v - mean) * (v - mean)).sum();
            let deviation = (squares / (n - 1.0)).sqrt();
            let variation = deviation / mean;
            let error = NORMAL_95 * deviation / n.sqrt();
            let relative = NORMAL_95 * (0.5 / (n - 1.0) + variation * variation / n).sqrt();
            statistics.mean_interval = Some([mean - error, mean + error]);
            statistics.standard_deviation = Some(deviation);
            statistics.coefficient_of_variation = Some(variation);
            statistics.coefficient_of_variation_interval =
                Some([-relative, relative].map(|r| variation * libm::exp(r)));
        }
        Some(statistics)
    }
}

/// A correlation.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Correlation {
    /// Number of pairs.
    pub count: usize,
    /// Pearson's coefficient.
    pub coefficient: f64,
    /// Its 95 % confidence interval; none of fewer than four pairs.
    pub interval: Option<[f64; 2]>,
}

impl Correlation {
    /// Returns the correlation of two columns; `None` of fewer than three pairs, or where a column does not vary.
    pub fn new(a: &[f64], b: &[f64]) -> Option<Self> {
        let count = a.len();
        let coefficient = correlation(a, b);
        if count < 3 || !coefficient.is_finite() {
            return None;
        }
        let interval = (count > 3).then(|| {
            let error = NORMAL_95 / ((count - 3) as f64).sqrt();
            let centre = libm::atanh(coefficient.clamp(-1.0, 1.0));
            [-error, error].map(|e| libm::tanh(centre + e))
        });
        Some(Correlation {
            count,
            coefficient,
            interval,
        })
    }
}

/// Returns Pearson's coefficient of correlation; NaN where a column does not vary.
pub(super) fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let mean = |x: &[f64]| x.iter().sum::<f64>() / x.len() as f64;
    let (ma, mb) = (mean(a), mean(b));
    let sum = a.iter().zip(b).fold([0.0; 3], |[ab, aa, bb], (x, y)| {
        let (x, y) = (x - ma, y - mb);
        [ab + x * y, aa + x * x, bb + y * y]
    });
    sum[0] / (sum[1] * sum[2]).sqrt()
}

/// Returns the intercept and the slope of the least-squares line through points.
pub(super) fn regression_line(x: &[f64], y: &[f64]) -> Option<[f64; 2]> {
    let n = x.len() as f64;
    let (mx, my) = (x.iter().sum::<f64>() / n, y.iter().sum::<f64>() / n);
    let (xy, xx) = x.iter().zip(y).fold((0.0, 0.0), |(xy, xx), (x, y)| {
        (xy + (x - mx) * (y - my), xx + (x - mx) * (x - mx))
    });
    let slope = xy / xx;
    slope.is_finite().then_some([my - slope * mx, slope])
}

#[cfg(test)]
mod tests {
    use super::*;
    use greenstick_wood::noise::unit;

    #[test]
    fn five_numbers_by_hand() {
        let s = Statistics::new(&[2.0, 4.0, 4.0, 5.0, 10.0]).unwrap();
        assert_eq!((s.count, s.mean), (5, 5.0));
        // Squares 9 + 1 + 1 + 0 + 25 over 4.
        assert_eq!(s.standard_deviation, Some(3.0));
        assert_eq!(s.coefficient_of_variation, Some(0.6));
        assert!(Statistics::new(&[]).is_none());
        assert!(Statistics::new(&[1.0]).unwrap().mean_interval.is_none());
        let line = regression_line(&[0.0, 1.0, 2.0], &[1.0, 3.0, 5.0]).unwrap();
        assert_eq!(line, [1.0, 2.0]);
        assert!(regression_line(&[1.0, 1.0], &[0.0, 1.0]).is_none());
        assert!(Correlation::new(&[1.0; 5], &[0.0, 1.0, 2.0, 3.0, 4.0]).is_none());
        // numpy.corrcoef, and Fisher's interval by hand.
        let r = Correlation::new(&[1.0, 2.0, 3.0, 4.0, 5.0], &[1.0, 3.0, 2.0, 5.0, 4.0]).unwrap();
        assert!((r.coefficient - 0.8).abs() < 1e-12);
        let [low, high] = r.interval.unwrap();
        assert!(
            (low + 0.2796).abs() < 1e-4 && (high - 0.9862).abs() < 1e-4,
            "{low} {high}"
        );
    }

    #[test]
    fn intervals_hold_the_truth_of_95_samples_in_100() {
        // Normal pairs: mean 1, coefficient of variation 0.2, correlation 0.7.
        let (samples, size) = (1000, 100);
        let mut misses = [0; 3];
        for sample in 0..samples {
            let normal = |i: i64, k: i64| {
                let [a, b] = [0, 1].map(|part| unit(5, sample, i, 2 * k + part));
                (-2.0 * (1.0 - a).ln()).sqrt() * (std::f64::consts::TAU * b).cos()
            };
            let (a, b): (Vec<f64>, Vec<f64>) = (0..size)
                .map(|i| {
                    let (x, y) = (normal(i, 0), normal(i, 1));
                    (1.0 + 0.2 * x, 0.7 * x + 0.51f64.sqrt() * y)
                })
                .unzip();
            let s = Statistics::new(&a).unwrap();
            let r = Correlation::new(&a, &b).unwrap();
            let truth = [
                (s.mean_interval, 1.0),
                (s.coefficient_of_variation_interval, 0.2),
                (r.interval, 0.7),
            ];
            for (miss, (interval, value)) in misses.iter_mut().zip(truth) {
                let [low, high] = interval.unwrap();
                *miss += usize::from(!(low..=high).contains(&value));
            }
        }
        // 50 are expected, ± 7.
        for miss in misses {
            assert!((29..=71).contains(&miss), "{misses:?}");
        }
    }
}
