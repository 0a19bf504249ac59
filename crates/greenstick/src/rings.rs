//! Annual rings of one section: a JSON file with its outline goes in, one with its rings comes out (Forests 2023 §3.3).

mod eroded;

pub use eroded::ErodedRings;

use crate::erosion::InnerCircleError;
use glam::DVec2;
use greenstick_picture::Picture;
use greenstick_wood::rings::{RingError, RingField, RingList, estimate_pith};
use serde::Serialize;
use serde_json::{Map, Value, json};
use std::f64::consts::TAU;

/// Points of a ring in the file, and directions in which rings are compared.
const POINTS: usize = 360;
/// Colours of a picture, sRGB: around the section, earlywood, latewood, the pith.
const AROUND: [f64; 3] = [246.0, 244.0, 240.0];
const EARLYWOOD: [f64; 3] = [226.0, 190.0, 140.0];
const LATEWOOD: [f64; 3] = [140.0, 88.0, 46.0];
const PITH: [f64; 3] = [96.0, 58.0, 32.0];
/// Part of a ring from which on it turns to latewood, and the share of the mean radius that is pith.
const LATEWOOD_FROM: f64 = 0.55;
const PITH_SHARE: f64 = 0.008;

/// Why a section has no rings.
#[derive(Debug, thiserror::Error)]
pub enum RingsError {
    /// No JSON.
    #[error("the section is no JSON: {0}")]
    Json(#[from] serde_json::Error),
    /// A field is not there or is something else.
    #[error("`{field}` {found}; it must be {wanted}")]
    Field {
        /// Which, as a path.
        field: String,
        /// What is there.
        found: &'static str,
        /// What would be right.
        wanted: &'static str,
    },
    /// The outline, pith or rings do not go together.
    #[error(transparent)]
    Rings(#[from] RingError),
    /// The circle that an erosion starts from is not in the section.
    #[error(transparent)]
    InnerCircle(#[from] InnerCircleError),
    /// The section is too small for its pixels.
    #[error(
        "no pass takes anything off the section at {resolution} × {resolution} pixels; expected a wider outline or more pixels"
    )]
    Uneroded {
        /// Pixels along a side.
        resolution: usize,
    },
    /// Nothing to compare with.
    #[error("there are no annotated `rings` in the section to compare with")]
    Nothing,
}

/// A section as its file has it.
#[derive(Debug, Clone, PartialEq)]
pub struct Section {
    outline: Vec<DVec2>,
    pith: Option<DVec2>,
    /// Rings in the file, label and points: for comparison only.
    annotated: Vec<(String, Vec<DVec2>)>,
    /// y points up rather than down.
    upwards: bool,
    units: String,
    rest: Map<String, Value>,
}

/// A section with its rings.
#[derive(Debug, Clone, PartialEq)]
pub struct Rings {
    /// The field they are taken from, in the file's units.
    pub field: RingField,
    /// Ring coordinates, from the pith outwards.
    pub coordinates: Vec<f64>,
    /// Whether the pith was guessed from the outline.
    pub guessed: bool,
    section: Section,
}

/// How far one annotated ring is from the model's ring of the same mean radius.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RingComparison {
    /// Its label.
    pub label: String,
    /// Its mean radius about the pith, in the file's units.
    pub mean_radius: f64,
    /// Root mean square of the radial distances over the mean radius, %.
    pub model_percent: f64,
    /// The same for the outline made smaller.
    pub outline_percent: f64,
    /// The same for a circle about the pith.
    pub circle_percent: f64,
}

impl Section {
    /// Reads a section: `outer_contour` [[x, y], …], and if wanted `pith` [x, y], `rings` [{label, points}], `y_axis`
    /// `up` or `down`, `units`.
    ///
    /// # Errors
    /// [`RingsError`] that says which field is wrong.
    pub fn parse(json: &str) -> Result<Self, RingsError> {
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
            .map(|(i, ring)| {
                let label = match &ring["label"] {
                    Value::String(label) => label.clone(),
                    Value::Number(number) => number.to_string(),
                    _ => (i + 1).to_string(),
                };
                Ok((
                    label,
                    points(&format!("rings[{i}].points"), &ring["points"])?,
                ))
            })
            .collect::<Result<_, RingsError>>()?;
        let upwards = match rest.get("y_axis") {
            None => false,
            Some(Value::String(axis)) if axis == "down" => false,
            Some(Value::String(axis)) if axis == "up" => true,
            Some(_) => return Err(wrong("y_axis", "is something else", "\"up\" or \"down\"")),
        };
        let units = match rest.get("units") {
            Some(Value::String(units)) => units.clone(),
            _ => "px".to_owned(),
        };
        Ok(Section {
            outline,
            pith,
            annotated,
            upwards,
            units,
            rest: rest.clone(),
        })
    }

