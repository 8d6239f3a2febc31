//! Runs whose frames are drawn, and what pictures, films and plots have together.
use super::fail::Failure;
use super::wound::{frames_of, scene_of};
use physics::parameter::Dimension;
use scene::Scene;
use sinew::input::units;
use sinew::lab::figure::Format;
use sinew::lab::picture::{self, Coloring, Request, Subject, Survey};
use sinew::output::frame::Frame;
use sinew::output::snapshot::Snapshot;
use sinew::output::vtkhdf::Reader;
use std::path::{Path, PathBuf};

/// A length with its unit [m].
pub fn length(text: &str, option: &str) -> Result<f64, Failure> {
    units::parse(text, Dimension::Length).map_err(|problem| {
        let units = units::accepted(Dimension::Length);
        Failure::usage(format!("{option} {problem}; write for example {option} \"85 mm\" (units: {units})"))
    })
}

/// Refuses a picture of nothing.
pub fn refuse_nothing(survey: &Survey, request: &Request) -> Result<(), Failure> {
    if !survey.is_empty() {
        return Ok(());
    }
    let words = request.cut.words();
    let place = if words.is_empty() { "in these frames".to_owned() } else { format!("in the {words}") };
    Err(Failure::usage(format!("there is nothing to draw {place}: no particle lies there")))
}

/// A run whose frames are drawn.
pub struct Run {
    folder: PathBuf,
    pub scene: Scene,
    pub reader: Reader,
    first: Option<Snapshot>,
}

impl Run {
    /// The run in a folder.
    pub fn open(folder: &Path) -> Result<Self, Failure> {
        let (reader, scene) = (frames_of(folder)?, scene_of(folder)?);
        if reader.frames() == 0 {
            return Err(Failure::usage(format!("{} holds no frame yet", folder.display())));
        }
        // what is loose is known from the first frame
        let first = scene.output.wound.is_some().then(|| reader.frame_with(0, &["failure"])).transpose()?;
        Ok(Self { folder: folder.to_owned(), scene, reader, first })
    }

    /// Frames by their numbers.
    pub fn frames(&self, numbers: &[usize]) -> Result<Vec<Snapshot>, Failure> {
        numbers.iter().map(|&number| Ok(self.reader.frame(number)?)).collect()
    }

    /// Frames with what is needed to draw them.
    pub fn subjects<'a>(&'a self, frames: &'a [Snapshot]) -> Vec<Subject<'a>> {
        let first = self.first.as_ref().map(|first| first as &dyn Frame);
        frames.iter().map(|frame| Subject { frame, first, scene: &self.scene }).collect()
    }

    /// The section and the exit of a frame, or of the last; the files written.
    pub fn standard(
        &self,
        number: Option<usize>,
        style: impl Fn(Request) -> Result<Request, Failure>,
    ) -> Result<Vec<PathBuf>, Failure> {
        let last = self.reader.frames() - 1;
        let frames = self.frames(&[number.unwrap_or(last)])?;
        let subjects = self.subjects(&frames);
        let coloring = Coloring::of(&frames[0]);
        let end = number.map_or(String::new(), |number| format!("-{number:04}"));
        let mut written = Vec::new();
        let requests = [
            ("section", Some(Request::section(&self.scene, coloring.clone()))),
            ("exit", Request::exit(&self.scene, coloring)),
        ];
        for (name, request) in requests {
            let Some(request) = request else { continue };
            let (request, file) = (style(request)?, self.folder.join(format!("{name}{end}.png")));
            let figure = picture::draw(&request, &subjects).map_err(Failure::usage)?;
            figure.write(&file, Format::Png, request.dpi)?;
            written.push(file);
        }
        Ok(written)
    }
}

/// Draws the last frame of the run in `folder`; the files written.
pub fn draw(folder: &Path) -> Result<Vec<PathBuf>, Failure> {
    Run::open(folder)?.standard(None, Ok)
}
