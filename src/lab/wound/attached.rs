//! Which particles still belong to the slab.
use super::{Tissue, code};
use std::collections::HashMap;

/// For each particle, whether it is in the largest body of target particles, connected through the faces of cubes
/// with edge `cube` [m], and not a failed one that moved farther than `reach` [m].
pub fn attached(tissue: &Tissue, cube: f64, reach: f64) -> Vec<bool> {
    let near = |i: usize| {
        let moved: f64 = (0..3).map(|a| (tissue.now[i][a] - tissue.start[i][a]).powi(2)).sum();
        tissue.failure[i] == code::NONE || moved <= reach * reach
    };
    let cube_of = |i: usize| tissue.now[i].map(|x| (x / cube).floor() as i64);
    let mut cubes: HashMap<[i64; 3], (usize, usize)> = HashMap::new(); // particles, label
    for i in (0..tissue.now.len()).filter(|&i| near(i)) {
        cubes.entry(cube_of(i)).or_default().0 += 1;
    }
    let largest = label_bodies(&mut cubes);
    let in_largest = |i: usize| cubes.get(&cube_of(i)).is_some_and(|cube| cube.1 == largest);
    (0..tissue.now.len()).map(|i| near(i) && in_largest(i)).collect()
}

/// Numbers connected bodies from 1 and returns the one with most particles. (Sums do not depend on hash order.)
fn label_bodies(cubes: &mut HashMap<[i64; 3], (usize, usize)>) -> usize {
    let mut keys: Vec<_> = cubes.keys().copied().collect();
    keys.sort_unstable();
    let (mut largest, mut most, mut label) = (0, 0, 0);
    for key in keys {
        if cubes[&key].1 != 0 {
            continue;
        }
        label += 1;
        let (mut particles, mut open) = (0, vec![key]);
        while let Some(key) = open.pop() {
            let Some(cube) = cubes.get_mut(&key).filter(|cube| cube.1 == 0) else { continue };
            cube.1 = label;
            particles += cube.0;
            for axis in 0..3 {
                for step in [-1, 1] {
                    let mut neighbor = key;
                    neighbor[axis] += step;
                    open.push(neighbor);
                }
            }
        }
        if particles > most {
            (largest, most) = (label, particles);
        }
    }
    largest
}
