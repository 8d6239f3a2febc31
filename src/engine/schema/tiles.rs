use super::{Home, LabelId};
use std::collections::BTreeMap;

/// How many tiles labels of the run have: one, where nothing is said.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tiles(BTreeMap<LabelId, usize>);

impl Tiles {
    /// Tiles of a shared label, where there are so many materials.
    pub fn of(&self, label: LabelId, materials: usize) -> usize {
        match label.home() {
            Home::Material => materials,
            _ => self.0.get(&label).copied().unwrap_or(1),
        }
    }

    /// A label has so many tiles.
    ///
    /// # Panics
    /// If its row does not leave that open (`several`): an error in the application.
    pub fn set(&mut self, label: LabelId, count: usize) {
        assert!(label.is_several(), "{} has one tile", label.name());
        self.0.insert(label, count);
    }
}
