//! Heat conduction, ρc ∂T/∂t = ∇·(k ∇T), with insulated faces: particles that stay where they are carry the temperature, nodes
//! gather and solve. A physics of its own on Sinew's engine, in four parts: labels, tasks, recipes, and a start.
use engine::prelude::{Life::Step, *};
use place::*;
use shapes::{Stencil, flat::Flat, linear::Linear};

// The labels: every quantity that passes between tasks, with its tile, home, unit and symbol.
engine::labels! {
    Position: [Wide; 3] = particle("m", "x_p").in_the_middle();
    Identity: Wide      = particle("1", "identity of p, as the bits of an integer");
    Volume: Wide        = particle("m^3", "V_p");
    Temperature: Wide   = particle("K", "T_p");
    Extent: [Wide; 6]   = block("cells", "where the particles of a block are").largest();
    Weights: Stencil    = chunk("1, 1/m", "S_Ip and its gradient");
    Sums: Wide          = node("J/K, J", "C_I = sum rho c V_p S_Ip, then C_I T_I").partials(3);
    Flow: Wide          = node("W", "-sum V_p k grad S_Ip . grad u_p: heat that flows to I").partials(3);
    Nodal: Wide         = node("mixed", "T_I, its change x, residual r, direction p, A p, C_I").values(3).lives(Step);
    Curvature: ExactSum = run("W K", "p . A p").exact();
    Squares: ExactSum   = run("W^2", "r . r").exact().lives(Step);
    AtFirst: ExactSum   = run("W^2", "r . r before the first round").exact().lives(Step);
    Krylov: Wide        = run("mixed", "r . r, alpha, beta");
    Solved: Wide        = run("1", "1 where the residual is small").lives(Step);
}
const ROLES: Roles =
    Roles { position: Position::ID, identity: Identity::ID, extent: Extent::ID, rates: None };
/// All labels, and those that the engine asks for by role.
pub static SCHEMA: Schema = Schema::new(&ROWS, ROLES);

#[rustfmt::skip] // the places of numbers in a line of `Nodal`, and of `Krylov`
mod place {
    pub const T: usize = 0; pub const X: usize = 1; pub const R: usize = 2; pub const P: usize = 3; pub const AP: usize = 4; pub const C: usize = 5;
    pub const RR: usize = 0; pub const ALPHA: usize = 1; pub const BETA: usize = 2;
}

// The tasks: each declares what it reads and writes, and its body receives that and nothing else.
kernel! { /// S_Ip and ∇S_Ip: hats, constant along collapsed axes.
    FindWeights(Flat<Linear>, f64) in weights: Particles {
        requires old { position: Position } computes { weights: Weights }
    }
    |it, at, io| for (x, stencil) in io.position.iter().zip(io.weights.iter_mut()) {
        stencil.fill::<S, _>(&it.0, x, &at.origin, it.1);
    }
}
kernel! { /// C_I = Σ ρc V_p S_Ip and Σ ρc V_p T_p S_Ip.
    GatherSums(f64) in gather_sums: Particles {
        requires old { volume: Volume, temperature: Temperature } requires new { weights: Weights }
        computes { sums: Sums @ 3 }
    }
    |it, at, io| for (tile, lane) in (0..at.count).map(|p| (p / 8, p % 8)) {
        let c = it.0 * io.volume[tile].0[lane];
        for (line, s, _) in io.weights[tile].nodes(lane, &at.origin) {
            io.sums[line].0[0] += c * s;
            io.sums[line].0[1] += c * s * io.temperature[tile].0[lane];
        }
    }
}
kernel! { /// T_I = Σ ρc V_p T_p S_Ip / C_I.
    NodalTemperature() in nodal_temperature: Nodes { requires new { sums: Sums } computes { nodal: Nodal } }
    |_it, _at, io| for (sum, node) in io.sums.iter().zip(io.nodal.iter_mut()) {
        let [c, heat, ..] = sum.0;
        *node = Wide([if c > 0.0 { heat / c } else { 0.0 }, 0.0, 0.0, 0.0, 0.0, c, 0.0, 0.0]);
    }
}
kernel! { /// −(K u)_I = −Σ V_p k ∇S_Ip · ∇u_p, where u is one of the numbers of `Nodal`.
    Conduct(f64, usize) in conduct: Particles {
        requires old { volume: Volume } requires new { weights: Weights } requires now { nodal: Nodal @ 3 }
        computes { flow: Flow @ 3 }
    }
    |it, at, io| for (tile, lane) in (0..at.count).map(|p| (p / 8, p % 8)) {
        let (nodes, mut gradient) = (|| io.weights[tile].nodes(lane, &at.origin), [0.0; 3]);
        for (line, _, g) in nodes() {
            (0..3).for_each(|a| gradient[a] += g[a] * io.nodal[line].0[it.1]);
        }
        let k = it.0 * io.volume[tile].0[lane];
        for (line, _, g) in nodes() {
            io.flow[line].0[0] -= k * (0..3).map(|a| g[a] * gradient[a]).sum::<f64>();
        }
    }
}
kernel! { /// x = Δt (−K T) / C: an explicit step.
    Explicit(f64) in explicit: Nodes { requires new { flow: Flow } modifies { nodal: Nodal } }
    |it, _at, io| for (flow, node) in io.flow.iter().zip(io.nodal.iter_mut()).filter(|(_, node)| node.0[C] > 0.0) {
        node.0[X] = it.0 * flow.0[0] / node.0[C];
    }
}
kernel! { /// T_p ← T_p + Σ S_Ip x_I.
    Collect() in collect: Particles {
        requires new { weights: Weights } requires now { nodal: Nodal @ 3 }
        modifies { temperature: Temperature }
    }
    |_it, at, io| for (tile, lane) in (0..at.count).map(|p| (p / 8, p % 8)) {
        let nodes = io.weights[tile].nodes(lane, &at.origin);
        io.temperature[tile].0[lane] += nodes.map(|(line, s, _)| s * io.nodal[line].0[X]).sum::<f64>();
    }
}

