//! Moves particles that drifted out of reach of their block to the block, and the patch, where they are now.
use crate::data::extent::{MARGIN, bounds};
use crate::data::labels::LabelId;
use crate::data::particles::ParticleBlock;
use crate::data::warehouse::{MaterialData, Warehouse};
use crate::grid::{BLOCK, BlockIndex, Level};
use crate::physics::shape::{BASES, BELOW};

/// A particle on its way.
struct Traveler {
    material: usize,
    /// Block and position that it left: arrivals are taken in this order, whatever the patches are.
    from: (BlockIndex, usize),
    who: Left,
    record: Vec<f64>,
}

/// A particle that is no longer in the level.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Left {
    /// Its material.
    pub material: usize,
    /// Its patch before it left.
    pub patch: usize,
    /// Its identity.
    pub identity: u64,
    /// Where it is [m].
    pub position: [f64; 3],
    /// How it moves [m/s].
    pub velocity: [f64; 3],
    /// Its mass [kg].
    pub mass: f64,
}

/// Relocates the particles of the materials that `moved`, where they need it. Returns those outside the level, which are
/// taken out, and how many particles moved.
///
/// Looks only at blocks whose extent (label `BlockExtent`) says that somebody left. Whether a particle moves
/// depends on the particle alone, and arrivals are ordered by where they come from: no decomposition shows.
pub fn relocate(warehouse: &mut Warehouse, moved: impl Fn(usize) -> bool) -> (Vec<Left>, u64) {
    let (level, mut travelers, mut left) = (warehouse.level, Vec::new(), Vec::new());
    let mut particles = 0;
    for (patch, homes) in warehouse.particles.iter_mut().enumerate() {
        for (material, home) in homes.iter_mut().enumerate().filter(|(material, _)| moved(*material)) {
            particles += home.blocks.iter().map(|block| block.count as u64).sum::<u64>();
            let data = &warehouse.materials[material];
            for block in home.blocks.iter_mut().filter(|block| somebody_left(&level, data, block)) {
                depart(&level, data, (patch, material), block, &mut travelers, &mut left);
            }
        }
    }
    travelers.sort_by_key(|t: &Traveler| (t.material, t.from));
    for traveler in travelers {
        let Traveler { material, who, record, .. } = traveler;
        if warehouse.insert(material, who.position, &record).is_err() {
            left.push(who);
        }
    }
    left.sort_by_key(|l| l.identity);
    (left, particles)
}

/// Whether the coordinate y (base node before rounding down) is out of reach of the block on some axis; particles
/// move a margin early.
fn out_of_reach(block: BlockIndex, axis: usize, y: f64) -> bool {
    let first = f64::from(BLOCK * block[axis] - BELOW);
    !(y >= first + MARGIN && y < first + f64::from(BASES) - MARGIN)
}

fn outside(level: &Level, data: &MaterialData, axis: usize, y: f64) -> bool {
    let half = data.half_size[axis];
    !(y >= -half && y <= level.cells[axis] as f64 - half)
}

fn somebody_left(level: &Level, data: &MaterialData, block: &ParticleBlock) -> bool {
    block.count > 0
        && (0..3).any(|axis| {
            let (least, most) = bounds(&block.extent, axis);
            [least, most].iter().any(|&y| {
                y.is_finite() && (out_of_reach(block.index, axis, y) || outside(level, data, axis, y))
            })
        })
}

fn depart(
    level: &Level,
    data: &MaterialData,
    (patch, material): (usize, usize),
    block: &mut ParticleBlock,
    travelers: &mut Vec<Traveler>,
    left: &mut Vec<Left>,
) {
    let layout = &data.layout;
    let mut leaving = Vec::new();
    for particle in 0..block.count {
        let get = |label, component| block.get(layout, label, particle, component);
        let x: [f64; 3] = std::array::from_fn(|a| get(LabelId::Position, a));
        let y = level.base(x, data.half_size);
        let gone = (0..3).any(|a| outside(level, data, a, y[a])) || !level.contains(x);
        if !gone && !(0..3).any(|a| out_of_reach(block.index, a, y[a])) {
            continue;
        }
        leaving.push(particle);
        let who = Left {
            material,
            patch,
            identity: get(LabelId::Identity, 0).to_bits(),
            position: x,
            velocity: std::array::from_fn(|a| get(LabelId::Velocity, a)),
            mass: get(LabelId::Mass, 0),
        };
        if gone {
            left.push(who);
        } else {
            let mut record = Vec::with_capacity(layout.total);
            block.read(layout, particle, &mut record);
            travelers.push(Traveler { material, from: (block.index, particle), who, record });
        }
    }
    block.remove(layout, level.middle(block.index), &leaving);
}
