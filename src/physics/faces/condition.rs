//! What holds on a face of the domain.

/// A condition on a face: pure functions of a node's velocity. Its parameters are its fields.
///
/// A new one is one file with this and [`Described`](crate::parameter::Described), and one line in
/// [`faces`](super).
pub trait FaceCondition {
    /// Whether it ever asks for a change.
    fn acts(&self) -> bool {
        true
    }

    /// Whether matter goes on beyond the face as its mirror image, so that a body that ends there has no surface there.
    fn is_mirror(&self) -> bool {
        false
    }

    /// Change of velocity [m/s] that the face asks of a node on it. `axis` (0, 1, 2) is normal to the face, `time` [s] the
    /// end of the step, `velocity` [m/s] that of the node so far.
    fn correction(&self, axis: usize, time: f64, velocity: [f64; 3]) -> [f64; 3];
}
