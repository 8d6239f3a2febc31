//! When tissue fails, as types: the criterion is compiled into the law.
use super::{State, Tissue};
use crate::law::{Events, Kinematics, MAX_COUNTS, MAX_EVENTS, UNSTABLE, Variable, inadmissible};
use crate::tensor::{determinant, solve};
use simd::{Mask, Simd};

/// Which terms of the energy still act.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Present {
    /// The matrix.
    pub matrix: Mask,
    /// The fibers.
    pub fiber: Mask,
    /// The volume term.
    pub volume: Mask,
}

impl Present {
    /// All terms in all lanes.
    const ALL: Self = Self { matrix: Mask::MAX, fiber: Mask::MAX, volume: Mask::MAX };

    /// The terms of `self` that are not in `other`.
    fn without(self, other: Self) -> Self {
        Self {
            matrix: self.matrix & !other.matrix,
            fiber: self.fiber & !other.fiber,
            volume: self.volume & !other.volume,
        }
    }
}

/// What a criterion found.
#[derive(Clone, Copy)]
pub struct Verdict {
    /// What still acts after the step.
    pub present: Present,
    /// What happened in the step.
    pub events: Events,
}

/// A failure criterion. `history` is that of the tissue: the three numbers of the fiber, then its own.
pub trait Failure: Copy + Send + Sync + 'static {
    /// Fiber direction and the numbers of the criterion.
    const HISTORY: &'static [Variable];

    /// Names of what can happen.
    const EVENTS: &'static [&'static str] = &[];

    /// Names of the states whose particles are counted; the last one is [`UNSTABLE`], which the tissue itself sees to.
    const COUNTS: &'static [&'static str];

    /// Judges the step of a tissue of this criterion.
    fn judge<S: Simd>(
        tissue: &Tissue<Self>,
        state: &State<S>,
        k: &Kinematics<S>,
        history: &mut [S],
    ) -> Verdict;

    /// What acts at a volume ratio J.
    fn present<S: Simd>(&self, j: S, history: &[S]) -> Present;

    /// Which particles are in each state of `COUNTS` but the last.
    #[inline(always)]
    fn counts<S: Simd>(&self, _history: &[S]) -> [Mask; MAX_COUNTS] {
        [0; MAX_COUNTS]
    }

    /// Energy released so far [J/m³].
    fn released<S: Simd>(&self, history: &[S]) -> S;
}

/// Tissue that never fails.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NoFailure;

impl Failure for NoFailure {
    const HISTORY: &'static [Variable] = &[FIBER[0], FIBER[1], FIBER[2]];
    const COUNTS: &'static [&'static str] = &[UNSTABLE];

    #[inline(always)]
    fn judge<S: Simd>(_: &Tissue<Self>, state: &State<S>, _: &Kinematics<S>, _: &mut [S]) -> Verdict {
        let events = Events { inverted: inadmissible(state.j), ..Events::default() };
        Verdict { present: Present::ALL, events }
    }
    #[inline(always)]
    fn present<S: Simd>(&self, _: S, _: &[S]) -> Present {
        Present::ALL
    }
    #[inline(always)]
    fn released<S: Simd>(&self, _: &[S]) -> S {
        S::splat(0.0)
    }
}

/// One surface for the matrix, one for the fibers (Ionescu et al. 2006, eqs. 6–8). What failed stays failed.
///
/// The matrix fails at (E₁ − E₃)/2 ≥ γ, with E₁ and E₃ the largest and the smallest principal value of the
/// Green-Lagrange strain; its term and the volume term go. The fibers fail at λ − 1 ≥ ε, with the total
/// stretch λ, whereas their stress follows from λ̃. A particle without any term left is frozen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TwoSurface {
    /// Fibers fail at λ ≥ 1 + ε.
    pub stretch: f64,
    /// The matrix fails at c₁ − c₃ ≥ this, with principal values of C = 2 E + I: 4 γ.
    pub span: f64,
    /// Lanes (all or none) in which the volume term outlives the matrix while J < 1; the paper: none.
    pub keeps_pressure: Mask,
    /// Lanes (all or none) in which an inadmissible J is total failure; in the others it is an error.
    pub crushes: Mask,
}

/// The history `failure`, as masks. Its values: 0 intact, 1 matrix, 2 fibers, 3 both, 4 crushed (J ≤ 0).
#[derive(Clone, Copy)]
struct Failed {
    matrix: Mask,
    fiber: Mask,
    crushed: Mask,
}

impl Failed {
    #[inline(always)]
    fn from_code<S: Simd>(code: S) -> Self {
        let from = |least: f64| code.ge(S::splat(least));
        Self { matrix: from(1.0) & !from(2.0) | from(3.0), fiber: from(2.0), crushed: from(4.0) }
    }
    #[inline(always)]
    fn code<S: Simd>(self) -> S {
        let digit = |mask: Mask, value: f64| S::select(mask, S::splat(value), S::splat(0.0));
        digit(self.matrix, 1.0) + digit(self.fiber, 2.0) + digit(self.crushed, 1.0)
    }
}

