//! Species and what is known of their wood.

use crate::convert::report;
use crate::failure::Failure;
use greenstick::wood::species::Species as Known;
use pyo3::prelude::*;

/// A species of the tables and the measured properties of its wood.
///
/// Densities are in kg/m³, strengths and moduli in Pa, heights in m; what has not been measured is `None`.
#[pyclass(module = "greenstick", frozen)]
pub struct Species(&'static Known);

#[pymethods]
impl Species {
    /// The species of a common or scientific name, in any order of words: "white oak".
    #[new]
    fn new(name: &str) -> PyResult<Self> {
        Ok(Species(Known::find(name).map_err(Failure::from)?))
    }

    /// The common name as in the table: "Oak, white".
    #[getter]
    fn name(&self) -> &str {
        &self.0.name
    }

    /// The scientific name without author.
    #[getter]
    fn scientific_name(&self) -> &str {
        &self.0.scientific_name
    }

    /// Mass over volume at 12 % moisture, kg/m³.
    #[getter]
    fn air_dry_density(&self) -> Option<f64> {
        self.0.air_dry_density
    }

    /// Everything that is known, as a dictionary: `dry` and `green` hold the mechanical properties at 12 % moisture and of
    /// green wood, in SI units.
    fn as_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        report(py, self.0)
    }

    fn __eq__(&self, other: &Bound<'_, PyAny>) -> bool {
        let other = other.cast::<Species>().ok();
        other.is_some_and(|other| std::ptr::eq(other.get().0, self.0))
    }

    fn __hash__(&self) -> usize {
        std::ptr::from_ref(self.0) as usize
    }

    fn __repr__(&self) -> String {
        format!(
            "<greenstick.Species {}, {}>",
            self.0.name, self.0.scientific_name
        )
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> (Bound<'py, PyAny>, (String,)) {
        let name = slf.get().0.name.clone();
        (slf.get_type().into_any(), (name,))
    }
}

/// All species of the tables.
#[pyfunction]
pub fn species() -> Vec<Species> {
    Known::all().iter().map(Species).collect()
}
