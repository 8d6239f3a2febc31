//! What a line of a node holds: the lane of each number stands here, and nowhere else.
use bytemuck::{Pod, Zeroable};
use physics::contact::dot;
use simd::{Simd, Wide};

/// What particles of one field give to a node: m, m v (3), f (3), V.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(transparent)]
pub struct Sums(pub Wide);

impl Sums {
    /// m_I [kg]
    #[inline(always)]
    pub fn mass(&self) -> f64 {
        self.0.0[0]
    }
    /// f_I [N]
    #[inline(always)]
    pub fn force(&self) -> [f64; 3] {
        let [_, _, _, _, x, y, z, _] = self.0.0;
        [x, y, z]
    }
    /// V_I [m³]
    #[inline(always)]
    pub fn volume(&self) -> f64 {
        self.0.0[7]
    }
    /// (m v)_I [N s]
    #[inline(always)]
    pub fn momentum(&self) -> [f64; 3] {
        let [_, x, y, z, ..] = self.0.0;
        [x, y, z]
    }
    /// The signs of a line whose momentum and force R turns.
    #[inline(always)]
    pub fn signs([x, y, z]: [f64; 3]) -> Wide {
        Wide([1.0, x, y, z, x, y, z, 1.0])
    }
    /// Adds a momentum.
    #[inline(always)]
    pub fn add_momentum(&mut self, momentum: [f64; 3]) {
        (0..3).for_each(|axis| self.0.0[1 + axis] += momentum[axis]);
    }
    /// Adds a force.
    #[inline(always)]
    pub fn add_force(&mut self, force: [f64; 3]) {
        (0..3).for_each(|axis| self.0.0[4 + axis] += force[axis]);
    }
    /// Takes away momentum and force along the axes that R turns.
    #[inline(always)]
    pub fn hold(&mut self, signs: [f64; 3]) {
        for axis in (0..3).filter(|&axis| signs[axis] < 0.0) {
            (self.0.0[1 + axis], self.0.0[4 + axis]) = (0.0, 0.0);
        }
    }
    /// (m v)_I, as the velocity of a [`Motion`] without a change.
    #[inline(always)]
    pub fn momentum_line<S: Simd>(&self) -> S {
        S::blend_force(S::load(&self.0).momentum_to_low(), S::splat(0.0))
    }
    /// f_I, as velocity and change of a [`Motion`].
    #[inline(always)]
    pub fn force_line<S: Simd>(&self) -> S {
        let force = S::load(&self.0).momentum_to_low().swap_halves();
        S::join_low(force, force)
    }
}

/// Where the surface of one field lies near a node: m, m x (3), Σ V ∇S (3), m b.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(transparent)]
pub struct Surface(pub Wide);

impl Surface {
    /// m_I of the particles that told where they are [kg].
    #[inline(always)]
    pub fn mass(&self) -> f64 {
        self.0.0[0]
    }
    /// The part of its mass whose bonds hold.
    #[inline(always)]
    pub fn bonded(&self) -> f64 {
        self.0.0[7] / self.0.0[0]
    }
    /// (m x)_I, an axis of it [kg m].
    #[inline(always)]
    pub fn moment(&self, axis: usize) -> f64 {
        self.0.0[1 + axis]
    }
    /// Σ V ∇S, which points out of the matter, an axis of it [m²].
    #[inline(always)]
    pub fn outward(&self, axis: usize) -> f64 {
        self.0.0[4 + axis]
    }
    /// Adds what particles gave to the image of this node beyond a mirror at `plane` [m] across `axis`.
    #[inline(always)]
    pub fn add_image(&mut self, image: &Surface, axis: usize, plane: f64) {
        let mut mirrored = image.0.0;
        mirrored[1 + axis] = 2.0 * plane * image.0.0[0] - image.0.0[1 + axis];
        mirrored[4 + axis] = -image.0.0[4 + axis];
        self.0.0.iter_mut().zip(mirrored).for_each(|(sum, part)| *sum += part);
    }
    /// A node on the mirror: what lies before it and its image have their center there, and no surface.
    #[inline(always)]
    pub fn center_on(&mut self, axis: usize, plane: f64) {
        self.0.0[1 + axis] = plane * self.0.0[0];
        self.0.0[4 + axis] = 0.0;
    }
}

/// Of a node's mass; a grip that holds less of it does not hold the node.
const LEAST: f64 = 1e-9;

