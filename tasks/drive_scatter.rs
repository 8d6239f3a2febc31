use crate::drives::{Driven, Drives};
use crate::images::Images;
use crate::labels::{DriveIndex, DriveSums, Mass, NodeSums, OwnStep, Position, Weights};
use engine::graph::task::{At, Body};
use grid::Lattice;
use simd::{LANES, Simd};

engine::task! {
    /// Driven particles tell their nodes how the drive moves them, axis by axis: M_I = Σ_p S_Ip m_p and P_I = Σ_p S_Ip m_p V(x_I), with V(x_I)
    /// the velocity that takes the node along with their drive. So nodes between two drives know of both.
    /// A particle that turns gives nodes the velocity of its matter there, v_p + L (x_I − x_p): else it would brake and its drive would
    /// push it on again, with a torque that grows as 1/Δt.
    pub struct DriveScatter {
        /// The drives.
        pub drives: Drives,
        /// Faces: what belongs to nodes beyond them goes to their images.
        pub images: Images,
        /// Where nodes are.
        pub lattice: Lattice,
    }

    Particles task {
        requires old { index: DriveIndex, mass: Mass, position: Position }
        requires new { step: OwnStep, weights: Weights }
        computes { driven: DriveSums @ 3, nodes: NodeSums @ 3 }
    }
}

impl Body for DriveScatter {
    #[inline(always)]
    fn run<S: Simd>(&self, at: &At<'_>, mut io: Io<'_>) {
        let mut drives = self.drives.during(&io.step[0]);
        for (tile, (index, mass)) in io.index.iter().zip(io.mass.iter()).enumerate() {
            for lane in (0..LANES).filter(|&lane| index.0[lane] > 0.0) {
                let Some(Driven { chord, components, gradient }) = drives.of(index.0[lane]) else { continue };
                let x = io.position[tile].map(|x| x.0[lane]);
                for (line, s, _) in io.weights[tile].nodes(lane, &at.origin) {
                    let (node, sm) = (at.origin.node_at(line), s * mass.0[lane]);
                    let place = self.lattice.position(node);
                    let v = chord.velocity(place);
                    let (image, signs) = self.images.within(node);
                    let v = [0, 1, 2].map(|a| signs[a] * v[a]);
                    io.driven[at.in_buffer(image)].add(sm, components, v);
                    let r: [f64; 3] = std::array::from_fn(|a| place[a] - x[a]);
                    let more = |a: usize| (0..3).map(|b| gradient[3 * a + b] * r[b]).sum::<f64>();
                    io.nodes[line]
                        .add_momentum([0, 1, 2].map(|a| if components[a] { sm * more(a) } else { 0.0 }));
                }
            }
        }
    }
}
