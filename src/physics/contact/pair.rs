//! A pair of materials at a node, and what a contact law makes of it.
use super::held::HeldPair;

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

/// What a contact law answers: impulses on a; b receives the opposite [N s].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Exchange {
    /// Along the normal.
    pub normal: [f64; 3],
    /// Across it.
    pub friction: [f64; 3],
}

impl Exchange {
    /// The whole impulse on a [N s].
    #[inline(always)]
    pub fn all(&self) -> [f64; 3] {
        std::array::from_fn(|a| self.normal[a] + self.friction[a])
    }
}

/// A contact law: a pure function of a pair. Its parameters are its fields.
///
/// A new one is one file with this and [`Described`](crate::parameter::Described), and one line in
/// [`contact`](super).
pub trait ContactLaw {
    /// The impulses that the pair exchanges where its surfaces touch.
    fn exchange(&self, pair: &Pair) -> Exchange;

    /// The same where drives hold some of the matter.
    fn exchange_held(&self, pair: &HeldPair) -> Exchange;

    /// −∂(impulse on a)/∂(relative velocity) of the same, row by row [kg]: how much more it pushes where the relative velocity is less.
    fn stiffness(&self, pair: &Pair) -> [[f64; 3]; 3];

    /// A symmetric S, not below zero, with impulse = −S u: where [`ContactLaw::stiffness`] leads in circles, this leads on, more slowly.
    fn secant(&self, pair: &Pair) -> [[f64; 3]; 3] {
        self.stiffness(pair)
    }

    /// Whether it asks for the traction between the surfaces, which only bodies that deform have.
    fn asks_traction(&self) -> bool {
        false
    }

    /// What it bears, if it holds two materials together, whatever they do.
    fn bond(&self) -> Option<Strength> {
        None
    }

    /// The impulses that the pair exchanges where its bond is broken and its surfaces touch.
    fn broken(&self, pair: &Pair) -> Exchange {
        self.exchange(pair)
    }

    /// The same where drives hold some of the matter.
    fn broken_held(&self, pair: &HeldPair) -> Exchange {
        self.exchange_held(pair)
    }
}

/// The tractions that a bond bears [Pa].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Strength {
    /// Tension.
    pub normal: f64,
    /// Shear.
    pub shear: f64,
}

impl Strength {
    /// Whether a bond ever breaks.
    pub fn is_finite(self) -> bool {
        self.normal.is_finite() || self.shear.is_finite()
    }

    /// Whether a tension and a shear [Pa] are too much.
    pub fn is_exceeded(self, tension: f64, shear: f64) -> bool {
        tension > self.normal || shear > self.shear
    }
}

impl Pair {
    /// m (s n nᵀ + t (1 − n nᵀ)): what takes a share of the velocity along the normal, and of that across.
    pub(super) fn takes(&self, along: f64, across: f64) -> [[f64; 3]; 3] {
        let (m, n) = (self.reduced_mass, self.normal);
        let one = |i: usize, j: usize| if i == j { across } else { 0.0 };
        std::array::from_fn(|i| std::array::from_fn(|j| m * ((along - across) * n[i] * n[j] + one(i, j))))
    }

    /// The exchange that changes the relative velocity by −`along` n and by −`across`.
    pub(super) fn exchange(&self, along: f64, across: [f64; 3]) -> Exchange {
        Exchange {
            normal: self.normal.map(|n| -self.reduced_mass * along * n),
            friction: across.map(|v| -self.reduced_mass * v),
        }
    }
}

/// a × b
#[inline(always)]
pub fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// a · b
#[inline(always)]
pub fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
