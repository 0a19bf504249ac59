//! Reports as text.

use super::report::{MAX_PLACES, Report, SelfIntersections};
use std::fmt::{Display, Formatter, Result};

impl Display for Report {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        writeln!(
            f,
            "{}, {}, {}, {}",
            count(self.triangles, ["triangle", "triangles"]),
            count(self.points, ["point", "points"]),
            count(self.vertices, ["vertex", "vertices"]),
            count(self.components, ["component", "components"]),
        )?;
        write!(f, "area {} m²", number(self.area_m2))?;
        match self.volume_m3 {
            Some(v) => writeln!(
                f,
                ", volume {} m³{}",
                number(v),
                if v < 0.0 { " (inside out)" } else { "" }
            )?,
            None => writeln!(f, ", no volume (the surface is not closed and oriented)")?,
        }
        writeln!(
            f,
            "{}, {}",
            if self.closed { "closed" } else { "not closed" },
            if self.oriented {
                "oriented"
            } else {
                "not oriented"
            }
        )?;
        for defect in self.defects() {
            defect.write(f)?;
        }
        match &self.self_intersections {
            None => writeln!(f, "self-intersections not looked for"),
            Some(s) if s.crossing + s.touching == 0 && !s.incomplete => {
                writeln!(f, "no self-intersections")
            }
            Some(s) => {
                for defect in s.defects() {
                    defect.write(f)?;
                }
                if s.incomplete {
                    writeln!(
                        f,
                        "the search for crossing triangles was ended early: too many lie within each other"
                    )?;
                }
                Ok(())
            }
        }
    }
}

/// A kind of defect, as reports print it.
struct Defect<'a> {
    found: usize,
    /// Its name for one and for several.
    names: [&'a str; 2],
    /// Where the first few are; empty for kinds without a place.
    places: &'a [[f64; 3]],
}

impl Report {
    /// The kinds of defects other than self-intersections, in the order in which they are printed.
    fn defects(&self) -> [Defect<'_>; 9] {
        let defect = |found, names, places| Defect {
            found,
            names,
            places,
        };
        [
            defect(
                self.boundary_edges,
                ["boundary edge", "boundary edges"],
                &[][..],
            ),
            defect(
                self.boundary_loops,
                ["boundary loop", "boundary loops"],
                &self.boundary_places,
            ),
            defect(
                self.misoriented_edges,
                [
                    "edge used twice in one direction",
                    "edges used twice in one direction",
                ],
                &self.misoriented_places,
            ),
            defect(
                self.non_manifold_edges,
                [
                    "edge of more than two triangles",
                    "edges of more than two triangles",
                ],
                &self.non_manifold_edge_places,
            ),
            defect(
                self.non_manifold_vertices,
                ["vertex of several fans", "vertices of several fans"],
                &self.non_manifold_vertex_places,
            ),
            defect(
                self.degenerate_triangles,
                ["degenerate triangle", "degenerate triangles"],
                &self.degenerate_places,
            ),
            defect(
                self.duplicate_triangles,
                ["duplicate triangle", "duplicate triangles"],
                &[],
            ),
            defect(
                self.non_finite_positions,
                [
                    "vertex with a position that is not finite",
                    "vertices with a position that is not finite",
                ],
                &[],
            ),
            defect(
                self.indices_out_of_range,
                [
                    "triangle with an index out of range",
                    "triangles with an index out of range",
                ],
                &[],
            ),
        ]
    }
}

impl SelfIntersections {
    fn defects(&self) -> [Defect<'_>; 2] {
        [
            Defect {
                found: self.crossing,
                names: ["crossing pair of triangles", "crossing pairs of triangles"],
                places: &self.crossing_places,
            },
            Defect {
                found: self.touching,
                names: ["touching pair of triangles", "touching pairs of triangles"],
                places: &self.touching_places,
            },
        ]
    }
}

impl Defect<'_> {
    /// Writes one line, or nothing where there is no such defect.
    fn write(&self, f: &mut Formatter<'_>) -> Result {
        if self.found == 0 {
            return Ok(());
        }
        write!(f, "{}", count(self.found, self.names))?;
        for (i, p) in self.places.iter().enumerate() {
            let [x, y, z] = p.map(number);
            write!(f, "{} ({x}, {y}, {z})", if i == 0 { " at" } else { "," })?;
        }
        let more = !self.places.is_empty() && self.found > MAX_PLACES;
        writeln!(
            f,
            "{}{}",
            if self.places.is_empty() { "" } else { " m" },
            if more { " …" } else { "" }
        )
    }
}

/// A number of things with their name for one or for several.
fn count(n: usize, [one, several]: [&str; 2]) -> String {
    format!("{n} {}", if n == 1 { one } else { several })
}

/// A number with at most six significant digits.
fn number(x: f64) -> String {
    if x != 0.0 && x.is_finite() && !(1e-3..1e6).contains(&x.abs()) {
        let text = format!("{x:.5e}");
        let (digits, exponent) = text.split_once('e').unwrap_or((&text, "0"));
        return format!(
            "{}e{exponent}",
            digits.trim_end_matches('0').trim_end_matches('.')
        );
    }
    let decimals = if x == 0.0 {
        0
    } else {
        (5 - x.abs().log10().floor() as i32).clamp(0, 9)
    };
    let text = format!("{x:.*}", decimals as usize);
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}
