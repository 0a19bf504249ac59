//! How long breaks go on once they are cancelled.
//!
//! `cargo bench -p greenstick --bench cancelling` breaks each case to its end, then again and again, cancelled at other moments.

use greenstick::fracture::recipe::Recipe;
use greenstick::geometry::{CancelToken, Context, Scene};
use greenstick::wood::primitive;
use greenstick::{Break, BreakRequest, BreakSession, built_in_branch};
use std::time::{Duration, Instant};

/// Moments of each break at which it is cancelled.
const MOMENTS: u32 = 20;

/// A name, presets, settings and how far the pieces are moved apart, m.
const CASES: [(&str, &[&str], &[&str], f64); 6] = [
    ("default", &[], &[], 0.03),
    ("splintering", &["splintering-tension"], &[], 0.03),
    ("twist", &["twist"], &[], 0.03),
    ("200 x 200", &[], &["rings=200", "sectors=200"], 0.0),
    (
        "1,500 cracks",
        &["fig21"],
        &[
            "crack_groups.large.count=500",
            "crack_groups.medium.count=500",
            "crack_groups.small.count=500",
        ],
        0.0,
    ),
    ("frayed", &["fig17"], &["fray=1"], 0.03),
];

fn request(presets: &[&str], settings: &[&str], separation: f64) -> BreakRequest {
    let mut one = Break {
        separation,
        recipe: Recipe::resolve(presets, None, &[]).expect("presets"),
        ..Break::default()
    };
    for setting in settings {
        greenstick::fracture::recipe::apply_setting(&mut one, setting).expect("a parameter");
    }
    BreakRequest::single(one)
}

/// Breaks a scene, cancelled after a time, and returns how long it went on then; `None` where it had ended.
fn goes_on(scene: &Scene, request: &BreakRequest, after: Duration) -> Option<Duration> {
    let token = CancelToken::default();
    let (context, mut session) = (
        Context::silent(token.clone()),
        BreakSession::new(scene.clone()),
    );
    std::thread::scope(|threads| {
        let working = threads.spawn(|| {
            let result = session.broken(request, &context);
            (result.is_err(), Instant::now())
        });
        std::thread::sleep(after);
        let cancelled = Instant::now();
        token.cancel();
        let (stopped, ended) = working.join().expect("no panic");
        stopped.then(|| ended.saturating_duration_since(cancelled))
    })
}

fn print(name: &str, scene: &Scene, request: &BreakRequest) {
    let start = Instant::now();
    let whole = BreakSession::new(scene.clone()).broken(request, &Context::quiet());
    let whole = whole.map(|_| start.elapsed()).expect("breaks");
    let moments = (1..MOMENTS).map(|i| whole * i / MOMENTS);
    let mut times: Vec<(Duration, Duration)> = moments
        .filter_map(|after| Some((goes_on(scene, request, after)?, after)))
        .collect();
    times.sort_unstable();
    let Some((longest, after)) = times.last() else {
        return println!("{name:<28} never cancelled");
    };
    let ms = |time: &Duration| 1e3 * time.as_secs_f64();
    println!(
        "{name:<28} {:>9.0} {:>9.0} {:>9.0} {:>9.0}",
        ms(&whole),
        ms(&times[times.len() / 2].0),
        ms(longest),
        ms(after)
    );
}

fn main() {
    println!(
        "{:<28} {:>9} {:>9} {:>9} {:>9}  ms",
        "", "whole", "median", "longest", "after"
    );
    let branch = built_in_branch();
    for (name, presets, settings, separation) in CASES {
        print(name, &branch, &request(presets, settings, separation));
    }
    let tube = Scene {
        nodes: vec![greenstick::geometry::Node::new(
            "tube",
            glam::DAffine3::IDENTITY,
            primitive::cylinder_of(0.05, 1.0, 1000, 500),
        )],
        ..Scene::default()
    };
    print(
        "a tube of 1,000,000 triangles",
        &tube,
        &BreakRequest::default(),
    );
}
