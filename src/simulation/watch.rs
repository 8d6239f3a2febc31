//! Warnings that a run gives itself: what its numbers say against it, each once, with cause and remedy.
use super::Simulation;
use super::report::{MaterialReport, Report};
use engine::data::warehouse::Warehouse;
use engine::exec::ranks::{NetworkError, collective};
use engine::schema::Label;
use physics::law::UNSTABLE;
use scene::{Body, Scene};
use simd::LANES;
use std::collections::{BTreeSet, HashMap, HashSet};
use tasks::labels::{Position, SignalSpeed};

/// Of the energy turned over, which the accounts may not explain.
const UNEXPLAINED: f64 = 0.05;
/// Cells across a body that deforms, below which its stresses are those of the grid.
const THIN: f64 = 2.0;

/// Of the particles of a material, which may be beyond its stability: those that fail in the next steps pass through it.
const FEW: f64 = 0.002;

/// What was said so far.
#[derive(Debug, Default)]
pub struct Watch {
    said: BTreeSet<String>,
    /// Pairs of materials of which neither yields to the other.
    strangers: Vec<[usize; 2]>,
    begun: bool,
}

impl Watch {
    /// Of a run that goes on, and has said this.
    pub fn after(said: &[Said]) -> Self {
        Self { said: said.iter().map(|(key, _)| key.clone()).collect(), ..Self::default() }
    }

    /// What there is to say at a row of the history, and was not said before: the same on all ranks, which all call it.
    ///
    /// # Errors
    /// If a rank is gone.
    pub fn look(&mut self, simulation: &mut Simulation, report: &Report) -> Result<Vec<Said>, NetworkError> {
        let mut found = Vec::new();
        if !std::mem::replace(&mut self.begun, true) {
            self.strangers = strangers(&simulation.scene);
            found.extend(thin(&simulation.scene));
            found.extend(sharp(&simulation.scene));
        }
        found.extend(unexplained(report));
        found.extend(too_fast(simulation, report));
        found.extend(unstable(report, &simulation.scene));
        found.extend(self.meetings(simulation, report)?);
        found.retain(|(key, _)| self.said.insert(key.clone()));
        Ok(found)
    }

    /// Materials that pass through one another.
    fn meetings(&mut self, simulation: &mut Simulation, report: &Report) -> Result<Vec<Said>, NetworkError> {
        if self.strangers.is_empty() {
            return Ok(Vec::new());
        }
        let Simulation { scene, warehouse, .. } = &*simulation;
        let here = |pair: &[usize; 2]| u64::from(overlap(warehouse, *pair, closest(scene, *pair)));
        let mut met: Vec<u64> = self.strangers.iter().map(here).collect();
        collective::sum(simulation.network(), &mut met)?;
        let pairs: Vec<_> = self.strangers.iter().zip(&met).filter(|(_, met)| **met > 0).collect();
        let scene = &simulation.scene;
        let told = pairs.iter().map(|(pair, _)| {
            let [a, b] = pair.map(|m| scene.materials[m].name.as_str());
            let why = match scene.meet(pair) {
                true => "drives hold both. Let one of them yield, or keep them apart",
                false => "they have no [[contact]]. Add one between them, or give their bodies one material",
            };
            let text = format!("{a} and {b} pass through one another, t = {:.4e} s: {why}", report.time);
            (format!("meet {a} {b}"), text)
        });
        let told = told.collect();
        let met: HashSet<_> = pairs.into_iter().map(|(pair, _)| *pair).collect();
        self.strangers.retain(|pair| !met.contains(pair));
        Ok(told)
    }
}

/// What is said once, by its key.
pub type Said = (String, String);

fn unexplained(report: &Report) -> Option<Said> {
    let part = report.residual / report.turnover;
    let (percent, time) = (100.0 * part.abs(), report.time);
    let what = match part {
        part if part > UNEXPLAINED => "has vanished",
        part if part < -UNEXPLAINED => "has come from nowhere",
        _ => return None,
    };
    let text = format!(
        "{percent:.0} % of the energy turned over {what}, t = {time:.4e} s. Lower run.cfl; if that does not help, look for matter that is \
         asked to move in two ways at once (a grip against a face, a layer thinner than three cells between tools)"
    );
    Some((format!("energy {what}"), text))
}

/// A particle that alone has more energy than was ever turned over.
fn too_fast(simulation: &Simulation, report: &Report) -> Option<Said> {
    let (scene, shared) = (&simulation.scene, &simulation.warehouse.shared);
    scene.deformable().find_map(|m| {
        let lanes = shared.get::<[simd::Wide; 3]>(SignalSpeed::ID, m)[2].0;
        let speed = lanes.into_iter().fold(0.0, f64::max);
        let mass = lightest(scene, m)?;
        let energy = 0.5 * mass * speed * speed;
        (report.turnover > 0.0 && energy > (1.0 + UNEXPLAINED) * report.turnover).then(|| {
            let name = &scene.materials[m].name;
            let text = format!(
                "a particle of {name} moves at {speed:.3e} m/s, t = {:.4e} s: it alone has more energy than was turned over. Lower run.cfl, or use \
                 more particles a cell where it was torn off",
                report.time
            );
            (format!("fast {name}"), text)
        })
    })
}

