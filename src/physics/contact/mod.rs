//! Contact of two materials at one node: pure functions of masses, velocities and surfaces.
pub mod bonded;
pub mod friction;
pub mod surface;

/// What a contact law sees of a pair at a node. The first material is a, the second b.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pair {
    /// v_a − v_b [m/s]
    pub relative: [f64; 3],
    /// Reduced mass m_a m_b / (m_a + m_b) [kg].
    pub reduced_mass: f64,
    /// Unit normal from a to b.
    pub normal: [f64; 3],
    /// Normal traction between the surfaces, positive in tension [Pa].
    pub traction: f64,
}

/// What a contact law answers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Exchange {
    /// Impulse on a; b receives the opposite [N s].
    pub impulse: [f64; 3],
    /// Kinetic energy that goes into friction [J].
    pub friction: f64,
    /// Kinetic energy that is lost because the surfaces do not bounce within a node [J].
    pub impact: f64,
}

/// a · b
#[inline(always)]
pub fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

impl Pair {
    /// The exchange that changes the relative velocity by −`normal_part` along the normal and −`tangential`.
    fn exchange(&self, normal_part: f64, tangential: [f64; 3]) -> Exchange {
        let impulse =
            std::array::from_fn(|a| -self.reduced_mass * (normal_part * self.normal[a] + tangential[a]));
        // energy lost: impulse times mean relative velocity, split by direction
        let along = dot(self.relative, self.normal);
        let impact = self.reduced_mass * normal_part * (along - 0.5 * normal_part);
        let slip: [f64; 3] =
            std::array::from_fn(|a| self.relative[a] - along * self.normal[a] - 0.5 * tangential[a]);
        Exchange { impulse, friction: self.reduced_mass * dot(tangential, slip), impact }
    }
}
