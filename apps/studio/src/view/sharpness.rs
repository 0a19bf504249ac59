//! How many pixels are drawn while the picture moves: as many as the graphics card has time for. What rests is drawn whole.

/// Pixels along a side of the picture, of those that it has, from the sharpest on.
const SIDES: [f32; 5] = [1.0, 0.7, 0.5, 0.35, 0.25];
/// Where a card begins that is the processor.
const SIDE_OF_PROCESSOR: usize = 2;
/// Frames that take longer are too slow, and those that take less leave time for more pixels, s.
const TOO_SLOW: f64 = 0.05;
const QUICK: f64 = 0.02;
/// So many quick frames make the picture sharper. What makes it too slow again takes more than twice as long.
const QUICK_FRAMES: u32 = 20;
/// A picture rests so long after it moved last, s: a hand stops for moments.
const REST: f64 = 0.2;

/// What moves in the picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Motion {
    /// Nothing.
    Rest,
    /// What is looked at, which is played or follows a slider, or a hand holds the picture still.
    Scene,
    /// The camera.
    Camera,
}

/// What is known of the speed of a card.
#[derive(Debug, Clone, PartialEq)]
pub struct Sharpness {
    side: usize,
    /// When the picture moved last, s.
    moved_at: f64,
    /// Whether the camera moved in the frame before.
    turned: bool,
    quick: u32,
}

impl Sharpness {
    /// Of a card that nothing is known of but whether it is the processor.
    pub fn new(is_processor: bool) -> Self {
        Sharpness {
            side: if is_processor { SIDE_OF_PROCESSOR } else { 0 },
            moved_at: f64::NEG_INFINITY,
            turned: false,
            quick: 0,
        }
    }

    /// Takes note of a frame that begins at a time (s), so many seconds after the one before, and of what moves in its picture.
    /// Returns the part of the pixels along a side to draw, and after how many seconds another frame is needed, if one is.
    pub fn next(&mut self, now: f64, seconds: f64, motion: Motion) -> (f32, Option<f64>) {
        // Each frame with another camera is drawn, and others may not be.
        if std::mem::replace(&mut self.turned, motion == Motion::Camera) {
            self.learn(seconds);
        }
        if motion != Motion::Rest {
            self.moved_at = now;
        }
        let rests_in = self.moved_at + REST - now;
        if rests_in <= 0.0 {
            return (1.0, None);
        }
        // Frames of a camera that moves follow each other, as they are timed.
        let after = if self.turned { 0.0 } else { rests_in };
        (SIDES[self.side], Some(after))
    }

    fn learn(&mut self, seconds: f64) {
        if seconds > TOO_SLOW {
            // The time goes with the pixels.
            let most = SIDES[self.side] * (TOO_SLOW / seconds).sqrt() as f32;
            let quick_enough = SIDES.iter().position(|side| *side <= most);
            self.side = quick_enough.unwrap_or(SIDES.len() - 1);
            self.quick = 0;
        } else if seconds < QUICK {
            self.quick += 1;
            if self.quick >= QUICK_FRAMES {
                self.quick = 0;
                self.side = self.side.saturating_sub(1);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Turns the picture for some frames on a card that draws all pixels in `whole` seconds; returns how long each frame takes.
    fn turned(sharpness: &mut Sharpness, whole: f64, frames: usize) -> Vec<f64> {
        let mut before = 1.0 / 60.0;
        let mut now = 0.0;
        let frame = |_| {
            let (side, soon) = sharpness.next(now, before, Motion::Camera);
            assert_eq!(soon, Some(0.0));
            // No screen shows more than 60.
            before = (whole * f64::from(side * side)).max(1.0 / 60.0);
            now += before;
            before
        };
        (0..frames).map(frame).collect()
    }

    #[test]
    fn a_slow_card_draws_fewer_pixels_while_the_picture_moves_and_all_when_it_rests() {
        let mut sharpness = Sharpness::new(false);
        let times = turned(&mut sharpness, 0.3, 100);
        assert!((times[0] - 0.3).abs() < 1e-6, "{times:?}");
        assert!(times[1..].iter().all(|t| *t < 0.05), "{times:?}");
        let now: f64 = times.iter().sum();
        let last = now - times[99];
        let (side, again) = sharpness.next(last + 0.1, 0.02, Motion::Rest);
        assert!(side < 1.0 && again.is_some_and(|s| (s - 0.1).abs() < 1e-6));
        assert_eq!(sharpness.next(last + 0.21, 0.1, Motion::Rest), (1.0, None));
    }

    #[test]
    fn a_quick_card_always_draws_all() {
        let mut sharpness = Sharpness::new(false);
        turned(&mut sharpness, 0.004, 100);
        assert_eq!(sharpness.next(9.0, 0.01, Motion::Camera).0, 1.0);
        // A pause before the picture moves says nothing of the card.
        for motion in [Motion::Scene, Motion::Rest] {
            sharpness.next(20.0, 0.01, motion);
            assert_eq!(sharpness.next(30.0, 10.0, Motion::Scene).0, 1.0);
        }
    }

    #[test]
    fn a_processor_begins_with_half_and_gets_back_to_all_where_it_can() {
        let mut sharpness = Sharpness::new(true);
        assert_eq!(sharpness.next(0.0, 0.01, Motion::Camera).0, 0.5);
        turned(&mut sharpness, 0.015, 100);
        assert_eq!(sharpness.next(9.0, 0.01, Motion::Camera).0, 1.0);
    }

    #[test]
    fn what_is_too_sharp_is_not_tried_again_and_again() {
        let mut sharpness = Sharpness::new(false);
        let times = turned(&mut sharpness, 0.06, 1000);
        let slow = times.iter().filter(|t| **t > TOO_SLOW).count();
        assert_eq!(slow, 1);
        // A single frame that waits for something else is made up for.
        let mut sharpness = Sharpness::new(false);
        turned(&mut sharpness, 0.004, 10);
        sharpness.next(9.0, 0.4, Motion::Camera);
        turned(&mut sharpness, 0.004, 200);
        assert_eq!(sharpness.next(9.0, 0.01, Motion::Camera).0, 1.0);
    }
}
