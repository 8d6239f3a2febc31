//! The tree of a program in lines.
use super::{Loop, Program, ProgramNode};
use std::fmt;

impl Loop {
    /// Until when it runs, in words.
    pub fn title(&self) -> String {
        match self.most {
            u64::MAX => format!("loop until {}", self.until.name()),
            1 => format!("loop until {}, once", self.until.name()),
            most => format!("loop until {}, at most {most} rounds", self.until.name()),
        }
    }
}

impl fmt::Display for Program {
    /// A line a graph and a loop, indented.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "program {}", self.name)?;
        lines(&self.nodes, 1, f)
    }
}

fn lines(nodes: &[ProgramNode], depth: usize, f: &mut fmt::Formatter<'_>) -> fmt::Result {
    for node in nodes {
        write!(f, "{:indent$}", "", indent = 2 * depth)?;
        match node {
            ProgramNode::Graph(graph) => {
                let tasks = graph.graph.node_count();
                writeln!(f, "graph {}: {tasks} task{}", graph.name, if tasks == 1 { "" } else { "s" })?;
            }
            ProgramNode::Loop(it) => {
                writeln!(f, "{}", it.title())?;
                lines(&it.body, depth + 1, f)?;
            }
        }
    }
    Ok(())
}
