//! Annual rings of a section.

use crate::arrays::{self, Expected};
use crate::convert::{Reduced, points, report};
use crate::failure::Failure;
use crate::pickled::{unseal, version_seal};
use crate::pictures::Picture;
use crate::values::{dictionary, each};
use crate::work;
use greenstick::SectionRingSettings;
use greenstick::files::{self, Output, read_photograph};
use greenstick::geometry::{Context, Provenance};
use greenstick::picture::Picture as Drawn;
use greenstick::schema::Parameters;
use greenstick::wood::rings::{RingsFile, SectionFile, SectionFileError};
use greenstick::{ErrorKind, provenance};
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict, PyMapping, PyString};
use serde_json::json;
use std::path::{Path, PathBuf};

impl From<SectionFileError> for Failure {
    fn from(error: SectionFileError) -> Self {
        let kind = match &error {
            SectionFileError::Cancelled(_) => ErrorKind::Cancelled,
            _ => ErrorKind::Request,
        };
        Failure::new("SectionError", kind, error)
    }
}

/// The annual rings of a section, in the units and axes of its file. They pickle as the section and what was asked, and are made
/// again when they are unpickled.
#[pyclass(module = "greenstick", frozen)]
pub struct Rings {
    section: RingsFile,
    source: Source,
    settings: SectionRingSettings,
    provenance: Provenance,
    /// Where the stem began to be eccentric, as a share of its radius: fitted or given; None for that of an average tree.
    #[pyo3(get)]
    eccentricity_onset: Option<f64>,
    /// The unit of all lengths, "px" where the file does not say.
    #[pyo3(get)]
    units: String,
}

#[pymethods]
impl Rings {
    /// The pith: shape (2,), float64.
    #[getter]
    fn pith<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &self.section.rings.pith().to_array())
    }

    /// Whether the pith was guessed from the outline.
    #[getter]
    fn is_pith_guessed(&self) -> bool {
        self.section.rings.is_pith_estimated()
    }

    /// The outline of the section: shape (n, 2), float64. A copy.
    #[getter]
    fn outline<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        points(py, &self.section.rings.outline().points)
    }

    /// The outer contours of the rings from the pith outwards: arrays of shape (n, 2), float64. The last point is joined to the
    /// first. Copies.
    #[getter]
    fn curves<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyArray2<f64>>>> {
        let curves = work::run(py, None, |context| {
            Ok(self.section.rings.curves(context)?)
        })?;
        curves.iter().map(|c| points(py, &c.points)).collect()
    }

    /// The mean radii of the rings about the pith, from the pith outwards: shape (k,), float64.
    #[getter]
    fn mean_radii<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let curves = work::run(py, None, |context| {
            Ok(self.section.rings.curves(context)?)
        })?;
        let radii = curves.iter().map(|c| c.mean_radius).collect();
        Ok(PyArray1::from_vec(py, radii))
    }

    /// The rings that the section's file has, each beside the ring of the same mean radius: a list of dictionaries with the
    /// root mean square of the radial distances in % of the mean radius, of these rings (`model_percent`), of the outline scaled
    /// down and of a circle.
    fn compare<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let found = work::run(py, None, |context| Ok(self.section.compare(context)?))?;
        report(py, &found)
    }

    /// The section's file with these rings in place of its own, as JSON: the text that the program writes.
    fn json(&self, py: Python<'_>) -> PyResult<String> {
        work::run(py, None, |context| {
            Ok(self.section.json(&self.provenance, context)?)
        })
    }

    /// Writes that file.
    fn write(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let bytes = self.json(py)?.into_bytes();
        Ok(files::write_all(&[Output { path, bytes }]).map_err(Failure::from)?)
    }

    /// A picture of the rings, or with `photo`, a file, of them over a photograph whose pixels are the section's coordinates.
    #[pyo3(signature = (photo=None))]
    fn picture(&self, py: Python<'_>, photo: Option<PathBuf>) -> PyResult<Picture> {
        let photo = photo.as_deref().map(read_photograph).transpose();
        let photo = photo.map_err(Failure::from)?;
        let size = self.settings.picture_size;
        let painted = work::run(py, None, |context| {
            Ok(match &photo {
                Some(photo) => self.section.paint_over(photo, context)?,
                None => self.section.paint(size, context)?,
            })
        })?;
        let drawn = Drawn {
            width: painted.width,
            height: painted.height,
            rgb: painted.rgb,
        };
        Ok(Picture::new(drawn, self.provenance.metadata()))
    }

    fn _repr_png_<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        Ok(self.picture(py, None)?.png(py).into_any())
    }

    fn __len__(&self) -> usize {
        self.section.rings.ring_count()
    }

    fn __reduce__<'py>(
        slf: &Bound<'py, Self>,
    ) -> Reduced<'py, (Bound<'py, PyBytes>, Source, Bound<'py, PyDict>)> {
        let (py, rings) = (slf.py(), slf.get());
        let settings = dictionary(py, rings.settings.changed())?;
        let parts = (version_seal(py), rings.source.clone(), settings);
        Ok((slf.get_type().getattr("_again")?, parts))
    }

    /// The rings of a pickle.
    #[staticmethod]
    fn _again(
        py: Python<'_>,
        seal: &[u8],
        source: Source,
        settings: &Bound<'_, PyDict>,
    ) -> PyResult<Self> {
        unseal("rings", seal)?;
        let asked = settings_of([Some(settings), None])?;
        make_rings(py, source, asked, None)
    }

    fn __repr__(&self) -> String {
        format!("<greenstick.Rings {} rings>", self.__len__())
    }
}

