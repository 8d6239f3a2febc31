//! `docs/SCENE.md` says what the reader does, `docs/FIELDS.md` what frames show.

fn is_up_to_date(name: &str, page: &str, command: &str) {
    let file = format!("{}/docs/{name}", env!("CARGO_MANIFEST_DIR"));
    if std::env::var_os("SINEW_WRITE_DOCS").is_some() {
        std::fs::write(&file, page).expect("the page can be written");
    }
    let written = std::fs::read_to_string(&file).unwrap_or_default();
    assert!(written == page, "docs/{name} is out of date: run `sinew {command} > docs/{name}`");
}

#[test]
fn the_page_on_scenes_is_up_to_date() {
    is_up_to_date("SCENE.md", &sinew::input::documentation(), "scene-docs");
}

#[test]
fn the_page_on_fields_is_up_to_date() {
    is_up_to_date("FIELDS.md", &sinew::input::documentation_of_fields(), "scene-docs fields");
}
