use super::*;
use crate::noise;
use crate::rings::{ErodedPasses, Pass, PixelCircle, RingPart, erode_from_both_sides};
use glam::DVec2;

/// The passes, which nobody cancels.
fn passes(map: &Bitmap, schedule: &KernelSchedule) -> Vec<u16> {
    erosion_passes(map, schedule, &Context::quiet()).unwrap()
}

/// The definition, pixel by pixel.
fn plain(map: &Bitmap, kernel: &Kernel) -> Bitmap {
    let mut out = Bitmap::new(map.width(), map.height());
    let inside = |x: i64, y: i64| {
        (0..map.width() as i64).contains(&x)
            && (0..map.height() as i64).contains(&y)
            && map.get(x as usize, y as usize)
    };
    for y in 0..map.height() {
        for x in 0..map.width() {
            let mut black = 0;
            for j in 0..i64::from(kernel.height) {
                for i in 0..i64::from(kernel.width) {
                    let u = x as i64 + i64::from(kernel.offset.0) + i
                        - (i64::from(kernel.width) - 1) / 2;
                    let v = y as i64 + i64::from(kernel.offset.1) + j
                        - (i64::from(kernel.height) - 1) / 2;
                    black += u32::from(!inside(u, v));
                }
            }
            out.set(x, y, map.get(x, y) && black < kernel.threshold);
        }
    }
    out
}

/// A number from `low` to `high`.
fn pick(seed: i64, what: i64, low: i64, high: i64) -> i64 {
    low + (noise::hash(7, seed, what, 0) % (high - low + 1) as u64) as i64
}

/// Blobs and dust of a density that changes with the seed.
fn random_map(seed: i64) -> Bitmap {
    let (w, h) = (
        pick(seed, 1, 1, 150) as usize,
        pick(seed, 2, 1, 40) as usize,
    );
    let share = [0.5, 0.9, 0.97, 1.1][pick(seed, 3, 0, 3) as usize];
    let mut map = Bitmap::new(w, h);
    for y in 0..h {
        for x in 0..w {
            map.set(x, y, noise::unit(9, x as i64, y as i64, seed) < share);
        }
    }
    map
}

fn random_kernel(seed: i64) -> Kernel {
    let size = [3, 5, 12, 80][pick(seed, 4, 0, 3) as usize];
    let (width, height) = (
        pick(seed, 5, 1, size) as u32,
        pick(seed, 6, 1, size.min(20)) as u32,
    );
    let most = i64::from(width * height);
    let thresholds = [1, 1, pick(seed, 7, 1, most), pick(seed, 7, 0, most + 1)];
    let reach = [0, 2, 90][pick(seed, 8, 0, 2) as usize];
    Kernel {
        width,
        height,
        offset: (
            pick(seed, 9, -reach, reach) as i32,
            pick(seed, 10, -reach, reach) as i32,
        ),
        threshold: thresholds[pick(seed, 11, 0, 3) as usize] as u32,
    }
}

#[test]
fn words_of_pixels_erode_as_single_pixels_do() {
    for seed in 0..500 {
        let (map, kernel) = (random_map(seed), random_kernel(seed));
        let expected = plain(&map, &kernel);
        assert!(
            erode(&map, &kernel) == expected,
            "seed {seed}: {kernel:?} on {} x {}",
            map.width(),
            map.height()
        );
    }
}

#[test]
fn passes_are_the_erosions_one_after_the_other() {
    for seed in 0..60 {
        let map = random_map(seed);
        let parts = [RingPart::Latewood, RingPart::Earlywood, RingPart::Latewood];
        let list = (0..3)
            .map(|i| Pass {
                kernel: random_kernel(seed * 3 + i),
                part: parts[i as usize],
            })
            .collect();
        let schedule = KernelSchedule::new(list, 1).unwrap();
        let numbers = passes(&map, &schedule);
        let mut now = map.clone();
        for number in 0..25 {
            for (i, &n) in numbers.iter().enumerate() {
                let white = now.get(i % map.width(), i / map.width());
                let remains = map.get(i % map.width(), i / map.width()) && n > number;
                assert_eq!(white, remains, "seed {seed}, pass {number}, pixel {i}");
            }
            now = plain(&now, &schedule.pass(usize::from(number) + 1).kernel);
        }
    }
}

