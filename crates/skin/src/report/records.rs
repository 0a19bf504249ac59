//! The report on a break and its parts, in numbers with units.

use crate::hang::HangReport;
use crate::lean::LeanReport;
use greenstick_geometry::text::one_line;
use greenstick_wood::scan::ScannedReport;
use serde::{Deserialize, Serialize};
use std::fmt;

/// The input.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct InputReport {
    /// Meshes in the scene.
    pub meshes: usize,
    /// Triangles of all of them.
    pub triangles: usize,
    /// Area of all of them, m².
    pub area_m2: f64,
    /// Volume, m³; none unless the shell that was cut is closed and oriented.
    pub volume_m3: Option<f64>,
    /// Whether the shell that was cut is closed.
    pub closed: bool,
    /// What was left out, repaired or changed in the mesh; one sentence each.
    pub repairs: Vec<String>,
}

/// Where the break is.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PlaceReport {
    /// Name of the mesh that was cut.
    pub mesh: String,
    /// `round`, `board`, `dowel` or `pole`.
    pub kind: String,
    /// Length of the stem's axis before any break, m.
    pub stem_length_m: f64,
    /// Length along the axis to the break, m.
    pub length_m: f64,
    /// Point of the axis there, m.
    pub point_m: [f64; 3],
    /// Radius of the circle as large as the section, m.
    pub radius_m: f64,
    /// Pith in the section, m from the axis.
    pub pith_m: [f64; 2],
    /// Range along the axis that was free for the break, m.
    pub free_m: [f64; 2],
}

/// The broken face.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FaceReport {
    /// Seed of this break, which follows from that of the request, the stem, and the number of the break.
    pub seed: u64,
    /// `smooth` or `fibrous`.
    pub surface: String,
    /// Fibre bundles.
    pub bundles: usize,
    /// Thorns.
    pub thorns: usize,
    /// Lowest and highest point, m from the location of the break along the grain.
    pub range_m: [f64; 2],
    /// The 5th and the 95th percentile of the heights of its corners, m from the location: the height that a species calls for
    /// lies between these two, and single corners reach farther.
    pub percentiles_m: [f64; 2],
    /// Factors on heights below and above the location, under 1 where those as drawn would have left the stem or met another
    /// limb.
    pub scales: [f64; 2],
    /// How far the face was moved up along the stem to have more room, m.
    pub moved_m: f64,
    /// Corners that were limited further than in proportion.
    pub limited: usize,
    /// Lowest and highest point as drawn, before both, m.
    pub wanted_m: [f64; 2],
}

/// The effect of the species on the break.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SpeciesReport {
    /// Common name.
    pub name: String,
    /// Scientific name.
    pub scientific_name: String,
    /// Moisture content, percent.
    pub moisture_percent: f64,
    /// Rule for the height.
    pub rule: String,
    /// Source of the values that it uses.
    pub basis: String,
    /// Height by the rule, m: of the whole face by Eq. 9, of a bundle 1 mm wide by shear lag.
    pub height_m: f64,
    /// Factor on the torn relief.
    pub relief: f64,
}

/// A piece.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PieceReport {
    /// Name of its node.
    pub name: String,
    /// Triangles.
    pub triangles: usize,
    /// Volume, m³; none unless it is closed and oriented.
    pub volume_m3: Option<f64>,
    /// Whether it is closed.
    pub closed: bool,
    /// Triangles of its fuzz, a mesh of its own that the other figures leave out.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub fuzz_triangles: usize,
    /// How its splinters lean, if they do.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lean: Option<LeanReport>,
}

/// Returns whether a piece has no fuzz, which its report then leaves out.
fn is_zero(triangles: &usize) -> bool {
    *triangles == 0
}

/// The report on a break.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BreakReport {
    /// The scan from which the mesh was reconstructed, if the input was one.
    pub scan: Option<ScannedReport>,
    /// The input.
    pub input: InputReport,
    /// Where it broke.
    pub place: PlaceReport,
    /// The broken face.
    pub face: FaceReport,
    /// The species, if one was named.
    pub species: Option<SpeciesReport>,
    /// The pieces.
    pub pieces: Vec<PieceReport>,
    /// How the upper piece hangs, if it does.
    pub hang: Option<HangReport>,
    /// Volume lost to drying cracks, m³.
    pub crack_volume_m3: Option<f64>,
    /// Breaks of the request after the first one.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub further_breaks: Vec<FurtherBreak>,
    /// What was assumed, limited or not possible; one sentence each.
    pub notes: Vec<String>,
}

