//! Bytes as a scene: it is read, or refused in words that say where and fit a screen.
#![no_main]
#[path = "../../tests/common/told.rs"]
mod told;

use libfuzzer_sys::fuzz_target;
use sinew::input::identity::first_difference;
use sinew::input::read_text;

/// So few particles that each scene takes milliseconds.
const MEMORY: usize = 2 << 20;

fuzz_target!(|bytes: &[u8]| {
    // what stands behind a NUL is an override
    let (text, set) = match bytes.iter().position(|byte| *byte == 0) {
        Some(at) => (&bytes[..at], &bytes[at + 1..]),
        None => (bytes, &[][..]),
    };
    let (text, set) = (String::from_utf8_lossy(text), String::from_utf8_lossy(set));
    let set: Vec<_> =
        set.split_once('=').map(|(key, value)| (key.to_owned(), value.to_owned())).into_iter().collect();
    match read_text("scene.toml", &text, &set, Some(MEMORY)) {
        Ok(scene) => {
            // a restart reads it so
            let again =
                read_text("again", &scene.resolved, &[], Some(MEMORY)).expect("what was resolved is read");
            assert_eq!(first_difference(&scene.resolved, &again.resolved), None);
        }
        Err(error) => drop(told::told(&error).expect("words for people")),
    }
});
