//! A simulation that is stopped, or killed, and resumed ends in the same bytes; and what is refused.

use greenstick::fibre::scene::Scene;
use greenstick::geometry::Context;
use greenstick::simulate::{SimulateError, SimulateRequest, frames, simulate};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

const SCENE: &str = "duration = 0.012\nframes_per_second = 250.0\nrows_per_second = 1000.0\n\
[stem]\nkind = \"cylinder\"\nlength = \"6 cm\"\ndiameter = \"6 mm\"\n\
[wood]\nstiffness = 0.002\n[rods]\nnumber = 12\nedge = [\"4 mm\", \"5 mm\"]\ntwist = \"off\"\nweibull = 5.0\n\
[[clamp]]\nto = 0.2\n\
[[body]]\nat = 0.9\ntouch = [0, 0, 1]\nvelocity = [0, 0, -1.5]\n\
[[body]]\nshape = \"sphere\"\ndiameter = \"1 cm\"\nat = 0.5\ntouch = [0, 0, -1]\ngap = \"1 mm\"\nmotion = \"free\"\nvelocity = [0, 0, 1]\n";

fn request(folder: &Path, resume: bool) -> SimulateRequest {
    SimulateRequest {
        scene: Scene::read(SCENE).unwrap(),
        beside: PathBuf::new(),
        folder: folder.to_owned(),
        resume,
    }
}

fn folder(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("greenstick-{}-{name}", std::process::id()));
    let _ = fs::remove_dir_all(&folder);
    folder
}

const FILES: [&str; 4] = ["energy.csv", "events.csv", "frames.gsf", "checkpoint.bin"];

fn bytes(folder: &Path) -> Vec<Vec<u8>> {
    FILES.map(|f| fs::read(folder.join(f)).unwrap()).to_vec()
}

#[test]
fn a_run_that_was_stopped_or_killed_ends_in_the_same_bytes() {
    let whole = folder("whole");
    let report = simulate(None, &request(&whole, false), &Context::quiet()).unwrap();
    assert!(
        report.broke[2] > 0,
        "the scene must break something: {report}"
    );
    assert_eq!((report.frames, frames(&whole).unwrap().len()), (4, 4));
    let parts = folder("parts");
    for stop in [2, 7, 10] {
        let cancel = AtomicBool::new(false);
        let progress = |stage: &str, done: f64| {
            if stage == "simulate" && done * 12.0 > f64::from(stop) - 0.5 {
                cancel.store(true, Ordering::Relaxed);
            }
        };
        let context = Context {
            cancel: &cancel,
            progress: &progress,
        };
        let stopped = simulate(None, &request(&parts, stop > 2), &context);
        assert!(
            matches!(stopped, Err(SimulateError::Cancelled(_))),
            "{stopped:?}"
        );
        // A kill leaves rows and half a frame behind the checkpoint.
        for name in &FILES[..3] {
            let mut all = fs::read(parts.join(name)).unwrap();
            all.extend(b"0.5,1,2,3");
            fs::write(parts.join(name), all).unwrap();
        }
        frames(&parts).unwrap();
    }
    simulate(None, &request(&parts, true), &Context::quiet()).unwrap();
    assert!(bytes(&parts) == bytes(&whole));
    // Resuming what is done changes nothing.
    simulate(None, &request(&parts, true), &Context::quiet()).unwrap();
    assert!(bytes(&parts) == bytes(&whole));

    let taken = simulate(None, &request(&parts, false), &Context::quiet());
    assert!(
        matches!(taken, Err(SimulateError::Taken { .. })),
        "{taken:?}"
    );
    let mut other = request(&parts, true);
    other.scene.seed = 2;
    let foreign = simulate(None, &other, &Context::quiet());
    assert!(
        matches!(foreign, Err(SimulateError::OtherRun { .. })),
        "{foreign:?}"
    );
    let point = parts.join("checkpoint.bin");
    let good = fs::read(&point).unwrap();
    for (at, words) in [
        (8, "of version 255"),
        (200, "checksum is wrong"),
        (0, "no checkpoint"),
    ] {
        let mut bad = good.clone();
        bad[at] = 255;
        fs::write(&point, bad).unwrap();
        let told = simulate(None, &request(&parts, true), &Context::quiet())
            .unwrap_err()
            .to_string();
        assert!(told.contains(words), "{told}");
    }
    fs::write(&point, &good).unwrap();
    assert!(
        bytes(&parts) == bytes(&whole),
        "a refused checkpoint must cost nothing"
    );
    fs::write(parts.join("energy.csv"), "short").unwrap();
    let told = simulate(None, &request(&parts, true), &Context::quiet())
        .unwrap_err()
        .to_string();
    assert!(
        told.contains("has 5 bytes, but the checkpoint was written when it had"),
        "{told}"
    );
    let _ = fs::remove_dir_all(&whole);
    let _ = fs::remove_dir_all(&parts);
}

#[test]
fn a_step_that_is_not_stable_is_refused_with_the_limit() {
    let place = folder("unstable");
    let mut wrong = request(&place, false);
    wrong.scene.step = Some(0.01);
    let told = simulate(None, &wrong, &Context::quiet())
        .unwrap_err()
        .to_string();
    assert!(told.contains("is not stable: the limit is"), "{told}");
    let _ = fs::remove_dir_all(&place);
}
