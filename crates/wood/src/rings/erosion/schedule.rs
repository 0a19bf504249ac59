//! The order of kernels in an erosion (Forests 2023 §3.3 and Fig. 6).

use super::kernel::Kernel;
use crate::rings::RingPart;

/// Size of the kernel of eccentric rings, and the part of its pixels that is its threshold: together 2 pixels a pass, and
/// corners rounded over about 20.
const ECCENTRIC_SIZE: u32 = 21;
const ECCENTRIC_THRESHOLD: f64 = 0.4;

/// One pass of the erosion.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Pass {
    /// Its kernel.
    pub kernel: Kernel,
    /// What it takes off.
    pub part: RingPart,
}

/// Why a list of passes is not a schedule.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ScheduleError {
    /// It has no pass.
    #[error("the schedule has no passes; give at least one")]
    Empty,
    /// The pass to repeat from lies beyond its end.
    #[error("the schedule repeats from pass {from}, but has {count} passes, counted from 0")]
    Repeat {
        /// The index that was given.
        from: usize,
        /// Passes in the list.
        count: usize,
    },
}

/// The passes of an erosion from the contour inwards; after the last one, some of the last repeat until the section is
/// gone.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct KernelSchedule {
    passes: Vec<Pass>,
    repeat_from: usize,
}

impl KernelSchedule {
    /// All `passes` once, then those from index `repeat_from` on repeatedly.
    ///
    /// # Errors
    /// [`ScheduleError`] where there are none or `repeat_from` lies beyond them.
    pub fn new(passes: Vec<Pass>, repeat_from: usize) -> Result<Self, ScheduleError> {
        let count = passes.len();
        if count == 0 {
            return Err(ScheduleError::Empty);
        }
        if repeat_from >= count {
            return Err(ScheduleError::Repeat {
                from: repeat_from,
                count,
            });
        }
        Ok(KernelSchedule {
            passes,
            repeat_from,
        })
    }

    /// Rings all alike: a latewood pass, then an earlywood pass, and again.
    pub fn alternating(latewood: Kernel, earlywood: Kernel) -> Self {
        KernelSchedule {
            passes: ring(latewood, earlywood).to_vec(),
            repeat_from: 0,
        }
    }

    /// The paper's Table 1 and Fig. 5: every pass takes off one pixel. Its kernel of 1 × 1 for latewood cannot erode
    /// anything as defined (it would see only the pixel itself), so that 3 × 3 takes its place.
    pub fn one_pixel_per_pass() -> Self {
        Self::alternating(Kernel::square(3), Kernel::square(3))
    }

    /// The paper's Fig. 6, from the bark inwards: a few thin rings (3, 5), the narrowest ones (3 only), then wider and
    /// wider ones (3, 5), (3, 7), (3, 9) and (3, 11) to the pith. A section of 256 × 256 pixels whose largest inscribed
    /// square is 2 × 80 wide gets 24 rings, as there; the paper gives no numbers for its "few", and these add up.
    pub fn figure_6() -> Self {
        let groups = [(4, 5), (6, 3), (5, 5), (4, 7), (3, 9), (2, 11)];
        let passes: Vec<Pass> = groups
            .into_iter()
            .flat_map(|(rings, size)| {
                std::iter::repeat_n(ring(Kernel::square(3), Kernel::square(size)), rings)
            })
            .flatten()
            .collect();
        let repeat_from = passes.len() - 2;
        KernelSchedule {
            passes,
            repeat_from,
        }
    }

    /// The same for bitmaps `factor` times as large: a kernel that takes off d pixels takes off `factor` · d.
    #[must_use]
    pub fn scaled(mut self, factor: u32) -> Self {
        for pass in &mut self.passes {
            pass.kernel = pass.kernel.scaled(factor);
        }
        self
    }