// The same by an implicit step, (C/Δt + K) x = −K T, solved by conjugate gradients.
kernel! { /// r = p = −K T.
    Begin() in begin: Nodes {
        requires new { flow: Flow } computes { squares: Squares, first: AtFirst } modifies { nodal: Nodal }
    }
    |_it, _at, io| for (flow, node) in io.flow.iter().zip(io.nodal.iter_mut()) {
        (node.0[R], node.0[P]) = (flow.0[0], flow.0[0]);
        io.squares[0].add(node.0[R] * node.0[R]);
        io.first[0].add(node.0[R] * node.0[R]);
    }
}
kernel! { /// A p = C p/Δt + K p, and p · A p.
    Apply(f64) in apply: Nodes {
        requires new { flow: Flow } computes { curvature: Curvature } modifies { nodal: Nodal }
    }
    |it, _at, io| for (flow, node) in io.flow.iter().zip(io.nodal.iter_mut()) {
        node.0[AP] = node.0[C] * node.0[P] / it.0 - flow.0[0];
        io.curvature[0].add(node.0[P] * node.0[AP]);
    }
}
kernel! { /// α = r · r / p · A p.
    Length() in length: Once {
        requires new { curvature: Curvature } requires now { squares: Squares } computes { krylov: Krylov }
    }
    |_it, _at, io| {
        let (rr, curvature) = (io.squares[0].value(), io.curvature[0].value());
        io.krylov[0].0[RR] = rr;
        io.krylov[0].0[ALPHA] = if curvature > 0.0 { rr / curvature } else { 0.0 };
    }
}
kernel! { /// x ← x + α p, r ← r − α A p.
    Update() in update: Nodes {
        requires new { krylov: Krylov } computes { squares: Squares } modifies { nodal: Nodal }
    }
    |_it, _at, io| for node in io.nodal.iter_mut() {
        let alpha = io.krylov[0].0[ALPHA];
        node.0[X] += alpha * node.0[P];
        node.0[R] -= alpha * node.0[AP];
        io.squares[0].add(node.0[R] * node.0[R]);
    }
}
kernel! { /// β, and whether |r| has fallen to some part of its start.
    Judge(f64) in judge: Once {
        requires new { squares: Squares } requires now { first: AtFirst }
        computes { solved: Solved } modifies { krylov: Krylov }
    }
    |it, _at, io| {
        let (rr, before) = (io.squares[0].value(), io.krylov[0].0[RR]);
        io.krylov[0].0[BETA] = if before > 0.0 { rr / before } else { 0.0 };
        io.solved[0].0[0] = f64::from(u8::from(rr <= it.0 * it.0 * io.first[0].value()));
    }
}
kernel! { /// p ← r + β p.
    Direction() in direction: Nodes { requires new { krylov: Krylov } modifies { nodal: Nodal } }
    |_it, _at, io| for node in io.nodal.iter_mut() {
        node.0[P] = node.0[R] + io.krylov[0].0[BETA] * node.0[P];
    }
}

