//! The table that scenes are read by.
use physics::law::{Law, MAX_HISTORY};
use physics::materials::{AnyLaw, LAWS, WithLaw};
use physics::parameter::{Entry, Kind, Values};
use physics::table::Table;

/// Every default, and 2 or the least value where there is none.
fn defaults(entry: &Entry<AnyLaw>) -> Values {
    let mut values = Values::default();
    for p in entry.parameters {
        match p.kind {
            Kind::Number { default, least, .. } => {
                values.numbers.insert(p.key, default.unwrap_or(least.max(2.0)));
            }
            Kind::Choice(words) => {
                values.choices.insert(p.key, words[0].to_string());
            }
            Kind::Flag(on) => {
                values.flags.insert(p.key, on);
            }
            Kind::Motion { .. } => {
                values.motions.insert(p.key, Table(vec![(0.0, [0.0; 3])]));
            }
        }
    }
    values
}

struct HistoryLength;

impl WithLaw for HistoryLength {
    type Output = usize;
    fn with<L: Law>(self, _: L) -> usize {
        L::HISTORY.len()
    }
}

fn entry(name: &str) -> &'static Entry<AnyLaw> {
    LAWS.iter().find(|entry| entry.name == name).unwrap()
}

#[test]
fn every_law_builds_from_its_defaults() {
    for entry in LAWS {
        let mut keys: Vec<_> = entry.parameters.iter().map(|p| p.key).collect();
        keys.sort_unstable();
        keys.dedup();
        assert_eq!(keys.len(), entry.parameters.len(), "{} repeats a key", entry.name);
        let law = (entry.build)(&defaults(entry)).unwrap();
        assert!(law.visit(HistoryLength) <= MAX_HISTORY);
    }
}

#[test]
fn one_word_chooses_among_the_tissues() {
    let tissue = entry("tissue");
    let mut values = defaults(tissue);
    let AnyLaw::FailingTissue(law) = (tissue.build)(&values).unwrap() else { panic!("fails by default") };
    assert_eq!((law.failure.stretch, law.failure.span), (1.4, 1.0));
    values.choices.insert("strain", "right-cauchy-green".into());
    values.choices.insert("inversion", "fail".into());
    values.flags.insert("keep-compression", true);
    let AnyLaw::FailingTissue(law) = (tissue.build)(&values).unwrap() else { panic!("still fails") };
    assert_eq!((law.failure.span, law.failure.keeps_pressure, law.failure.crushes), (0.5, 0xFF, 0xFF));
    values.choices.insert("failure", "none".into());
    assert_eq!((tissue.build)(&values).unwrap_err().0, "inversion");
    values.choices.insert("inversion", "error".into());
    assert!(matches!((tissue.build)(&values), Ok(AnyLaw::Tissue(_))));
}