/// Makes the annual rings of a section from its outline, its pith and their number, or from measured radii or widths.
///
/// `section` is a file as the program reads it (.json), its text, a dictionary of the same content, or the outline alone: an
/// array of shape (n, 2). Keys are those of the program's `rings`: `rings=40`, `widths=[...]`, `pith=[x, y]`,
/// `rings_by="erosion"`. `fit=True` fits where the stem began to be eccentric to the rings that the file has.
#[pyfunction]
#[pyo3(signature = (section, settings=None, *, fit=false, progress=None, **keys))]
pub fn rings(
    py: Python<'_>,
    section: &Bound<'_, PyAny>,
    settings: Option<&Bound<'_, PyDict>>,
    fit: bool,
    progress: Option<&Bound<'_, PyAny>>,
    keys: Option<&Bound<'_, PyDict>>,
) -> PyResult<Rings> {
    let asked = settings_of([settings, keys])?;
    let (text, name) = section_text(section)?;
    make_rings(py, (text, name, fit), asked, progress)
}

/// The text of a section, the file that it was read from, and whether the rings are fitted to those that it has.
type Source = (String, Option<PathBuf>, bool);

/// Reads what is asked of rings.
fn settings_of(dictionaries: [Option<&Bound<'_, PyDict>>; 2]) -> PyResult<SectionRingSettings> {
    let mut asked = SectionRingSettings::default();
    each(dictionaries, |key, value| Ok(asked.set(key, value)?))?;
    asked.check().map_err(Failure::from)?;
    Ok(asked)
}

fn make_rings(
    py: Python<'_>,
    source: Source,
    asked: SectionRingSettings,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<Rings> {
    let (text, name, fit) = &source;
    let about = |error: SectionFileError| -> Failure {
        let failure = Failure::from(error);
        match name {
            Some(path) => failure.about(path),
            None => failure,
        }
    };
    let (method, pith) = (asked.method(), asked.pith_point().map(Into::into));
    let make = |context: &Context| -> Result<_, SectionFileError> {
        let file = SectionFile::parse(text)?;
        let units = file.units().to_owned();
        let onset = match (asked.eccentricity_onset, *fit) {
            (None, true) => Some(file.fit_eccentricity_onset(pith, context)?),
            (given, _) => given,
        };
        let file = file.with_eccentricity_onset(onset);
        Ok((file.rings(&method, pith, context)?, onset, units))
    };
    let (section, eccentricity_onset, units) =
        work::run(py, progress, |context| make(context).map_err(about))?;
    let input = name.as_deref().and_then(Path::file_name);
    let input = input.map(|name| name.to_string_lossy().into_owned());
    Ok(Rings {
        section,
        provenance: provenance("rings", input.as_deref(), &asked),
        source,
        settings: asked,
        eccentricity_onset,
        units,
    })
}

/// The text of a section, and the file that it was read from.
fn section_text(section: &Bound<'_, PyAny>) -> PyResult<(String, Option<PathBuf>)> {
    let py = section.py();
    if let Ok(text) = section.cast::<PyString>()
        && text.to_str()?.contains('{')
    {
        return Ok((text.to_str()?.to_owned(), None));
    }
    if let Ok(path) = section.extract::<PathBuf>() {
        let text = files::read_text(&path).map_err(Failure::from)?;
        return Ok((text, Some(path)));
    }
    if section.cast::<PyMapping>().is_ok() {
        let text = py.import("json")?.call_method1("dumps", (section,))?;
        return Ok((text.extract()?, None));
    }
    let expected = Expected {
        name: "section",
        columns: 2,
        dtype: "float64",
        kinds: "fiu",
    };
    let (flat, _) = arrays::rows::<f64>(section, &expected)?;
    arrays::check_finite("section", &flat, 2)?;
    let outline: Vec<&[f64]> = flat.chunks_exact(2).collect();
    Ok((json!({ "outer_contour": outline }).to_string(), None))
}
