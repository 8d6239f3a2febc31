use crate::labels::{MassFlow, NodeSums, ScatterRows, StressFlow, Weights};
use bytemuck::cast_slice_mut;
use engine::graph::task::{At, Body};
use shapes::for_each_particle_by_class;
use shapes::transfer::scatter;
use shapes::{GROUP, NodeRows, Stencil};
use simd::{Simd, Wide, load};

engine::task! {
    /// Particles add their mass, momentum, internal force and volume to the grid nodes around them.
    pub struct Scatter;

    Particles task {
        requires new { weights: Weights, mass: MassFlow, stress: StressFlow }
        computes { nodes: NodeSums @ 3 }
        scratch { rows: ScatterRows }
    }
}

impl Body for Scatter {
    #[inline(always)]
    fn run<S: Simd>(&self, at: &At<'_>, mut io: Io<'_>) {
        for ((m, s), rows) in io.mass.iter().zip(io.stress.iter()).zip(io.rows.iter_mut()) {
            let [mass, px, py, pz] = load::<S, 4>(m);
            let [xx, xy, xz, yy, yz, zz, volume] = load::<S, 7>(s);
            to_rows([mass, px, py, pz], [xx, xy, xz, yy, yz, zz], volume, rows);
        }
        scatter_rows::<S>(at, &io.weights, &io.rows, cast_slice_mut(&mut io.nodes));
    }
}

/// Columns of eight particles to the rows that `scatter` takes: A and B go with S_Ip, the symmetric T with ∇S_Ip.
#[inline(always)]
pub fn to_rows<S: Simd>(a: [S; 4], t: [S; 6], b: S, rows: &mut NodeRows) {
    let zero = S::splat(0.0);
    let [xx, xy, xz, yy, yz, zz] = t;
    let first = S::transpose([a[0], a[1], a[2], a[3], xx, xy, xz, b]);
    let second = S::transpose([xz, yz, zz, zero, xy, yy, yz, zero]);
    for lane in 0..8 {
        first[lane].store(&mut rows[lane][0]);
        second[lane].store(&mut rows[lane][1]);
    }
}

/// Adds rows to nodes, group by group of tiles, within a group by class, within a class in particle order: an
/// order that only the block's own particles decide.
#[inline(always)]
pub fn scatter_rows<S: Simd>(at: &At<'_>, weights: &[Stencil], rows: &[NodeRows], nodes: &mut [Wide]) {
    for (group, (weights, rows)) in weights.chunks(GROUP).zip(rows.chunks(GROUP)).enumerate() {
        let count = at.count.saturating_sub(8 * GROUP * group).min(8 * GROUP);
        for_each_particle_by_class!(weights, count, |i, X, Y, Z| scatter::<S, X, Y, Z>(
            nodes,
            &weights[i >> 3],
            i & 7,
            &rows[i >> 3][i & 7]
        ));
    }
}
