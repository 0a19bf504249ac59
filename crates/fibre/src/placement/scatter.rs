//! Scatter of strength.

/// Returns a strength relative to the mean, Weibull distributed, for a uniform number from 0 to 1; 1 for an infinite
/// modulus.
pub(crate) fn weibull(modulus: f64, uniform: f64) -> f64 {
    if modulus.is_infinite() {
        return 1.0;
    }
    libm::pow(-libm::log1p(-uniform), 1.0 / modulus) / libm::tgamma(1.0 + 1.0 / modulus)
}
