//! A physics that means nothing: labels of every combination, life and crossing, and tasks that pass them on.
use engine::data::extent::Bases;
use engine::graph::recipe::Recipe;
use engine::grid::{BlockShape, Origin};
use engine::prelude::{Life::*, *};

engine::labels! {
    Position: [Wide; 3]   = particle("cells", "x_p").in_the_middle();
    Identity: Wide        = particle("1", "identity of p, as the bits of an integer");
    Velocity: [Wide; 3]   = particle("cells", "how far p goes in a step");
    Charge: Wide          = particle("C", "q_p").inert(&[7.0]);
    Whole: Wide           = particle("1", "a whole number, which may be huge");
    Seen: [Wide; 4]       = particle("mixed", "what p has read of nodes");
    Memory: Wide          = particle("1", "as many numbers as the material says").by_material();
    Extent: [Wide; 6]     = block("cells", "where the particles of a block are").largest();
    Place: [Wide; 6]      = chunk("cells", "lowest node of p, and how far behind it p lies");

    StageSum: Wide        = node("C", "sum S q").partials(3);
    TickSum: [Wide; 2]    = node("C", "sum S q, sum S").partials(2).lives(Tick);
    StepSum: [Wide; 3]    = node("C", "sum S q x").partials(3).lives(Step);
    KeptSum: Wide         = node("C", "sum S S q").partials(3).lives(Carried);
    StageExact: ExactSum  = node("1", "sum of whole numbers").exact().partials(3);
    TickMost: Wide        = node("C", "largest q, -q").largest().partials(3).lives(Tick);
    StageFirst: Wide      = node("C", "smallest q, and whose").first().partials(3);
    MeetSum: Wide         = node("C", "sum S q of fields that meet").partials(3).where_fields_meet();
    TickValue: Wide       = node("C", "what p reads in the same graph").values(3);
    StepValue: [Wide; 2]  = node("C", "what rounds change").values(3).lives(Step);
    Total: [Wide; 3]      = node("C", "what comes together over the steps, and fades").values(2).lives(Carried);
    MeetValue: Wide       = node("C", "MeetSum, for p").values(3).lives(Step).where_fields_meet();
    TickOwn: Wide         = node("C", "what stays at its node for a graph");
    StepOwn: [Wide; 2]    = node("C", "for a step").lives(Step);
    KeptOwn: [Wide; 3]    = node("C", "for ever").lives(Carried);
    MeetKept: [Wide; 2]   = node("C", "for ever, where fields meet").lives(Carried).where_fields_meet();

    RunExact: ExactSum    = run("1", "sum of whole numbers").exact();
    RunMost: Wide         = run("C", "largest q, -q").largest().lives(Step);
    RunFirst: Wide        = run("C", "smallest q, and whose").first().lives(Carried);
    Steps: Wide           = run("1", "steps taken").lives(Carried);
    Change: ExactSum      = run("1", "nodes that a round changes").exact();
    Rounds: Wide          = run("1", "rounds taken").lives(Step);
    Done: Wide            = run("1", "1 after enough rounds").lives(Step);
    OwnExact: [ExactSum; 2] = material("1", "sums of whole numbers").exact();
    OwnMost: [Wide; 2]    = material("C", "largest q, -q").largest().lives(Carried);
    OwnFirst: Wide        = material("C", "smallest q, and whose").first().lives(Step);
    OwnSteps: Wide        = material("1", "steps taken").lives(Carried);
}
const ROLES: Roles =
    Roles { position: Position::ID, identity: Identity::ID, extent: Extent::ID, rates: None };
/// All labels.
pub static SCHEMA: Schema = Schema::new(&ROWS, ROLES);

/// Rounds of the loop of a step.
pub const ROUNDS: f64 = 3.0;

/// Nodes of a hat in a block's buffer, and its weights, in x-major order.
fn corners(place: &[Wide; 6], lane: usize, origin: &Origin) -> impl Iterator<Item = (usize, f64)> {
    let shape = origin.shape;
    let count = [0, 1, 2].map(|a| if shape.is_collapsed(a) { 1 } else { 2 });
    let (base, t) = ([0, 1, 2].map(|a| place[a].0[lane]), [0, 1, 2].map(|a| place[a + 3].0[lane]));
    let first = [0, 1, 2].map(|a| (base[a] - origin.node[a]) as usize);
    let [nx, ny, nz] = count;
    (0..nx * ny * nz).map(move |n| {
        let at = [n / (ny * nz), n / nz % ny, n % nz];
        let line = (0..3).map(|a| (first[a] + at[a]) * shape.buffer_strides[a] as usize).sum();
        let s = [0, 1, 2].map(|a| if at[a] == 1 { t[a] } else { 1.0 - t[a] });
        (line, s[0] * s[1] * s[2])
    })
}