    /// Eccentric rings (the paper's Fig. 8, which gives no numbers): twice and more as wide on the side of positive x as on the
    /// other, for a section of 256 × 256 pixels.
    ///
    /// A narrow kernel with a threshold of one black pixel takes a corner of the outline inwards as it is, and the rings get a
    /// kink on the line between two sides. A wide kernel with a threshold of little less than half of its pixels advances by the
    /// small rest, d = (½ − M_K/K²) K, and by more where the front is curved: it rounds corners off, as growth does. The offset
    /// adds to d on one side what it takes on the other.
    pub fn eccentric() -> Self {
        let kernel = Kernel {
            threshold: (ECCENTRIC_THRESHOLD * f64::from(ECCENTRIC_SIZE * ECCENTRIC_SIZE)) as u32,
            offset: (1, 0),
            ..Kernel::square(ECCENTRIC_SIZE)
        };
        Self::alternating(kernel, kernel)
    }

    /// The schedule of a front that runs outwards: latewood and earlywood of every ring exchanged, as a year's earlywood lies
    /// inside its latewood.
    #[must_use]
    pub fn for_outward_front(mut self) -> Self {
        let mut i = 0;
        while i + 1 < self.passes.len() {
            if (self.passes[i].part, self.passes[i + 1].part)
                == (RingPart::Latewood, RingPart::Earlywood)
            {
                self.passes.swap(i, i + 1);
                i += 1;
            }
            i += 1;
        }
        self
    }

    /// Pass `number`, counted from 1 (0 counts as 1).
    pub fn pass(&self, number: usize) -> &Pass {
        let index = number.saturating_sub(1);
        let count = self.passes.len();
        if index < count {
            return &self.passes[index];
        }
        &self.passes[self.repeat_from + (index - count) % (count - self.repeat_from)]
    }

    /// The passes before any repeats.
    pub fn passes(&self) -> &[Pass] {
        &self.passes
    }

    /// Number of passes after which every kernel has had its turn, from any pass on.
    pub(super) fn period(&self) -> usize {
        self.passes.len()
    }

    /// The annual ring of every pass up to `last`, as [`ring_numbers`] counts them.
    pub fn ring_numbers(&self, last: u16) -> Vec<u16> {
        ring_numbers((1..=usize::from(last)).map(|n| self.pass(n).part))
    }
}

/// The annual ring of every pass of given parts, counted from 1 at the bark; entry 0, outside the section, is 0. A ring
/// begins where latewood follows earlywood.
pub fn ring_numbers(parts: impl Iterator<Item = RingPart>) -> Vec<u16> {
    let mut ring = 0;
    let mut before = None;
    std::iter::once(0)
        .chain(parts.map(|part| {
            if before.is_none() || (before, part) == (Some(RingPart::Earlywood), RingPart::Latewood)
            {
                ring += 1;
            }
            before = Some(part);
            ring
        }))
        .collect()
}

fn ring(latewood: Kernel, earlywood: Kernel) -> [Pass; 2] {
    [
        Pass {
            kernel: latewood,
            part: RingPart::Latewood,
        },
        Pass {
            kernel: earlywood,
            part: RingPart::Earlywood,
        },
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_passes_repeat_and_rings_begin_with_latewood() {
        let schedule = KernelSchedule::figure_6();
        let sizes = [1, 2, 8, 10, 30, 47, 48, 49, 50].map(|n| schedule.pass(n).kernel.width);
        assert_eq!(sizes, [3, 5, 5, 3, 5, 3, 11, 3, 11]);
        let rings = schedule.ring_numbers(50);
        assert_eq!([rings[0], rings[1], rings[2], rings[3]], [0, 1, 1, 2]);
        assert_eq!((rings[48], rings[50]), (24, 25));
        assert_eq!(schedule.clone().for_outward_front().pass(1).kernel.width, 5);
        assert_eq!(
            KernelSchedule::new(Vec::new(), 0).unwrap_err(),
            ScheduleError::Empty
        );
        let one = vec![*schedule.pass(1)];
        assert!(KernelSchedule::new(one.clone(), 1).is_err());
        assert_eq!(
            KernelSchedule::new(one, 0).unwrap().ring_numbers(3),
            [0, 1, 1, 1]
        );
    }
}
