//! Faces beyond which matter goes on as its image, and the nodes of a block's buffer that lie on and beyond them.
//!
//! A node beyond a face, a ghost, moves as its image within the domain moves: v_full = C v. So M = Cᵀ M_full C and f = Cᵀ f_full, and
//! the ghosts need not be solved for: what particles give to them is folded onto their images, and particles that read
//! them find the motion of their images. Both are done in the buffer of a block, which has the image of each ghost that particles
//! within the domain touch; where faces meet, one axis after the other.
use engine::graph::task::At;
use grid::IndexBox;
use physics::faces::Image;

/// The faces that have images, in the order x−, x+, y−, y+, z−, z+.
#[derive(Clone, Debug, PartialEq)]
pub struct Images {
    /// How matter goes on beyond each face.
    pub faces: [Option<Image>; 6],
    /// Cells of the level along each axis.
    pub cells: [usize; 3],
}

/// A face within reach of the particles of a block.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reached {
    /// Which one.
    pub face: usize,
    /// Its normal.
    pub axis: usize,
    /// The nodes that lie on it.
    pub plane: i32,
    /// The diagonal of R.
    pub signs: [f64; 3],
    /// The nodes on the face that the particles touch.
    pub on: IndexBox,
    /// The nodes beyond it that they touch.
    pub beyond: IndexBox,
    touched: IndexBox,
}

impl Images {
    /// Whether there is any.
    pub fn is_empty(&self) -> bool {
        self.faces.iter().all(Option::is_none)
    }

    /// The image within the domain of a node, and the diagonal of all R on the way: itself and 1 within the domain.
    #[inline]
    pub fn within(&self, node: [i32; 3]) -> ([i32; 3], [f64; 3]) {
        let (mut image, mut signs) = (node, [1.0; 3]);
        for face in 0..6 {
            let Some(here) = self.faces[face] else { continue };
            let (axis, last) = (face / 2, self.cells[face / 2] as i32);
            let plane = if face.is_multiple_of(2) { 0 } else { last };
            if (plane == 0 && image[axis] < 0) || (plane > 0 && image[axis] > last) {
                image[axis] = 2 * plane - image[axis];
                let turned = here.signs(axis);
                signs = [0, 1, 2].map(|a| signs[a] * turned[a]);
            }
        }
        (image, signs)
    }

    /// The faces within reach of the particles of a block.
    #[inline(always)]
    pub fn reached<'a>(&'a self, at: &At<'_>) -> impl Iterator<Item = Reached> + use<'a> {
        let touched = at.touched;
        (0..6).filter_map(move |face| {
            let (axis, image) = (face / 2, self.faces[face]?);
            let plane = if face.is_multiple_of(2) { 0 } else { self.cells[axis] as i32 };
            if plane < touched.lower[axis] || plane >= touched.upper[axis] {
                return None;
            }
            let (mut on, mut beyond) = (touched, touched);
            (on.lower[axis], on.upper[axis]) = (plane, plane + 1);
            match face.is_multiple_of(2) {
                true => beyond.upper[axis] = plane,
                false => beyond.lower[axis] = plane + 1,
            }
            Some(Reached { face, axis, plane, signs: image.signs(axis), on, beyond, touched })
        })
    }
}

impl Reached {
    /// The nodes beyond the face that the particles touch, with their images; `None`: no particle within the domain reaches so far.
    #[inline(always)]
    pub fn ghosts(self) -> impl Iterator<Item = ([i32; 3], Option<[i32; 3]>)> {
        self.beyond.iter().map(move |ghost| {
            let mut image = ghost;
            image[self.axis] = 2 * self.plane - ghost[self.axis];
            (ghost, self.touched.contains(image).then_some(image))
        })
    }
}
