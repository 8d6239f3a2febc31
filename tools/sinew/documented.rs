//! The commands that pages show are commands.
use super::Cli;
use clap::Parser;
use std::path::{Path, PathBuf};

/// All pages.
fn pages() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let in_folder = |folder: &str| {
        let entries = std::fs::read_dir(root.join(folder)).expect("a folder");
        entries.map(|entry| entry.expect("an entry").path()).collect::<Vec<_>>()
    };
    let problems = in_folder("problems").into_iter().map(|folder| folder.join("README.md"));
    let mut pages: Vec<PathBuf> = problems.filter(|page| page.exists()).collect();
    pages
        .extend(in_folder("docs").into_iter().filter(|page| page.extension().is_some_and(|end| end == "md")));
    pages.extend(["README.md", "CONTRIBUTING.md"].map(|page| root.join(page)));
    pages
}

/// Words of a line of a shell, quotes taken off; without a comment.
fn words(line: &str) -> Vec<String> {
    let (mut words, mut word, mut quote, mut begun) = (Vec::new(), String::new(), None, false);
    for c in line.chars() {
        match (quote, c) {
            (None, '\'' | '"') => (quote, begun) = (Some(c), true),
            (Some(q), c) if c == q => quote = None,
            (None, c) if c.is_whitespace() => {
                if begun {
                    words.push(std::mem::take(&mut word));
                }
                begun = false;
            }
            (None, '#') if !begun => return words,
            (_, c) => {
                word.push(c);
                begun = true;
            }
        }
    }
    if begun {
        words.push(word);
    }
    words
}

/// The words after `sinew` of a line of an indented block; those of `tools/run` are those of `sinew run`.
fn command(line: &str) -> Option<Vec<String>> {
    let line = line.strip_prefix("    ")?;
    let words = words(line);
    let run = words.iter().position(|word| word == "tools/run");
    // not where it is what another program is given
    let given = words.first().is_some_and(|word| word == "node" || word.starts_with("python"));
    let sinew = words.iter().position(|word| !given && (word == "sinew" || word.ends_with("/sinew")));
    let end = |rest: &[String]| {
        rest.iter().take_while(|word| !["|", ">", "&&", ";"].contains(&word.as_str())).cloned().collect()
    };
    match (run, sinew) {
        (Some(at), _) => {
            let rest: Vec<String> = end(&words[at + 1..]);
            // without a word it says how it is used
            (!rest.is_empty()).then(|| [vec!["run".to_owned()], rest].concat())
        }
        (None, Some(at)) if at + 1 < words.len() => Some(end(&words[at + 1..])),
        _ => None,
    }
}

#[test]
fn all_commands_of_all_pages_are_commands() {
    let mut found = 0;
    for page in pages() {
        let text = std::fs::read_to_string(&page).expect("a page");
        let text = text.replace("\\\n", " ");
        for line in text.lines() {
            let Some(words) = command(line) else { continue };
            // a place holder of a batch system, or of a reader
            if words.iter().any(|word| word.contains("...") || word.starts_with('$') && word.contains('@')) {
                continue;
            }
            let parsed = Cli::try_parse_from([vec!["sinew".to_owned()], words].concat());
            let said = parsed.err().filter(|error| error.exit_code() != 0);
            assert!(said.is_none(), "{}: {line}\n{}", page.display(), said.expect("an error"));
            found += 1;
        }
    }
    assert!(found > 30, "{found} commands");
}

#[test]
fn words_are_those_of_a_shell() {
    let of = |line: &str| command(line).map(|words| words.join("|"));
    assert_eq!(
        of("    tools/run problems/slab --set 'domain.cell=1 mm'  # a comment").as_deref(),
        Some("run|problems/slab|--set|domain.cell=1 mm")
    );
    assert_eq!(of("    mpirun -n 2 target/release/sinew run \"a b\" | tail").as_deref(), Some("run|a b"));
    assert_eq!(of("sinew run"), None, "it is no block");
}