#[test]
fn huge_kernels_and_empty_bitmaps_are_valid() {
    let mut map = Bitmap::new(70, 9);
    for y in 0..9 {
        for x in 0..70 {
            map.set(x, y, true);
        }
    }
    let huge = |threshold| Kernel {
        width: u32::MAX,
        height: u32::MAX,
        offset: (i32::MAX, i32::MIN),
        threshold,
    };
    assert_eq!(erode(&map, &huge(1)).count(), 0);
    assert_eq!(erode(&map, &huge(u32::MAX)).count(), 0);
    let wide = Kernel {
        width: 1 << 20,
        height: 1,
        offset: (0, 0),
        // Of 2^20 pixels 70 lie in the picture.
        threshold: (1 << 20) - 69,
    };
    assert_eq!(erode(&map, &wide).count(), 630);
    let more = Kernel {
        threshold: wide.threshold - 1,
        ..wide
    };
    assert_eq!(erode(&map, &more).count(), 0);
    for (w, h) in [(0, 0), (0, 5), (5, 0)] {
        let nothing = Bitmap::new(w, h);
        for kernel in [Kernel::square(3), huge(5), wide] {
            assert_eq!(erode(&nothing, &kernel), nothing);
        }
        assert!(passes(&nothing, &KernelSchedule::one_pixel_per_pass()).is_empty());
    }
    // The paper's K = 1 never takes anything.
    let stuck = KernelSchedule::alternating(Kernel::square(1), Kernel::square(1));
    assert!(passes(&map, &stuck).iter().all(|&n| n == NOT_ERODED));
}

/// A bumpy section whose largest inscribed square is `2 * half` − 1 pixels wide.
fn section(size: usize, half: usize) -> Bitmap {
    let (middle, scale) = (size as f64 / 2.0, half as f64);
    let mut map = Bitmap::new(size, size);
    for y in 0..size {
        for x in 0..size {
            let (u, v) = ((x as f64 - middle) / scale, (y as f64 - middle) / scale);
            let a = v.atan2(u);
            map.set(x, y, u.hypot(v) <= 1.36 + 0.03 * (5.0 * a).cos());
        }
    }
    let (low, high) = (size / 2 - half + 1, size / 2 + half - 1);
    for y in low..=high {
        for x in low..=high {
            map.set(x, y, true);
        }
    }
    map
}

#[test]
fn the_papers_sections_have_its_numbers_of_contours() {
    for (size, contours) in [(32, 11), (64, 21), (128, 41), (256, 80), (512, 159)] {
        let map = section(size, (159 * size + 256) / 512);
        let numbers = passes(&map, &KernelSchedule::one_pixel_per_pass());
        let last = numbers.iter().copied().max().unwrap();
        // Chebyshev distance to the outside, by the largest white square about each pixel (dynamic programming).
        let mut side = vec![0u16; size * size];
        for y in 1..size {
            for x in 1..size {
                let before = [(1, 0), (0, 1), (1, 1)].map(|(i, j)| side[(y - j) * size + x - i]);
                if map.get(x, y) {
                    side[y * size + x] = 1 + before.into_iter().min().unwrap();
                }
            }
        }
        let widest = side.into_iter().max().unwrap();
        assert_eq!(last, widest.div_ceil(2), "{size}");
        assert!(last.abs_diff(contours) <= 1, "{size}: {last}");
    }
    let numbers = passes(&section(256, 80), &KernelSchedule::figure_6());
    let last = numbers.iter().copied().max().unwrap();
    assert_eq!(
        KernelSchedule::figure_6().ring_numbers(last).last(),
        Some(&24)
    );
}

#[test]
fn eccentric_kernels_move_the_middle() {
    let map = section(128, 40);
    let middle = |schedule: &KernelSchedule| {
        let numbers = passes(&map, schedule);
        let last = *numbers.iter().max().unwrap();
        let (sum, count) = (0..numbers.len())
            .filter(|&i| numbers[i] == last)
            .fold((0, 0), |(s, c), i| (s + i % 128, c + 1));
        sum as f64 / f64::from(count)
    };
    let still = middle(&KernelSchedule::one_pixel_per_pass());
    let moved = middle(&KernelSchedule::eccentric());
    assert!(moved < still - 8.0, "{moved} {still}");
}

