//! `sinew check`: is the scene sound, and what will it cost?
use super::args::SceneArgs;
use super::fail::Failure;
use super::progress::duration;
use super::trial::{Pace, Trial};
use scene::{Body, Rates, Scene};
use simd::Isa;
use sinew::simulation::rates;

/// Validate a scene; print particles, cells, memory, steps and the predicted wall time
#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    scene: SceneArgs,
    /// Only validate: no particles are made and no steps are tried
    #[arg(long)]
    validate_only: bool,
}

/// Rates of their own are told of, if they take less than this part of the time.
const WORTH: f64 = 0.9;

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
    let common = scene.run.rates == Rates::Common;
    let tried = Trial::of(scene, isa)?;
    let mib = |bytes: usize| bytes as f64 / f64::from(1 << 20);
    println!(
        "memory         {:.0} MiB of particles ({} bytes each), {:.0} MiB of nodes ({} bytes each in active blocks)",
        mib(tried.particles.1),
        tried.particles.1 / tried.particles.0.max(1),
        mib(tried.nodes.1),
        tried.nodes.1 / tried.nodes.0.max(1)
    );
    let Some(pace) = &tried.pace else {
        println!("step           the run ends with step {}", tried.steps);
        return Ok(());
    };
    let of_ticks = if pace.ticks == 1.0 { String::new() } else { format!(" in {:.1} ticks", pace.ticks) };
    println!(
        "step           {:.3e} s{of_ticks} at the start; {:.0} steps, if it stays so",
        pace.step, pace.all
    );
    println!(
        "wall time      about {} ({:.2} million particle updates a second on {} threads, {} steps tried)",
        duration(pace.wall()),
        pace.updates_per_s / 1e6,
        tried.threads,
        pace.tried
    );
    if common {
        with_own_rates(args, isa, pace)?;
    }
    Ok(())
}

/// What rates of their own would save, if it is much.
fn with_own_rates(args: &Args, isa: Isa, common: &Pace) -> Result<(), Failure> {
    let mut overrides = args.scene.changes.overrides()?;
    overrides.push(("run.rates".to_owned(), "per-material".to_owned()));
    let scene = sinew::input::read(&args.scene.scene, &overrides)?;
    if rates::at_rest(&scene).own.iter().all(|own| own.ticks < 2) {
        return Ok(());
    }
    let Some(pace) = Trial::of(scene, isa)?.pace else { return Ok(()) };
    if pace.wall() < WORTH * common.wall() {
        println!(
            "with rates     about {}, if each material takes steps of its own (--set run.rates=per-material; what it costs in accuracy: \
             problems/slab)",
            duration(pace.wall())
        );
    }
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
        "{} frames (at most one a step) of up to {:.1} MiB each: {}",
        scene.output.frames_until(scene.run.until),
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
