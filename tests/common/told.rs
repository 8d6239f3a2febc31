//! What every refusal of a scene must fulfil, whatever the scene.
#![allow(dead_code)] // each test takes what it needs

use miette::{GraphicalReportHandler, GraphicalTheme};
use sinew::input::SceneError;

/// Bytes of a report that still fit a screen that scrolls.
const LONGEST: usize = 20_000;

/// All that is wrong, each with its line.
pub fn faults(error: &SceneError) -> Vec<(Option<usize>, String)> {
    std::iter::once(error).chain(error.more()).map(|error| (error.line(), error.to_string())).collect()
}

/// The error as people see it.
///
/// # Errors
/// What keeps people from finding the fault: it has no place, is too long, or does something to the terminal.
pub fn told(error: &SceneError) -> Result<String, String> {
    let mut report = String::new();
    GraphicalReportHandler::new_themed(GraphicalTheme::unicode_nocolor())
        .with_width(100)
        .render_report(&mut report, error)
        .map_err(|error| format!("the report cannot be written: {error}"))?;
    if report.len() > LONGEST {
        return Err(format!(
            "the report has {} bytes:\n{}",
            report.len(),
            &report[..report.floor_char_boundary(2_000)]
        ));
    }
    if let Some(control) = report.chars().find(|c| c.is_control() && *c != '\n') {
        return Err(format!("{control:?} reaches the terminal:\n{report:?}"));
    }
    let counted = |message: &str| message.starts_with("and ") && message.ends_with(" more");
    for error in std::iter::once(error).chain(error.more()) {
        let message = error.to_string();
        if message.trim().is_empty() {
            return Err(format!("a fault without words:\n{report}"));
        }
        if error.line().is_none() && !report.contains("--set") && !counted(&message) {
            return Err(format!("{message:?} has no line:\n{report}"));
        }
    }
    Ok(report)
}
