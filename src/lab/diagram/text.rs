//! What a diagram adds to the table of tasks: items, messages and the critical path, for people.
use super::{Diagram, Kind, Runs, Source, bytes, time};
use engine::graph::traffic::Messages;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;

impl Diagram<'_> {
    /// The table of tasks (collapsed) or all items (expanded).
    pub fn table(&self) -> String {
        if self.expanded { self.list() } else { self.shown().to_text() }
    }

    /// Messages, critical path and measured times.
    pub fn report(&self) -> String {
        let mut out = String::new();
        self.messages(&mut out);
        self.critical(&mut out);
        self.times(&mut out);
        out
    }

    /// One line an item, with what it does where it comes first, and what comes into it.
    fn list(&self) -> String {
        let mut out = String::new();
        let mut told = BTreeSet::new();
        let mut incoming = vec![Vec::new(); self.items.len()];
        self.links.iter().for_each(|link| incoming[link.to].push(link));
        for (column, title) in self.columns.iter().enumerate() {
            let items = || self.items.iter().enumerate().filter(|(_, item)| item.column == column);
            if items().next().is_some() {
                let _ = writeln!(out, "{title}");
            }
            for (at, item) in items() {
                let size = match item.kind {
                    Kind::Task(_) => format!("{} {}", item.work, self.unit(item.kind)),
                    _ => format!("{} messages, {}", item.messages.count, bytes(item.messages.bytes)),
                };
                let _ = writeln!(out, "  {:<44} {size}, {}", self.title(item), time(item.cost));
                if told.insert(self.about(item)) {
                    let _ = writeln!(out, "    {}", self.about(item));
                }
                for link in &incoming[at] {
                    let ghost = if link.ghost > 0 { format!("@{}", link.ghost) } else { String::new() };
                    let from = self.title(&self.items[link.from]);
                    let _ = writeln!(
                        out,
                        "    {} {}{ghost} {} {} <- {from}",
                        link.why.name(),
                        link.label.name(),
                        self.material(link.material),
                        bytes(link.bytes)
                    );
                }
            }
        }
        out
    }

    fn unit(&self, kind: Kind) -> &'static str {
        use engine::graph::task::Domain;
        let Kind::Task(node) = kind else { return "" };
        match self.graph.graph[node].declaration.domain {
            Domain::Nodes => "nodes",
            Domain::Once => "run",
            _ => "particles",
        }
    }

    /// Messages of a step by what they are about, then by pair of ranks.
    fn messages(&self, out: &mut String) {
        let per = match (self.cycle.most, self.runs) {
            (Some(_), _) => "tick in which all materials act",
            (None, Runs::Rounds) => "round",
            (None, _) => "step",
        };
        let (ranks, patches) = (self.traffic.ranks, self.traffic.patches());
        let word = |n: usize, one: &str, many: &str| format!("{n} {}", if n == 1 { one } else { many });
        let _ = writeln!(
            out,
            "messages a {per}, at the start of the scene, on {} and {}:",
            word(ranks, "rank", "ranks"),
            word(patches, "patch", "patches")
        );
        if ranks == 1 {
            let _ = writeln!(out, "  none: one rank has all patches (--ranks N shows what N would send)");
            return;
        }
        let causes = self.traffic.by_cause(self.graph);
        if causes.is_empty() {
            let _ = writeln!(out, "  none: it needs nothing of other ranks");
            return;
        }
        let mut all: BTreeMap<(usize, usize), Messages> = BTreeMap::new();
        for (cause, pairs) in &causes {
            let mut sum = Messages::default();
            for (&pair, m) in pairs {
                sum.add(m.count, m.bytes);
                all.entry(pair).or_default().add(m.count, m.bytes);
            }
            let _ = writeln!(out, "  {cause:<44} {:>6} messages {:>10}", sum.count, bytes(sum.bytes));
        }
        const SHOWN: usize = 64;
        let _ = writeln!(out, "  by pair of ranks:");
        for ((from, to), sum) in all.iter().take(SHOWN) {
            let parts = causes.iter().filter_map(|(cause, pairs)| {
                pairs.get(&(*from, *to)).map(|m| format!("{cause} {} ({})", m.count, bytes(m.bytes)))
            });
            let parts = parts.collect::<Vec<_>>().join("; ");
            let _ =
                writeln!(out, "    {from} -> {to}: {} messages, {}: {parts}", sum.count, bytes(sum.bytes));
        }
        if all.len() > SHOWN {
            let _ = writeln!(out, "    and {} more pairs: --format json has all", all.len() - SHOWN);
        }
    }

    fn critical(&self, out: &mut String) {
        let how = if self.measured.is_some() {
            "times of the trace, where it has them; workers of a rank added up"
        } else {
            &self.estimate
        };
        let _ = writeln!(out, "critical path of {}: {} ({how})", self.span(), time(self.path_ns));
        for &at in &self.path {
            let item = &self.items[at];
            let mark = match (item.source, self.measured) {
                (_, None) | (Source::Measured, _) => String::new(),
                (source, _) => format!(" ({})", source.word()),
            };
            let _ = writeln!(out, "  {:<44} {:>10}{mark}", self.title(item), time(item.cost));
        }
    }

    /// Measured means a step: of each item, then of each worker.
    fn times(&self, out: &mut String) {
        let Some(measured) = self.measured else { return };
        let _ = writeln!(
            out,
            "mean times a step, of all workers of a rank together; of a stage of several tasks the time is measured, and split among them as \
             estimated:"
        );
        for item in self.items.iter().filter(|item| item.source != Source::Estimated) {
            let idle = item.idle.map_or(String::new(), |idle| format!(", idle {}", time(idle)));
            let word = if matches!(item.kind, Kind::Halo(_) | Kind::Reduction(_)) { "waits " } else { "" };
            let split = if item.source == Source::Split { " (split)" } else { "" };
            let _ = writeln!(out, "  {:<44} {word}{}{split}{idle}", self.title(item), time(item.cost));
        }
        out.push_str(&measured.table());
    }
}
