//! Painting on the broken face: where it breaks, where it splinters, and what stays on which piece. A stroke becomes heights of the
//! request, so that a recipe holds it and the command line makes the same pieces.

use super::project::Project;
use greenstick::fracture::height_grid::HeightGrid;
use greenstick::fracture::heights::{FailureMode, SectionSpan, grid_middle};
use greenstick::fracture::parameters::{BreakParameters, SurfaceStyle};

/// Rings and sectors of a grid that painting begins.
const RINGS: usize = 16;
const SECTORS: usize = 48;
/// The steepest plane of a face that painting begins with, degrees: beyond it heights are those of the stem's whole length.
const STEEPEST: f64 = 80.0;
/// By how much a dab of full strength raises the face, radii.
const RISE: f64 = 0.16;
/// The splintering that dabs lead to, over that of the species, and the height of slabs and slivers, radii, that they lead to where
/// the parameters of the face are those of a short break. The part of the way that a dab of full strength goes.
const SPLINTERY: f64 = 3.0;
const LONG: f64 = 3.0;
const SPLINTER_STEP: f64 = 0.5;
/// Splintering below which wood that is painted blunt is crushed, over that of the species.
const BLUNT: f64 = 0.3;
/// Weight of a dab from which on a cell fails as it says.
const OWN: f64 = 0.25;
/// Parts of a metre and of splintering to which values are rounded, so that files are short.
const METRE: f64 = 1e6;
const PART: f64 = 1e3;

/// What a brush does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BrushKind {
    /// Brings the face to the stroke.
    Break,
    /// Makes splinters longer; reversed, the face blunt.
    Splinter,
    /// Lets wood stay on the piece below; reversed, on the piece above.
    Stay,
}

impl BrushKind {
    /// All brushes.
    pub const ALL: [BrushKind; 3] = [BrushKind::Break, BrushKind::Splinter, BrushKind::Stay];

    /// Its name, and what it does.
    pub fn label(self) -> (&'static str, &'static str) {
        match self {
            BrushKind::Break => (
                "Break",
                "The wood breaks where the stroke goes: on the bark at the pointer's height, on the face at the height where the \
                 stroke began. Shift evens out.",
            ),
            BrushKind::Splinter => (
                "Splinter",
                "Splinters grow longer under the stroke. With Ctrl the wood is crushed and blunt.",
            ),
            BrushKind::Stay => (
                "Stay",
                "Wood stays on the piece below: the face rises under the stroke. With Ctrl wood stays on the piece above.",
            ),
        }
    }
}

/// A brush.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Brush {
    /// What it does.
    pub kind: BrushKind,
    /// How far it reaches, radii of the stem.
    pub size: f64,
    /// How much a dab does, 0 to 1.
    pub strength: f64,
}

/// A dab of a brush.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dab {
    /// Ring coordinate of its middle.
    pub rho: f64,
    /// Angle of its middle about the pith, rad.
    pub angle: f64,
    /// Height that a face is brought to, m over the break's.
    pub height: f64,
    /// Whether it does the opposite.
    pub reversed: bool,
    /// Whether it evens out instead.
    pub smooths: bool,
}

/// The stem that is painted on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Site {
    /// Radius of the stem, m.
    pub radius: f64,
    /// The species' factor on the torn relief.
    pub relief: f64,
}

/// What values of a grid count from.
#[derive(Debug, Clone)]
struct Ground {
    radius: f64,
    /// Height of the face under each cell, m, where the grid is added to it.
    levels: Vec<f64>,
    /// Splintering that is that of the species, and that dabs of splinters lead to.
    relief: f64,
    splintery: f64,
}

impl Ground {
    fn new(face: &BreakParameters, grid: &HeightGrid, site: Site) -> Self {
        let torn = (face.slab_height + face.sliver_height).max(1e-3);
        let splintery = (SPLINTERY * site.relief).max(LONG / torn);
        if !grid.added {
            return Ground {
                radius: site.radius,
                levels: vec![0.0; grid.values.len()],
                relief: site.relief,
                splintery,
            };
        }
        let levels = middles(grid).map(|(rho, angle)| level(face, rho, angle) * site.radius);
        Ground {
            radius: site.radius,
            levels: levels.collect(),
            relief: 1.0,
            splintery: splintery / site.relief.max(1e-3),
        }
    }
}

