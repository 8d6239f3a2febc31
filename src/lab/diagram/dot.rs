//! Graphviz.
use super::{Diagram, Group, Item, Kind, Link, bytes, time};
use engine::graph::recipe::Why;
use std::fmt::Write;

impl Diagram<'_> {
    /// Graphviz, one cluster a fused stage: solid edges carry data, dashed ones protect what is still read; the critical
    /// path is bold. If materials take steps of their own, a cluster of the tick holds all but what waits.
    pub fn to_dot(&self) -> String {
        let mut out =
            String::from("digraph step {\n  rankdir=LR;\n  node [shape=box, fontname=\"sans-serif\"];\n");
        match self.cycle.most {
            Some(_) if !self.expanded => {
                out.push_str(
                    "  subgraph cluster_step { label=\"step: until all materials are together again\";\n",
                );
                let _ = writeln!(out, "  subgraph cluster_tick {{ label={:?};", self.lanes[0].title);
                self.dot_lane(Some(0), &mut out);
                out.push_str("  }\n");
                self.dot_lane(Some(1), &mut out);
                out.push_str("  }\n");
            }
            _ => self.dot_lane(None, &mut out),
        }
        self.links.iter().for_each(|link| self.dot_link(link, &mut out));
        out.push_str("}\n");
        out
    }

    /// The groups of a lane, or of all.
    fn dot_lane(&self, lane: Option<usize>, out: &mut String) {
        let groups = self.groups.iter().enumerate();
        for (number, group) in groups.filter(|(_, group)| lane.is_none_or(|lane| group.lane == lane)) {
            self.dot_group(number, group, out);
        }
    }

    fn dot_group(&self, number: usize, group: &Group, out: &mut String) {
        if !group.stage {
            group.items.iter().for_each(|&at| self.dot_item(&self.items[at], "  ", out));
            return;
        }
        let place = match &self.lanes[group.lane] {
            lane if self.expanded && !group.items.is_empty() => format!(", {}", lane.title),
            _ => String::new(),
        };
        let title = format!("{}{place}", group.title);
        let _ = writeln!(out, "  subgraph cluster_{number} {{ label={title:?};");
        group.items.iter().for_each(|&at| self.dot_item(&self.items[at], "    ", out));
        out.push_str("  }\n");
    }

    fn dot_item(&self, item: &Item, indent: &str, out: &mut String) {
        let bold = if item.critical { ", penwidth=3, color=\"#c0392b\"" } else { "" };
        let _ = match item.kind {
            Kind::Task(_) => writeln!(out, "{indent}{} [label=\"{}\"{bold}];", item.id, item.name),
            _ => writeln!(
                out,
                "{indent}{} [label=\"{}\\n{} messages, {}\", shape=hexagon{bold}];",
                item.id,
                item.name,
                item.messages.count,
                bytes(item.messages.bytes)
            ),
        };
    }

    fn dot_link(&self, link: &Link, out: &mut String) {
        let ghost = if link.ghost > 0 { format!(" @{}", link.ghost) } else { String::new() };
        let carried = if link.bytes > 0 { format!("\\n{}", bytes(link.bytes)) } else { String::new() };
        let style = if link.why == Why::Flow { "solid" } else { "dashed" };
        let bold = if link.critical { ", penwidth=3, color=\"#c0392b\"" } else { "" };
        let (from, to) = (&self.items[link.from], &self.items[link.to]);
        let tip = format!("{}, {}", self.material(link.material), time(from.cost));
        let _ = writeln!(
            out,
            "  {} -> {} [label=\"{}{ghost}{carried}\", tooltip=\"{}\", style={style}{bold}];",
            from.id,
            to.id,
            link.label.name(),
            tip.trim_start_matches(", ")
        );
    }
}
