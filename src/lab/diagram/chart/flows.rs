//! What passes between two graphs, in one piece.
use super::Chart;
use engine::program::Delay;
use engine::schema::LabelId;

/// All labels that pass from one graph to another at one time.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Flow {
    /// The graph that leaves them.
    pub(super) from: usize,
    /// The graph that reads them.
    pub(super) to: usize,
    /// When they are read.
    pub(super) delay: Delay,
    /// The labels.
    pub(super) labels: Vec<LabelId>,
    /// The passes, by number.
    pub(super) passes: Vec<usize>,
    /// The innermost loop around both, by number.
    pub(super) home: Option<usize>,
}

impl Chart<'_> {
    /// What passes between graphs, each pair once.
    pub(super) fn flows(&self) -> Vec<Flow> {
        let mut flows: Vec<Flow> = Vec::new();
        for (number, pass) in self.passes.iter().enumerate() {
            let (from, to, delay) = (pass.from, pass.to, pass.delay);
            let known = flows.iter().position(|flow| (flow.from, flow.to, flow.delay) == (from, to, delay));
            let at = known.unwrap_or_else(|| {
                let (labels, passes, home) = (Vec::new(), Vec::new(), self.home(from, to));
                flows.push(Flow { from, to, delay, labels, passes, home });
                flows.len() - 1
            });
            flows[at].passes.push(number);
            if !flows[at].labels.contains(&pass.label) {
                flows[at].labels.push(pass.label);
            }
        }
        flows
    }

    /// The innermost loop around two graphs.
    fn home(&self, a: usize, b: usize) -> Option<usize> {
        let both = self.around[a].iter().zip(&self.around[b]).take_while(|(a, b)| a == b);
        both.last().map(|(it, _)| *it)
    }
}
