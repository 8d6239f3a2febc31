//! Fields: where several touch a node, each has numbers of its own there. A material has one field or more.
use std::ops::Range;

/// A field (for a body that moves, a velocity field).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct FieldId(u32);

impl FieldId {
    /// The field with a number.
    pub fn new(index: usize) -> Self {
        Self(index as u32)
    }

    /// Its number.
    #[inline(always)]
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// The fields of all materials, one material's after the other's.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Fields {
    /// The material of each field.
    materials: Vec<u32>,
    /// First field of each material, and the end.
    starts: Vec<u32>,
}

impl Fields {
    /// So many fields for each material.
    pub fn new(of_materials: impl IntoIterator<Item = usize>) -> Self {
        let mut fields = Self { materials: Vec::new(), starts: vec![0] };
        for (material, count) in (0..).zip(of_materials) {
            fields.materials.extend(std::iter::repeat_n(material, count));
            fields.starts.push(fields.materials.len() as u32);
        }
        fields
    }

    /// Number of fields.
    pub fn len(&self) -> usize {
        self.materials.len()
    }

    /// Whether there is no field.
    pub fn is_empty(&self) -> bool {
        self.materials.is_empty()
    }

    /// The material of a field.
    #[inline(always)]
    pub fn material(&self, field: FieldId) -> usize {
        self.materials[field.index()] as usize
    }

    /// Numbers of the fields of a material.
    #[inline(always)]
    pub fn of(&self, material: usize) -> Range<usize> {
        self.starts[material] as usize..self.starts[material + 1] as usize
    }
}

/// Which fields are somewhere: a bit each, as many words as they need.
#[derive(Clone, Copy, Debug)]
pub struct FieldSet<'a>(pub &'a [u64]);

impl FieldSet<'_> {
    /// Words that so many fields need.
    pub fn words(fields: usize) -> usize {
        fields.div_ceil(64).max(1)
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.0.iter().all(|&word| word == 0)
    }

    /// The fields, ascending.
    pub fn iter(&self) -> impl Iterator<Item = FieldId> {
        self.0.iter().enumerate().flat_map(|(at, &word)| {
            (0..64).filter(move |bit| word >> bit & 1 == 1).map(move |bit| FieldId::new(64 * at + bit))
        })
    }

    /// Whether these are just the fields of a list, which ascends.
    pub fn is(&self, list: &[FieldId]) -> bool {
        let count: u32 = self.0.iter().map(|word| word.count_ones()).sum();
        count as usize == list.len() && list.iter().all(|field| has(self.0, *field))
    }
}

/// Whether a set has a field.
#[inline(always)]
pub fn has(words: &[u64], field: FieldId) -> bool {
    words[field.index() / 64] >> (field.index() % 64) & 1 == 1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_follow_their_materials() {
        let fields = Fields::new([1, 3, 2]);
        assert_eq!((fields.len(), fields.of(1), fields.of(2)), (6, 1..4, 4..6));
        assert_eq!((0..6).map(|f| fields.material(FieldId::new(f))).collect::<Vec<_>>(), [0, 1, 1, 1, 2, 2]);
    }

    #[test]
    fn sets_have_no_limit() {
        let list = [0, 63, 64, 299].map(FieldId::new);
        let mut words = vec![0; FieldSet::words(300)];
        list.iter().for_each(|f| words[f.index() / 64] |= 1 << (f.index() % 64));
        let set = FieldSet(&words);
        assert_eq!(set.iter().collect::<Vec<_>>(), list);
        assert!(set.is(&list) && !set.is(&list[..3]) && !set.is_empty() && has(&words, list[3]));
    }
}