    /// The unit of its lengths, px where the file does not say.
    pub fn units(&self) -> &str {
        &self.units
    }

    /// Its rings about `pith`, or the file's pith, or a guessed one.
    ///
    /// # Errors
    /// [`RingsError::Rings`] where they do not fit into the outline.
    pub fn rings(self, list: &RingList, pith: Option<DVec2>) -> Result<Rings, RingsError> {
        let (field, guessed) = self.field(pith)?;
        Ok(Rings {
            coordinates: field.coordinates(list)?,
            guessed,
            field,
            section: self,
        })
    }

    /// The field about `pith`, or the file's pith, or a guessed one; whether it was guessed.
    fn field(&self, pith: Option<DVec2>) -> Result<(RingField, bool), RingsError> {
        let given = pith.or(self.pith);
        // The first attempt says what is wrong with the outline before a pith is looked for in it.
        let first = given.or(self.outline.first().copied()).unwrap_or_default();
        let field = match RingField::of_section(&self.outline, first) {
            Err(RingError::Pith { .. }) | Ok(_) if given.is_none() => {
                RingField::of_section(&self.outline, estimate_pith(&self.outline))?
            }
            other => other?,
        };
        Ok((field, given.is_none()))
    }

    /// Least and greatest coordinates of the outline.
    fn reach(&self) -> (DVec2, DVec2) {
        self.outline
            .iter()
            .fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(a, b), &p| {
                (a.min(p), b.max(p))
            })
    }

    /// Its file with other rings, each a mean radius and a curve, from the pith outwards.
    fn json(
        &self,
        how: &str,
        pith: DVec2,
        guessed: bool,
        rings: impl Iterator<Item = (f64, Vec<DVec2>)>,
    ) -> String {
        let round = |p: DVec2| [p.x, p.y].map(|v| (v * 1e4).round() / 1e4);
        let list = |curve: &[DVec2]| curve.iter().map(|&p| round(p)).collect::<Vec<_>>();
        let rings: Vec<Value> = rings
            .enumerate()
            .map(|(i, (mean_radius, curve))| {
                json!({
                    "label": (i + 1).to_string(),
                    "mean_radius": mean_radius,
                    "points": list(&curve),
                })
            })
            .collect();
        let mut file = self.rest.clone();
        // What was said of the annotated rings is not true of these.
        file.remove("stats");
        file.insert("kind".into(), json!(how));
        file.insert("units".into(), json!(self.units));
        let axis = if self.upwards { "up" } else { "down" };
        file.insert("y_axis".into(), json!(axis));
        file.insert("pith".into(), json!(round(pith)));
        file.insert("pith_guessed".into(), json!(guessed));
        file.insert("outer_contour".into(), json!(list(&self.outline)));
        file.insert("rings".into(), Value::Array(rings));
        Value::Object(file).to_string() + "\n"
    }

    /// A picture, `size` pixels wide and high, as it lies in the file, of places' colours (sRGB).
    fn picture(&self, size: u32, colour: impl Fn(DVec2) -> [f64; 3]) -> Picture {
        let size = size.max(1);
        let reach = self.reach();
        let (middle, extent) = (
            (reach.0 + reach.1) * 0.5,
            (reach.1 - reach.0).max_element() * 1.06,
        );
        const SAMPLES: u32 = 3;
        let mut rgb = Vec::with_capacity(size as usize * size as usize * 3);
        for y in 0..size {
            for x in 0..size {
                let mut sum = [0.0; 3];
                for i in 0..SAMPLES * SAMPLES {
                    let at = |p: u32, s: u32| {
                        (f64::from(p) + (f64::from(s) + 0.5) / f64::from(SAMPLES)) / f64::from(size)
                            - 0.5
                    };
                    let mut p = DVec2::new(at(x, i % SAMPLES), at(y, i / SAMPLES)) * extent;
                    if self.upwards {
                        p.y = -p.y;
                    }
                    for (sum, c) in sum.iter_mut().zip(colour(middle + p)) {
                        *sum += c / f64::from(SAMPLES * SAMPLES);
                    }
                }
                rgb.extend(sum.map(|c| c as u8));
            }
        }
        Picture {
            width: size,
            height: size,
            rgb,
        }
    }
}

/// The annotated rings of a section, each beside a model's ring: `model` gives radii of one of about a mean radius.
fn comparison(
    section: &Section,
    pith: DVec2,
    model: impl Fn(f64) -> Vec<f64>,
) -> Result<Vec<RingComparison>, RingsError> {
    if section.annotated.is_empty() {
        return Err(RingsError::Nothing);
    }
    let outer = radii(&section.outline, pith);
    let compare = |(label, curve): &(String, Vec<DVec2>)| {
        let real = radii(curve, pith);
        let mean_radius = real.iter().sum::<f64>() / POINTS as f64;
        RingComparison {
            label: label.clone(),
            mean_radius,
            model_percent: deviation(&model(mean_radius), &real),
            outline_percent: deviation(&outer, &real),
            circle_percent: deviation(&[1.0; POINTS], &real),
        }
    };
    Ok(section.annotated.iter().map(compare).collect())
}

