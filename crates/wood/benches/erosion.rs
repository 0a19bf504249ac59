//! How long all contours of a section take, beside Table 1 of Forests 2023, and 512 sections at once.
//!
//! `cargo bench -p greenstick-wood --bench erosion`. `python3 crates/wood/benches/erosion_opencv.py` runs this and a loop
//! of OpenCV's `erode` over the same sections by turns and prints both.

use greenstick_geometry::{Bitmap, Context};
use greenstick_wood::rings::{KernelSchedule, erosion_passes};
use rayon::prelude::*;
use std::hint::black_box;
use std::time::Instant;

/// Sizes of the paper's Table 1.
const SIZES: [usize; 5] = [32, 64, 128, 256, 512];

/// A round, slightly lobed section whose largest inscribed square is 2 × 159/512 of the size wide.
fn section(size: usize) -> Bitmap {
    let middle = size as f64 / 2.0;
    let half = 159.0 / 512.0 * size as f64;
    let mut map = Bitmap::new(size, size);
    for y in 0..size {
        for x in 0..size {
            let (u, v) = (x as f64 + 0.5 - middle, y as f64 + 0.5 - middle);
            let lobes = 1.37 + 0.03 * (5.0 * v.atan2(u)).cos();
            let square = u.abs().max(v.abs()) < half;
            map.set(x, y, square || u.hypot(v) < lobes * half);
        }
    }
    map
}

fn main() {
    let schedule = KernelSchedule::one_pixel_per_pass();
    let passes = |section: &Bitmap| {
        erosion_passes(section, &schedule, &Context::quiet()).expect("nobody cancels")
    };
    // With --pictures FOLDER the sections are left there as PBM files, for the script.
    let arguments: Vec<String> = std::env::args().collect();
    let folder = arguments
        .iter()
        .position(|a| a == "--pictures")
        .and_then(|i| arguments.get(i + 1));
    println!("size contours median_ms least_ms");
    for size in SIZES {
        let map = section(size);
        if let Some(folder) = folder {
            let mut text = format!("P1\n{size} {size}\n");
            for y in 0..size {
                text.extend((0..size).map(|x| if map.get(x, y) { '1' } else { '0' }));
                text.push('\n');
            }
            std::fs::write(format!("{folder}/{size}.pbm"), text)
                .expect("the folder can be written");
        }
        let contours = passes(&map).into_iter().max().unwrap_or(0);
        let mut times: Vec<f64> = (0..41)
            .map(|_| {
                let start = Instant::now();
                black_box(passes(black_box(&map)));
                start.elapsed().as_secs_f64() * 1e3
            })
            .collect();
        times.sort_by(f64::total_cmp);
        println!("{size} {contours} {:.4} {:.4}", times[20], times[0]);
    }
    let many = vec![section(512); 512];
    let start = Instant::now();
    black_box(many.par_iter().map(passes).collect::<Vec<_>>());
    println!("512x512 - {:.1} -", start.elapsed().as_secs_f64() * 1e3);
}
