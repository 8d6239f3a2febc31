//! Contact where drives hold matter along some axes: it goes there as they say, whatever it receives.
//!
//! An impulse P on the first of two materials changes their relative velocity u by W P, with W_a = Σ 1/m over those that are free along the
//! axis a. What stops an approach may make surfaces slip then, and what friction takes may part them, so that both are found together:
//! P = −p n − φ t with n·(u + W P) = 0, φ ≤ μ p, and a slip t·(u + W P) that is zero or goes on. With u′ = u + W P the work of
//! the impulses, P·(u + u′)/2 = −φ t·u′ − ½ P·W P, is never above zero.
use super::pair::{ContactLaw, Exchange, Pair, dot};
use std::array::from_fn;

/// What a contact law sees of such a pair at a node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeldPair {
    /// u = v_a − v_b [m/s]
    pub relative: [f64; 3],
    /// W, axis by axis [1/kg].
    pub mobility: [f64; 3],
    /// n·W n below which nothing can be exchanged, because both are held along the normal [1/kg].
    pub least: f64,
    /// n, from a to b.
    pub normal: [f64; 3],
    /// Normal traction between the surfaces, positive in tension [Pa].
    pub traction: f64,
}

/// What a contact law sees of two materials at a node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Seen {
    /// Nothing holds them.
    Free(Pair),
    /// Drives hold one of them, or both.
    Held(HeldPair),
}

impl Seen {
    /// See [`ContactLaw::exchange`].
    #[inline]
    pub fn exchange(&self, law: &impl ContactLaw) -> Exchange {
        match self {
            Self::Free(pair) => law.exchange(pair),
            Self::Held(pair) => law.exchange_held(pair),
        }
    }

    /// See [`ContactLaw::broken`].
    #[inline]
    pub fn broken(&self, law: &impl ContactLaw) -> Exchange {
        match self {
            Self::Free(pair) => law.broken(pair),
            Self::Held(pair) => law.broken_held(pair),
        }
    }
}

/// Of the largest mobility; less is rounding.
const LEAST: f64 = 1e-12;

impl HeldPair {
    /// x·W y
    fn mobile(&self, x: [f64; 3], y: [f64; 3]) -> f64 {
        (0..3).map(|a| x[a] * self.mobility[a] * y[a]).sum()
    }

    fn largest(&self) -> f64 {
        self.mobility.into_iter().fold(0.0, f64::max)
    }

    /// Stops an approach n·u, and slip as far as a coefficient of friction allows.
    pub(super) fn rub(&self, approach: f64, mu: f64) -> Exchange {
        let (u, n) = (self.relative, self.normal);
        let nn = self.mobile(n, n);
        if nn <= self.least.max(f64::MIN_POSITIVE) {
            return Exchange::default();
        }
        let alone = approach / nn;
        let goes_on: [f64; 3] = from_fn(|a| u[a] - alone * self.mobility[a] * n[a]);
        let along = dot(goes_on, n);
        let slip: [f64; 3] = from_fn(|a| goes_on[a] - along * n[a]);
        let speed = dot(slip, slip).sqrt();
        if speed == 0.0 {
            return Exchange { normal: n.map(|n| -alone * n), friction: [0.0; 3] };
        }
        let t = slip.map(|s| s / speed);
        let (nt, tt) = (self.mobile(n, t), self.mobile(t, t));
        let determinant = nn * tt - nt * nt;
        if determinant > LEAST * nn * self.largest() {
            let (p, phi) = ((tt * approach - nt * dot(u, t)) / determinant, nn * speed / determinant);
            if phi <= mu * p {
                return Exchange { normal: n.map(|n| -p * n), friction: t.map(|t| -phi * t) };
            }
        }
        // where friction alone parts them, or jams them, there is an end to what it presses with
        let p = approach / (nn + mu * nt).max(self.least).max(LEAST * nn);
        Exchange { normal: n.map(|n| -p * n), friction: t.map(|t| -mu * p * t) }
    }

    /// Takes away all relative velocity that is not held.
    pub(super) fn hold(&self) -> Exchange {
        let least = LEAST * self.largest();
        let taken =
            |a: usize| if self.mobility[a] > least { -self.relative[a] / self.mobility[a] } else { 0.0 };
        let (all, n): ([f64; 3], _) = (from_fn(taken), self.normal);
        let along = dot(all, n);
        Exchange { normal: n.map(|n| along * n), friction: from_fn(|a| all[a] - along * n[a]) }
    }
}
