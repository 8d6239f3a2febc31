//! What bonds make one at the nodes of a block.
use crate::node::{Impulse, Motion};
use crate::reactions::{NUMBERS, Reaction};
use engine::data::exact_sum::ExactSum;
use engine::data::fields::FieldId;
use engine::graph::task::At;
use grid::{Lattice, NODES};

/// The bonds between fields.
#[derive(Clone, Debug)]
pub struct Bonds {
    /// The fields, and the tile of `Reactions` of each, in the order of the scene.
    pub pairs: Vec<([FieldId; 2], usize)>,
    /// Where nodes are.
    pub lattice: Lattice,
}

/// Notes what a field receives from those with which it is one.
pub type Exchange<'a> = dyn FnMut(usize, [f64; 3], &mut [[ExactSum; NUMBERS]]) + 'a;

impl Bonds {
    /// Goes through all that is one, as [`each_group`], with what notes exchanges.
    pub fn each_group(
        &self,
        at: &At<'_>,
        impulses: &mut [Impulse],
        mut each: impl FnMut(usize, &[usize], &mut Exchange<'_>),
    ) {
        each_group(at.fields.len(), impulses, |n, members, impulses| {
            let x = self.lattice.position(at.node_of(n));
            each(n, members, &mut |slot, impulse, reactions| {
                impulses[NODES * slot + n].add(1.0, impulse, [0.0; 3]);
                // of two that are one, the first tells it; of more, the contact that names it first
                let field = at.fields[slot].field;
                if let Some((_, tile)) = self.pairs.iter().find(|(pair, _)| pair[0] == field) {
                    let mut reaction = Reaction::default();
                    reaction.add(x, impulse, [0.0; 3]);
                    reaction.store(&mut reactions[*tile]);
                }
            });
        });
    }
}

/// Goes through all that bonds make one: the node in the block, the places of its fields, and the impulses of the block.
pub fn each_group(
    fields: usize,
    impulses: &mut [Impulse],
    mut each: impl FnMut(usize, &[usize], &mut [Impulse]),
) {
    // where fields do not meet there are no impulses
    if impulses.is_empty() {
        return;
    }
    let mut members = Vec::new();
    for (n, first) in (0..NODES).flat_map(|n| (0..fields).map(move |slot| (n, slot))) {
        let group = 1 + first;
        if impulses[NODES * first + n].group() == group {
            members.clear();
            members.extend((first..fields).filter(|slot| impulses[NODES * slot + n].group() == group));
            each(n, &members, impulses);
        }
    }
}

/// The lines of the other fields that bonds make one with that of a line, at its node.
pub fn bonded_to(impulses: &[Impulse], fields: usize, line: usize) -> impl Iterator<Item = usize> + use<'_> {
    let group = impulses.get(line).map_or(0, Impulse::group);
    let lines = (0..if group > 0 { fields } else { 0 }).map(move |slot| NODES * slot + line % NODES);
    lines.filter(move |&other| other != line && impulses[other].group() == group)
}

/// Σ m v / Σ m
pub fn common_velocity<'a>(members: impl Iterator<Item = &'a Motion>) -> [f64; 3] {
    let (mut mass, mut momentum) = (0.0, [0.0; 3]);
    for motion in members {
        mass += motion.mass();
        (0..3).for_each(|a| momentum[a] += motion.mass() * motion.velocity()[a]);
    }
    momentum.map(|p| p / mass)
}
