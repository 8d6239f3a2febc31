//! A program in lines: its outline, then each graph.
use super::Chart;
use engine::graph::traffic::names;
use engine::program::Delay;
use std::fmt::Write;

impl Chart<'_> {
    /// The outline; then of each graph its tasks (collapsed) or items (expanded), what it takes of other graphs, rounds and
    /// steps, messages, critical path and measured times.
    pub fn to_text(&self) -> String {
        let mut out = self.program.to_string();
        for (number, diagram) in self.diagrams.iter().enumerate() {
            let _ = writeln!(out, "\ngraph {}", self.name(number));
            out += &diagram.table();
            self.taken(number, &mut out);
            out.push('\n');
            out += &diagram.report();
        }
        out
    }

    /// What a graph reads before it writes it, and whose it is.
    fn taken(&self, graph: usize, out: &mut String) {
        for flow in self.flows().iter().filter(|flow| flow.to == graph) {
            let from = self.name(flow.from);
            let of = match flow.delay {
                Delay::Onward => format!("graph {from}"),
                Delay::NextRound => format!("graph {from} in the round before"),
                Delay::NextStep => format!("graph {from} in the step before"),
            };
            let _ = writeln!(out, "takes from {of}: {}", names(&flow.labels));
        }
    }
}
