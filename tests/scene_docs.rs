//! `docs/SCENE.md` says what the reader does.

#[test]
fn the_page_on_scenes_is_up_to_date() {
    let page = sinew::input::documentation();
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/SCENE.md");
    if std::env::var_os("SINEW_WRITE_DOCS").is_some() {
        std::fs::write(file, &page).expect("docs/SCENE.md can be written");
    }
    let written = std::fs::read_to_string(file).unwrap_or_default();
    assert!(written == page, "docs/SCENE.md is out of date: run `sinew scene-docs > docs/SCENE.md`");
}
