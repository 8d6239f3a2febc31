//! Mass, center and inertia of bodies: sums over lattices to which each rank adds its share of rows, and which no order changes.
use super::roll::rows;
use super::share;
use engine::data::exact_sum::ExactSum;
use engine::data::warehouse::Warehouse;
use engine::exec::ranks::{Network, NetworkError, collective};
use engine::schema::Label;
use nalgebra::{Matrix3, Vector3};
use scene::sampling::{self, Filling, Span, size};
use scene::{Behavior, Body, RigidMotion, Scene};
use tasks::labels::RigidMotion as RigidMotionLabel;
use tasks::labels::{Position, ReferencePosition};
use tasks::recipes;
use tasks::rigid::state::RigidState;

/// Sums over the points of a box along an axis: of x, counted from `from` [m], and of x². They are evenly spaced.
fn along(filling: &Filling, piece: &Span, axis: usize, from: f64) -> [f64; 2] {
    let (first, last) = (filling.at(axis, piece[axis].start), filling.at(axis, piece[axis].end - 1));
    let (count, half) = ((piece[axis].end - piece[axis].start) as f64, 0.5 * (last - first));
    let mean = first + half - from;
    // of n points over 2 half: their variance is half² (n + 1) / (3 (n - 1))
    let variance = if count > 1.0 { half * half * (count + 1.0) / (3.0 * (count - 1.0)) } else { 0.0 };
    [count * mean, count * (mean * mean + variance)]
}

/// Adds up `N` numbers of each box of particles of some bodies, over all ranks.
fn sums<'a, const N: usize>(
    scene: &Scene,
    bodies: impl Iterator<Item = &'a Body>,
    network: &mut dyn Network,
    of: impl Fn(&Body, &Filling, &Span) -> [f64; N],
) -> Result<[f64; N], NetworkError> {
    let mut sums = [ExactSum::default(); N];
    for body in bodies {
        let numbering = rows(scene, body);
        for row in share(network, numbering.rows()) {
            numbering.pieces(row, &mut |piece| {
                let numbers = of(body, numbering.filling(), piece);
                sums.iter_mut().zip(numbers).for_each(|(sum, number)| sum.add(number));
            });
        }
    }
    // digits add up without a carry between them
    collective::sum(network, bytemuck::cast_slice_mut(&mut sums))?;
    Ok(sums.map(|sum| sum.value()))
}

/// Mass of the particles of a box, and mass times position, if each has a mass of `m`.
fn mass_and_moment(filling: &Filling, piece: &Span, m: f64) -> [f64; 4] {
    let count = size(piece) as f64;
    let moment = [0, 1, 2].map(|a| {
        let beside = count / (piece[a].end - piece[a].start) as f64;
        m * (along(filling, piece, a, 0.0)[0] * beside)
    });
    [m * count, moment[0], moment[1], moment[2]]
}

/// The center of mass of a body's particles [m]. All ranks call it.
///
/// # Errors
/// If a rank is gone.
pub fn center(scene: &Scene, body: &Body, network: &mut dyn Network) -> Result<[f64; 3], NetworkError> {
    let of = |_: &Body, filling: &Filling, piece: &Span| mass_and_moment(filling, piece, 1.0);
    let [count, moment @ ..] = sums(scene, std::iter::once(body), network, of)?;
    Ok(moment.map(|sum| if count > 0.0 { sum / count } else { 0.0 }))
}

/// Puts rigid bodies where they are at the start. All ranks call it.
///
/// # Errors
/// If a rank is gone.
pub fn place_bodies(
    scene: &Scene,
    warehouse: &mut Warehouse,
    network: &mut dyn Network,
) -> Result<(), NetworkError> {
    for material in 0..scene.materials.len() {
        if let Behavior::Rigid(motion) = &scene.materials[material].behavior {
            let body = start(scene, material, motion, network)?;
            warehouse.shared.set(RigidMotionLabel::ID, material, body);
            refer(warehouse, material, body.center);
        }
    }
    Ok(())
}

