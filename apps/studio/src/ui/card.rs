//! The graphics card that the window draws on, and whether it was lost.

use eframe::egui::Rect;
use std::sync::{Arc, Mutex, PoisonError};

/// The card that the window draws on.
#[derive(Default)]
pub struct Card {
    /// The device and its queue. That they are held here keeps the end of a window, which drops its own, from being taken for a loss;
    /// and a device whose queue is gone never tells that it was lost.
    pub(super) device: Option<(wgpu::Device, wgpu::Queue)>,
    /// Why it was lost, once it was.
    pub(super) lost: Arc<Mutex<Option<String>>>,
    /// Where the window was when it was drawn last, in points of the display.
    pub(super) place: WindowPlace,
}

/// Where a window is.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct WindowPlace {
    /// What is inside of its frame, where the display tells.
    pub inner: Option<Rect>,
    /// The whole of it, likewise.
    pub outer: Option<Rect>,
    /// Whether it takes the whole of the display but for bars.
    pub maximized: bool,
    /// Whether it takes the whole of the display.
    pub fullscreen: bool,
}

impl Card {
    /// Whether there is one that draws.
    pub(super) fn is_there(&self) -> bool {
        self.device.is_some()
    }

    /// Why it was lost, if it was.
    pub(super) fn why_lost(&self) -> Option<String> {
        if let Some((device, _)) = &self.device {
            // A device tells of its end only where it is asked for news. What it answers besides is of no use here.
            let _ = device.poll(wgpu::PollType::Poll);
        }
        let lost = self.lost.lock();
        lost.unwrap_or_else(PoisonError::into_inner).clone()
    }
}
