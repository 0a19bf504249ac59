//! Opens the studio's window and takes its graphics device away after some seconds, as a driver that is reset does. The window then
//! begins again by itself, with everything as it was: `lost_card SECONDS [FILE]`.

use std::cell::Cell;
use std::process::ExitCode;
use std::time::Duration;

fn main() -> ExitCode {
    let mut arguments = std::env::args().skip(1);
    let seconds = arguments.next().and_then(|s| s.parse().ok());
    let Some(seconds) = seconds.and_then(|s| Duration::try_from_secs_f64(s).ok()) else {
        eprintln!("usage: lost_card SECONDS [FILE]");
        return ExitCode::from(2);
    };
    let path = arguments.next();
    let taken = Cell::new(false);
    let take = |device: &wgpu::Device| {
        if !taken.replace(true) {
            let device = device.clone();
            std::thread::spawn(move || {
                std::thread::sleep(seconds);
                device.destroy();
            });
        }
    };
    match greenstick_studio::window::run(path.as_deref(), take) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}
