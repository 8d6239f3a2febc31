//! How a scene is cut into patches.
use grid::{BlockIndex, Decomposition, Level};
use scene::sampling;
use scene::{Patches, Scene};
use std::collections::BTreeMap;
use tasks::recipes;

/// The level of a scene.
pub fn level(scene: &Scene) -> Level {
    Level { lower: scene.domain.lower, cell: scene.domain.cell, cells: scene.domain.cells }
}

/// The patches that the scene asks for, or about `wanted` of them, cut where the particles are; and the number of particles
/// in each.
///
/// # Errors
/// Patches that do not fit the level.
pub fn decompose(scene: &Scene, wanted: usize) -> Result<(Decomposition, Vec<u64>), String> {
    cut(scene, wanted, &census(scene, &level(scene)))
}

/// The same, where the particles are in blocks that are known.
///
/// # Errors
/// Patches that do not fit the level.
pub fn cut(
    scene: &Scene,
    wanted: usize,
    census: &[(BlockIndex, u64)],
) -> Result<(Decomposition, Vec<u64>), String> {
    let level = level(scene);
    let counts = match scene.run.patches {
        Some(Patches::Grid(counts)) => counts,
        Some(Patches::Total(total)) => Decomposition::automatic(&level, total, census),
        None => Decomposition::automatic(&level, wanted, census),
    };
    let decomposition = Decomposition::new(&level, counts)?;
    let loads = decomposition.loads(census);
    Ok((decomposition, loads))
}

/// The blocks that the particles of `scene` occupy, with their number.
fn census(scene: &Scene, level: &Level) -> Vec<(BlockIndex, u64)> {
    let mut blocks = BTreeMap::new();
    for body in &scene.bodies {
        let half_size = recipes::half_size(scene, body.material);
        for x in sampling::sample(scene, body) {
            let block = Level::block_of(level.base_node(x, half_size));
            *blocks.entry(block).or_default() += 1;
        }
    }
    blocks.into_iter().collect()
}