/// Where the lines of a particle's field begin in a buffer.
fn field(identity: &Wide, lane: usize, fields: usize, shape: &BlockShape) -> usize {
    (identity.0[lane].to_bits() as usize % fields) * shape.buffer_len()
}

fn most(into: &mut Wide, lane: usize, x: f64) {
    into.0[lane] = into.0[lane].max(x);
}

/// The line of a key, if it comes before what is there.
fn first(into: &mut Wide, key: f64, who: &Wide, lane: usize) {
    let who = who.0[lane].to_bits() as f64;
    if (key, who) < (into.0[0], into.0[1]) {
        *into = Wide([key, who, -key, 0.0, 0.0, 0.0, 0.0, 0.0]);
    }
}

kernel! { /// Lowest node, and the way from it.
    FindPlace() in find_place: Particles { requires now { position: Position } computes { place: Place } }
    |_it, at, io| for (x, place) in io.position.iter().zip(io.place.iter_mut()) {
        for (a, lane) in (0..24).map(|i| (i / 8, i % 8)) {
            let on = if at.origin.shape.is_collapsed(a) { 0.0 } else { x[a].0[lane] };
            (place[a].0[lane], place[a + 3].0[lane]) = (on.floor(), on - on.floor());
        }
    }
}
kernel! { /// Particles read what the last step left, before anybody adds to nodes.
    Recall(usize) in recall: Particles {
        requires old { identity: Identity } requires new { place: Place } requires now { total: Total @ 2 }
        modifies { seen: Seen }
    }
    |it, at, io| for (tile, lane) in (0..at.count).map(|p| (p / 8, p % 8)) {
        let begin = field(&io.identity[tile], lane, it.0, at.origin.shape);
        for (line, s) in corners(&io.place[tile], lane, &at.origin) {
            io.seen[tile][0].0[lane] += s * io.total[begin + line][2].0[7];
        }
    }
}
kernel! { /// Half of what has come together goes.
    Fade() in fade: Nodes { modifies { total: Total, kept: KeptOwn } }
    |_it, _at, io| {
        io.total.iter_mut().flatten().for_each(|line| line.0.iter_mut().for_each(|x| *x *= 0.5));
        io.kept.iter_mut().for_each(|node| node[1].0[1] *= 0.75);
    }
}
kernel! { /// Everything that particles can add to nodes.
    Give(usize) in give: Particles {
        requires old { identity: Identity, charge: Charge, whole: Whole }
        requires new { place: Place }
        requires now { position: Position }
        computes {
            stage: StageSum @ 3, tick: TickSum @ 2, step: StepSum @ 3, kept: KeptSum @ 3,
            exact: StageExact @ 3, most: TickMost @ 3, first: StageFirst @ 3,
        }
    }
    |it, at, io| for (tile, lane) in (0..at.count).map(|p| (p / 8, p % 8)) {
        let begin = field(&io.identity[tile], lane, it.0, at.origin.shape);
        let q = io.charge[tile].0[lane];
        for (line, s) in corners(&io.place[tile], lane, &at.origin) {
            let line = begin + line;
            io.stage[line].0[0] += s * q;
            io.tick[line][0].0[3] += s * q;
            io.tick[line][1].0[7] += s;
            (0..3).for_each(|a| io.step[line][a].0[a] += s * q * io.position[tile][a].0[lane]);
            io.kept[line].0[5] += s * s * q;
            io.exact[line].add(io.whole[tile].0[lane]);
            most(&mut io.most[line], 0, q);
            most(&mut io.most[line], 6, -q);
            first(&mut io.first[line], q, &io.identity[tile], lane);
        }
    }
}
kernel! { /// The same where fields meet.
    GiveMeeting(usize) in give_meeting: NearParticles {
        requires old { identity: Identity, charge: Charge } requires new { place: Place }
        computes { sum: MeetSum @ 3 }
    }
    |it, at, io| for (tile, lane) in (0..at.count).map(|p| (p / 8, p % 8)) {
        let begin = field(&io.identity[tile], lane, it.0, at.origin.shape);
        for (line, s) in corners(&io.place[tile], lane, &at.origin) {
            io.sum[begin + line].0[2] += s * io.charge[tile].0[lane];
        }
    }
}
kernel! { /// Everything that particles can reduce.
    Reduce() in reduce: Particles {
        requires old { identity: Identity, charge: Charge, whole: Whole }
        computes {
            exact: RunExact, most: RunMost, first: RunFirst,
            own_exact: OwnExact, own_most: OwnMost, own_first: OwnFirst,
        }
    }
    |_it, at, io| for (tile, lane) in (0..at.count).map(|p| (p / 8, p % 8)) {
        let (q, whole) = (io.charge[tile].0[lane], io.whole[tile].0[lane]);
        io.exact[0].add(whole);
        io.own_exact[0][0].add(whole);
        io.own_exact[0][1].add(-2.0 * whole);
        most(&mut io.most[0], 0, q);
        most(&mut io.most[0], 5, -q);
        most(&mut io.own_most[0][1], 4, q);
        first(&mut io.first[0], q, &io.identity[tile], lane);
        first(&mut io.own_first[0], -q, &io.identity[tile], lane);
    }
}
kernel! { /// Values at nodes from sums, and what comes together there over the steps.
    Solve() in solve: Nodes {
        requires new {
            stage: StageSum, tick: TickSum, step: StepSum, exact: StageExact, most: TickMost, first: StageFirst,
            kept: KeptSum,
        }
        computes { value: TickValue, step_value: StepValue, own: TickOwn, step_own: StepOwn }
        modifies { total: Total, kept_own: KeptOwn }
    }
    |_it, _at, io| for n in 0..io.stage.len() {
        let (sum, weight) = (io.stage[n].0[0], io.tick[n][1].0[7]);
        io.value[n] = Wide::default();
        io.step_value[n] = [Wide::default(); 2];
        io.own[n] = Wide([io.tick[n][0].0[3] - 2.0 * io.kept[n].0[5]; 8]);
        io.step_own[n][1] = Wide([io.own[n].0[4] + 1.0; 8]);
        if weight > 0.0 {
            io.value[n].0[0] = sum / weight;
            io.value[n].0[1] = io.most[n].0[0] + 4.0 * io.most[n].0[6];
            io.step_value[n][1].0[6] = io.first[n].0[0] + io.first[n].0[1] + io.first[n].0[2];
            io.step_value[n][0].0[0] = io.exact[n].value();
            (0..3).for_each(|a| io.total[n][a].0[7] += io.step[n][a].0[a]);
            io.kept_own[n][1].0[1] += io.step_own[n][1].0[3] * weight;
        }
    }
}
kernel! { /// The same where fields meet: nodes of other blocks have none of these labels.
    Meet() in meet: Nodes { requires new { sum: MeetSum } computes { value: MeetValue } modifies { kept: MeetKept } }
    |_it, _at, io| for (n, sum) in io.sum.iter().enumerate() {
        io.value[n] = Wide([sum.0[2]; 8]);
        io.kept[n][1].0[0] += sum.0[2];
    }
}
kernel! { /// Particles read what nodes have in the same graph.
    Take(usize) in take: Particles {
        requires old { identity: Identity } requires new { place: Place, value: TickValue @ 3 }
        modifies { seen: Seen }
    }
    |it, at, io| for (tile, lane) in (0..at.count).map(|p| (p / 8, p % 8)) {
        let begin = field(&io.identity[tile], lane, it.0, at.origin.shape);
        for (line, s) in corners(&io.place[tile], lane, &at.origin) {
            io.seen[tile][1].0[lane] += s * io.value[begin + line].0[0];
            io.seen[tile][1].0[lane] += s * io.value[begin + line].0[1];
        }
    }
}
kernel! { /// The same where fields meet; where they do not, there are zeros.
    TakeMeeting(usize) in take_meeting: NearParticles {
        requires old { identity: Identity } requires new { place: Place, value: MeetValue @ 3 }
        modifies { seen: Seen }
    }
    |it, at, io| for (tile, lane) in (0..at.count).map(|p| (p / 8, p % 8)) {
        let begin = field(&io.identity[tile], lane, it.0, at.origin.shape);
        for (line, s) in corners(&io.place[tile], lane, &at.origin) {
            io.seen[tile][2].0[lane] += s * io.value[begin + line].0[5];
        }
    }
}
kernel! { /// Once: steps and rounds are counted.
    Count() in count: Once { computes { rounds: Rounds } modifies { steps: Steps, own: OwnSteps } }
    |_it, _at, io| {
        io.rounds[0].0[0] = 0.0;
        io.steps[0].0[0] += 1.0;
        (1..).zip(io.own.iter_mut()).for_each(|(m, own)| own.0[3] += f64::from(m));
    }
}
kernel! { /// A round: nodes to particles, and back.
    Spread(usize) in spread: Particles {
        requires old { identity: Identity } requires new { place: Place } requires now { value: StepValue @ 3 }
        computes { sum: StageSum @ 3 }
    }
    |it, at, io| for (tile, lane) in (0..at.count).map(|p| (p / 8, p % 8)) {
        let begin = field(&io.identity[tile], lane, it.0, at.origin.shape);
        let nodes = || corners(&io.place[tile], lane, &at.origin);
        let here: f64 = nodes().map(|(line, s)| s * io.value[begin + line][1].0[6]).sum();
        nodes().for_each(|(line, s)| io.sum[begin + line].0[1] += s * here);
    }
}
kernel! { /// The values after a round, and how many are not 0.
    Relax() in relax: Nodes { requires new { sum: StageSum } computes { change: Change } modifies { value: StepValue } }
    |_it, _at, io| for (sum, value) in io.sum.iter().zip(io.value.iter_mut()) {
        value[1].0[6] = 0.5 * value[1].0[6] + 0.125 * sum.0[1];
        io.change[0].add(f64::from(u8::from(sum.0[1] != 0.0)));
    }
}
kernel! { /// Whether the rounds are enough.
    Judge() in judge: Once { requires new { change: Change } computes { done: Done } modifies { rounds: Rounds } }
    |_it, _at, io| {
        io.rounds[0].0[0] += 1.0;
        io.rounds[0].0[1] = io.change[0].value();
        io.done[0].0[0] = f64::from(u8::from(io.rounds[0].0[0] == ROUNDS));
    }
}
kernel! { /// Particles read what lives longer than a graph, and move, but not out of the level.
    Move(usize, [f64; 3]) in shift: Particles {
        requires old { identity: Identity, velocity: Velocity }
        requires new { place: Place }
        requires now { value: StepValue @ 3, total: Total @ 2, steps: Steps }
        computes { extent: Extent }
        modifies { position: Position, seen: Seen, memory: Memory }
    }
    |it, at, io| for (tile, lane) in (0..at.count).map(|p| (p / 8, p % 8)) {
        let begin = field(&io.identity[tile], lane, it.0, at.origin.shape);
        for (line, s) in corners(&io.place[tile], lane, &at.origin) {
            io.seen[tile][3].0[lane] += s * io.value[begin + line][1].0[6];
            io.seen[tile][3].0[lane] += s * (io.value[begin + line][0].0[0] + io.total[begin + line][0].0[7]);
        }
        let numbers = io.memory.len() / io.position.len();
        for (n, number) in io.memory.tile_mut(tile, numbers).iter_mut().enumerate() {
            number.0[lane] = 0.5 * number.0[lane] + n as f64;
        }
        let way = if io.steps[0].0[0] % 4.0 < 2.0 { -1.0 } else { 1.0 };
        let there = |a: usize| io.position[tile][a].0[lane] + way * io.velocity[tile][a].0[lane];
        let x = [0, 1, 2].map(|a| there(a).clamp(0.0, it.1[a]));
        (0..3).for_each(|a| io.position[tile][a].0[lane] = x[a]);
        Bases { inverse_cell: 1.0, half_size: [0.0; 3] }.include_one(&mut io.extent[0], &at.origin, lane, x);
    }
}

