//! Which override is at fault, where the file alone would not be.
use super::error::Fault;
use super::source::Place;
use std::collections::HashSet;

/// Gives faults that the file has with an override alone to that override. `without` reads the scene without one of them, by
/// its number: what is wrong then?
pub(super) fn overrides(
    mut fault: Fault,
    overrides: &[(String, String)],
    without: impl Fn(usize) -> Option<Fault>,
) -> Fault {
    let found = places(&fault);
    for (index, (key, _)) in overrides.iter().enumerate() {
        let others = without(index).as_ref().map(places).unwrap_or_default();
        // without one that mends something, other things are wrong, which says nothing
        if !others.is_subset(&found) {
            continue;
        }
        let place = Place { source: index + 1, start: 0, end: key.trim().len() };
        fault.each_mut(&mut |it| {
            if it.place.source == 0 && !others.contains(&it.place) {
                it.give_to(place);
            }
        });
    }
    fault
}

fn places(fault: &Fault) -> HashSet<Place> {
    let mut all = HashSet::new();
    fault.visit(&mut |it| {
        all.insert(it.place);
    });
    all
}
