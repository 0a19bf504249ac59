//! Schedules as text: lists of rings, each of kernels, from the bark inwards (Forests 2023 §3.3 gives its own in words).
//!
//! `4*3/5,6*3/3,7x5+1-2t4/9`: rings are separated by commas, their kernels by slashes. The first kernel of a ring takes off
//! latewood, the others earlywood; a ring of one kernel uses it for both. `4*` is four such rings. A kernel is K for
//! K × K pixels or WxH, optionally followed by where its middle lies, +X+Y or with minus signs, and by t and the threshold.
//! After the end of the list its last ring repeats.

use super::kernel::Kernel;
use super::schedule::{KernelSchedule, Pass};
use crate::rings::RingPart;
use std::fmt;
use std::str::FromStr;

/// Most pixels along a side of a kernel, and largest offset.
const MAX_SIDE: u32 = 4096;
/// Most passes of a list.
const MAX_PASSES: usize = 10_000;

/// Why a text is not a list of kernels.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("ring {ring}, \"{text}\": {found}; expected {wanted}")]
pub struct KernelListError {
    /// Which ring of the list, counted from 1.
    pub ring: usize,
    /// The text of that ring.
    pub text: String,
    /// What is wrong.
    pub found: String,
    /// What would be right.
    pub wanted: &'static str,
}

const RING: &str = "kernels from latewood to earlywood, such as 3/5, with an optional count before them, such as 4*";
const KERNEL: &str =
    "a size, with an optional offset and threshold, such as 3, 5x3, 5x3+1-2 or 5t4";

impl FromStr for KernelSchedule {
    type Err = KernelListError;

    fn from_str(list: &str) -> Result<Self, KernelListError> {
        let mut passes = Vec::new();
        let mut last = 0;
        for (i, text) in list.split(',').enumerate() {
            let wrong = |(found, wanted): (String, &'static str)| KernelListError {
                ring: i + 1,
                text: text.trim().to_owned(),
                found,
                wanted,
            };
            let (count, ring) = ring(text.trim()).map_err(wrong)?;
            if count > MAX_PASSES || passes.len() + count * ring.len() > MAX_PASSES {
                let found = format!("more than {MAX_PASSES} passes");
                return Err(wrong((found, "fewer: the last ring repeats anyway")));
            }
            last = ring.len();
            passes.extend(std::iter::repeat_n(ring, count).flatten());
        }
        let repeat_from = passes.len().saturating_sub(last);
        KernelSchedule::new(passes, repeat_from).map_err(|e| KernelListError {
            ring: 1,
            text: list.to_owned(),
            found: e.to_string(),
            wanted: RING,
        })
    }
}

/// How often a ring repeats, and its passes.
fn ring(text: &str) -> Result<(usize, Vec<Pass>), (String, &'static str)> {
    let (count, kernels) = match text.split_once('*') {
        None => (1, text),
        Some((count, kernels)) => match count.trim().parse() {
            Ok(count) if count > 0 => (count, kernels),
            _ => return Err((format!("\"{count}\" times"), RING)),
        },
    };
    let kernels: Vec<Kernel> = kernels
        .split('/')
        .map(|k| kernel(k.trim()))
        .collect::<Result<_, _>>()?;
    let latewood = kernels[0];
    let earlywood = match &kernels[1..] {
        [] => vec![latewood],
        more => more.to_vec(),
    };
    let pass = |kernel, part| Pass { kernel, part };
    let passes = std::iter::once(pass(latewood, RingPart::Latewood))
        .chain(earlywood.into_iter().map(|k| pass(k, RingPart::Earlywood)))
        .collect();
    Ok((count, passes))
}

