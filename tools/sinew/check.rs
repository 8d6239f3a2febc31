//! `sinew check`: is the scene sound, and what will it cost?
use super::fail::Failure;
use super::progress::duration;
use super::run::SceneArgs;
use sinew::simd::Isa;
use sinew::simulation::Simulation;
use std::time::Instant;

/// Validate a scene; print particles, cells, memory, steps and the predicted wall time
#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    scene: SceneArgs,
    /// Only validate: no particles are made and no steps are tried
    #[arg(long)]
    validate_only: bool,
}

/// Steps that are tried to predict the wall time.
const TRIAL: u32 = 5;

/// Runs the subcommand.
pub fn run(args: &Args) -> Result<(), Failure> {
    let scene = args.scene.read()?;
    let isa = Isa::from_environment().map_err(Failure::usage)?;
    println!("scene          {} ({})", scene.title, scene.name);
    let [nx, ny, nz] = scene.domain.cells;
    println!("cells          {nx} x {ny} x {nz} of {} mm", 1e3 * scene.domain.cell);
    for body in &scene.bodies {
        let count = sinew::input::lattice::count(&scene, body);
        println!(
            "body           {}: {count} particles of {}",
            body.name, scene.materials[body.material].name
        );
    }
    if args.validate_only {
        return Ok(());
    }
    let (until, most) = (scene.run.until, scene.run.steps);
    let mut simulation = Simulation::new(scene, isa)?;
    let mut step = || simulation.step();
    step()?;
    let began = Instant::now();
    for _ in 0..TRIAL {
        step()?;
    }
    let seconds = began.elapsed().as_secs_f64() / f64::from(TRIAL);
    let (particle_bytes, node_bytes) = simulation.bytes();
    let particles = simulation.warehouse.particle_count();
    let mib = |bytes: usize| bytes as f64 / f64::from(1 << 20);
    println!(
        "memory         {:.0} MiB of particles ({} bytes each), {:.0} MiB of nodes",
        mib(particle_bytes),
        particle_bytes / particles.max(1),
        mib(node_bytes)
    );
    let clock = simulation.clock();
    let by_time = (until / clock.step).ceil();
    let steps = most.map_or(by_time, |most| by_time.min(most as f64));
    println!("step           {:.3e} s at the start; {steps:.0} steps, if it stays so", clock.step);
    println!(
        "wall time      about {} ({:.2} million particle updates a second on {} threads, {TRIAL} steps tried)",
        duration(steps * seconds),
        particles as f64 / seconds / 1e6,
        simulation.threads()
    );
    Ok(())
}
