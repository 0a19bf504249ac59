//! Annual rings of one section: a JSON file with its outline goes in, one with its rings comes out (Forests 2023 §3.3).

use super::super::field::RingField;
use super::super::pith::estimate_pith;
use super::compare::{AnnotatedRing, RingComparison};
use super::curves::{mean, radii};
use super::file_error::SectionFileError;
use super::outline::SectionOutline;
use super::rings::{SectionRingMethod, SectionRings};
use crate::colour::RgbImage;
use glam::DVec2;
use greenstick_geometry::{Cancelled, Context, Provenance};
use serde_json::{Map, Value, json};
/// The file of a section.
#[derive(Debug, Clone, PartialEq)]
pub struct SectionFile {
    outline: SectionOutline,
    /// Rings in the file: for comparison only.
    annotated: Vec<AnnotatedRing>,
    units: String,
    /// The fields that are not read.
    rest: Map<String, Value>,
}

/// A section's file with its rings.
#[derive(Debug, Clone, PartialEq)]
pub struct RingsFile {
    /// The rings, in the file's units.
    pub rings: SectionRings,
    file: SectionFile,
}

impl SectionFile {
    /// Reads a section: `outer_contour` [[x, y], …], and optionally `pith` [x, y], `rings` [{label, points}], `y_axis` `up`
    /// or `down`, `units`.
    ///
    /// # Errors
    /// [`SectionFileError`] that says which field is wrong.
    ///
    /// ```
    /// use greenstick_geometry::Context;
    /// use greenstick_wood::rings::{RingSeries, SectionFile, SectionRingMethod};
    ///
    /// let square = r#"{ "outer_contour": [[0, 0], [8, 0], [8, 8], [0, 8]], "pith": [4, 4] }"#;
    /// let rings = SectionRingMethod::Field(RingSeries::Number(3));
    /// let file = SectionFile::parse(square)?.rings(&rings, None, &Context::quiet())?;
    /// assert_eq!(file.rings.ring_count(), 3);
    /// # Ok::<(), greenstick_wood::rings::SectionFileError>(())
    /// ```
    pub fn parse(json: &str) -> Result<Self, SectionFileError> {
        let mut value: Value = serde_json::from_str(json)?;
        let rest = value.as_object_mut().ok_or_else(|| {
            wrong(
                "the file",
                "is no object",
                "an object with an `outer_contour`",
            )
        })?;
        let outline = rest
            .remove("outer_contour")
            .ok_or_else(|| wrong("outer_contour", "is missing", "a list of points [x, y]"))?;
        let outline = points("outer_contour", &outline)?;
        let pith = match rest.remove("pith") {
            None | Some(Value::Null) => None,
            Some(value) => Some(point("pith", &value)?),
        };
        let rings = rest.remove("rings").unwrap_or(Value::Null);
        let annotated = rings
            .as_array()
            .into_iter()
            .flatten()
            .enumerate()
            .map(|(i, ring)| annotated_ring(i, ring))
            .collect::<Result<_, SectionFileError>>()?;
        let y_up = match rest.get("y_axis") {
            None => false,
            Some(Value::String(axis)) if axis == "down" => false,
            Some(Value::String(axis)) if axis == "up" => true,
            Some(_) => return Err(wrong("y_axis", "is something else", "\"up\" or \"down\"")),
        };
        let units = match rest.get("units") {
            Some(Value::String(units)) => units.clone(),
            _ => "px".to_owned(),
        };
        Ok(SectionFile {
            outline: SectionOutline {
                points: outline,
                pith,
                y_up,
                eccentricity_onset: None,
            },
            annotated,
            units,
            rest: rest.clone(),
        })
    }

    /// Returns the outline, with the pith where the file has one.
    pub fn outline(&self) -> &SectionOutline {
        &self.outline
    }

    /// The unit of its lengths, px where the file does not say.
    pub fn units(&self) -> &str {
        &self.units
    }

    /// Mean radii of the rings in the file, about its pith, as shares of the outline's, ascending: what another section
    /// takes of them.
    ///
    /// # Errors
    /// [`SectionFileError::NotAnnotated`] where none lies within the outline.
    pub fn ring_shares(&self) -> Result<Vec<f64>, SectionFileError> {
        let pith = self
            .outline
            .pith
            .unwrap_or_else(|| estimate_pith(&self.outline.points));
        let mean_radius = |curve: &[DVec2]| mean(&radii(curve, pith));
        let outer = mean_radius(&self.outline.points);
        let share = |ring: &AnnotatedRing| mean_radius(&ring.points) / outer;
        let mut shares: Vec<f64> = self.annotated.iter().map(share).collect();
        shares.retain(|&share| share > 0.0 && share <= 1.0);
        shares.sort_by(f64::total_cmp);
        shares.dedup();
        if shares.is_empty() {
            return Err(SectionFileError::NotAnnotated);
        }
        Ok(shares)
    }

    /// The ring coordinate at which eccentricity began, fitted to the points of the file's rings about `pith`, or the file's
    /// pith, or an estimated one.
    ///
    /// # Errors
    /// [`SectionFileError::NotAnnotated`] where no ring has two points, [`SectionFileError::Rings`] where the pith lies
    /// outside of the outline, [`SectionFileError::Cancelled`].
    pub fn fit_eccentricity_onset(
        &self,
        pith: Option<DVec2>,
        context: &Context,
    ) -> Result<f64, SectionFileError> {
        let pith = pith.or(self.outline.pith);
        let pith = pith.unwrap_or_else(|| estimate_pith(&self.outline.points));
        let rings: Vec<&[DVec2]> = self.annotated.iter().map(|r| &*r.points).collect();
        let fitted =
            RingField::fit_eccentricity_onset(&self.outline.points, pith, &rings, context)?;
        fitted.ok_or(SectionFileError::NotAnnotated)
    }

