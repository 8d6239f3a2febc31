//! Removes tasks whose results reach neither the next step nor an output.
use super::recipe::{Edge, Graph, Why};
use super::task::Mode;
use crate::schema::{Home, LabelId, Life};
use petgraph::stable_graph::NodeIndex;
use petgraph::visit::{Dfs, EdgeFiltered, Reversed};
use std::collections::{BTreeSet, HashSet};

/// Prunes until nothing changes; returns the names of what went and the labels that pass from step to step.
pub fn prune(graph: &mut Graph, outputs: &[LabelId]) -> (Vec<String>, BTreeSet<LabelId>) {
    let mut pruned = Vec::new();
    loop {
        let carried = carried(graph);
        let live = live(graph, |label| carried.contains(&label) || outputs.contains(&label));
        let dead: Vec<_> = graph.node_indices().filter(|n| !live.contains(n)).collect();
        if dead.is_empty() {
            return (pruned, carried);
        }
        pruned.extend(dead.into_iter().filter_map(|n| graph.remove_node(n)).map(|n| n.name));
    }
}

/// Labels that a task reads before any other task of the step writes them.
fn carried(graph: &Graph) -> BTreeSet<LabelId> {
    let reads_old = |node: NodeIndex, label: LabelId, mode: Mode| match mode {
        Mode::RequiresOld => true,
        Mode::Modifies | Mode::Requires => !graph
            .edges_directed(node, petgraph::Direction::Incoming)
            .any(|e| e.weight().label == label && e.weight().why == Why::Flow),
        _ => false,
    };
    let all = graph.node_indices().flat_map(|n| graph[n].declaration.access.iter().map(move |a| (n, a)));
    // what nodes keep passes from tick to tick, but for what is carried on purpose
    let passes = |label: LabelId| match label.home() {
        Home::Chunk => false,
        Home::Node => label.life() == Life::Carried,
        _ => true,
    };
    all.filter(|(_, a)| passes(a.label))
        .filter(|&(n, a)| reads_old(n, a.label, a.mode))
        .map(|(_, a)| a.label)
        .collect()
}

fn live(graph: &Graph, wanted: impl Fn(LabelId) -> bool) -> HashSet<NodeIndex> {
    let flow = EdgeFiltered::from_fn(graph, |e: petgraph::stable_graph::EdgeReference<'_, Edge>| {
        e.weight().why == Why::Flow
    });
    let writes_wanted =
        |n: &NodeIndex| graph[*n].declaration.access.iter().any(|a| a.mode.writes() && wanted(a.label));
    let mut live = HashSet::new();
    for root in graph.node_indices().filter(writes_wanted) {
        let upstream = Reversed(&flow);
        let mut walk = Dfs::new(upstream, root);
        while let Some(node) = walk.next(upstream) {
            live.insert(node);
        }
    }
    live
}
