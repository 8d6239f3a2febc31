//! What holds on a face of the domain.
use crate::contact::AnyContactLaw;
use crate::motion::Course;

/// A condition on a face: pure functions. Its parameters are its fields.
///
/// A new one is one file with this and [`Described`](crate::parameter::Described), and one line in
/// [`faces`](super).
pub trait FaceCondition {
    /// Whether it ever asks for a change.
    fn acts(&self) -> bool {
        true
    }

    /// How matter goes on beyond the face, if it does.
    fn image(&self) -> Option<Image> {
        None
    }

    /// How the face moves and meets matter, if it is a wall of its own.
    fn wall(&self) -> Option<Wall> {
        None
    }

    /// Change of velocity [m/s] that the face asks of a node on it. `axis` (0, 1, 2) is normal to the face, `time` [s] the
    /// end of the step, `velocity` [m/s] that of the node so far.
    fn correction(&self, axis: usize, time: f64, velocity: [f64; 3]) -> [f64; 3];
}

/// A face that pushes matter like a tool does.
#[derive(Clone, Debug, PartialEq)]
pub struct Wall {
    /// How it moves.
    pub course: Course,
    /// How it meets matter.
    pub law: AnyContactLaw,
}

/// How matter goes on beyond a face at rest: velocities, momenta and forces there are those of the mirrored node, turned by
/// R, and so a node on the face cannot move where R turns. Mass, volume and surfaces are mirrored in any case.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Image {
    /// R = 1 − 2 n nᵀ: a mirror.
    Mirror,
    /// R = −1: an odd continuation, so that what is between the face and the nodes next to it is sheared and compressed as if
    /// matter went on that rests on the average.
    Odd,
}

impl Image {
    /// The diagonal of R, for a face with its normal along `axis`.
    #[inline(always)]
    pub fn signs(self, axis: usize) -> [f64; 3] {
        match self {
            Image::Mirror => std::array::from_fn(|a| if a == axis { -1.0 } else { 1.0 }),
            Image::Odd => [-1.0; 3],
        }
    }
}
