//! Particles to compare, from frames and from checkpoints.
use super::{Column, Particles};
use crate::output::Result;
use crate::output::checkpoint::Reader;
use crate::output::snapshot::Snapshot;
use engine::schema::{Combine, Label, LabelId};
use tasks::labels::{self, SCHEMA};

/// All of a frame.
pub fn frame_particles(frame: Snapshot) -> Particles {
    let positions: Vec<[f64; 3]> = frame.positions.iter().map(|x| x.map(f64::from)).collect();
    let position =
        Column { label: "position".into(), components: 3, values: positions.as_flattened().to_vec() };
    let columns = frame.columns.into_iter().map(|(field, values)| Column {
        label: field.name,
        components: field.components,
        values: in_rows(field.components, values.into_iter().map(f64::from).collect()),
    });
    Particles {
        identities: frame.identities,
        materials: frame.materials.iter().map(|&m| m.into()).collect(),
        positions,
        columns: std::iter::once(position).chain(columns).collect(),
    }
}

/// Symmetric tensors row by row (xx, xy, xz, yy, yz, zz), as checkpoints have them, of those that VTK has: xx, yy, zz, xy, yz, xz.
fn in_rows(components: usize, mut values: Vec<f64>) -> Vec<f64> {
    if components == 6 {
        for tensor in values.as_chunks_mut::<6>().0 {
            let [xx, yy, zz, xy, yz, xz] = *tensor;
            *tensor = [xx, xy, xz, yy, yz, zz];
        }
    }
    values
}

/// One material of a checkpoint.
///
/// # Errors
/// If it cannot be read.
pub fn checkpoint_particles(reader: &Reader, material: usize) -> Result<Particles> {
    let stored = &reader.head.materials[material];
    let columns = reader.columns(material, &(0..stored.rows))?;
    let named = stored.labels.iter().zip(columns);
    let columns: Vec<Column> = named
        .map(|((label, components), values)| Column { label: label.clone(), components: *components, values })
        .collect();
    let of = |label: LabelId| columns.iter().find(|c| c.label == label.name()).map_or(&[][..], |c| &c.values);
    let identities: Vec<u64> = of(labels::Identity::ID).iter().map(|x| x.to_bits()).collect();
    let positions = of(labels::Position::ID).as_chunks().0.to_vec();
    let columns = columns.into_iter().filter(|c| c.label != labels::Identity::ID.name()).collect();
    Ok(Particles { materials: vec![material; identities.len()], identities, positions, columns })
}

/// What a checkpoint has besides particles, by name. Exact sums are digits, of which only the bits can be compared; they are
/// left out for a comparison by `value`.
pub fn checkpoint_shared(reader: &Reader, by_value: bool) -> Vec<(String, Vec<f64>)> {
    let is_value = |name: &str| SCHEMA.find(name).is_some_and(|label| label.combine() == Combine::None);
    let shared = reader.head.shared.iter().filter(|(name, _)| !by_value || is_value(name));
    let numbers = |words: &Vec<u64>| words.iter().map(|&word| f64::from_bits(word)).collect();
    let ledger = ("ledger".to_owned(), reader.head.ledger.clone());
    shared.map(|(name, words)| (name.clone(), numbers(words))).chain([ledger]).collect()
}