/// Mass, center, inertia and motion of a rigid material.
fn start(
    scene: &Scene,
    material: usize,
    motion: &RigidMotion,
    network: &mut dyn Network,
) -> Result<RigidState, NetworkError> {
    let bodies = || scene.bodies_of(material);
    let mass_of = |body: &Body| scene.materials[material].density * sampling::particle_volume(scene, body);
    let given = match motion {
        RigidMotion::Prescribed { center, .. } => *center,
        RigidMotion::Free { .. } => None,
    };
    // of a tool only its center counts: where it says, or that of what is in the domain
    let first = |body: &Body, filling: &Filling, piece: &Span| mass_and_moment(filling, piece, mass_of(body));
    let [mass, moment @ ..] = match given {
        Some(_) => [0.0; 4],
        None => sums(scene, bodies(), network, first)?,
    };
    let within = mass > 0.0;
    let of_mass =
        || if within { moment.map(|sum| sum / mass) } else { recipes::middle(&scene.shape(material)) };
    let center = given.unwrap_or_else(of_mass);
    let inertia = match motion {
        RigidMotion::Free { .. } => inertia(scene, bodies(), center, network, mass_of)?,
        RigidMotion::Prescribed { .. } => Matrix3::zeros(),
    };
    let (velocity, angular, free) = match motion {
        RigidMotion::Free { angular_velocity, locked, locked_turns, .. } => {
            let held =
                |v: [f64; 3], locked: &[bool; 3]| std::array::from_fn(|a| if locked[a] { 0.0 } else { v[a] });
            // its bodies start with one velocity
            let v = bodies().next().map_or([0.0; 3], |body| body.velocity);
            (held(v, locked), held(*angular_velocity, locked_turns), 1.0)
        }
        RigidMotion::Prescribed { .. } => ([0.0; 3], [0.0; 3], 0.0),
    };
    let mut body = RigidState {
        // what is there and has no mass would not be there
        mass: if within { mass } else { f64::MIN_POSITIVE },
        center,
        velocity,
        angular,
        free,
        origin: center,
        inertia: std::array::from_fn(|n| inertia[(n / 3, n % 3)]),
        ..bytemuck::Zeroable::zeroed()
    };
    (0..3).for_each(|a| body.rotation[4 * a] = 1.0);
    Ok(body)
}

/// The inertia of particles about a center [kg m²], each of them a box.
fn inertia<'a>(
    scene: &Scene,
    bodies: impl Iterator<Item = &'a Body>,
    center: [f64; 3],
    network: &mut dyn Network,
    mass_of: impl Fn(&Body) -> f64,
) -> Result<Matrix3<f64>, NetworkError> {
    let second = |body: &Body, filling: &Filling, piece: &Span| {
        let (m, count) = (mass_of(body), size(piece) as f64);
        let n = [0, 1, 2].map(|a| (piece[a].end - piece[a].start) as f64);
        let [x, y, z] = [0, 1, 2].map(|a| along(filling, piece, a, center[a]));
        let [xx, yy, zz] = [x[1] * (n[1] * n[2]), y[1] * (n[2] * n[0]), z[1] * (n[0] * n[1])];
        let edges = Vector3::from(body.particles_per_cell.map(|n| scene.domain.cell / n as f64));
        let own = edges.component_mul(&edges) * (count / 12.0);
        [
            m * (yy + zz + own.y + own.z),
            m * (zz + xx + own.z + own.x),
            m * (xx + yy + own.x + own.y),
            -m * (x[0] * y[0] * n[2]),
            -m * (y[0] * z[0] * n[0]),
            -m * (z[0] * x[0] * n[1]),
        ]
    };
    let [xx, yy, zz, xy, yz, zx] = sums(scene, bodies, network, second)?;
    Ok(Matrix3::new(xx, xy, zx, xy, yy, yz, zx, yz, zz))
}

/// Notes where the particles of a rigid material are, seen from its center [m].
fn refer(warehouse: &mut Warehouse, material: usize, center: [f64; 3]) {
    let layout = warehouse.materials[material].layout.clone();
    for block in warehouse.particles.iter_mut().flat_map(|patch| &mut patch[material].blocks) {
        for particle in 0..block.count {
            for (a, center) in center.iter().enumerate() {
                let r = block.get(&layout, Position::ID, particle, a) - center;
                block.set(&layout, ReferencePosition::ID, particle, a, r);
            }
        }
    }
}