fn kernel(text: &str) -> Result<Kernel, (String, &'static str)> {
    let wrong = || (format!("\"{text}\" is no kernel"), KERNEL);
    let number = |t: &str| {
        let digits = !t.is_empty() && t.bytes().all(|b| b.is_ascii_digit());
        t.parse::<u32>().ok().filter(|_| digits).ok_or_else(wrong)
    };
    let (rest, threshold) = match text.split_once('t') {
        None => (text, 1),
        Some((rest, t)) => (rest, number(t)?),
    };
    let signs: Vec<usize> = rest
        .bytes()
        .enumerate()
        .filter(|(_, b)| matches!(b, b'+' | b'-'))
        .map(|(i, _)| i)
        .collect();
    let (size, offset) = match signs[..] {
        [] => (rest, (0, 0)),
        [a, b] => {
            let coordinate = |t: &str| match number(&t[1..])? {
                n if n <= MAX_SIDE => Ok(if t.starts_with('-') {
                    -(n as i32)
                } else {
                    n as i32
                }),
                _ => Err(wrong()),
            };
            (
                &rest[..a],
                (coordinate(&rest[a..b])?, coordinate(&rest[b..])?),
            )
        }
        _ => return Err(wrong()),
    };
    let (width, height) = match size.split_once('x') {
        None => (number(size)?, number(size)?),
        Some((w, h)) => (number(w)?, number(h)?),
    };
    if !(1..=MAX_SIDE).contains(&width) || !(1..=MAX_SIDE).contains(&height) {
        let found = format!("\"{text}\" is {width} × {height} pixels");
        return Err((found, "1 to 4096 pixels along each side"));
    }
    let kernel = Kernel {
        width,
        height,
        offset,
        threshold,
    };
    // The pixel itself is never black.
    let holds = |first: i64, size: u32| first <= 0 && first + i64::from(size) > 0;
    let own = holds(kernel.left(), width) && holds(kernel.top(), height);
    let most = u64::from(width) * u64::from(height) - u64::from(own);
    if threshold == 0 || u64::from(threshold) > most {
        let found = if most == 0 {
            format!("\"{text}\" sees only the pixel itself and takes nothing off")
        } else {
            format!("\"{text}\" has the threshold {threshold}, of {most} pixels that can be black")
        };
        return Err((
            found,
            "a window of more than a pixel, and a threshold from 1 to what it holds",
        ));
    }
    Ok(kernel)
}

impl fmt::Display for KernelSchedule {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut rings: Vec<(usize, String)> = Vec::new();
        for (i, pass) in self.passes().iter().enumerate() {
            let k = pass.kernel;
            let mut text = k.width.to_string();
            if k.height != k.width {
                text += &format!("x{}", k.height);
            }
            if k.offset != (0, 0) {
                text += &format!("{:+}{:+}", k.offset.0, k.offset.1);
            }
            if k.threshold != 1 {
                text += &format!("t{}", k.threshold);
            }
            match rings.last_mut() {
                Some(ring) if i > 0 && pass.part == RingPart::Earlywood => {
                    ring.1 += &format!("/{text}")
                }
                _ => rings.push((1, text)),
            }
        }
        rings.dedup_by(|b, a| {
            let same = a.1 == b.1;
            a.0 += if same { b.0 } else { 0 };
            same
        });
        for (i, (count, ring)) in rings.iter().enumerate() {
            let comma = if i > 0 { "," } else { "" };
            match count {
                1 => write!(f, "{comma}{ring}")?,
                count => write!(f, "{comma}{count}*{ring}")?,
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_of_kernels_are_parsed_and_formatted() {
        let figure: KernelSchedule = "4*3/5, 6*3, 5*3/5,4*3/7,3*3/9,2*3/11".parse().unwrap();
        assert_eq!(figure, KernelSchedule::figure_6());
        assert_eq!(figure.to_string(), "4*3/5,6*3/3,5*3/5,4*3/7,3*3/9,2*3/11");
        assert_eq!(
            "3".parse::<KernelSchedule>().unwrap(),
            KernelSchedule::one_pixel_per_pass()
        );
        let free: KernelSchedule = "5x3+1-2t4/9/1x2+0+1".parse().unwrap();
        let first = Kernel {
            width: 5,
            height: 3,
            offset: (1, -2),
            threshold: 4,
        };
        assert_eq!((free.pass(1).kernel, free.pass(4).kernel), (first, first));
        assert_eq!(free.pass(3).part, RingPart::Earlywood);
        assert_eq!(free.to_string(), "5x3+1-2t4/9/1x2+0+1");
        assert_eq!(free.ring_numbers(7), [0, 1, 1, 1, 2, 2, 2, 3]);
        let moved = "1+1+0".parse::<KernelSchedule>().unwrap();
        assert_eq!(moved.pass(1).kernel.offset, (1, 0));
    }

    #[test]
    fn a_text_that_is_no_list_is_refused_with_the_ring() {
        for (text, expected) in [
            ("", "ring 1"),
            ("3,", "ring 2"),
            ("3/x", "\"x\" is no kernel"),
            ("0*3", "\"0\" times"),
            ("1", "sees only the pixel itself"),
            ("3,0x3", "0 × 3"),
            ("3t9", "threshold 9, of 8"),
            ("3t0", "threshold 0"),
            ("3+1", "no kernel"),
            ("5000", "5000"),
            ("-3", "no kernel"),
            ("9999*3/3/3", "10000 passes"),
            ("3+99999999999+0", "no kernel"),
        ] {
            let error = text.parse::<KernelSchedule>().unwrap_err().to_string();
            assert!(error.contains(expected), "{text}: {error}");
        }
    }
}
