//! Parts of shared labels from all ranks come together.
use super::{Network, NetworkError, collective};
use crate::data::reduction;
use crate::data::shared::Shared;
use crate::schema::{Home, LabelId};
use simd::{LANES, Wide};
use std::ops::Range;

/// Numbers that are summed over the ranks beside the labels (wrapping).
pub type Counters = [u64; LANES];

/// Reduces `labels` over all ranks, in one go with `counters`. Of labels that each material keeps, only those of materials
/// for which `fresh` holds: the others have been reduced before. What nobody `contributes` to is the same on all ranks, and stays.
///
/// # Errors
/// If a rank is gone.
pub fn reduce(
    network: &mut dyn Network,
    labels: &[LabelId],
    fresh: impl Fn(usize) -> bool,
    contributes: impl Fn(LabelId, usize) -> bool,
    shared: &mut Shared,
    counters: &mut Counters,
) -> Result<(), NetworkError> {
    if network.size() == 1 {
        return Ok(());
    }
    let pieces: Vec<(LabelId, Range<usize>)> =
        labels.iter().flat_map(|&label| pieces(label, shared.column(label).len(), &fresh)).collect();
    let mut message: Vec<Wide> = vec![bytemuck::cast(*counters)];
    for (label, lines) in &pieces {
        message.extend_from_slice(&shared.column(*label)[lines.clone()]);
    }
    collective::reduce(network, &mut message, |into, from| {
        let mut at = 1;
        let counts: &mut [u64] = bytemuck::cast_slice_mut(&mut into[..1]);
        let more: &[u64] = bytemuck::cast_slice(&from[..1]);
        counts.iter_mut().zip(more).for_each(|(a, &b)| *a = a.wrapping_add(b));
        for (label, lines) in &pieces {
            let here = at..at + lines.len();
            let material = if label.home() == Home::Material { lines.start / label.width() } else { 0 };
            if contributes(*label, material) {
                reduction::merge(label.combine(), &mut into[here.clone()], &from[here.clone()]);
            }
            at = here.end;
        }
    })?;
    *counters = bytemuck::cast(message[0]);
    let mut rest = &message[1..];
    for (label, lines) in pieces {
        let (part, after) = rest.split_at(lines.len());
        shared.column_mut(label)[lines].copy_from_slice(part);
        rest = after;
    }
    Ok(())
}

/// The lines of a label that take part.
fn pieces(label: LabelId, lines: usize, fresh: impl Fn(usize) -> bool) -> Vec<(LabelId, Range<usize>)> {
    match label.home() {
        Home::Material => {
            let tile = |material: usize| material * label.width()..(material + 1) * label.width();
            let materials = (0..lines / label.width()).filter(|&material| fresh(material));
            materials.map(|material| (label, tile(material))).collect()
        }
        _ => vec![(label, 0..lines)],
    }
}
