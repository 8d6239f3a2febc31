//! The `sinew` command, and what it says.
use std::path::Path;
use std::process::{Command, Output};

/// The value, or a panic that says why there is none.
#[track_caller]
pub fn ok<T, E: std::fmt::Display>(result: Result<T, E>) -> T {
    result.unwrap_or_else(|error| panic!("{error}"))
}

/// Runs `sinew`.
pub fn sinew(arguments: &[&str]) -> Output {
    ok(Command::new(assert_cmd::cargo::cargo_bin!("sinew")).args(arguments).output())
}

/// What a command has said. Messages are wrapped to the width of the terminal: here they are not.
pub fn words(output: &Output) -> String {
    let text =
        String::from_utf8_lossy(&output.stderr).into_owned() + &String::from_utf8_lossy(&output.stdout);
    text.replace('│', " ").split_whitespace().collect::<Vec<_>>().join(" ")
}

pub fn text(path: &Path) -> &str {
    path.to_str().expect("a path in UTF-8")
}

/// How often a test kills: `SINEW_TEST_KILLS`, if that is set.
pub fn kills(usually: usize) -> usize {
    std::env::var("SINEW_TEST_KILLS").ok().and_then(|n| n.parse().ok()).unwrap_or(usually)
}
