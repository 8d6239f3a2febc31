//! `sinew check`: is the scene sound, and what will it cost?
use super::args::SceneArgs;
use super::fail::Failure;
use super::progress::duration;
use scene::{Body, Scene};
use simd::Isa;
use sinew::simulation::{Simulation, rates};
use std::time::{Duration, Instant};

/// Validate a scene; print particles, cells, memory, steps and the predicted wall time
#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    scene: SceneArgs,
    /// Only validate: no particles are made and no steps are tried
    #[arg(long)]
    validate_only: bool,
}

/// Steps that are tried to predict the wall time: at least so many, and for as long.
const TRIAL: (u64, Duration) = (5, Duration::from_secs(1));

/// Pairs of materials without contact that are named.
const MOST_PAIRS: usize = 5;

/// Runs the subcommand.
pub fn run(args: &Args) -> Result<(), Failure> {
    let scene = args.scene.read()?;
    let isa = Isa::from_environment().map_err(Failure::usage)?;
    println!("scene          {} ({})", scene.title, scene.name);
    let [nx, ny, nz] = scene.domain.cells;
    println!("cells          {nx} x {ny} x {nz} of {} mm", 1e3 * scene.domain.cell);
    for body in &scene.bodies {
        let material = &scene.materials[body.material];
        let filled = if material.has_particles() {
            format!("{} particles", scene::sampling::count(&scene, body))
        } else {
            "a shape without particles".to_owned()
        };
        println!("body           {}: {filled}, of {}", body.name, material.name);
    }
    println!("output         {}", output(&scene));
    geometry(&scene).iter().for_each(|line| println!("{line}"));
    if args.validate_only {
        return Ok(());
    }
    if let Some(rates) = own_steps(&scene) {
        println!("rates          {rates} (an estimate at rest)");
    }
    let (until, most) = (scene.run.until, scene.run.steps);
    let mut simulation = Simulation::new(scene, isa)?;
    simulation.step()?;
    let (particle_bytes, node_bytes) = simulation.bytes();
    let (particles, nodes) = (simulation.warehouse.particle_count(), simulation.warehouse.node_count());
    let mib = |bytes: usize| bytes as f64 / f64::from(1 << 20);
    println!(
        "memory         {:.0} MiB of particles ({} bytes each), {:.0} MiB of nodes ({} bytes each in active blocks)",
        mib(particle_bytes),
        particle_bytes / particles.max(1),
        mib(node_bytes),
        node_bytes / nodes.max(1)
    );
    let (start, ticks, steps, updates) = state(&simulation);
    let began = Instant::now();
    while simulation.steps() < steps + TRIAL.0 || began.elapsed() < TRIAL.1 {
        if !simulation.step()? {
            break;
        }
    }
    let spent = began.elapsed().as_secs_f64();
    let (time, last_tick, last, updated) = state(&simulation);
    if last == steps {
        println!("step           the run ends with step {last}");
        return Ok(());
    }
    // steps as they are, with all ticks that each takes
    let tried = (last - steps) as f64;
    let (step, seconds) = ((time - start) / tried, spent / tried);
    let by_time = (until / step).ceil();
    let all = most.map_or(by_time, |most| by_time.min(most as f64));
    let of_ticks = match (last_tick - ticks) as f64 / tried {
        1.0 => String::new(),
        ticks => format!(" in {ticks:.1} ticks"),
    };
    println!("step           {step:.3e} s{of_ticks} at the start; {all:.0} steps, if it stays so");
    println!(
        "wall time      about {} ({:.2} million particle updates a second on {} threads, {tried} steps tried)",
        duration(all * seconds),
        (updated - updates) as f64 / spent / 1e6,
        simulation.threads()
    );
    Ok(())
}

/// Frames and what they take before they are compressed.
fn output(scene: &Scene) -> String {
    if scene.output.frames == 0 {
        return "no frames".to_owned();
    }
    let filled = scene.bodies.iter().filter(|body| scene.materials[body.material].has_particles());
    let particles: usize = filled.map(|body| scene::sampling::count(scene, body)).sum();
    let numbers: usize = scene.output.fields.iter().map(|shown| shown.components).sum();
    // position, identity, material
    let bytes = particles * (12 + 8 + 2 + 4 * numbers);
    let names: Vec<&str> = scene.output.fields.iter().map(|shown| shown.name).collect();
    format!(
        "{} frames of up to {:.1} MiB each: {}",
        scene.output.most_frames(scene.run.until),
        bytes as f64 / f64::from(1 << 20),
        names.join(", ")
    )
}

/// How well the grid resolves the smallest body, what may pass through what, and when a projectile leaves.
fn geometry(scene: &Scene) -> Vec<String> {
    let mut lines = Vec::new();
    let across = |body: &Body| {
        let (lower, upper) = body.solid.bounds();
        (0..3).map(|a| (upper[a] - lower[a]) / scene.domain.cell).fold(f64::INFINITY, f64::min)
    };
    let filled = scene.bodies.iter().filter(|body| scene.materials[body.material].has_particles());
    let thinnest = filled.min_by(|a, b| across(a).total_cmp(&across(b)));
    lines.extend(
        thinnest.map(|body| format!("thinnest       {}: {:.1} cells across", body.name, across(body))),
    );
    let mut free = scene.pairs().into_iter().filter(|pair| !scene.meet(pair));
    let name = |pair: [usize; 2]| pair.map(|m| scene.materials[m].name.as_str()).join(" and ");
    let mut names: Vec<String> = free.by_ref().take(MOST_PAIRS).map(name).collect();
    match free.count() {
        0 => {}
        more => names.push(format!("and {more} more pairs")),
    }
    if !names.is_empty() {
        lines.push(format!("no contact     {} pass through each other", names.join(", ")));
    }
    lines.extend(leaves(scene));
    lines
}

/// When the projectile of a shot, if nothing stops it, is out of the domain.
fn leaves(scene: &Scene) -> Option<String> {
    let wound = scene.output.wound.as_ref()?;
    let body = scene.bodies_of(wound.projectile).next()?;
    let (axis, speed) = (wound.axis, wound.direction * body.velocity[wound.axis]);
    let (lower, upper) = scene::sampling::inside(&scene.domain);
    let (from, to) = body.solid.bounds();
    let way = if wound.direction > 0.0 { upper[axis] - to[axis] } else { from[axis] - lower[axis] };
    let time = way / speed;
    (speed > 0.0 && time < scene.run.until)
        .then(|| format!("projectile     {}: unhindered it reaches the end of the domain after {:.3} ms, before the run ends", body.name, 1e3 * time))
}

/// Time, ticks, steps, and particles moved.
fn state(simulation: &Simulation) -> (f64, u64, u64, u64) {
    (simulation.clock().time, simulation.ticks(), simulation.steps(), simulation.updates())
}

/// The steps of materials in those of the fastest, if each takes its own: an estimate.
fn own_steps(scene: &Scene) -> Option<String> {
    let cycle = rates::at_rest(scene);
    cycle.most?;
    let fastest = &scene.materials[cycle.fastest].name;
    let slower = scene.materials.iter().zip(&cycle.own).filter(|(_, own)| own.ticks > 1);
    let slower: Vec<String> =
        slower.map(|(m, own)| format!("{} every {} ticks of {fastest}", m.name, own.ticks)).collect();
    Some(if slower.is_empty() { "all materials every tick".to_owned() } else { slower.join(", ") })
}
