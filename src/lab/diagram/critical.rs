//! The critical path: the chain of items that takes longest.
use super::{Diagram, Kind};
use std::collections::BTreeMap;

impl Diagram<'_> {
    /// Finds the critical path and marks it.
    pub(super) fn find_path(&mut self) {
        let order = self.order();
        let mut incoming: Vec<Vec<usize>> = vec![Vec::new(); self.items.len()];
        self.links.iter().enumerate().for_each(|(number, link)| incoming[link.to].push(number));
        let mut end: Vec<f64> = vec![0.0; self.items.len()];
        let mut before: Vec<Option<usize>> = vec![None; self.items.len()];
        let mut done = 0;
        while done < order.len() {
            // a reduction is complete when the parts of all ranks are: its items begin together
            let together = self.together(&order[done..]);
            let items = &order[done..done + together];
            let latest = |item: usize| {
                let links = incoming[item].iter().map(|&link| self.links[link].from);
                links.max_by(|&a, &b| end[a].total_cmp(&end[b]))
            };
            let first: Vec<Option<usize>> = items.iter().map(|&item| latest(item)).collect();
            let all = first.iter().flatten().copied().max_by(|&a, &b| end[a].total_cmp(&end[b]));
            for (&item, own) in items.iter().zip(first) {
                let from = if together > 1 { all } else { own };
                before[item] = from;
                end[item] = from.map_or(0.0, |from| end[from]) + self.items[item].cost;
            }
            done += together;
        }
        let mut at = (0..self.items.len()).max_by(|&a, &b| end[a].total_cmp(&end[b]));
        self.path.clear();
        while let Some(item) = at {
            self.path.push(item);
            at = before[item];
        }
        self.path.reverse();
        self.path_ns = self.path.iter().map(|&item| self.items[item].cost).sum();
        self.mark();
    }

    /// Items such that links go forward.
    fn order(&self) -> Vec<usize> {
        let mut order: Vec<usize> = (0..self.items.len()).collect();
        order.sort_by_key(|&at| {
            let item = &self.items[at];
            let entry = match item.kind {
                Kind::Task(node) => self.graph.graph[node].entry,
                _ => 0,
            };
            (item.column, entry, at)
        });
        order
    }

    /// How many of the next items begin together.
    fn together(&self, rest: &[usize]) -> usize {
        let Some(Kind::Reduction(phase)) = rest.first().map(|&at| self.items[at].kind) else { return 1 };
        rest.iter().take_while(|&&at| self.items[at].kind == Kind::Reduction(phase)).count()
    }

    fn mark(&mut self) {
        let next: BTreeMap<usize, usize> = self.path.windows(2).map(|pair| (pair[0], pair[1])).collect();
        for (number, item) in self.items.iter_mut().enumerate() {
            item.critical = self.path.contains(&number);
        }
        for link in &mut self.links {
            link.critical = next.get(&link.from) == Some(&link.to);
        }
    }
}
