//! Sweeps: every combination once, samples between their bounds and evenly spread, values that follow from the number alone.

use greenstick::schema::Value;
use greenstick_sweep::{Sweep, Variant};
use std::collections::BTreeSet;

fn sweep(text: &str) -> Sweep {
    Sweep::read(text, "".as_ref()).unwrap()
}

fn number(value: &Value) -> f64 {
    match value {
        Value::Number(x) => *x,
        Value::Integer(n) => *n as f64,
        other => panic!("{other}"),
    }
}

#[test]
fn every_combination_is_there_once() {
    let sweep = sweep(
        "[vary]\nseed = { from = 3, to = 11, by = 4 }\nspecies = ['white oak', 'Fichte']\nmoisture = { from = 8, to = 32, steps = 4 }",
    );
    assert_eq!(sweep.count(), 3 * 2 * 4);
    let all: BTreeSet<String> = (0..sweep.count())
        .map(|n| format!("{:?}", sweep.values(n)))
        .collect();
    assert_eq!(all.len() as u64, sweep.count());
    let column = |k: usize| -> BTreeSet<String> {
        (0..sweep.count())
            .map(|n| sweep.values(n)[k].to_string())
            .collect()
    };
    let keys: Vec<&str> = sweep.axes.iter().map(|a| a.info.key.as_str()).collect();
    assert_eq!(keys, ["moisture", "break.seed", "species"]);
    assert_eq!(column(0), ["8", "16", "24", "32"].map(str::to_owned).into());
    assert_eq!(column(1), ["3", "7", "11"].map(str::to_owned).into());
    let Variant::Break(request) = sweep.variant(sweep.count() - 1).unwrap().unwrap() else {
        panic!("another kind");
    };
    assert_eq!(request.common.recipe.moisture, Some(32.0));
    assert_eq!(request.common.recipe.face.seed, 11);
}

#[test]
fn samples_lie_between_their_bounds_and_sobol_points_fill_every_cell() {
    let text = |sampling: &str| {
        format!(
            "[sweep]\nsamples = 256\nsampling = '{sampling}'\nseed = 5\n[vary]\nmoisture = {{ between = [8, 24] }}\n\
             inclination = {{ between = [0, 16] }}\nslab_count = {{ between = [1, 4] }}\nspecies = ['white oak', 'Fichte']"
        )
    };
    let cells = |sweep: &Sweep| -> BTreeSet<[i64; 2]> {
        // The order is inclination, moisture, slab_count, species.
        let cell = |n: u64| {
            let values = sweep.values(n);
            let (inclination, moisture) = (number(&values[0]), number(&values[1]));
            assert!((0.0..16.0).contains(&inclination) && (8.0..24.0).contains(&moisture));
            assert!((1.0..=4.0).contains(&number(&values[2])));
            [inclination.floor() as i64, (moisture - 8.0).floor() as i64]
        };
        (0..256).map(cell).collect()
    };
    let even = sweep(&text("sobol"));
    assert_eq!(even.count(), 512);
    // 256 points in 16 × 16 cells: one in each.
    assert_eq!(cells(&even).len(), 256);
    let random = sweep(&text("random"));
    let filled = cells(&random).len();
    // Of as many random points, about 1 − 1/e of the cells have some.
    assert!((140..185).contains(&filled), "{filled}");
    let counts = |sweep: &Sweep, slabs: i64| {
        (0..256)
            .filter(|n| number(&sweep.values(*n)[2]) == slabs as f64)
            .count()
    };
    assert_eq!([1, 2, 3, 4].map(|slabs| counts(&even, slabs)), [64; 4]);
    // The second species has the same points of Sobol', and others at random.
    assert_eq!(even.values(3)[..3], even.values(3 + 256)[..3]);
    assert_ne!(random.values(3)[..3], random.values(3 + 256)[..3]);
    let other = sweep(&text("sobol").replace("seed = 5", "seed = 6"));
    assert_ne!(even.values(3), other.values(3));
    assert_ne!(even.hash(), other.hash());
}

#[test]
fn ratios_count_where_a_key_says_so() {
    let sweep =
        sweep("[vary]\nhigh.height = { from = 0.5, to = 8, steps = 5, scale = 'logarithmic' }");
    let values: Vec<f64> = (0..5).map(|n| number(&sweep.values(n)[0])).collect();
    for (value, expected) in values.iter().zip([0.5, 1.0, 2.0, 4.0, 8.0]) {
        assert!((value - expected).abs() < 1e-12, "{values:?}");
    }
}

#[test]
fn as_many_are_shown_as_are_wanted() {
    for (variants, sheet, expected) in [(1000, 24, 24), (7, 24, 7), (10, 3, 3), (5, 0, 0)] {
        let sweep = sweep(&format!(
            "[sweep]\nsheet = {sheet}\n[vary]\nseed = {{ from = 1, to = {variants} }}"
        ));
        let shown: Vec<u64> = (0..variants).filter(|n| sweep.is_shown(*n)).collect();
        assert_eq!(shown.len(), expected, "{shown:?}");
        let parts = (0..expected as u64).map(|p| (p * variants).div_ceil(expected as u64));
        assert_eq!(shown, parts.collect::<Vec<_>>());
    }
}

#[test]
fn more_steps_than_there_is_memory_for_are_refused_at_once() {
    let read = |steps: &str| {
        let text = format!("[vary]\ninclination = {{ from = 0, to = 30, steps = {steps} }}\n");
        Sweep::read(&text, "".as_ref())
    };
    assert_eq!(read("1048576").unwrap().count(), 1 << 20);
    let error = read("4294967296").unwrap_err().to_string();
    let expected = "steps is 4294967296; expected a whole number from 2 to 1048576";
    assert!(error.contains(expected), "{error}");
}
