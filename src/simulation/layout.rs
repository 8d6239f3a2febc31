//! How a scene is cut into patches.
use super::start::{Roll, census};
use engine::exec::ranks::Alone;
use grid::{BlockIndex, Decomposition, Level};
use scene::{Patches, Scene};

/// The level of a scene.
pub fn level(scene: &Scene) -> Level {
    Level { lower: scene.domain.lower, cell: scene.domain.cell, cells: scene.domain.cells }
}

/// The patches that the scene asks for, or about `wanted` of them, for so many ranks, cut where the particles are; and the
/// number of particles in each.
///
/// # Errors
/// Patches that do not fit the level.
pub fn decompose(scene: &Scene, wanted: usize, ranks: usize) -> Result<(Decomposition, Vec<u64>), String> {
    let count = |network: &mut Alone| census(scene, &Roll::call(scene, network)?, network);
    cut(scene, wanted, ranks, &count(&mut Alone).map_err(|lost| lost.to_string())?)
}

/// The same, where the particles are in blocks that are known.
///
/// # Errors
/// Patches that do not fit the level.
pub fn cut(
    scene: &Scene,
    wanted: usize,
    ranks: usize,
    census: &[(BlockIndex, u64)],
) -> Result<(Decomposition, Vec<u64>), String> {
    let level = level(scene);
    let decomposition = match scene.run.patches {
        Some(Patches::Grid(counts)) => Decomposition::new(&level, counts)?,
        Some(Patches::Total(total)) => Decomposition::automatic(&level, total, ranks, census),
        None => Decomposition::automatic(&level, wanted, ranks, census),
    };
    let loads = decomposition.loads(census);
    Ok((decomposition, loads))
}
