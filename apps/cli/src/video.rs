//! Pictures of a film's frames, and a video of them by ffmpeg where that is installed.

use crate::failure::Failure;
use greenstick::files::{self, Output};
use greenstick::geometry::{Context, Stage};
use greenstick::picture::PictureOptions;
use greenstick::skin::film::Run;
use greenstick_sweep::shown::{RunFilm, film_shot};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Endings of videos, with the encoder of each.
const ENCODERS: [(&str, &[&str]); 2] = [
    (
        "mp4",
        &["-c:v", "libx264", "-crf", "18", "-movflags", "+faststart"],
    ),
    ("webm", &["-c:v", "libvpx-vp9", "-crf", "30", "-b:v", "0"]),
];

/// Whether an ending is that of a video.
pub fn is_video(ending: &str) -> bool {
    ENCODERS.iter().any(|e| e.0 == ending)
}

/// Fails where ffmpeg cannot be run.
pub fn check_ffmpeg() -> Result<(), Failure> {
    let output = Command::new("ffmpeg").arg("-version").output();
    match output {
        Ok(output) if output.status.success() => Ok(()),
        _ => Err(
            Failure::work("videos are made by ffmpeg, which cannot be run here")
                .hint("install it, or ask for the frames as pictures: --pictures FOLDER"),
        ),
    }
}

/// Takes a picture of every frame into `folder`, which must be there; returns the files.
pub fn pictures(
    run: &Run,
    film: &mut RunFilm,
    folder: &Path,
    shot: &PictureOptions,
    context: &Context,
) -> Result<Vec<(String, usize)>, Failure> {
    let count = film.skinned().report.frames;
    let [framing, drawing] =
        context.split([(Stage::new("frames"), 1.0), (Stage::new("pictures"), 100.0)]);
    let all: Vec<usize> = (0..count).collect();
    let shot = film_shot(&film.view(&all, &framing)?, shot);
    let metadata = film.skinned().film.metadata.clone();
    let mut made = Vec::new();
    for number in 0..count {
        let shown = drawing.item(number, count);
        let scene = film.at(run, number)?;
        let picture = film.picture(run, &scene, &shot, &shown)?;
        let path = folder.join(format!("frame_{number:05}.png"));
        let bytes = picture.png_with(&metadata);
        made.push((path.display().to_string(), bytes.len()));
        files::write_all(&[Output { path, bytes }])?;
    }
    Ok(made)
}

/// Makes a video of the pictures in `folder`, beside its place first.
pub fn encode(
    folder: &Path,
    frames_per_second: f64,
    path: &Path,
    ending: &str,
) -> Result<usize, Failure> {
    let encoder = ENCODERS
        .iter()
        .find(|e| e.0 == ending)
        .map_or(&[][..], |e| e.1);
    let beside = folder.join(format!("video.{ending}"));
    let output = Command::new("ffmpeg")
        .args(["-y", "-loglevel", "error", "-framerate"])
        .arg(frames_per_second.to_string())
        .arg("-i")
        .arg(folder.join("frame_%05d.png"))
        .args(encoder)
        // Players take what does not say its colours for one thing or another by its size; and sides have to be even.
        .args([
            "-pix_fmt",
            "yuv420p",
            "-vf",
            "crop=floor(iw/2)*2:floor(ih/2)*2,scale=out_color_matrix=bt709:out_range=tv",
            "-colorspace",
            "bt709",
            "-color_range",
            "tv",
        ])
        .arg(&beside)
        .output()
        .map_err(|e| Failure::work(format!("ffmpeg cannot be run: {e}")))?;
    if !output.status.success() {
        let says = String::from_utf8_lossy(&output.stderr);
        return Err(Failure::work(format!("ffmpeg failed: {}", says.trim())));
    }
    let bytes =
        fs::read(&beside).map_err(|e| Failure::work(format!("ffmpeg left no video: {e}")))?;
    let length = bytes.len();
    files::write_all(&[Output {
        path: path.to_owned(),
        bytes,
    }])?;
    Ok(length)
}

/// A folder that is removed with its content when dropped.
pub struct Scratch(pub PathBuf);

impl Scratch {
    /// One beside `path`.
    pub fn beside(path: &Path) -> Result<Scratch, Failure> {
        let name = path
            .file_name()
            .map_or_else(String::new, |n| n.to_string_lossy().into_owned());
        let folder = path.with_file_name(format!(".{name}-{}", std::process::id()));
        fs::create_dir(&folder)
            .map_err(|e| Failure::work(format!("{}: cannot be made: {e}", folder.display())))?;
        Ok(Scratch(folder))
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        // What cannot be removed stays.
        let _ = fs::remove_dir_all(&self.0);
    }
}
