//! A graph for Graphviz.
use super::{Diagram, Group, Item, Kind, Link, bytes, time};
use engine::graph::recipe::Why;
use std::fmt::Write;

impl Diagram<'_> {
    /// A cluster a fused stage. If materials take steps of their own, a cluster of the tick holds all but what waits.
    pub(super) fn dot_groups(&self, out: &mut String) {
        match self.cycle.most {
            Some(_) if !self.expanded => {
                let (prefix, title) = (&self.prefix, &self.lanes[0].title);
                let _ = writeln!(out, "  subgraph cluster_{prefix}tick {{ label={title:?};");
                self.dot_lane(Some(0), out);
                out.push_str("  }\n");
                self.dot_lane(Some(1), out);
            }
            _ => self.dot_lane(None, out),
        }
    }

    /// The links.
    pub(super) fn dot_links(&self, out: &mut String) {
        self.links.iter().for_each(|link| self.dot_link(link, out));
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
        let _ = writeln!(out, "  subgraph cluster_{}{number} {{ label={title:?};", self.prefix);
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
