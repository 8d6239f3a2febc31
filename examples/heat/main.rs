//! 100 mm of steel cool (c rho = 3.9 MJ/(m³ K), k = 45 W/(m K)): half a cosine, against its closed form. Also under `mpirun`.
use engine::exec::ranks::launch::{Launch, threads};
use engine::exec::{Engine, Threads, Undirected};
use engine::{data::particles::ParticleBlock, grid::Level, schema::Label, simd::Isa};
use heat::{Heat, Position, Temperature};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (mut network, here) = Launch::of_this_process().connect()?;
    let level = Level { lower: [0.0; 3], cell: 2.5e-3, cells: [40, 4, 0] };
    let heat = Heat { capacity: 3.9e6, conductivity: 45.0, step: 1.0, tolerance: Some(1e-10) };
    let wave = std::f64::consts::PI / 0.1;
    let exact = |x: f64, t: f64| 300.0 + 100.0 * (wave * x).cos() * f64::exp(-45.0 / 3.9e6 * wave * wave * t);
    let (program, place) = (heat.program(&level, 4)?, ([4, 1, 1], network.rank(), network.size()));
    let mut warehouse = Heat::start(&program, (level, 2), place, |x| exact(x[0], 0.0))?;
    let workers = Box::new(Threads::new(threads(None, here.ranks).0)?);
    let mut engine = Engine::new(workers, Isa::detect(), &warehouse);
    for _ in 0..60 {
        engine.execute(&program, &mut warehouse, &mut *network, &mut Undirected)?;
    }
    let layout = &warehouse.materials[0].layout;
    let of = |block: &ParticleBlock, p| [Temperature::ID, Position::ID].map(|it| block.get(layout, it, p, 0));
    let all = warehouse.blocks().flat_map(|(_, block)| (0..block.count).map(move |p| of(block, p)));
    let error = all.map(|[t, x]| (t - exact(x, 60.0)).abs()).fold(0.0, f64::max);
    println!("rank {}: at most {error:.3} K from the closed form after 60 s", network.rank());
    Ok(())
}