    /// The same section with a known onset of eccentricity, as a ring coordinate.
    #[must_use]
    pub fn with_eccentricity_onset(mut self, onset: Option<f64>) -> Self {
        self.outline.eccentricity_onset = onset;
        self
    }

    /// Its rings about `pith`, or the file's pith, or an estimated one.
    ///
    /// # Errors
    /// [`SectionFileError::Rings`] where they do not fit into the outline.
    pub fn rings(
        self,
        method: &SectionRingMethod,
        pith: Option<DVec2>,
        context: &Context,
    ) -> Result<RingsFile, SectionFileError> {
        let outline = SectionOutline {
            pith: pith.or(self.outline.pith),
            ..self.outline.clone()
        };
        let rings = SectionRings::new(outline, method, context)?;
        Ok(RingsFile { rings, file: self })
    }
}

impl RingsFile {
    /// The section's file with these rings in place of its own, and where they come from.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn json(&self, provenance: &Provenance, context: &Context) -> Result<String, Cancelled> {
        let round = |p: DVec2| [p.x, p.y].map(|v| (v * 1e4).round() / 1e4);
        let list = |curve: &[DVec2]| curve.iter().map(|&p| round(p)).collect::<Vec<_>>();
        let rings: Vec<Value> = self
            .rings
            .curves(context)?
            .iter()
            .enumerate()
            .map(|(i, curve)| {
                json!({
                    "label": (i + 1).to_string(),
                    "mean_radius": curve.mean_radius,
                    "points": list(&curve.points),
                })
            })
            .collect();
        let kind = match self.rings.pass_count() {
            None => "rings of a model, from the outline and the pith",
            Some(_) => "rings by erosion, from the outline",
        };
        let mut file = self.file.rest.clone();
        // Statistics of the annotated rings are not those of these.
        file.remove("stats");
        file.insert("kind".into(), json!(kind));
        file.insert("provenance".into(), json!(provenance));
        file.insert("units".into(), json!(self.file.units));
        let outline = self.rings.outline();
        if let Some(onset) = outline.eccentricity_onset {
            file.insert("eccentricity_onset".into(), json!(onset));
        }
        let axis = if outline.y_up { "up" } else { "down" };
        file.insert("y_axis".into(), json!(axis));
        file.insert("pith".into(), json!(round(self.rings.pith())));
        file.insert("pith_guessed".into(), json!(self.rings.is_pith_estimated()));
        file.insert(
            "pith_uncertainty".into(),
            json!(self.rings.pith_uncertainty()),
        );
        file.insert("outer_contour".into(), json!(list(&outline.points)));
        file.insert("rings".into(), Value::Array(rings));
        Ok(Value::Object(file).to_string() + "\n")
    }

    /// The file's own rings, each beside the model's ring of the same mean radius.
    ///
    /// # Errors
    /// [`SectionFileError::NotAnnotated`] where the file has none, [`SectionFileError::Cancelled`].
    pub fn compare(&self, context: &Context) -> Result<Vec<RingComparison>, SectionFileError> {
        if self.file.annotated.is_empty() {
            return Err(SectionFileError::NotAnnotated);
        }
        Ok(self.rings.compare(&self.file.annotated, context)?)
    }

    /// Paints the rings, `size` pixels wide and high: light earlywood, dark latewood, with the file's y as it is.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn paint(&self, size: u32, context: &Context) -> Result<RgbImage, Cancelled> {
        self.rings.paint(size, context)
    }

    /// Draws outline, rings and pith over a photograph, whose pixels are the file's coordinates.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn paint_over(&self, photo: &RgbImage, context: &Context) -> Result<RgbImage, Cancelled> {
        self.rings.paint_over(photo, context)
    }
}

fn annotated_ring(index: usize, ring: &Value) -> Result<AnnotatedRing, SectionFileError> {
    Ok(AnnotatedRing {
        label: match &ring["label"] {
            Value::String(label) => label.clone(),
            Value::Number(number) => number.to_string(),
            _ => (index + 1).to_string(),
        },
        points: points(&format!("rings[{index}].points"), &ring["points"])?,
    })
}

fn wrong(field: &str, found: &'static str, expected: &'static str) -> SectionFileError {
    SectionFileError::Field {
        field: field.to_owned(),
        found,
        expected,
    }
}

fn point(field: &str, value: &Value) -> Result<DVec2, SectionFileError> {
    let expected = "two numbers [x, y]";
    let Some([x, y]) = value.as_array().map(Vec::as_slice) else {
        return Err(wrong(field, "is no pair", expected));
    };
    match (x.as_f64(), y.as_f64()) {
        (Some(x), Some(y)) => Ok(DVec2::new(x, y)),
        _ => Err(wrong(
            field,
            "contains values that are not numbers",
            expected,
        )),
    }
}

fn points(field: &str, value: &Value) -> Result<Vec<DVec2>, SectionFileError> {
    let list = value
        .as_array()
        .ok_or_else(|| wrong(field, "is no list", "a list of points [x, y]"))?;
    list.iter()
        .enumerate()
        .map(|(i, p)| point(&format!("{field}[{i}]"), p))
        .collect()
}
