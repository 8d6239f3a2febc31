//! Films of a run: one window and one range of colors for all frames.
use super::drawing::{Run, refuse_nothing};
use super::fail::Failure;
use super::folder::refuse_result;
use sinew::lab::figure::{Animation, Figure, Raster};
use sinew::lab::picture::{Request, Sight, Survey, draw_with};
use sinew::output::io;
use std::fs::File;
use std::io::{BufWriter, IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

/// Writes a film of frames; the file.
pub fn write(
    run: &Run,
    request: &Request,
    numbers: &[usize],
    file: &Path,
    rate: u16,
) -> Result<PathBuf, Failure> {
    refuse_result(file)?;
    let kind = file.extension().and_then(|end| end.to_str()).unwrap_or_default().to_lowercase();
    if !["png", "apng", "mp4"].contains(&kind.as_str()) {
        return Err(Failure::usage(format!(
            "{}: a film is a .png (an animated one) or a .mp4 file",
            file.display()
        )));
    }
    let shows = std::io::stderr().is_terminal();
    let tell = |what: &str, n: usize| {
        if shows {
            eprint!("\r{what} {} of {} frames ", n + 1, numbers.len());
        }
    };
    let mut survey = Survey::new(request);
    for (n, number) in numbers.iter().enumerate() {
        let frames = run.frames(&[*number])?;
        survey.add(request, &Sight::of(request, &run.subjects(&frames)));
        tell("looked at", n);
    }
    refuse_nothing(&survey, request)?;
    let picture = |number: usize| -> Result<Figure, Failure> {
        let frames = run.frames(&[number])?;
        draw_with(request, &survey, &Sight::of(request, &run.subjects(&frames))).map_err(Failure::usage)
    };
    let draft = Draft::of(file);
    let failed =
        |problem: String| Failure::Run(format!("{}: {problem}; the film was not written", file.display()));
    let mut film: Option<Film> = None;
    for (n, number) in numbers.iter().enumerate() {
        let raster = picture(*number)?.rasterize(request.dpi).map_err(failed)?;
        let film = match &mut film {
            Some(film) => film,
            None => film.insert(Film::begin(
                &draft.path,
                &kind,
                &raster,
                numbers.len() as u32,
                rate,
                request.dpi,
            )?),
        };
        film.add(&raster).map_err(failed)?;
        tell("drew", n);
    }
    if shows {
        eprintln!();
    }
    film.map_or(Ok(()), |film| film.end().map_err(failed))?;
    draft.put_in_place(file)?;
    Ok(file.to_owned())
}

/// A film on its way: what fails leaves nothing.
struct Draft {
    path: PathBuf,
}

impl Draft {
    fn of(file: &Path) -> Self {
        let name = file.file_name().unwrap_or_default().to_string_lossy();
        // ffmpeg knows what to write by the ending
        Self { path: file.with_file_name(format!(".part-{name}")) }
    }

    fn put_in_place(self, file: &Path) -> Result<(), Failure> {
        Ok(std::fs::rename(&self.path, file).map_err(io("rename", file))?)
    }
}

impl Drop for Draft {
    fn drop(&mut self) {
        // it is not there, if all went well
        let _ = std::fs::remove_file(&self.path);
    }
}

/// A film in the making.
enum Film {
    Png(Animation<BufWriter<File>>),
    Mp4(Child),
}

impl Film {
    fn begin(
        file: &Path,
        kind: &str,
        first: &Raster,
        frames: u32,
        rate: u16,
        dpi: f64,
    ) -> Result<Self, Failure> {
        if kind == "mp4" {
            return Ok(Self::Mp4(ffmpeg(file, first.size, rate)?));
        }
        let out = File::create(file).map_err(io("create", file))?;
        let animation = Animation::begin(BufWriter::new(out), first.size, dpi, Some((frames, rate)));
        animation.map(Self::Png).map_err(|problem| Failure::Run(format!("{}: {problem}", file.display())))
    }

    fn add(&mut self, raster: &Raster) -> Result<(), String> {
        match self {
            Self::Png(animation) => animation.add(raster),
            Self::Mp4(child) => {
                let input = child.stdin.as_mut().ok_or("ffmpeg takes no pictures")?;
                input
                    .write_all(raster.pixels.as_flattened())
                    .map_err(|error| format!("ffmpeg has ended ({error})"))
            }
        }
    }

    fn end(self) -> Result<(), String> {
        match self {
            Self::Png(animation) => animation.end(),
            Self::Mp4(mut child) => {
                drop(child.stdin.take());
                let status = child.wait().map_err(|error| error.to_string())?;
                if status.success() { Ok(()) } else { Err(format!("ffmpeg failed ({status})")) }
            }
        }
    }
}

/// ffmpeg, which takes pixels and writes a film that players and slides show.
fn ffmpeg(file: &Path, [width, height]: [usize; 2], rate: u16) -> Result<Child, Failure> {
    let mut command = Command::new("ffmpeg");
    command.args(["-loglevel", "error", "-y", "-f", "rawvideo", "-pix_fmt", "rgb24"]);
    command.args(["-s", &format!("{width}x{height}"), "-r", &rate.to_string(), "-i", "-"]);
    // players want even numbers of pixels, and colors at half the resolution
    command.args(["-vf", "crop=trunc(iw/2)*2:trunc(ih/2)*2", "-pix_fmt", "yuv420p", "-crf", "18"]);
    command.arg(file).stdin(Stdio::piped());
    command.spawn().map_err(|error| {
        Failure::usage(format!(
            "{}: a .mp4 needs ffmpeg, which cannot be started ({error}): install it, or write an animated .png",
            file.display()
        ))
    })
}
