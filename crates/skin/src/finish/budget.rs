//! A budget of triangles: the finest face with which the pieces of a break have no more than they may.
//!
//! Rings and sectors, and with them the levels of spiral grain, become fewer in proportion. How many triangles that leaves
//! depends on the skin, on what stands out and on what had to be repaired, so it is counted, not computed.

use super::piece::Pieces;
use crate::error::BreakError;
use crate::stages::BreakStages;
use greenstick_fracture::parameters::BreakParameters;

/// The most breaks that are tried between the finest face and the coarsest.
const ATTEMPTS: usize = 6;
/// Part of a budget with which a face is fine enough, so that no further is tried.
const WELL_USED: f64 = 0.9;
/// Part of a budget that is aimed at.
const AIM: f64 = 0.96;
/// Factor on a resolution by which a next coarser one is looked for.
const ONE_STEP: f64 = 0.97;
/// The fewest rings and sectors that a face can have.
const COARSEST: (u32, u32) = (3, 10);

/// Returns how many triangles the pieces of a break have beyond those of the shell that was broken.
pub fn added_triangles(stages: &BreakStages, pieces: &Pieces) -> usize {
    let all: usize = pieces.reports.iter().map(|piece| piece.triangles).sum();
    all.saturating_sub(stages.stem.sound.shell_triangles)
}

/// Makes a break with `face`, or with the finest face like it that adds no more triangles than `most`. `make` makes it, `added`
/// says how many triangles it adds.
///
/// # Errors
/// Those of `make`, and [`BreakError::TooFewTriangles`] where even the coarsest face adds more.
pub fn within_budget<T, E: From<BreakError>>(
    most: Option<u32>,
    face: &BreakParameters,
    mut make: impl FnMut(&BreakParameters) -> Result<T, E>,
    added: impl Fn(&T) -> usize,
) -> Result<T, E> {
    let finest = make(face)?;
    let Some(most) = most.map(|most| most as usize) else {
        return Ok(finest);
    };
    if added(&finest) <= most {
        return Ok(finest);
    }
    let next = |part: f64, count: usize| part * (AIM * most as f64 / count.max(1) as f64).sqrt();
    // The triangles of a face grow as the square of its resolution. The best so far, and what is too fine.
    let mut best: Option<(f64, T)> = None;
    let (mut too_fine, mut part) = (1.0, next(1.0, added(&finest)));
    drop(finest);
    let mut tried = resolution(face, 1.0);
    for _ in 0..ATTEMPTS {
        while best.is_none() && resolution(face, part) == tried && tried != COARSEST {
            // Slightly too fine: the guess is not a step of the resolution away.
            part *= ONE_STEP;
        }
        if resolution(face, part) == tried {
            break;
        }
        tried = resolution(face, part);
        let made = make(&with_resolution(face, tried))?;
        let count = added(&made);
        let fits = count <= most;
        let guess = next(part, count);
        if fits {
            best = Some((part, made));
            if count as f64 >= WELL_USED * most as f64 {
                break;
            }
        } else {
            too_fine = part;
        }
        let known = best.as_ref().map_or(0.0, |best| best.0);
        part = if known < guess && guess < too_fine {
            guess
        } else {
            (known + too_fine) / 2.0
        };
    }
    if let Some((_, made)) = best {
        return Ok(made);
    }
    let made = make(&with_resolution(face, COARSEST))?;
    let least = added(&made);
    if least > most {
        return Err(BreakError::TooFewTriangles { most, least }.into());
    }
    Ok(made)
}

/// Rings and sectors of a face at a part of its resolution.
fn resolution(face: &BreakParameters, part: f64) -> (u32, u32) {
    let of = |count: u32, least: u32| ((f64::from(count) * part).round() as u32).max(least);
    (of(face.rings, COARSEST.0), of(face.sectors, COARSEST.1))
}

fn with_resolution(face: &BreakParameters, (rings, sectors): (u32, u32)) -> BreakParameters {
    BreakParameters {
        rings,
        sectors,
        ..face.clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A break that adds `fixed` triangles and `each` for a bundle.
    fn fitted(most: u32, fixed: usize, each: usize) -> Result<(u32, usize, usize), BreakError> {
        let count = |p: &BreakParameters| fixed + each * (p.rings * p.sectors) as usize;
        let mut made = 0;
        let face = BreakParameters::default();
        let make = |p: &BreakParameters| {
            made += 1;
            Ok::<_, BreakError>((p.rings, count(p)))
        };
        let (rings, added) = within_budget(Some(most), &face, make, |m| m.1)?;
        Ok((rings, added, made))
    }

    #[test]
    fn budgets_are_kept_and_used() {
        assert_eq!(fitted(1_000_000, 100, 10).unwrap(), (48, 71_140, 1));
        for most in [20_000, 5_000, 2_000, 1_000] {
            for fixed in [0, 400] {
                let (_, added, made) = fitted(most, fixed, 10).unwrap();
                assert!(added <= most as usize, "{most}: {added}");
                assert!(added as f64 > 0.7 * f64::from(most), "{most}: {added}");
                assert!(made <= 2 + ATTEMPTS);
            }
        }
    }

    /// Of these the guess after a face that is slightly too fine is that face again.
    #[test]
    fn a_face_that_is_slightly_too_fine_is_followed_by_one_a_step_coarser() {
        for (most, fixed) in [
            (690, 0),
            (1_180, 400),
            (2_810, 400),
            (5_570, 400),
            (6_410, 400),
        ] {
            let (_, added, made) = fitted(most, fixed, 10).unwrap();
            assert!(added <= most as usize, "{most}: {added}");
            assert!(added as f64 > 0.6 * f64::from(most), "{most}: {added}");
            assert!(made <= 2 + ATTEMPTS);
        }
    }

    #[test]
    fn a_budget_that_cannot_be_kept_says_the_least_that_can() {
        let error = fitted(500, 400, 10).unwrap_err();
        assert_eq!(
            error.to_string(),
            "500 triangles are too few for this break: even the coarsest face adds 700"
        );
        assert_eq!(fitted(700, 400, 10).unwrap().1, 700);
    }
}
