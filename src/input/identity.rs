//! What of a resolved scene determines its physics: all but names for people, where a run ends, how it is computed and
//! what is written.
use twox_hash::XxHash3_128;

/// Keys that a restart may change. `output` stands for all that is in it.
const FREE: [&str; 7] =
    ["title", "run.until", "run.steps", "run.patches", "run.threads", "run.rebalance-every", "output"];

/// A hash of all that determines the physics of a resolved scene: 32 hexadecimal digits.
pub fn fingerprint(resolved: &str) -> String {
    let mut hasher = XxHash3_128::new();
    for (key, value) in values(resolved) {
        hasher.write(format!("{key} = {value}\n").as_bytes());
    }
    format!("{:032x}", hasher.finish_128())
}

/// The first key by which a run of one resolved scene cannot go on as one of the other, with what each says: its physics,
/// and what its frames show, which is one for all of a run.
pub fn first_difference(one: &str, other: &str) -> Option<String> {
    let all = |resolved: &str| [values(resolved), shown(resolved)].concat();
    let (one, other) = (all(one), all(other));
    let same = one.iter().zip(&other).take_while(|(a, b)| a == b).count();
    match (one.get(same), other.get(same)) {
        (None, None) => None,
        (Some((key, a)), Some((other, b))) if key == other => {
            Some(format!("{key} is {a} there and {b} here"))
        }
        (Some((key, a)), there) if there.is_none() || !other.iter().any(|(k, _)| k == key) => {
            Some(format!("{key} is {a} there and not given here"))
        }
        (_, Some((key, b))) if !one.iter().any(|(k, _)| k == key) => {
            Some(format!("{key} is {b} here and not given there"))
        }
        (Some((key, _)), _) | (_, Some((key, _))) => Some(format!("{key} stands at another place")),
    }
}

/// All values that determine the physics by dotted key, in their order, which is that of materials and bodies.
fn values(resolved: &str) -> Vec<(String, String)> {
    let mut found = Vec::new();
    match resolved.parse::<toml::Table>() {
        Ok(table) => visit("", &toml::Value::Table(table), &mut found),
        Err(_) => found.push((String::new(), resolved.to_owned())),
    }
    found
}

/// What frames show, if the scene says so.
fn shown(resolved: &str) -> Vec<(String, String)> {
    let table = resolved.parse::<toml::Table>().unwrap_or_default();
    let fields = table.get("output").and_then(|output| output.get("fields"));
    fields.map(|fields| ("output.fields".to_owned(), fields.to_string())).into_iter().collect()
}

fn visit(path: &str, value: &toml::Value, found: &mut Vec<(String, String)>) {
    // the digest of a mesh tells what it is, and not where it lies
    if FREE.contains(&path) || path.ends_with(".mesh.file") {
        return;
    }
    // whether particles that leave are deleted, or end the run, says nothing of those before; mirrors have accounts
    if path == "run.leaving" && value.as_str() != Some("reflect") {
        return;
    }
    match value {
        toml::Value::Table(table) => {
            table.iter().for_each(|(key, value)| visit(&super::document::dotted(path, key), value, found));
        }
        toml::Value::Array(items) if items.iter().any(toml::Value::is_table) => {
            let items = items.iter().enumerate();
            items.for_each(|(i, item)| visit(&super::document::dotted(path, &i.to_string()), item, found));
        }
        leaf => found.push((path.to_owned(), leaf.to_string())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SCENE: &str =
        "title = 'a'\n[material.soft]\ndensity = 1.0\n[run]\nuntil = 1.0\ncfl = 0.4\n[output]\nframes = 3\n";

    #[test]
    fn the_end_of_a_run_and_its_output_do_not_identify_it() {
        let other =
            SCENE.replace("until = 1.0", "until = 2.0\nthreads = 2").replace("frames = 3", "frames = 4");
        assert_eq!(first_difference(SCENE, &other), None);
        assert_eq!(fingerprint(SCENE), fingerprint(&other));
    }

    #[test]
    fn what_becomes_of_particles_that_leave_may_change_unless_they_come_back() {
        let with = |word: &str| SCENE.replace("cfl", &format!("leaving = '{word}'\ncfl"));
        assert_eq!(first_difference(&with("error"), &with("delete")), None);
        let said = first_difference(&with("error"), &with("reflect")).expect("other physics");
        assert!(said.contains("run.leaving is \"reflect\" here"), "{said}");
    }

    #[test]
    fn the_first_difference_is_named() {
        let other = SCENE.replace("0.4", "0.2");
        assert_ne!(fingerprint(SCENE), fingerprint(&other));
        assert_eq!(first_difference(SCENE, &other).as_deref(), Some("run.cfl is 0.4 there and 0.2 here"));
        let more = SCENE.replace("cfl", "viscosity = 1\ncfl");
        assert_eq!(
            first_difference(SCENE, &more).as_deref(),
            Some("run.viscosity is 1 here and not given there")
        );
        let less = first_difference(&more, SCENE);
        assert_eq!(less.as_deref(), Some("run.viscosity is 1 there and not given here"));
    }
}
