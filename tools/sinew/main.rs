use sinew::input::read;
use sinew::simd::Isa;
use sinew::simulation::Simulation;
use std::time::Instant;
fn main() {
    let args: Vec<String> = std::env::args().collect();
    let mut ov = vec![];
    for a in &args[2..] {
        let (k, v) = a.split_once('=').unwrap();
        ov.push((k.to_string(), v.to_string()));
    }
    let scene = match read(std::path::Path::new(&args[1]), &ov) {
        Ok(s) => s,
        Err(e) => {
            eprintln!("{:?}", miette::Report::new(e));
            std::process::exit(2)
        }
    };
    let t = Instant::now();
    let mut sim = Simulation::new(scene, Isa::from_environment().unwrap()).unwrap();
    println!("{}", sim.graph.to_text());
    println!(
        "setup {:?} particles {} threads {}",
        t.elapsed(),
        sim.warehouse.particle_count(),
        sim.threads()
    );
    let n = sim.warehouse.particle_count() as f64;
    let mut t = Instant::now();
    let mut last = 0;
    loop {
        match sim.step() {
            Ok(true) => {}
            Ok(false) => break,
            Err(e) => {
                println!("{e}");
                break;
            }
        }
        if t.elapsed().as_secs_f64() > 3.0 {
            let rate = (sim.steps() - last) as f64 * n / t.elapsed().as_secs_f64() / 1e6;
            let r = sim.report();
            let e = r.energy();
            println!(
                "step {} t {:.4e} dt {:.3e} {} rate {:.2} M/s  K {:.4e} S {:.3e} P {:.3e} F {:.3e} fr {:.3e} im {:.3e} bw {:.3e} res {:.3e} del {}",
                sim.steps(),
                r.time,
                r.step,
                r.limited_by,
                rate,
                e.kinetic,
                e.strain,
                e.plastic,
                e.fracture,
                r.friction,
                r.impact,
                r.boundary_work,
                r.residual,
                r.deleted
            );
            for m in &r.materials {
                println!(
                    "    v {:.4?} c {:.5?} failed {:?} of {}",
                    m.velocity(),
                    m.center,
                    m.failed,
                    m.particles
                );
            }
            t = Instant::now();
            last = sim.steps();
        }
    }
    println!("{:016x}", sim.state_hash());
    let r = sim.report();
    println!("{r:#?}");
}
