//! Pictures.

use crate::arrays;
use crate::convert::Reduced;
use crate::pickled::damaged;
use greenstick::files::{self, Output};
use greenstick::geometry::Metadata;
use greenstick::picture::Picture as Drawn;
use numpy::{PyArray3, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use std::path::PathBuf;

/// A picture. A notebook shows it.
#[pyclass(module = "greenstick", frozen)]
pub struct Picture {
    picture: Drawn,
    metadata: Metadata,
}

impl Picture {
    pub fn new(picture: Drawn, metadata: Metadata) -> Self {
        Picture { picture, metadata }
    }
}

#[pymethods]
impl Picture {
    /// The pixels: an array of shape (height, width, 3) and dtype uint8, red, green and blue in sRGB, rows from top to
    /// bottom. It looks into the picture's memory without a copy, and is read-only.
    #[getter]
    fn array<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyArray3<u8>>> {
        let picture = &slf.get().picture;
        let flat = arrays::view(slf.as_any(), &picture.rgb, 3)?;
        flat.reshape([picture.height as usize, picture.width as usize, 3])
    }

    /// Width, pixels.
    #[getter]
    fn width(&self) -> u32 {
        self.picture.width
    }

    /// Height, pixels.
    #[getter]
    fn height(&self) -> u32 {
        self.picture.height
    }

    /// The picture as a PNG file.
    pub fn png<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        let bytes = py.detach(|| self.picture.png_with(&self.metadata));
        PyBytes::new(py, &bytes)
    }

    fn _repr_png_<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        self.png(py)
    }

    /// Writes the picture as a PNG file, beside its place first.
    fn write(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let output = Output {
            path,
            bytes: py.detach(|| self.picture.png_with(&self.metadata)),
        };
        Ok(files::write_all(&[output]).map_err(crate::failure::Failure::from)?)
    }

    #[pyo3(signature = (dtype=None, copy=None))]
    fn __array__<'py>(
        slf: &Bound<'py, Self>,
        dtype: Option<&Bound<'py, PyAny>>,
        copy: Option<bool>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let array = Picture::array(slf)?.into_any();
        match (dtype, copy) {
            (Some(dtype), _) => array.call_method1("astype", (dtype,)),
            (None, Some(true)) => array.call_method0("copy"),
            _ => Ok(array),
        }
    }

    fn __repr__(&self) -> String {
        format!(
            "<greenstick.Picture {}x{}>",
            self.picture.width, self.picture.height
        )
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> Reduced<'py, PictureParts<'py>> {
        let picture = slf.get();
        let py = slf.py();
        let names = picture.metadata.entries.iter();
        let metadata = names.map(|e| (e.name.clone(), e.text.clone())).collect();
        let parts = (
            picture.picture.width,
            picture.picture.height,
            PyBytes::new(py, &picture.picture.rgb),
            metadata,
        );
        Ok((slf.get_type().getattr("_again")?, parts))
    }

    /// The picture of a pickle.
    #[staticmethod]
    fn _again(
        width: u32,
        height: u32,
        rgb: Vec<u8>,
        metadata: Vec<(String, String)>,
    ) -> PyResult<Self> {
        let (found, expected) = (
            rgb.len() as u128,
            3 * u128::from(width) * u128::from(height),
        );
        if found != expected {
            let problem = format!("{width} x {height} pixels have {expected} bytes, not {found}");
            return Err(damaged("a picture", problem).into());
        }
        let mut all = Metadata::default();
        for (name, text) in metadata {
            all.push(&name, &text);
        }
        Ok(Picture::new(Drawn { width, height, rgb }, all))
    }
}

/// What a pickle of a picture holds.
type PictureParts<'py> = (u32, u32, Bound<'py, PyBytes>, Vec<(String, String)>);