#[test]
fn eccentric_rings_have_no_kinks_where_a_polygon_has_corners() {
    // A triangle with its corners cut off, the hardest of sections: after ten passes kernels of one black pixel still
    // have its corners, those of many have not.
    let corners = [
        (-90.0, -60.0),
        (-60.0, -80.0),
        (70.0, -50.0),
        (80.0, -20.0),
        (0.0, 90.0),
        (-40.0, 90.0),
    ];
    let mut map = Bitmap::new(256, 256);
    for (x, y) in (0..256).flat_map(|y| (0..256).map(move |x| (x, y))) {
        let p = DVec2::new(x as f64 - 128.0, y as f64 - 128.0);
        let inside = (0..6).all(|i| {
            let [a, b] = [corners[i], corners[(i + 1) % 6]].map(DVec2::from);
            (b - a).perp_dot(p - a) > 0.0
        });
        map.set(x, y, inside);
    }
    // The sharpest turn of the front, of chords of 12 pixels' length.
    let sharpest = |schedule: &KernelSchedule, pass: u16| {
        let numbers = passes(&map, schedule);
        let stays = |p: DVec2| {
            let (x, y) = ((p.x + 128.5) as usize, (p.y + 128.5) as usize);
            numbers[y * 256 + x] > pass
        };
        let white: Vec<DVec2> = (0..256 * 256)
            .map(|i| DVec2::new((i % 256) as f64 - 128.0, (i / 256) as f64 - 128.0))
            .filter(|p| stays(*p))
            .collect();
        let centre = white.iter().sum::<DVec2>() / white.len() as f64;
        let front: Vec<DVec2> = (0..720)
            .map(|k| DVec2::from_angle(f64::from(k) * std::f64::consts::TAU / 720.0))
            .map(|ray| {
                let steps = (0..).take_while(|s| stays(centre + ray * 0.25 * f64::from(*s)));
                centre + ray * 0.25 * steps.last().map_or(0.0, f64::from)
            })
            .collect();
        let after = |i: usize| {
            let far = |j: &usize| front[(i + j) % 720].distance(front[i]) >= 12.0;
            (i + (1..720).find(far).unwrap_or(0)) % 720
        };
        (0..720)
            .map(|i| {
                let (j, k) = (after(i), after(after(i)));
                (front[j] - front[i]).angle_to(front[k] - front[j]).abs()
            })
            .fold(0.0, f64::max)
            .to_degrees()
    };
    let kinked = sharpest(&KernelSchedule::one_pixel_per_pass(), 20);
    let smooth = sharpest(&KernelSchedule::eccentric(), 10);
    println!("sharpest turns {kinked:.0} and {smooth:.0} degrees");
    assert!(kinked > 70.0, "{kinked}");
    assert!(smooth < 55.0, "{smooth}");
}

#[test]
fn two_fronts_meet_and_cover_the_section() {
    let map = section(128, 40);
    let inward = KernelSchedule::alternating(Kernel::square(3), Kernel::square(5));
    let outward = inward.clone().for_outward_front();
    let circle = PixelCircle {
        centre: DVec2::new(60.0, 66.0),
        radius: 9.0,
    };
    let both: ErodedPasses =
        erode_from_both_sides(&map, &inward, &outward, circle, &Context::quiet()).unwrap();
    let alone = passes(&map, &inward);
    let last = both.parts.len() as u16;
    let steps = (last - 1) / 2;
    let disc: Vec<DVec2> = (0..128 * 128)
        .map(|j| DVec2::new(f64::from(j % 128), f64::from(j / 128)))
        .filter(|q| q.distance(circle.centre) <= circle.radius)
        .collect();
    for (i, &n) in both.passes.iter().enumerate() {
        let (x, y) = (i % 128, i / 128);
        let p = DVec2::new(x as f64, y as f64);
        assert_eq!(n == 0, !map.get(x, y));
        assert_eq!(
            n == last,
            n != 0 && p.distance(circle.centre) <= circle.radius
        );
        assert!(n <= last, "a pixel is left");
        if n <= steps {
            assert_eq!(
                n, alone[i],
                "the outer front is not changed by the inner one"
            );
        } else if n < last {
            // Chebyshev distance from the circle's pixels grows by 1 and 2 pixels in turn from inside.
            let from_inside = last - n;
            let reach = from_inside / 2 * 3 + if from_inside % 2 == 1 { 2 } else { 0 };
            let near = disc
                .iter()
                .any(|q| (q - p).abs().max_element() <= f64::from(reach));
            assert!(near, "{x} {y}");
        }
    }
    assert_eq!(both.parts[0], RingPart::Latewood);
    assert_eq!(both.parts[usize::from(last) - 2], RingPart::Earlywood);
}