/// What drives prescribe to a node: the mass that they hold along each axis (3), 0, and the momentum that they give it (3), 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(transparent)]
pub struct Driven(pub Wide);

impl Driven {
    /// Along each axis [kg].
    #[inline(always)]
    pub fn mass(&self) -> [f64; 3] {
        let [x, y, z, ..] = self.0.0;
        [x, y, z]
    }
    /// Along each axis [N s].
    #[inline(always)]
    pub fn momentum(&self) -> [f64; 3] {
        let [_, _, _, _, x, y, z, _] = self.0.0;
        [x, y, z]
    }
    /// How drives move a node of mass `m` [kg] along an axis, if they hold it [m/s].
    #[inline(always)]
    pub fn velocity(&self, axis: usize, m: f64) -> Option<f64> {
        (self.mass()[axis] > LEAST * m).then(|| self.momentum()[axis] / self.mass()[axis])
    }
    /// Adds a mass that is to move at `v` along the axes that count.
    #[inline(always)]
    pub fn add(&mut self, mass: f64, along: [bool; 3], v: [f64; 3]) {
        for axis in (0..3).filter(|&axis| along[axis]) {
            self.0.0[axis] += mass;
            self.0.0[4 + axis] += mass * v[axis];
        }
    }
}

/// What drives gave to a node: along each axis, for each mass that they hold [N s/kg] (3), 0; the mean velocity of the step (3), 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(transparent)]
pub struct Gift(pub Wide);

impl Gift {
    /// What was given, and how the node moved [m/s].
    #[inline(always)]
    pub fn new([x, y, z]: [f64; 3], [u, v, w]: [f64; 3]) -> Self {
        Self(Wide([x, y, z, 0.0, u, v, w, 0.0]))
    }
    /// More of it along an axis, for each mass that drives hold [N s/kg].
    #[inline(always)]
    pub fn give(&mut self, axis: usize, more: f64) {
        self.0.0[axis] += more;
    }
    /// For each mass that drives hold [N s/kg].
    #[inline(always)]
    pub fn share(&self) -> [f64; 3] {
        let [x, y, z, ..] = self.0.0;
        [x, y, z]
    }
    /// (v⁰ + v)/2 [m/s]
    #[inline(always)]
    pub fn mean(&self) -> [f64; 3] {
        let [_, _, _, _, x, y, z, _] = self.0.0;
        [x, y, z]
    }
}

/// What a node knows of the matter of one field near rigid bodies: where its center is (3), its mass, its normal traction, and how drives
/// move it (3), infinite along axes along which they do not.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(transparent)]
pub struct Site(pub Wide);

impl Site {
    /// From the sums of a node at whose place particles were some time [s] ago; nothing where none told where it is.
    #[inline(always)]
    pub fn of(sum: &Sums, surface: &Surface, ago: f64, v: [f64; 3], held: [Option<f64>; 3]) -> Self {
        if surface.mass() <= 0.0 {
            return Self::default();
        }
        // the center of mass goes on with the node while the particles wait
        let [x, y, z] = [0, 1, 2].map(|a| surface.moment(a) / surface.mass() + ago * v[a]);
        // the internal force of a uniformly stressed surface is −σ Σ V ∇S
        let outward: [f64; 3] = std::array::from_fn(|a| surface.outward(a));
        let square = dot(outward, outward);
        let traction = if square > 0.0 { -dot(sum.force(), outward) / square } else { 0.0 };
        let [u, v, w] = held.map(|v| v.unwrap_or(f64::INFINITY));
        Self(Wide([x, y, z, sum.mass(), traction, u, v, w]))
    }
    /// How drives move the matter, if there is some and they hold it [m/s].
    #[inline(always)]
    pub fn held(&self) -> Option<[f64; 3]> {
        let [_, _, _, m, _, u, v, w] = self.0.0;
        (m > 0.0 && u.is_finite() && v.is_finite() && w.is_finite()).then_some([u, v, w])
    }
    /// Y = Σ S m x / m: the center of the matter [m].
    #[inline(always)]
    pub fn center(&self) -> [f64; 3] {
        let [x, y, z, ..] = self.0.0;
        [x, y, z]
    }
    /// m_I [kg]; 0 where nothing is near.
    #[inline(always)]
    pub fn mass(&self) -> f64 {
        self.0.0[3]
    }
    /// Normal traction of the matter, positive in tension [Pa].
    #[inline(always)]
    pub fn traction(&self) -> f64 {
        self.0.0[4]
    }
}