/// Particles whose law has lost its stability.
fn unstable<'a>(report: &'a Report, scene: &'a Scene) -> impl Iterator<Item = Said> + 'a {
    let told = |(m, it): (usize, &MaterialReport)| {
        let (count, name, time) = (it.count(UNSTABLE), &scene.materials[m].name, report.time);
        let text = format!(
            "{count} of {} particles of {name} are beyond the stability of their law, t = {time:.4e} s: pulled further they bear less, strain \
             gathers in single cells, and results depend on the cell size. Load it less, let it fail before, or check its parameters \
             (fibers that are straight too early, a bulk modulus too small)",
            it.particles
        );
        (count as f64 > FEW * it.particles as f64).then(|| (format!("unstable {name}"), text))
    };
    report.materials.iter().enumerate().filter_map(told)
}

/// Mass of the lightest particle of a material at the start [kg].
fn lightest(scene: &Scene, material: usize) -> Option<f64> {
    let bodies = scene.bodies.iter().filter(|body| body.material == material);
    let most = bodies.map(|body| body.particles_per_cell.iter().product::<usize>()).max()?;
    Some(scene.materials[material].density * scene.domain.cell.powi(3) / most as f64)
}

/// Bodies that the grid does not resolve.
fn thin(scene: &Scene) -> Vec<Said> {
    let deforms = |body: &&Body| !scene.materials[body.material].is_rigid();
    let one = |body: &Body| {
        let (lower, upper) = body.solid.bounds();
        let (first, last) = scene::sampling::inside(&scene.domain);
        // what reaches a face goes on there: as far again, or, between two of them, without end
        let reaches = |a: usize| usize::from(lower[a] <= first[a]) + usize::from(upper[a] >= last[a]);
        let across = |a: usize| {
            let images = [1.0, 2.0, f64::INFINITY][reaches(a)];
            images * (upper[a] - lower[a]) / scene.domain.cell
        };
        let a = (0..3).find(|&a| across(a) < THIN - 1e-6)?;
        let (name, axis, cells) = (&body.name, ["x", "y", "z"][a], across(a));
        let text = format!(
            "body {name:?} is {cells:.2} cells thick along {axis}: below {THIN} cells its stiffness is that of the grid. Use smaller cells"
        );
        Some((format!("thin {name}"), text))
    };
    scene.bodies.iter().filter(deforms).filter_map(one).collect()
}

/// Tools and rigid bodies that the grid makes blunt: narrow along two axes. A plate is narrow along one: it holds as it should.
fn sharp(scene: &Scene) -> Vec<Said> {
    let rigid = |body: &&Body| scene.materials[body.material].is_rigid();
    let one = |body: &Body| {
        let mut extents = body.solid.extents();
        extents.sort_by(f64::total_cmp);
        let (name, cells) = (&body.name, extents[1] / scene.domain.cell);
        let text = format!(
            "tool {name:?} is {cells:.2} cells across: below {THIN} cells it presses like one as wide as the grid, with two to three times the \
             force. Use smaller cells"
        );
        (cells < THIN - 1e-6).then(|| (format!("sharp {name}"), text))
    };
    scene.bodies.iter().filter(rigid).filter_map(one).collect()
}

/// Pairs of materials with particles that have no contact, or that drives hold both.
fn strangers(scene: &Scene) -> Vec<[usize; 2]> {
    let driven = |m: &usize| scene.drives.iter().any(|drive| drive.material == *m);
    let yields = |pair: &[usize; 2]| scene.meet(pair) && !pair.iter().all(driven);
    let seen = |pair: &[usize; 2]| pair.iter().all(|&m| scene.materials[m].has_particles());
    scene.pairs().into_iter().filter(|pair| seen(pair) && !yields(pair)).collect()
}

/// How close particles of two materials come that do not lie in one another [m]: well below their spacing.
fn closest(scene: &Scene, pair: [usize; 2]) -> f64 {
    let bodies = scene.bodies.iter().filter(|body| pair.contains(&body.material));
    let most = bodies.flat_map(|body| body.particles_per_cell).max().unwrap_or(1);
    0.7 * scene.domain.cell / most as f64
}

/// Whether particles of both materials lie in one cube with this side [m], on this rank.
fn overlap(warehouse: &Warehouse, [a, b]: [usize; 2], side: f64) -> bool {
    let level = &warehouse.level;
    let mut cells: HashMap<[i32; 3], HashSet<[i64; 3]>> = HashMap::new();
    let in_cells = |material: usize, block: &engine::data::particles::ParticleBlock| -> Vec<[i64; 3]> {
        let layout = &warehouse.materials[material].layout;
        let column = block.column(layout, Position::ID);
        let at = |p: usize, axis: usize| {
            ((column[p / LANES * 3 + axis].0[p % LANES] - level.lower[axis]) / side).floor() as i64
        };
        (0..block.count).map(|p| [at(p, 0), at(p, 1), at(p, 2)]).collect()
    };
    let of = |material: usize| warehouse.blocks().filter(move |(m, block)| *m == material && block.count > 0);
    let shared: HashSet<[i32; 3]> = of(b).map(|(_, block)| block.index).collect();
    for (m, block) in of(a).filter(|(_, block)| shared.contains(&block.index)) {
        cells.entry(block.index).or_default().extend(in_cells(m, block));
    }
    let meets = |m: usize, block: &engine::data::particles::ParticleBlock| {
        cells
            .get(&block.index)
            .is_some_and(|there| in_cells(m, block).iter().any(|cell| there.contains(cell)))
    };
    of(b).any(|(m, block)| meets(m, block))
}