impl TwoSurface {
    /// Lanes in which the matrix is sheared too far.
    ///
    /// With the differences d of the principal values of C (or of b, which has the same), J₂ and J₃ of its
    /// deviator, and T the limit of the largest: Π (d² − T²) = 4 J₂³ − 27 J₃² − 9 J₂² T² + 6 J₂ T⁴ − T⁶.
    /// The squares sum to 6 J₂, and the largest is within 3 J₂ and 4 J₂, so the others are at most 3 J₂.
    /// Where 3 J₂ < T² the product has therefore the sign of d_max² − T²: no eigenvalue is needed, and where 4 J₂ < T² nothing.
    #[inline(always)]
    fn sheared<S: Simd>(&self, state: &State<S>) -> Mask {
        let splat = S::splat;
        let State { j2, j3, root, .. } = *state;
        // these are invariants of b̃ = J^(−2/3) b, so T shrinks alike; t = T²
        let limit = splat(self.span) * root * root;
        let t = limit * limit;
        let suspects = j2.ge(splat(0.25) * t);
        if suspects == 0 {
            return suspects;
        }
        let square = splat(4.0).fma(j2, splat(-9.0) * t).fma(j2, splat(6.0) * t * t);
        let product = (splat(-27.0) * j3).fma(j3, square.fma(j2, -(t * t * t)));
        j2.ge(splat(1.0 / 3.0) * t) | suspects & product.ge(splat(0.0))
    }

    /// What acts at a volume ratio J.
    #[inline(always)]
    fn terms_left<S: Simd>(&self, failed: Failed, j: S) -> Present {
        let squeezed = j.lt(S::splat(1.0)) & self.keeps_pressure & !failed.crushed;
        Present { matrix: !failed.matrix, fiber: !failed.fiber, volume: !failed.matrix | squeezed }
    }

    /// Lanes that can never again carry stress.
    #[inline(always)]
    fn frozen(&self, failed: Failed) -> Mask {
        failed.crushed | failed.matrix & failed.fiber & !self.keeps_pressure
    }
}

impl Failure for TwoSurface {
    const HISTORY: &'static [Variable] = &[
        FIBER[0],
        FIBER[1],
        FIBER[2],
        Variable::new("failure", "1", "what has failed").codes(CODES).usual(),
        Variable::new(
            "fracture_energy",
            "J/m^3",
            "stored energy that failure has released, over reference volume",
        ),
    ];
    const EVENTS: &'static [&'static str] = &["matrix", "fiber"];
    const COUNTS: &'static [&'static str] = &["matrix", "fiber", "total", "crushed", UNSTABLE];

    #[inline(always)]
    fn judge<S: Simd>(
        tissue: &Tissue<Self>,
        state: &State<S>,
        k: &Kinematics<S>,
        history: &mut [S],
    ) -> Verdict {
        let (limits, was) = (&tissue.failure, Failed::from_code(history[CODE]));
        let was_frozen = limits.frozen(was);
        let bad = inadmissible(state.j);
        let crushed = bad & limits.crushes & !was_frozen;
        let sound = !(bad | was_frozen);
        let torn = state.stretch.ge(S::splat(limits.stretch));
        let now = Failed {
            matrix: was.matrix | limits.sheared(state) & sound | crushed,
            fiber: was.fiber | torn & sound | crushed,
            crushed: was.crushed | crushed,
        };
        let mut own = [0; MAX_EVENTS];
        own[0] = now.matrix & !was.matrix;
        own[1] = now.fiber & !was.fiber;
        let frozen = limits.frozen(now);
        if own[0] | own[1] | crushed != 0 {
            // a crushed particle releases what it held before the step, if that can be known
            let old = solve(&k.increment, &k.f);
            let (mut f, j) = (k.f, S::select(crushed, determinant(&old), k.j));
            for (f, old) in f.iter_mut().zip(old) {
                *f = S::select(crushed, old, *f);
            }
            let lost = limits.terms_left(was, j).without(limits.terms_left(now, j));
            let stored = tissue.terms(&State::new(&f, j, &[history[0], history[1], history[2]]));
            let released = S::select(inadmissible(j) | was_frozen, S::splat(0.0), stored.sum(lost));
            history[CODE] = now.code();
            history[RELEASED] = history[RELEASED] + released;
        }
        let events = Events { own, inverted: bad & !frozen, frozen };
        Verdict { present: limits.terms_left(now, state.j), events }
    }
    #[inline(always)]
    fn present<S: Simd>(&self, j: S, history: &[S]) -> Present {
        self.terms_left(Failed::from_code(history[CODE]), j)
    }
    #[inline(always)]
    fn counts<S: Simd>(&self, history: &[S]) -> [Mask; MAX_COUNTS] {
        let Failed { matrix, fiber, crushed } = Failed::from_code(history[CODE]);
        // each particle in one of them: failed in its matrix alone, in its fibers alone, in both, in both by inversion
        let mut counts = [0; MAX_COUNTS];
        counts[0] = matrix & !fiber;
        counts[1] = fiber & !matrix;
        counts[2] = matrix & fiber & !crushed;
        counts[3] = crushed;
        counts
    }
    #[inline(always)]
    fn released<S: Simd>(&self, history: &[S]) -> S {
        history[RELEASED]
    }
}

// where in the history
const CODE: usize = 3;
const RELEASED: usize = 4;

/// What the numbers of `failure` mean.
const CODES: &[&str] = &[
    "intact",
    "matrix failed",
    "fibers failed",
    "both failed",
    "both failed, because it was turned inside out",
];

/// History of the fiber: the unit vector a₀.
const FIBER: [Variable; 3] = [
    Variable::new("fiber_x", "1", "x of a₀: direction of the fibers at the start"),
    Variable::new("fiber_y", "1", "y of a₀: direction of the fibers at the start"),
    Variable::new("fiber_z", "1", "z of a₀: direction of the fibers at the start"),
];
