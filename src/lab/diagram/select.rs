//! Parts of a diagram, and how much of one can be drawn.
use super::{Diagram, Item};
use std::collections::BTreeSet;

/// The most items that pictures show.
pub const MOST_DRAWN: usize = 3000;

impl Diagram<'_> {
    /// Keeps the items that are `wanted`, those next to them, and the links that begin or end at a wanted one.
    pub fn keep(&mut self, wanted: impl Fn(&Item) -> bool) {
        let center: BTreeSet<usize> = (0..self.items.len()).filter(|&at| wanted(&self.items[at])).collect();
        self.links.retain(|link| center.contains(&link.from) || center.contains(&link.to));
        let beside = self.links.iter().flat_map(|link| [link.from, link.to]);
        let kept: BTreeSet<usize> = center.iter().copied().chain(beside).collect();
        let mut moved = vec![None; self.items.len()];
        kept.iter().enumerate().for_each(|(to, &from)| moved[from] = Some(to));
        let renumber = |list: &mut Vec<usize>| *list = list.iter().filter_map(|&at| moved[at]).collect();
        let mut number = 0;
        self.items.retain(|_| {
            number += 1;
            kept.contains(&(number - 1))
        });
        self.groups.iter_mut().for_each(|group| renumber(&mut group.items));
        renumber(&mut self.path);
        for link in &mut self.links {
            if let (Some(from), Some(to)) = (moved[link.from], moved[link.to]) {
                (link.from, link.to) = (from, to);
            }
        }
    }

    /// Lets ids begin with `prefix`, so that they are unique among the graphs of a program.
    pub(super) fn rename(&mut self, prefix: &str) {
        self.items.iter_mut().for_each(|item| item.id = format!("{prefix}{}", item.id));
        self.prefix = prefix.to_owned();
    }
}

/// Refuses a picture of more items than anyone can look at.
///
/// # Errors
/// Too many items; the message says what to do.
pub(super) fn drawable(items: usize) -> Result<(), String> {
    match items {
        many if many > MOST_DRAWN => Err(format!(
            "a picture of {many} items shows nothing (at most {MOST_DRAWN}): give fewer --patches, show a part with --patch P or --rank R, or write --format json or dot"
        )),
        _ => Ok(()),
    }
}
