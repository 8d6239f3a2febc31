//! Which materials add to which labels of nodes.
use crate::schema::LabelId;

/// Labels with the materials that add to them. Asked for every block: quick to read.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Adders(Vec<(LabelId, Vec<bool>)>);

impl Adders {
    /// Nobody.
    pub const fn new() -> Self {
        Self(Vec::new())
    }

    /// Notes that a material adds to a label.
    pub fn insert(&mut self, label: LabelId, material: usize) {
        let known = self.0.iter().position(|(other, _)| *other == label);
        let at = known.unwrap_or_else(|| {
            self.0.push((label, Vec::new()));
            self.0.len() - 1
        });
        let materials = &mut self.0[at].1;
        materials.resize(materials.len().max(material + 1), false);
        materials[material] = true;
    }

    /// Whether a material adds to a label.
    pub fn contains(&self, label: LabelId, material: usize) -> bool {
        let materials = self.0.iter().find(|(other, _)| *other == label);
        materials.is_some_and(|(_, materials)| materials.get(material) == Some(&true))
    }
}
