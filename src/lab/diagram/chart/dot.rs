//! A program for Graphviz.
use super::Chart;
use engine::graph::traffic::names;
use engine::program::{Delay, ProgramNode};
use std::fmt::Write;

impl Chart<'_> {
    /// A cluster a loop, a fused stage, and, where there are several, a graph. Solid edges carry data, dashed ones within a
    /// graph protect what is still read, dashed ones back carry data to the next round; the critical path is bold.
    pub fn to_dot(&self) -> String {
        let mut out = format!(
            "digraph {:?} {{\n  rankdir=LR;\n  node [shape=box, fontname=\"sans-serif\"];\n",
            self.program.name
        );
        self.dot_nodes(&self.program.nodes, (&mut 0, &mut 0), &mut out);
        self.diagrams.iter().for_each(|diagram| diagram.dot_links(&mut out));
        for ((from, to, delay), labels) in self.arrows() {
            let back = if delay == Delay::NextRound { ", style=dashed, constraint=false" } else { "" };
            let labels = names(&labels).replace(", ", "\\n");
            let _ = writeln!(
                out,
                "  {from} -> {to} [label=\"{labels}\", tooltip=\"{}\", color=\"#3b5b8c\"{back}];",
                delay.name()
            );
        }
        out.push_str("}\n");
        out
    }

    fn dot_nodes(&self, nodes: &[ProgramNode], (graph, round): (&mut usize, &mut usize), out: &mut String) {
        for node in nodes {
            match node {
                ProgramNode::Graph(it) if self.several() => {
                    let _ = writeln!(out, "  subgraph cluster_graph{graph} {{ label=\"graph {}\";", it.name);
                    self.diagrams[*graph].dot_groups(out);
                    out.push_str("  }\n");
                    *graph += 1;
                }
                ProgramNode::Graph(_) => self.diagrams[*graph].dot_groups(out),
                ProgramNode::Loop(it) => {
                    let title = it.title();
                    let _ = writeln!(
                        out,
                        "  subgraph cluster_loop{round} {{ label={title:?}; color=\"#3b5b8c\";"
                    );
                    *round += 1;
                    self.dot_nodes(&it.body, (graph, round), out);
                    out.push_str("  }\n");
                }
            }
        }
    }
}
