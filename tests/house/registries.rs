//! The registries that scenes choose from: each entry can be named, is documented, and keeps what its trait promises.

use crate::common::{Random, minus, norm};
use physics::contact::{self, ContactLaw, Pair, dot};
use physics::faces::{self, FaceCondition};
use physics::materials;
use physics::parameter::{Described, Entry, Kind, Parameter, Refusal, Values};
use physics::table::Table;
use std::array::from_fn;
use std::collections::BTreeSet;

/// Every default, and what else is in range where there is none.
fn defaults(parameters: &[Parameter]) -> Values {
    let mut values = Values::default();
    for Parameter { key, kind, .. } in parameters {
        match *kind {
            Kind::Number { default, least, .. } => {
                values.numbers.insert(key, default.unwrap_or(least.max(0.5)));
            }
            Kind::Choice(words) => {
                values.choices.insert(key, words[0].to_owned());
            }
            Kind::Flag(on) => {
                values.flags.insert(key, on);
            }
            Kind::Motion { .. } => {
                values.motions.insert(key, ramp());
            }
        }
    }
    values
}

/// A velocity that changes in time.
fn ramp() -> Table {
    Table(vec![(1.0, [3.0, -1.0, 0.5]), (2.0, [-2.0, 4.0, 0.25])])
}

fn built<T>(entries: &[Entry<T>]) -> impl Iterator<Item = (&'static str, T)> {
    entries.iter().map(|entry| {
        let made = (entry.build)(&defaults(entry.parameters));
        (entry.name, made.unwrap_or_else(|(key, problem)| panic!("{}: {key}: {problem}", entry.name)))
    })
}

/// Names and keys are unique, and the page on scenes has each of them with its meaning.
fn sound<T>(entries: &[Entry<T>]) {
    let page = sinew::input::documentation();
    let names: BTreeSet<_> = entries.iter().map(|entry| entry.name).collect();
    assert_eq!(names.len(), entries.len(), "two entries share a name");
    for entry in entries {
        let keys: BTreeSet<_> = entry.parameters.iter().map(|parameter| parameter.key).collect();
        assert_eq!(keys.len(), entry.parameters.len(), "{} repeats a key", entry.name);
        assert!(
            page.contains(&format!("`\"{}\"`", entry.name)) || page.contains(&format!("`{}`", entry.name))
        );
        assert!(
            !entry.summary.is_empty() && page.contains(entry.summary),
            "{} is not documented",
            entry.name
        );
        for parameter in entry.parameters {
            assert!(!parameter.meaning.is_empty(), "{}.{} means nothing", entry.name, parameter.key);
            // a parameter that says all is documented by its entry
            let sole = entry.parameters.len() == 1 && parameter.key == entry.name;
            let row = format!("| `{}` | {} |", parameter.key, parameter.meaning);
            assert!(sole || page.contains(&row), "{}.{} is not documented", entry.name, parameter.key);
        }
    }
    assert_eq!(built(entries).count(), entries.len());
}

#[test]
fn every_entry_has_a_name_of_its_own_and_is_documented() {
    sound(materials::LAWS);
    sound(contact::LAWS);
    sound(faces::CONDITIONS);
}

/// Whichever material comes first: the impulses are opposite. And contact takes relative motion away, it never adds any.
#[test]
fn contact_laws_exchange_opposite_impulses() {
    let mut random = Random(1);
    for (name, law) in built(contact::LAWS) {
        let mut acted = 0;
        for _ in 0..1000 {
            let n = random.vector();
            let pair = Pair {
                relative: random.vector(),
                reduced_mass: 10f64.powf(3.0 * random.sign()),
                normal: n.map(|x| x / norm(n)),
                traction: random.sign(),
            };
            let seen_by_b =
                Pair { relative: pair.relative.map(|v| -v), normal: pair.normal.map(|n| -n), ..pair };
            let (on_a, on_b) = (law.exchange(&pair), law.exchange(&seen_by_b));
            assert_eq!(on_a.normal, on_b.normal.map(|p| -p), "{name}");
            assert_eq!(on_a.friction, on_b.friction.map(|p| -p), "{name}");
            let impulse: [f64; 3] = from_fn(|a| on_a.normal[a] + on_a.friction[a]);
            let left: [f64; 3] = from_fn(|a| pair.relative[a] + impulse[a] / pair.reduced_mass);
            assert!(norm(left) <= norm(pair.relative) * (1.0 + 1e-15), "{name}");
            assert!(dot(on_a.friction, pair.normal).abs() <= 1e-15 * pair.reduced_mass, "{name}");
            acted += usize::from(norm(impulse) > 0.0);
        }
        assert!(acted > 100, "{name} never acts");
    }
}