fn across(rho: f64, angle: f64) -> glam::DVec2 {
    glam::DVec2::from_angle(angle) * rho
}

/// The grid that painting begins with: it changes nothing.
pub fn blank_grid() -> HeightGrid {
    HeightGrid {
        sectors: SECTORS as u32,
        values: vec![0.0; RINGS * SECTORS],
        modes: vec![FailureMode::Torn; RINGS * SECTORS],
        splintering: vec![1.0; RINGS * SECTORS],
        added: true,
        ..HeightGrid::default()
    }
}

/// Height of a face, radii, as its inclination and its layers shape it.
fn level(face: &BreakParameters, rho: f64, angle: f64) -> f64 {
    let steep = face.inclination.min(STEEPEST).to_radians().tan();
    let upwards = across(steep, face.inclination_direction.to_radians());
    let layers = [
        (face.high.sector(), face.high.height),
        (face.low.sector(), face.low.height),
    ];
    let here = layers
        .into_iter()
        .filter(|(sector, _)| sector.contains(angle.to_degrees(), rho));
    across(rho, angle).dot(upwards) + here.map(|(_, height)| height).sum::<f64>()
}

fn rounded(x: f64, parts: f64) -> f64 {
    (x * parts).round() / parts
}

/// The middle of each cell of a grid.
pub fn middles(grid: &HeightGrid) -> impl Iterator<Item = (f64, f64)> {
    let sectors = (grid.sectors as usize).max(1);
    let count = grid.values.len();
    let span = SectionSpan {
        rho: grid.between_rings.into(),
        phi: match grid.between_angles[..] {
            [from, to] => Some((from, to)),
            _ => None,
        },
    };
    (0..count).map(move |cell| grid_middle(&span, (count.div_ceil(sectors), sectors), cell))
}

/// Dabs on a grid over a face.
pub fn dab(grid: &mut HeightGrid, brush: &Brush, dab: &Dab, face: &BreakParameters, site: Site) {
    if grid.modes.len() != grid.values.len() {
        let count = grid.values.len();
        grid.modes = vec![FailureMode::Torn; count];
        // Heights alone are the face as it was measured: it has no relief of its own but where that is painted.
        grid.splintering = vec![f64::from(u8::from(grid.added)); count];
    }
    let ground = Ground::new(face, grid, site);
    let middle = across(dab.rho, dab.angle);
    let weights: Vec<f64> = middles(grid)
        .map(|(rho, angle)| {
            let far = across(rho, angle).distance(middle) / brush.size.max(f64::MIN_POSITIVE);
            let near = (1.0 - far * far).max(0.0);
            near * near
        })
        .collect();
    let heights: Vec<f64> = (grid.values.iter().zip(&ground.levels))
        .map(|(value, level)| value + level)
        .collect();
    let before = (heights, grid.splintering.clone());
    for (cell, weight) in weights.into_iter().enumerate() {
        if weight == 0.0 {
            continue;
        }
        let part = weight * brush.strength;
        let (mut height, torn) = (before.0[cell], &mut grid.splintering[cell]);
        if dab.smooths {
            let around = neighbours(cell, grid.sectors as usize, before.0.len());
            let mean = |of: &[f64]| around.iter().map(|i| of[*i]).sum::<f64>() / 4.0;
            height += (mean(&before.0) - height) * part;
            *torn += (mean(&before.1) - *torn) * part;
        } else {
            match brush.kind {
                BrushKind::Break => height += (dab.height - height) * part,
                BrushKind::Stay => {
                    let by = RISE * ground.radius * part;
                    height += if dab.reversed { -by } else { by };
                }
                BrushKind::Splinter if dab.reversed => {
                    *torn -= *torn * SPLINTER_STEP * part;
                    if weight > OWN && *torn < BLUNT * ground.relief {
                        grid.modes[cell] = FailureMode::Crushed;
                    }
                }
                BrushKind::Splinter => {
                    *torn += (ground.splintery - *torn).max(0.0) * SPLINTER_STEP * part;
                    if weight > OWN {
                        grid.modes[cell] = FailureMode::Torn;
                    }
                }
            }
        }
        grid.values[cell] = rounded(height - ground.levels[cell], METRE);
        *torn = rounded(*torn, PART);
    }
}

