//! Quantiles of weighted values.

/// A value with its weight.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Weighted {
    pub value: f64,
    pub weight: f64,
}

/// Returns the value below which the part `part` of the weights lies; 0 where there are no values.
pub(crate) fn quantile(values: &[Weighted], part: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(|a, b| a.value.total_cmp(&b.value));
    let total: f64 = sorted.iter().map(|v| v.weight).sum();
    let mut below = 0.0;
    for v in &sorted {
        below += v.weight;
        if below >= part * total {
            return v.value;
        }
    }
    sorted.last().map_or(0.0, |v| v.value)
}

/// Returns the distance from the 5th to the 95th percentile.
pub(super) fn spread(values: &[Weighted]) -> f64 {
    quantile(values, 0.95) - quantile(values, 0.05)
}

/// Returns the sum of value times weight: the mean, where the weights add up to 1.
pub(super) fn weighted_sum(values: &[Weighted]) -> f64 {
    values.iter().map(|v| v.value * v.weight).sum()
}