impl Rings {
    /// The section's file with these rings in place of its own.
    pub fn json(&self) -> String {
        let rings = self
            .coordinates
            .iter()
            .map(|&ring| (self.field.mean_radius(ring), self.field.curve(ring, POINTS)));
        let how = "rings of a model, from the outline and the pith";
        self.section
            .json(how, self.field.pith(), self.guessed, rings)
    }

    /// The file's own rings, each beside the model's ring of the same mean radius.
    ///
    /// # Errors
    /// [`RingsError::Nothing`] where the file has none.
    pub fn compare(&self) -> Result<Vec<RingComparison>, RingsError> {
        let pith = self.field.pith();
        comparison(&self.section, pith, |mean_radius| {
            let ring = self.field.ring_of_mean_radius(mean_radius);
            let curve = self.field.curve(ring, POINTS);
            curve.iter().map(|p| p.distance(pith)).collect()
        })
    }

    /// A picture, `size` pixels wide and high: light earlywood, dark latewood, as it lies in the file.
    pub fn picture(&self, size: u32) -> Picture {
        self.section.picture(size, |p| self.colour(p))
    }

    /// The colour of a place, sRGB.
    fn colour(&self, p: DVec2) -> [f64; 3] {
        let ring = self.field.address(p).0;
        if ring > 1.0 {
            return AROUND;
        }
        if ring < PITH_SHARE {
            return PITH;
        }
        let i = self.coordinates.partition_point(|&c| c < ring);
        let inner = if i == 0 { 0.0 } else { self.coordinates[i - 1] };
        // Beyond the last ring is the year that is not over.
        let outer = self.coordinates.get(i).copied().unwrap_or(1.0);
        let t = (ring - inner) / (outer - inner).max(1e-12);
        let dark = ((t - LATEWOOD_FROM) / (1.0 - LATEWOOD_FROM)).clamp(0.0, 1.0);
        let dark = dark * dark;
        std::array::from_fn(|c| EARLYWOOD[c] + (LATEWOOD[c] - EARLYWOOD[c]) * dark)
    }
}

/// Root mean square of the distances of a model ring, scaled to the real one's mean, from it; % of that mean.
fn deviation(model: &[f64], real: &[f64]) -> f64 {
    let count = real.len() as f64;
    let mean = real.iter().sum::<f64>() / count;
    let scale = mean / (model.iter().sum::<f64>() / count);
    let squares = model
        .iter()
        .zip(real)
        .map(|(m, r)| (m * scale - r) * (m * scale - r));
    (squares.sum::<f64>() / count).sqrt() / mean * 100.0
}

/// Radii of a closed curve about `pith` at equal angles, the farthest where there are more.
fn radii(curve: &[DVec2], pith: DVec2) -> Vec<f64> {
    (0..POINTS)
        .map(|i| {
            let (sin, cos) = libm::sincos(TAU * i as f64 / POINTS as f64);
            let direction = DVec2::new(cos, sin);
            let crossings = (0..curve.len()).filter_map(|j| {
                let (a, b) = (curve[j] - pith, curve[(j + 1) % curve.len()] - pith);
                let (u, v) = (direction.perp_dot(a), direction.perp_dot(b));
                ((u > 0.0) != (v > 0.0)).then(|| direction.dot(a + (b - a) * (u / (u - v))))
            });
            crossings.fold(0.0, f64::max)
        })
        .collect()
}

fn wrong(field: &str, found: &'static str, wanted: &'static str) -> RingsError {
    RingsError::Field {
        field: field.to_owned(),
        found,
        wanted,
    }
}

fn point(field: &str, value: &Value) -> Result<DVec2, RingsError> {
    match value.as_array().map(Vec::as_slice) {
        Some([x, y]) => match (x.as_f64(), y.as_f64()) {
            (Some(x), Some(y)) => Ok(DVec2::new(x, y)),
            _ => Err(wrong(
                field,
                "holds something else than numbers",
                "two numbers [x, y]",
            )),
        },
        _ => Err(wrong(field, "is no pair", "two numbers [x, y]")),
    }
}

fn points(field: &str, value: &Value) -> Result<Vec<DVec2>, RingsError> {
    let list = value
        .as_array()
        .ok_or_else(|| wrong(field, "is no list", "a list of points [x, y]"))?;
    list.iter()
        .enumerate()
        .map(|(i, p)| point(&format!("{field}[{i}]"), p))
        .collect()
}