/// The cells beside a cell: outwards, inwards, and to both sides.
fn neighbours(cell: usize, sectors: usize, count: usize) -> [usize; 4] {
    let (ring, sector) = (cell / sectors, cell % sectors);
    let first = ring * sectors;
    let outer = if cell + sectors < count {
        cell + sectors
    } else {
        cell
    };
    [
        outer,
        cell.checked_sub(sectors).unwrap_or(cell),
        first + (sector + 1) % sectors,
        first + (sector + sectors - 1) % sectors,
    ]
}

impl Project {
    /// The painted heights of a break; none where its face is drawn by its parameters.
    pub fn painted(&self, number: usize) -> Option<&HeightGrid> {
        let one = self.file.breaks.get(number).unwrap_or(&self.file.common);
        Some(&one.heights).filter(|grid| !grid.values.is_empty())
    }

    /// Whether the heights of a break were measured, so that its plane and its layers change nothing.
    pub fn has_own_heights(&self, number: usize) -> bool {
        self.painted(number).is_some_and(|grid| !grid.added)
    }

    /// Whether the face of a break is drawn without splinters, whatever is painted.
    pub fn has_no_splinters(&self, number: usize) -> bool {
        let one = self.file.breaks.get(number).unwrap_or(&self.file.common);
        one.recipe.face.surface == SurfaceStyle::Smooth
    }

    /// Paints on the face of a break, as part of a stroke.
    ///
    /// # Errors
    /// As [`Project::change`].
    pub fn paint(
        &mut self,
        number: usize,
        brush: &Brush,
        dabs: &[Dab],
        site: Site,
    ) -> Result<bool, String> {
        self.change("painting", true, |file| {
            let one = match file.breaks.get_mut(number) {
                Some(one) => one,
                None => &mut file.common,
            };
            if one.heights.values.is_empty() {
                one.heights = blank_grid();
            }
            for d in dabs {
                dab(&mut one.heights, brush, d, &one.recipe.face, site);
            }
            Ok::<(), String>(())
        })
    }