/// What the matter is like, and how steps are taken.
#[derive(Clone, Copy, Debug)]
pub struct Heat {
    /// ρc [J/(m³ K)]
    pub capacity: f64,
    /// k [W/(m K)]
    pub conductivity: f64,
    /// Δt [s]
    pub step: f64,
    /// If steps are implicit: conjugate gradients stop when |r| has fallen to this part of its start.
    pub tolerance: Option<f64>,
}

// The recipes: a list of tasks is an algorithm; graphs in sequence and loops are a program.
impl Heat {
    /// The program of a step, or what the graph refuses.
    pub fn program(&self, level: &Level, patches: usize) -> Result<Program, GraphError> {
        let collapsed = [0, 1, 2].map(|axis| level.shape().is_collapsed(axis));
        let weights = || weights::FindWeights(Flat { shape: Linear, collapsed }, 1.0 / level.cell);
        let recipe = || Recipe::new(&SCHEMA, vec!["matter".to_owned()]);
        let (mut begin, mut round, mut end) = (recipe(), recipe(), recipe());
        begin.add(0, "", weights());
        begin.add(0, "", gather_sums::GatherSums(self.capacity));
        begin.all("", nodal_temperature::NodalTemperature());
        begin.add(0, "", weights());
        begin.add(0, "", conduct::Conduct(self.conductivity, T));
        end.add(0, "", weights());
        end.add(0, "", collect::Collect());
        let Some(tolerance) = self.tolerance else {
            begin.all("", explicit::Explicit(self.step));
            let script = vec![Script::Graph("flow", begin), Script::Graph("collect", end)];
            return Program::build("explicit step", script, &[Temperature::ID], patches);
        };
        begin.all("", begin::Begin());
        round.add(0, "", weights());
        round.add(0, "", conduct::Conduct(self.conductivity, P));
        round.all("", apply::Apply(self.step));
        round.all("", length::Length());
        round.all("", update::Update());
        round.all("", judge::Judge(tolerance));
        round.all("", direction::Direction());
        let solve = Script::Loop { body: vec![Script::Graph("round", round)], until: Solved::ID, most: 1000 };
        let script = vec![Script::Graph("residual", begin), solve, Script::Graph("collect", end)];
        Program::build("implicit step", script, &[Temperature::ID], patches)
    }

    /// `n` particles along each axis of each cell, with a temperature by place: those of one of some ranks. Patches must fit the level.
    pub fn start(
        program: &Program,
        (level, n): (Level, usize),
        (patches, rank, ranks): ([usize; 3], usize, usize),
        temperature: impl Fn([f64; 3]) -> f64,
    ) -> Result<Warehouse, Box<dyn std::error::Error>> {
        let cut = Decomposition::new(&level, patches)?;
        let partition = Partition::by_cost(&cut, &vec![1; cut.patches.len()], rank, ranks)?;
        let labels = [Position::ID, Identity::ID, Volume::ID, Temperature::ID];
        let matter = vec![MaterialData::new(&SCHEMA, "matter", labels)];
        let mut warehouse = Warehouse::new(&SCHEMA, level, (cut, partition), matter, program.labels());
        let axis = |cells| if cells > 0 { level.cell / n as f64 } else { 1.0 };
        let volume = level.cells.map(axis).iter().product();
        for (i, x) in level.lattice(n).enumerate() {
            if warehouse.partition.is_mine(warehouse.home(0, x)?.1) {
                let record = [x[0], x[1], x[2], f64::from_bits(i as u64), volume, temperature(x)];
                warehouse.insert(0, x, &record)?;
            }
        }
        Ok(warehouse)
    }
}
