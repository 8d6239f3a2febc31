//! Makes diagrams: columns from phases and exchanges, items in them, and links from the edges of the graph.
use super::{Diagram, ESTIMATE, Group, Item, Kind, Lane, Link, Runs, Source};
use crate::output::trace::measured::Measured;
use crate::simulation::rates::Cycle;
use engine::graph::build::TaskGraph;
use engine::graph::phase::{Stage, When};
use engine::graph::task::Domain;
use engine::graph::traffic::{Messages, Traffic, names};
use engine::schema::LabelId;
use std::collections::BTreeMap;

impl<'a> Diagram<'a> {
    /// One item a task and exchange.
    pub fn collapsed(
        graph: &'a TaskGraph,
        cycle: &'a Cycle,
        traffic: &'a Traffic,
        measured: Option<&'a Measured>,
    ) -> Self {
        Self::new(graph, cycle, traffic, measured, false)
    }

    /// One item a task and patch, halos one a pair of ranks, reductions and relocation one a rank.
    pub fn expanded(
        graph: &'a TaskGraph,
        cycle: &'a Cycle,
        traffic: &'a Traffic,
        measured: Option<&'a Measured>,
    ) -> Self {
        Self::new(graph, cycle, traffic, measured, true)
    }

    fn new(
        graph: &'a TaskGraph,
        cycle: &'a Cycle,
        traffic: &'a Traffic,
        measured: Option<&'a Measured>,
        expanded: bool,
    ) -> Self {
        let diagram = Self {
            graph,
            cycle,
            traffic,
            measured,
            estimate: ESTIMATE.to_owned(),
            expanded,
            runs: Runs::Alone,
            prefix: String::new(),
            columns: Vec::new(),
            lanes: Vec::new(),
            groups: Vec::new(),
            items: Vec::new(),
            links: Vec::new(),
            path: Vec::new(),
            path_ns: 0.0,
        };
        let mut builder = Builder { diagram, at: BTreeMap::new(), links: BTreeMap::new() };
        builder.lanes();
        builder.columns();
        builder.edges();
        let Builder { mut diagram, links, .. } = builder;
        diagram.links = links.into_values().collect();
        diagram.weigh();
        diagram.find_path();
        diagram
    }
}

/// An item's place: a patch, a rank, or two ranks; all `None` in a collapsed diagram.
pub(super) type Place = (Option<usize>, Option<usize>, Option<usize>);

/// Source, target, label, material and reason of a link.
pub(super) type Key = (usize, usize, LabelId, Option<usize>, u8);

pub(super) struct Builder<'a> {
    pub(super) diagram: Diagram<'a>,
    pub(super) at: BTreeMap<(Kind, Place), usize>,
    pub(super) links: BTreeMap<Key, Link>,
}