    /// Leaves the face of a break to its parameters again.
    ///
    /// # Errors
    /// As [`Project::change`].
    pub fn clear_paint(&mut self, number: usize) -> Result<bool, String> {
        self.change("painting taken away", false, |file| {
            let one = match file.breaks.get_mut(number) {
                Some(one) => one,
                None => &mut file.common,
            };
            one.heights = HeightGrid::default();
            Ok::<(), String>(())
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::input::Input;
    use greenstick::RequestFile;

    const SITE: Site = Site {
        radius: 0.02,
        relief: 1.2,
    };

    fn brush(kind: BrushKind) -> Brush {
        Brush {
            kind,
            size: 0.4,
            strength: 1.0,
        }
    }

    const AT: Dab = Dab {
        rho: 0.8,
        angle: 6.2,
        height: 0.05,
        reversed: false,
        smooths: false,
    };

    #[test]
    fn a_dab_changes_what_is_near_alone() {
        let face = BreakParameters {
            inclination: 30.0,
            ..BreakParameters::default()
        };
        // A face that is added to, and one that was measured: there heights and splintering are whole, not beside the face's.
        let added = blank_grid();
        let measured = HeightGrid {
            splintering: vec![SITE.relief; added.values.len()],
            added: false,
            ..added.clone()
        };
        for (first, unit) in [(added, 1.0), (measured, SITE.relief)] {
            changes_what_is_near(&face, &first, unit);
        }
    }

    fn changes_what_is_near(face: &BreakParameters, first: &HeightGrid, unit: f64) {
        // The plane of the face, by its slope.
        let plane = |(rho, angle): (f64, f64)| match first.added {
            true => SITE.radius * rho * angle.cos() * 30f64.to_radians().tan(),
            false => 0.0,
        };
        for kind in BrushKind::ALL {
            for reversed in [false, true] {
                let mut grid = first.clone();
                for _ in 0..30 {
                    dab(&mut grid, &brush(kind), &Dab { reversed, ..AT }, face, SITE);
                }
                assert!(grid.source().is_ok());
                let (mut changed, mut nearest) = (0, (f64::INFINITY, 0, 0.0));
                for (cell, (rho, angle)) in middles(&grid).enumerate() {
                    let far = across(rho, angle).distance(across(AT.rho, AT.angle));
                    let same = grid.values[cell] == first.values[cell]
                        && grid.splintering[cell] == first.splintering[cell];
                    assert!(same || far < 0.4, "{kind:?} at {far}");
                    changed += usize::from(!same);
                    if far < nearest.0 {
                        nearest = (far, cell, plane((rho, angle)));
                    }
                }
                assert!(changed > 20, "{kind:?}: {changed}");
                let (height, torn) = (grid.values[nearest.1], grid.splintering[nearest.1]);
                match (kind, reversed) {
                    (BrushKind::Break, _) => {
                        let there = height + nearest.2;
                        assert!((there - AT.height).abs() < 1e-3, "{there}");
                    }
                    (BrushKind::Splinter, false) => assert!(torn > 2.9 * unit, "{torn}"),
                    (BrushKind::Splinter, true) => {
                        assert_eq!(grid.modes[nearest.1], FailureMode::Crushed);
                        assert!(torn < 0.1, "{torn}");
                    }
                    (BrushKind::Stay, false) => assert!(height > first.values[nearest.1] + 0.05),
                    (BrushKind::Stay, true) => assert!(height < first.values[nearest.1] - 0.05),
                }
            }
        }
    }

    #[test]
    fn smoothing_leaves_a_level_face_and_levels_a_hill() {
        let face = BreakParameters::default();
        let flat = blank_grid();
        let smooth = Dab {
            smooths: true,
            ..AT
        };
        let mut grid = flat.clone();
        dab(&mut grid, &brush(BrushKind::Stay), &smooth, &face, SITE);
        assert_eq!(grid, flat);
        dab(&mut grid, &brush(BrushKind::Stay), &AT, &face, SITE);
        let rough = |grid: &HeightGrid| -> f64 {
            let sectors = grid.sectors as usize;
            let steps = (0..grid.values.len()).flat_map(|i| {
                let around = neighbours(i, sectors, grid.values.len());
                around.map(|n| (grid.values[n] - grid.values[i]).powi(2))
            });
            steps.sum()
        };
        let before = rough(&grid);
        for _ in 0..20 {
            dab(&mut grid, &brush(BrushKind::Stay), &smooth, &face, SITE);
        }
        assert!(rough(&grid) < 0.7 * before, "{} {before}", rough(&grid));
    }

    #[test]
    fn one_of_several_breaks_is_painted_alone() {
        let mut project = Project::new(Input::built_in(), RequestFile::default());
        let place = greenstick::wood::stem::StemLocation::Fraction(0.7);
        project.add_break(place).unwrap();
        let splinter = brush(BrushKind::Splinter);
        assert_eq!(project.paint(1, &splinter, &[AT], SITE), Ok(true));
        assert!(project.painted(0).is_none() && project.painted(1).is_some());
        let breaks = project.file.request().breaks;
        assert!(breaks[0].heights.values.is_empty() && !breaks[1].heights.values.is_empty());
        project.clear_paint(1).unwrap();
        assert!(project.painted(1).is_none());
    }

    #[test]
    fn strokes_are_one_step_and_stand_in_the_recipe() {
        let mut project = Project::new(Input::built_in(), RequestFile::default());
        let stay = brush(BrushKind::Stay);
        for _ in 0..3 {
            assert_eq!(project.paint(0, &stay, &[AT, AT], SITE), Ok(true));
        }
        project.history.rest();
        assert!(project.painted(0).is_some());
        let text = project.file.to_toml();
        let read = RequestFile::resolve(&[], Some(&text), &[]).unwrap();
        assert_eq!(read, project.file);
        project.clear_paint(0).unwrap();
        assert!(project.painted(0).is_none());
        project.undo();
        assert!(project.painted(0).is_some());
        project.undo();
        assert_eq!(project.file, RequestFile::default());
    }
}
