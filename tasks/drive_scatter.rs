use crate::drives::Drives;
use crate::images::Images;
use crate::labels::{DriveIndex, DriveSums, Mass, OwnStep, Weights};
use engine::graph::task::{At, Body};
use grid::Lattice;
use simd::{LANES, Simd};

/// M_I = Σ_p S_Ip m_p and P_I = Σ_p S_Ip m_p V(x_I) over the driven particles, axis by axis, with V(x_I) the velocity that takes the
/// node along with their drive: so nodes between two drives know of both.
pub struct DriveScatter {
    /// The drives.
    pub drives: Drives,
    /// Faces: what belongs to nodes beyond them goes to their images.
    pub images: Images,
    /// Where nodes are.
    pub lattice: Lattice,
}

engine::task! { Particles task DriveScatter {
    requires old { index: DriveIndex, mass: Mass }
    requires new { step: OwnStep, weights: Weights }
    computes { nodes: DriveSums @ 3 }
}}

impl Body for DriveScatter {
    #[inline(always)]
    fn run<S: Simd>(&self, at: &At<'_>, mut io: Io<'_>) {
        let mut drives = self.drives.during(&io.step[0]);
        for (tile, (index, mass)) in io.index.iter().zip(io.mass.iter()).enumerate() {
            for lane in (0..LANES).filter(|&lane| index.0[lane] > 0.0) {
                let Some((chord, components)) = drives.of(index.0[lane]) else { continue };
                for (line, s, _) in io.weights[tile].nodes(lane, &at.origin) {
                    let node = at.origin.node_at(line);
                    let v = chord.velocity(self.lattice.position(node));
                    let (image, signs) = self.images.within(node);
                    let v = [0, 1, 2].map(|a| signs[a] * v[a]);
                    io.nodes[at.in_buffer(image)].add(s * mass.0[lane], components, v);
                }
            }
        }
    }
}