/// A break of a stem that is broken at several places.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FurtherBreak {
    /// Where it is.
    pub place: PlaceReport,
    /// Its face.
    pub face: FaceReport,
    /// The species, if one was named.
    pub species: Option<SpeciesReport>,
    /// How the part beyond it hangs, if it does.
    pub hang: Option<HangReport>,
    /// Volume lost to drying cracks, m³.
    pub crack_volume_m3: Option<f64>,
}

/// How all volumes of a report are written, so that they can be compared: in the unit that suits the largest.
fn volume_format(volumes: impl Iterator<Item = f64>) -> impl Fn(f64) -> String {
    let in_cubic_metres = volumes.fold(0.0, |a: f64, v| a.max(v.abs())) >= 1e-3;
    move |v| {
        if in_cubic_metres {
            format!("{v:.6} m³")
        } else {
            format!("{:.4} cm³", v * 1e6)
        }
    }
}

/// Formats a length.
fn length(l: f64) -> String {
    match l.abs() {
        a if a >= 1.0 => format!("{l:.3} m"),
        a if a >= 0.01 => format!("{:.2} cm", l * 100.0),
        _ => format!("{:.2} mm", l * 1000.0),
    }
}

impl fmt::Display for BreakReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (i, p, face) = (&self.input, &self.place, &self.face);
        let pieces = self.pieces.iter().filter_map(|piece| piece.volume_m3);
        let volume = volume_format(pieces.chain(i.volume_m3));
        if let Some(scan) = &self.scan {
            write!(f, "{scan}")?;
        }
        let kind = if i.closed { "closed" } else { "open" };
        let inside = i
            .volume_m3
            .map(|v| format!(", {}", volume(v)))
            .unwrap_or_default();
        writeln!(
            f,
            "input    {} triangles in {} meshes, {:.4} m², {kind}{inside}",
            i.triangles, i.meshes, i.area_m2
        )?;
        write_break(f, (p, face), &self.species, &self.hang)?;
        for more in &self.further_breaks {
            write_break(f, (&more.place, &more.face), &more.species, &more.hang)?;
        }
        for piece in &self.pieces {
            let inside = match piece.volume_m3 {
                Some(v) => format!("closed, {}", volume(v)),
                None if piece.closed => "closed".to_owned(),
                None => "open".to_owned(),
            };
            let fuzz = match piece.fuzz_triangles {
                0 => String::new(),
                triangles => format!(", and {triangles} of fuzz"),
            };
            writeln!(
                f,
                "piece    {}: {} triangles, {inside}{fuzz}",
                one_line(&piece.name),
                piece.triangles
            )?;
            if let Some(lean) = &piece.lean {
                let straight = lean.straight_volume_m3.map(&volume);
                let before = straight.map_or(String::new(), |v| format!("; {v} before"));
                writeln!(f, "lean     {}: {lean}{before}", one_line(&piece.name))?;
            }
        }
        let further = self.further_breaks.iter().map(|more| more.crack_volume_m3);
        for v in [self.crack_volume_m3].into_iter().chain(further).flatten() {
            writeln!(f, "cracks   {} opened", volume(v))?;
        }
        for note in i.repairs.iter().chain(&self.notes) {
            writeln!(f, "note     {}", one_line(note))?;
        }
        Ok(())
    }
}

/// Writes where a break is, its face, its species and how it hangs.
fn write_break(
    f: &mut fmt::Formatter<'_>,
    (p, face): (&PlaceReport, &FaceReport),
    species: &Option<SpeciesReport>,
    hang: &Option<HangReport>,
) -> fmt::Result {
    writeln!(
        f,
        "place    {} of {} along {} \"{}\", radius {}",
        length(p.length_m),
        length(p.stem_length_m),
        if p.kind == "round" { "stem" } else { &p.kind },
        one_line(&p.mesh),
        length(p.radius_m)
    )?;
    writeln!(
        f,
        "face     {}, {} bundles, {} thorns, from {} to {}, seed {}",
        face.surface,
        face.bundles,
        face.thorns,
        length(face.range_m[0]),
        length(face.range_m[1]),
        face.seed
    )?;
    if let Some(s) = species {
        writeln!(
            f,
            "species  {} ({}) at {} % moisture: height {} by {} ({}), relief × {:.2}; nine tenths of the corners from {} to {}",
            s.name,
            s.scientific_name,
            s.moisture_percent,
            length(s.height_m),
            s.rule,
            s.basis,
            s.relief,
            length(face.percentiles_m[0]),
            length(face.percentiles_m[1])
        )?;
    }
    if let Some(hang) = hang {
        writeln!(f, "hang     {hang}")?;
    }
    Ok(())
}