/// What a face has corrected it leaves alone; one beyond which there is an image takes what the image turns, and
/// nothing else.
#[test]
fn face_conditions_correct_once() {
    let mut random = Random(2);
    for (name, condition) in built(faces::CONDITIONS) {
        let mut acted = false;
        for round in 0..300 {
            let (axis, time, v) = (round % 3, 3.0 * random.unit(), random.vector());
            let change = condition.correction(axis, time, v);
            let held: [f64; 3] = from_fn(|a| v[a] + change[a]);
            let again = condition.correction(axis, time, held);
            assert!(norm(again) <= 1e-15 * (1.0 + norm(held)), "{name} changes {held:?} by {again:?}");
            acted |= norm(change) > 0.0;
            if let Some(image) = condition.image() {
                let signs = image.signs(axis);
                assert!(signs[axis] < 0.0, "{name}: matter would cross the face");
                let turned: [f64; 3] = from_fn(|a| if signs[a] < 0.0 { -v[a] } else { 0.0 });
                assert_eq!(change, turned, "{name}");
            }
        }
        assert_eq!(acted, condition.acts(), "{name}");
    }
    let (_, first) = built(faces::CONDITIONS).next().expect("conditions");
    assert!(
        !first.acts() && faces::CONDITIONS[0].parameters.is_empty(),
        "a scene that names none has this one"
    );
}

#[test]
fn walls_follow_their_tables() {
    for (name, bonds) in [("velocity", true), ("plate", false)] {
        let (_, face) = built(faces::CONDITIONS).find(|(other, _)| *other == name).expect("walls");
        let wall = face.wall().expect("a wall");
        assert_eq!((wall.law.bond().is_some(), face.image(), face.acts()), (bonds, None, false));
        for (time, wanted) in [(0.0, [3.0, -1.0, 0.5]), (1.5, [0.5, 1.5, 0.375]), (9.0, [-2.0, 4.0, 0.25])] {
            let way = wall.course.way(time, time + 1e-6).map(|way| way / 1e-6);
            assert!(norm(minus(way, wanted)) < 1e-5, "{name} at {time} s: {way:?}");
        }
    }
}

/// Anything can have a registry: what describes itself and what is built from it need not be the same.
#[test]
fn an_entry_builds_what_its_registry_holds() {
    struct Spring;
    impl Described for Spring {
        const NAME: &'static str = "spring";
        const SUMMARY: &'static str = "Pulls back.";
        const PARAMETERS: &'static [Parameter] = &[
            Parameter::flag("stiff", true, "Whether it does so much."),
            Parameter::choice("kind", &["coil", "leaf"], "Its kind."),
        ];
        type Built = &'static str;
        fn build(values: &Values) -> Result<&'static str, Refusal> {
            match (values.flag("stiff"), values.choice("kind")) {
                (true, "leaf") => Err(("kind", "leaves bend".into())),
                _ => Ok("a spring"),
            }
        }
    }
    let entry = Entry::<String>::of::<Spring>();
    let mut values = defaults(entry.parameters);
    assert_eq!((entry.build)(&values).as_deref(), Ok("a spring"));
    values.choices.insert("kind", "leaf".into());
    assert_eq!((entry.build)(&values), Err(("kind", "leaves bend".to_owned())));
}
