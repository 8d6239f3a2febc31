//! Which labels a material's particles have, and which labels nodes have: how much memory, and where in it.
use crate::schema::{Home, Inert, LabelId, Life, Schema};
use std::collections::BTreeMap;

/// Which particle labels a material has, and how many lines a tile each takes.
#[derive(Clone, Debug)]
pub struct ParticleLayout {
    /// Lines a tile of each label of the schema; 0: the material does not have it.
    pub widths: Vec<usize>,
    /// Lines a tile of all labels before each label.
    pub starts: Vec<usize>,
    /// Lines a tile of all labels.
    pub total: usize,
    labels: Vec<LabelId>,
    /// The label that says where a particle is.
    pub(super) position: LabelId,
    /// What labels whose tiles the material decides hold where there is no particle.
    of_material: BTreeMap<LabelId, Vec<f64>>,
}

impl ParticleLayout {
    /// The layout of a material that needs `labels`. `of_material` says, of each label whose tiles the material decides,
    /// what a tile holds where there is no particle.
    pub fn new(
        schema: &'static Schema,
        labels: impl IntoIterator<Item = LabelId>,
        of_material: BTreeMap<LabelId, Vec<f64>>,
    ) -> Self {
        let mut widths = vec![0; schema.len()];
        for label in labels {
            debug_assert_eq!(label.home(), Home::Particle);
            let elements = if label.by_material() { of_material.get(&label).map_or(0, Vec::len) } else { 1 };
            widths[label.index()] = label.width() * elements;
        }
        let mut starts = vec![0; schema.len()];
        let mut total = 0;
        for (start, width) in starts.iter_mut().zip(&widths) {
            *start = total;
            total += width;
        }
        let labels = schema.labels().filter(|label| widths[label.index()] > 0).collect();
        Self { widths, starts, total, labels, position: schema.roles.position, of_material }
    }

    /// The labels in the layout, in the order of the schema.
    pub fn labels(&self) -> impl Iterator<Item = LabelId> + Clone + '_ {
        self.labels.iter().copied()
    }

    /// Those that are the state of particles: all but what is known from the start.
    pub fn state_labels(&self) -> impl Iterator<Item = LabelId> + Clone + '_ {
        self.labels().filter(|label| !label.is_known())
    }

    /// Lines a tile of a label.
    #[inline(always)]
    pub fn width(&self, label: LabelId) -> usize {
        self.widths[label.index()]
    }

    /// What a component of a label holds where there is no particle, in a block with its middle at `middle` [m].
    pub fn inert(&self, label: LabelId, component: usize, middle: [f64; 3]) -> f64 {
        match label.inert() {
            Inert::Zero => 0.0,
            Inert::Numbers(numbers) => numbers[component],
            Inert::Middle => middle[component],
            Inert::OfMaterial => self.of_material.get(&label).map_or(0.0, |numbers| numbers[component]),
        }
    }

    /// The numbers of a lane without a particle, label after label.
    pub fn inert_record(&self, middle: [f64; 3]) -> Vec<f64> {
        let of = |label| (0..self.width(label)).map(move |component| self.inert(label, component, middle));
        self.labels().flat_map(of).collect()
    }
}

/// Which labels of nodes there are: those that blocks of nodes keep, and those for which blocks of particles have buffers.
#[derive(Clone, Debug)]
pub struct NodeLayout {
    stored: Vec<LabelId>,
    partial: Vec<LabelId>,
    /// Place of each label of the schema among the stored ones and among the partial ones.
    places: Vec<[Option<u16>; 2]>,
    /// Nodes of a block.
    pub nodes: usize,
    /// Nodes of a buffer.
    pub buffer: usize,
}

impl NodeLayout {
    /// The layout for `labels` on blocks of a shape.
    pub fn new(
        schema: &'static Schema,
        labels: impl IntoIterator<Item = LabelId>,
        shape: &grid::BlockShape,
    ) -> Self {
        let mut all: Vec<LabelId> = labels.into_iter().filter(|label| label.home() == Home::Node).collect();
        all.sort_unstable();
        all.dedup();
        let stored: Vec<_> = all.iter().copied().filter(|label| label.is_stored_on_nodes()).collect();
        let partial: Vec<_> = all.into_iter().filter(|label| label.is_partial()).collect();
        let place = |list: &[LabelId], label| list.iter().position(|l| *l == label).map(|at| at as u16);
        let places = schema.labels().map(|label| [place(&stored, label), place(&partial, label)]).collect();
        Self { stored, partial, places, nodes: shape.node_count(), buffer: shape.buffer_len() }
    }

    /// The labels that blocks of nodes keep.
    pub fn stored(&self) -> &[LabelId] {
        &self.stored
    }

    /// Those of them that pass from step to step.
    pub fn carried(&self) -> impl Iterator<Item = LabelId> + '_ {
        self.stored.iter().copied().filter(|label| label.life() == Life::Carried)
    }

    /// The labels for which blocks of particles have buffers.
    pub fn partial(&self) -> &[LabelId] {
        &self.partial
    }

    /// Place of a label among those that blocks of nodes keep.
    #[inline(always)]
    pub fn stored_place(&self, label: LabelId) -> Option<usize> {
        self.places[label.index()][0].map(usize::from)
    }

    /// Place of a label among those with buffers.
    #[inline(always)]
    pub fn partial_place(&self, label: LabelId) -> Option<usize> {
        self.places[label.index()][1].map(usize::from)
    }
}