impl Builder<'_> {
    /// Everything in one lane; what waits below what each tick has; or a lane for each rank's exchanges and each patch.
    fn lanes(&mut self) {
        let Diagram { traffic, cycle, expanded, .. } = self.diagram;
        let lane = |title: String, rank| Lane { title, rank };
        self.diagram.lanes = if expanded {
            let ranks = (0..traffic.ranks).flat_map(|rank| {
                let of_rank = (0..traffic.patches()).filter(move |&p| traffic.rank_of[p] == rank);
                let patches = of_rank.map(move |p| lane(format!("patch {p}"), Some(rank)));
                std::iter::once(lane(format!("rank {rank}"), Some(rank))).chain(patches)
            });
            ranks.collect()
        } else if cycle.most.is_some() {
            vec![lane("in every tick".to_owned(), None), lane(String::new(), None)]
        } else {
            vec![lane(String::new(), None)]
        };
    }

    /// The lane of a patch, or of a rank.
    fn lane(&self, patch: Option<usize>, rank: Option<usize>) -> usize {
        let title = match (patch, rank) {
            (Some(patch), _) => format!("patch {patch}"),
            (None, Some(rank)) => format!("rank {rank}"),
            _ => return 0,
        };
        self.diagram.lanes.iter().position(|lane| lane.title == title).unwrap_or(0)
    }

    fn columns(&mut self) {
        let graph = self.diagram.graph;
        for (number, phase) in graph.phases.iter().enumerate() {
            if !phase.halos.is_empty() {
                self.exchange(Kind::Halo(number), &phase.halos);
            }
            if !phase.reductions.is_empty() {
                self.exchange(Kind::Reduction(Some(number)), &phase.reductions);
            }
            self.diagram.columns.push(format!("phase {number}"));
            phase.stages.iter().for_each(|stage| self.stage(stage));
        }
        if !graph.at_end.is_empty() {
            self.exchange(Kind::Reduction(None), &graph.at_end);
        }
        if graph.moves_particles() {
            self.exchange(Kind::Relocation, &[]);
        }
    }

    /// A column of exchanges.
    fn exchange(&mut self, kind: Kind, labels: &[LabelId]) {
        let traffic = self.diagram.traffic;
        let (word, pairs) = match kind {
            Kind::Halo(phase) => {
                ("Halo", traffic.halo(&self.diagram.graph.phases[phase], &self.diagram.graph.exchanges))
            }
            Kind::Relocation => ("Relocate", traffic.relocation()),
            _ => ("Reduce", traffic.reduce(labels)),
        };
        self.diagram.columns.push(word.to_owned());
        let name = format!("{word} {}", names(labels)).trim_end().to_owned();
        let sum = |wanted: &dyn Fn(usize, usize) -> bool| {
            let mut sum = Messages::default();
            pairs.iter().filter(|((a, b), _)| wanted(*a, *b)).for_each(|(_, m)| sum.add(m.count, m.bytes));
            sum
        };
        let places: Vec<(Place, Messages)> = match (self.diagram.expanded, kind) {
            (false, _) => vec![((None, None, None), sum(&|_, _| true))],
            (true, Kind::Halo(_)) => {
                pairs.iter().map(|(&(a, b), &m)| ((None, Some(a), Some(b)), m)).collect()
            }
            _ => (0..traffic.ranks).map(|r| ((None, Some(r), None), sum(&|from, _| from == r))).collect(),
        };
        for (place, messages) in places {
            let lane = self.lane(None, place.1);
            let group = self.group(String::new(), lane, false);
            self.item(kind, &name, labels, None, place, group, (0, messages));
        }
    }

    /// The items of a stage.
    fn stage(&mut self, stage: &Stage) {
        let traffic = self.diagram.traffic;
        if !self.diagram.expanded {
            let waits = self.diagram.cycle.most.is_some()
                && stage.material.is_some_and(|m| self.diagram.cycle.own[m].ticks > 1);
            let patches: Vec<usize> = (0..traffic.patches()).collect();
            self.stage_at(stage, (None, None, None), usize::from(waits), &patches);
        } else if stage.domain == Domain::Once {
            for rank in 0..traffic.ranks {
                self.stage_at(stage, (None, Some(rank), None), self.lane(None, Some(rank)), &[]);
            }
        } else {
            for patch in 0..traffic.patches() {
                let counts = if stage.domain == Domain::Nodes { &traffic.nodes } else { &traffic.particles };
                let count: u64 = stage.material.map_or(counts[patch].iter().sum(), |m| counts[patch][m]);
                if count > 0 {
                    let place = (Some(patch), Some(traffic.rank_of[patch]), None);
                    self.stage_at(stage, place, self.lane(Some(patch), None), &[patch]);
                }
            }
        }
    }

    fn stage_at(&mut self, stage: &Stage, place: Place, lane: usize, patches: &[usize]) {
        let title = self.title(stage);
        let group = self.group(title, lane, true);
        for &node in &stage.nodes {
            let it = &self.diagram.graph.graph[node];
            let (task, material) = (it.declaration, it.material);
            let work = self.diagram.work(&task, material, patches);
            self.item(Kind::Task(node), task.name, &[], material, place, group, (work, Messages::default()));
        }
    }

    fn title(&self, stage: &Stage) -> String {
        let cycle = self.diagram.cycle;
        let mut title = match (stage.domain, stage.material) {
            (Domain::Once, _) => "once".to_owned(),
            (Domain::Nodes, _) => "nodes".to_owned(),
            (_, material) => format!("particles of {}", self.diagram.material(material)),
        };
        if let (Some(_), Some(material)) = (cycle.most, stage.material) {
            title += if stage.when == When::Begin { "\nas its step begins" } else { "\nas its step ends" };
            let ticks = cycle.own[material].ticks;
            if ticks > 1 {
                title += &format!(" (about every {ticks} ticks)");
            }
        }
        title
    }

    fn group(&mut self, title: String, lane: usize, stage: bool) -> usize {
        let column = self.diagram.columns.len() - 1;
        self.diagram.groups.push(Group { title, column, lane, items: Vec::new(), stage });
        self.diagram.groups.len() - 1
    }

    #[allow(clippy::too_many_arguments)] // one place makes all items
    fn item(
        &mut self,
        kind: Kind,
        name: &str,
        labels: &[LabelId],
        material: Option<usize>,
        place: Place,
        group: usize,
        (work, messages): (u64, Messages),
    ) {
        let number = self.diagram.items.len();
        let (patch, rank, to_rank) = place;
        let column = self.diagram.groups[group].column;
        self.diagram.groups[group].items.push(number);
        self.at.insert((kind, place), number);
        self.diagram.items.push(Item {
            id: id(kind, place),
            kind,
            name: name.to_owned(),
            labels: labels.to_vec(),
            material,
            column,
            group,
            patch,
            rank,
            to_rank,
            work,
            messages,
            cost: 0.0,
            idle: None,
            source: Source::Estimated,
            critical: false,
        });
    }
}

/// A name without spaces: `t7`, `t7p0`, `h2`, `h2r0to1`, `r3`, `rend`, `moved`.
fn id(kind: Kind, (patch, rank, to): Place) -> String {
    let what = match kind {
        Kind::Task(node) => format!("t{}", node.index()),
        Kind::Halo(phase) => format!("h{phase}"),
        Kind::Reduction(Some(phase)) => format!("r{phase}"),
        Kind::Reduction(None) => "rend".to_owned(),
        Kind::Relocation => "moved".to_owned(),
    };
    match (patch, rank, to) {
        (Some(patch), _, _) => format!("{what}p{patch}"),
        (_, Some(rank), Some(to)) => format!("{what}r{rank}to{to}"),
        (_, Some(rank), _) => format!("{what}r{rank}"),
        _ => what,
    }
}