/// The program of a step for materials of so many fields each.
pub fn program(fields: &[usize], cells: [usize; 3], patches: usize) -> Result<Program, GraphError> {
    let names: Vec<String> = (0..fields.len()).map(|m| format!("matter {m}")).collect();
    let recipe = || Recipe::new(&SCHEMA, names.clone());
    let each = |recipe: &mut Recipe, add: &dyn Fn(&mut Recipe, usize, usize)| {
        (0..fields.len()).for_each(|m| {
            recipe.add(m, "", find_place::FindPlace());
            add(recipe, m, fields[m]);
        });
    };
    let (mut before, mut begin, mut round, mut end) = (recipe(), recipe(), recipe(), recipe());
    each(&mut before, &|it, m, fields| it.add(m, "", recall::Recall(fields)));
    before.all("", fade::Fade());
    each(&mut begin, &|it, m, fields| {
        it.add(m, "", give::Give(fields));
        it.add(m, "", give_meeting::GiveMeeting(fields));
        it.add(m, "", reduce::Reduce());
    });
    begin.all("", solve::Solve());
    begin.all("", meet::Meet());
    each(&mut begin, &|it, m, fields| {
        it.add(m, "", take::Take(fields));
        it.add(m, "", take_meeting::TakeMeeting(fields));
    });
    begin.all("", count::Count());
    each(&mut round, &|it, m, fields| it.add(m, "", spread::Spread(fields)));
    round.all("", relax::Relax());
    round.all("", judge::Judge());
    let upper = cells.map(|n| n as f64);
    each(&mut end, &|it, m, fields| it.add(m, "", shift::Move(fields, upper)));
    let rounds = Script::Loop { body: vec![Script::Graph("round", round)], until: Done::ID, most: 10 };
    let script = vec![
        Script::Graph("before", before),
        Script::Graph("begin", begin),
        rounds,
        Script::Graph("end", end),
    ];
    let outputs = [
        Seen::ID,
        RunExact::ID,
        RunMost::ID,
        OwnExact::ID,
        OwnMost::ID,
        OwnFirst::ID,
        Rounds::ID,
        Memory::ID,
    ];
    Program::build("toy", script, &outputs, patches)
}