/// How one field moves at a node: v (3), m, Δv (3), 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(transparent)]
pub struct Motion(pub Wide);

impl Motion {
    /// m_I [kg]
    #[inline(always)]
    pub fn mass(&self) -> f64 {
        self.0.0[3]
    }
    /// v_I [m/s]
    #[inline(always)]
    pub fn velocity(&self) -> [f64; 3] {
        let [x, y, z, ..] = self.0.0;
        [x, y, z]
    }
    /// v⁰_I: the velocity that the step began with [m/s].
    #[inline(always)]
    pub fn start(&self) -> [f64; 3] {
        let [x, y, z, _, dx, dy, dz, _] = self.0.0;
        [x - dx, y - dy, z - dz]
    }
    /// (v⁰ + v)/2 [m/s]
    #[inline(always)]
    pub fn mean(&self) -> [f64; 3] {
        let [x, y, z, _, dx, dy, dz, _] = self.0.0;
        [x - 0.5 * dx, y - 0.5 * dy, z - 0.5 * dz]
    }
    /// The signs with which the image of a node beyond a face moves; it has no mass.
    #[inline(always)]
    pub fn signs([x, y, z]: [f64; 3]) -> Wide {
        Wide([x, y, z, 0.0, x, y, z, 0.0])
    }
    /// Adds `dv` to the velocity that the step begins with: particles are not told of it.
    #[inline(always)]
    pub fn begin_with(&mut self, dv: [f64; 3]) {
        (0..3).for_each(|axis| self.0.0[axis] += dv[axis]);
    }
    /// Adds `dv` to the velocity, and to what particles will be told of the change.
    #[inline(always)]
    pub fn add(&mut self, dv: [f64; 3]) {
        for axis in 0..3 {
            self.0.0[axis] += dv[axis];
            self.0.0[4 + axis] += dv[axis];
        }
    }
}

/// What loads have changed of the velocity of a node in this step (3), 0 (5).
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(transparent)]
pub struct Change(pub Wide);

impl Change {
    /// So much [m/s].
    #[inline(always)]
    pub fn new([x, y, z]: [f64; 3]) -> Self {
        Self(Wide([x, y, z, 0.0, 0.0, 0.0, 0.0, 0.0]))
    }
    /// Δv [m/s]
    #[inline(always)]
    pub fn velocity(&self) -> [f64; 3] {
        let [x, y, z, ..] = self.0.0;
        [x, y, z]
    }
}

/// What contact has given to one field at a node in this step: normal impulse (3), what became of a bond, friction (3), what bonds make one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(transparent)]
pub struct Impulse(pub Wide);

impl Impulse {
    /// The part along normals [N s].
    #[inline(always)]
    pub fn normal(&self) -> [f64; 3] {
        let [x, y, z, ..] = self.0.0;
        [x, y, z]
    }
    /// Whether a bond broke here in this step.
    #[inline(always)]
    pub fn is_broken(&self) -> bool {
        self.0.0[3] == 1.0
    }
    /// Whether a bond holds here whose stress other nodes bear.
    #[inline(always)]
    pub fn is_aside(&self) -> bool {
        self.0.0[3] == 2.0
    }
    /// A bond holds here, and other nodes bear its stress.
    #[inline(always)]
    pub fn hold_aside(&mut self) {
        if !self.is_broken() {
            self.0.0[3] = 2.0;
        }
    }
    /// A bond breaks here.
    #[inline(always)]
    pub fn break_bond(&mut self) {
        self.0.0[3] = 1.0;
    }
    /// Which fields at the node bonds make one: 1 + the place of the first of them among the fields of the block; 0: none.
    #[inline(always)]
    pub fn group(&self) -> usize {
        self.0.0[7] as usize
    }
    /// They are one with others.
    #[inline(always)]
    pub fn set_group(&mut self, group: usize) {
        self.0.0[7] = group as f64;
    }
    /// The part of friction [N s].
    #[inline(always)]
    pub fn friction(&self) -> [f64; 3] {
        let [_, _, _, _, x, y, z, _] = self.0.0;
        [x, y, z]
    }
    /// Adds ± an exchange.
    #[inline(always)]
    pub fn add(&mut self, sign: f64, normal: [f64; 3], friction: [f64; 3]) {
        for axis in 0..3 {
            self.0.0[axis] += sign * normal[axis];
            self.0.0[4 + axis] += sign * friction[axis];
        }
    }
}
