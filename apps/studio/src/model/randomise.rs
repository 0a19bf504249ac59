//! Random values for all parameters of the face that are not locked.

use greenstick::schema::{Kind, Parameters, Scale, Value};
use greenstick::wood::noise::unit;
use std::collections::BTreeSet;

/// Part of a parameter's range on either side of its default within which it is drawn: the far ends of most ranges are there for
/// special cases, and a face at all ends at once looks like no wood.
const REACH: f64 = 0.15;
/// Keys that decide cost or identity, not shape.
const LEFT_ALONE: [&str; 3] = ["break.rings", "break.sectors", "break.diameter"];

/// Draws every number of the broken face that is not locked, around its present value.
pub fn randomise<P: Parameters + Clone>(parameters: &mut P, locked: &BTreeSet<String>, seed: u64) {
    let drawn = |p: &greenstick::schema::ParameterInfo| {
        p.key.starts_with("break.")
            && !p.key.ends_with("_proportion")
            && !LEFT_ALONE.contains(&p.key.as_str())
            && !locked.contains(&p.key)
    };
    let list = parameters.list();
    for (i, p) in list.iter().enumerate().filter(|(_, p)| drawn(p)) {
        let share = unit(seed, i as i64, 0, 0);
        let value = match p.kind {
            Kind::Number { min, max, .. } => {
                let Value::Number(now) = p.value else {
                    continue;
                };
                if max - min > 1e6 {
                    continue;
                }
                Value::Number(draw(share, now, (min, max), p.scale))
            }
            Kind::Integer { min, max, step, .. } => {
                let Value::Integer(now) = p.value else {
                    continue;
                };
                if p.key.ends_with("seed") {
                    Value::Integer((share * 1e6) as i128)
                } else {
                    let x = draw(share, now as f64, (min as f64, max as f64), p.scale);
                    Value::Integer((x / step as f64).round() as i128 * step)
                }
            }
            _ => continue,
        };
        let before = parameters.clone();
        if parameters.set(&p.key, &value).is_err() || parameters.check().is_err() {
            *parameters = before;
        }
    }
}

fn draw(share: f64, now: f64, (min, max): (f64, f64), scale: Scale) -> f64 {
    let spread = match scale {
        // A value at rest near the low end of a wide range varies by its own size.
        Scale::Linear => (REACH * (max - min)).min(0.75 * now.abs() + 0.02 * (max - min)),
        Scale::Logarithmic => 0.75 * now.abs(),
    };
    (now + (2.0 * share - 1.0) * spread).clamp(min, max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use greenstick::RequestFile;
    use greenstick::fracture::parameters::BreakParameters;

    #[test]
    fn what_is_locked_stays_and_the_rest_is_valid() {
        let locked = BTreeSet::from(["break.inclination".to_owned(), "break.seed".to_owned()]);
        for seed in 0..20 {
            let mut file = RequestFile::default();
            randomise(&mut file, &locked, seed);
            file.check().unwrap();
            let face = &file.common.recipe.face;
            let usual = BreakParameters::default();
            assert_eq!((face.inclination, face.seed), (0.0, 1));
            assert_eq!((face.rings, face.sectors), (usual.rings, usual.sectors));
            assert_ne!(face.slab_height, usual.slab_height);
        }
    }
}
