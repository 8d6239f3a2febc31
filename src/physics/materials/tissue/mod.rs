//! Soft tissue: an isotropic matrix with one family of fibers, and how it fails.
mod failure;
mod family;

pub use failure::{Failure, NoFailure, Present, TwoSurface, Verdict};
pub use family::Family;

use crate::acoustic::Stiffness;
use crate::law::Energies;
use crate::law::Events;
use crate::law::Kinematics;
use crate::law::Law;
use crate::law::MAX_COUNTS;
use crate::law::Reference;
use crate::law::Response;
use crate::law::Variable;
use crate::law::inadmissible;
use crate::quantities::{Eight, Quantity, Tile};
use crate::tensor::apply;
use crate::tensor::deviator_invariants;
use crate::tensor::quadratic;
use crate::tensor::scaled;
use crate::tensor::times_transpose;
use simd::Mask;
use simd::Simd;
use simd::math;

/// Transversely isotropic hyperelasticity (Weiss, Maker & Govindjee 1996; Ionescu et al. 2006, eqs. 1–5):
/// W = C₁ (tr b̃ − 3) + F₂(λ̃) + K/2 (ln J)², with b̃ = J^(−2/3) F Fᵀ, λ̃ = J^(−1/3) λ, λ = |F a₀|, and
/// h = λ̃ F₂′(λ̃) =
///
/// - 0 for λ̃ < 1,
/// - C₃ (exp(C₄ (λ̃ − 1)) − 1) up to λ* (the toe; eq. 5 as printed misplaces the −1),
/// - C₅ λ̃ + C₆ beyond, with C₆ such that h is continuous.
///
/// The small-strain shear modulus of the matrix is μ = 2 C₁. `F` is the failure criterion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tissue<F> {
    /// C₁ of the matrix [Pa].
    pub c1: f64,
    /// C₃, scale of the toe [Pa].
    pub c3: f64,
    /// C₄, rate of uncrimping.
    pub c4: f64,
    /// C₅, modulus of straight fibers [Pa].
    pub c5: f64,
    /// λ*, stretch at which fibers are straight; ≥ 1.
    pub straight: f64,
    /// Bulk modulus K [Pa].
    pub bulk: f64,
    /// What fails, and when.
    pub failure: F,
}

/// Deformation as the three terms of the energy see it.
#[derive(Clone, Copy)]
pub struct State<S> {
    /// J
    pub j: S,
    /// ln J
    pub ln_j: S,
    /// b̃: xx, xy, xz, yy, yz, zz.
    pub b: [S; 6],
    /// tr b̃ / 3
    pub mean: S,
    /// Second invariant of dev b̃.
    pub j2: S,
    /// Third invariant of dev b̃.
    pub j3: S,
    /// J^(−1/3)
    pub root: S,
    /// F a₀ = λ a
    pub fiber: [S; 3],
    /// λ
    pub stretch: S,
}

impl<S: Simd> State<S> {
    /// Of F with J = det F, and the unit vector a₀.
    #[inline(always)]
    pub fn new(f: &[S; 9], j: S, fiber: &[S; 3]) -> Self {
        let ln_j = math::ln(j);
        let root = math::inverse_cube_root(j);
        let scale = root * root;
        let b = scaled(scale, times_transpose(f));
        let (mean, j2, j3) = deviator_invariants(&b);
        let fiber = apply(f, fiber);
        let [x, y, z] = fiber;
        let stretch = x.fma(x, y.fma(y, z * z)).sqrt();
        Self { j, ln_j, b, mean, j2, j3, root, fiber, stretch }
    }
}

/// Energy of each term of W [J/m³].
#[derive(Clone, Copy)]
pub struct Terms<S> {
    /// C₁ (tr b̃ − 3)
    pub matrix: S,
    /// F₂(λ̃)
    pub fiber: S,
    /// K/2 (ln J)²
    pub volume: S,
}

impl<S: Simd> Terms<S> {
    /// Sum of the terms that are in `present`.
    #[inline(always)]
    pub fn sum(&self, present: Present) -> S {
        keep(present.matrix, self.matrix)
            + keep(present.fiber, self.fiber)
            + keep(present.volume, self.volume)
    }
}

/// x in the lanes of `mask`, else 0.
#[inline(always)]
fn keep<S: Simd>(mask: Mask, x: S) -> S {
    S::select(mask, x, S::splat(0.0))
}

impl<F> Tissue<F> {
    /// Fiber stress h and its slope λ̃ dh/dλ̃ [Pa].
    #[inline(always)]
    fn fiber<S: Simd>(&self, stretch: S) -> (S, S) {
        let (one, zero) = (S::splat(1.0), S::splat(0.0));
        let (c3, c4, c5) = (S::splat(self.c3), S::splat(self.c4), S::splat(self.c5));
        let strain = stretch.min(S::splat(self.straight)) - one;
        let growth = c3 * math::exp(c4 * strain);
        let straight = S::splat(self.straight).lt(stretch);
        // beyond λ*: h(λ*) + C₅ (λ̃ − λ*), so that C₆ needs no name
        let stress = c5.fma((stretch - S::splat(self.straight)).max(zero), growth - c3);
        let slope = stretch * S::select(straight, c5, c4 * growth);
        let taut = one.lt(stretch);
        (keep(taut, stress), keep(taut, slope))
    }

    /// Energy of each term, whether failed or not.
    #[inline(always)]
    fn terms<S: Simd>(&self, state: &State<S>) -> Terms<S> {
        let one = S::splat(1.0);
        let matrix = S::splat(3.0 * self.c1) * (state.mean - one);
        let volume = S::splat(0.5 * self.bulk) * state.ln_j * state.ln_j;

        // F₂ = ∫ h(x)/x dx from 1 to λ̃: the toe by quadrature (its closed form has an exponential integral)
        let straight = S::splat(self.straight);
        let stretch = (state.root * state.stretch).max(one);
        let half = S::splat(0.5) * (stretch.min(straight) - one);
        let mut toe = S::splat(0.0);
        for (node, weight) in GAUSS {
            for node in [-node, node] {
                let strain = half.fma(S::splat(node), half);
                let stress = math::exp(S::splat(self.c4) * strain) - one;
                toe = S::splat(weight).fma(stress / (one + strain), toe);
            }
        }
        let c6 = self.c3 * ((self.c4 * (self.straight - 1.0)).exp() - 1.0) - self.c5 * self.straight;
        let beyond = stretch.max(straight);
        let line = S::splat(self.c5).fma(beyond - straight, S::splat(c6) * math::ln(beyond / straight));
        Terms { matrix, fiber: (S::splat(self.c3) * half).fma(toe, line), volume }
    }

    /// What resists a wave, with these K, μ, h and λ̃ dh/dλ̃.
    #[inline(always)]
    fn stiffness<S: Simd>(state: &State<S>, bulk: S, shear: S, [h, slope]: [S; 2]) -> Stiffness<S> {
        let State { ln_j, mean, j2, .. } = *state;
        // J² U″ = K (1 − ln J)
        let volumetric = bulk.fnma(ln_j, bulk);
        Stiffness { volumetric, shear, mean, j2, fiber_stress: h, fiber_slope: slope }
    }

    /// Stress and modulus of the terms that are present.
    #[inline(always)]
    fn respond<S: Simd>(&self, state: &State<S>, present: Present, events: Events) -> Response<S> {
        let State { ln_j, b, mean, .. } = *state;
        let shear = keep(present.matrix, S::splat(2.0 * self.c1));
        let bulk = keep(present.volume, S::splat(self.bulk));
        let (h, slope) = self.fiber(state.root * state.stretch);
        let (h, slope) = (keep(present.fiber, h), keep(present.fiber, slope));

        // τ = 2 C₁ dev b̃ + h dev(a⊗a) + K ln J I
        let along = keep(present.fiber, h / (state.stretch * state.stretch));
        let spherical = bulk.fma(ln_j, -h * S::splat(1.0 / 3.0));
        let [x, y, z] = state.fiber;
        let normal = |b: S, u: S| shear.fma(b - mean, (along * u).fma(u, spherical));
        let mixed = |b: S, u: S, v: S| shear.fma(b, along * u * v);
        let mut kirchhoff = [
            normal(b[0], x),
            mixed(b[1], x, y),
            mixed(b[2], x, z),
            normal(b[3], y),
            mixed(b[4], y, z),
            normal(b[5], z),
        ];

        let stiffness = Self::stiffness(state, bulk, shear, [h, slope]);
        // lanes without a term, or with J ≤ 0, may hold anything, even NaN
        let carries = (present.matrix | present.fiber | present.volume) & !inadmissible(state.j);
        for t in &mut kirchhoff {
            *t = keep(carries, *t);
        }
        Response { kirchhoff, modulus: keep(carries, stiffness.bound()), events }
    }
}

impl<F: Failure> Tissue<F> {
    /// Which particles have all their terms and yet no wave along their fibers: where J has grown so far that the volume
    /// resists no more (K (1 − ln J)), or where h grows slower than the fibers get thin, as beyond a small λ*.
    #[inline(always)]
    fn unstable<S: Simd>(&self, k: &Kinematics<S>, history: &[S]) -> Mask {
        let state = State::new(&k.f, k.j, &[history[0], history[1], history[2]]);
        let Present { matrix, fiber, volume } = self.failure.present(k.j, history);
        let (h, slope) = self.fiber(state.root * state.stretch);
        let (bulk, shear) = (S::splat(self.bulk), S::splat(2.0 * self.c1));
        let along = quadratic(&state.b, &state.fiber) / (state.stretch * state.stretch);
        let modulus = Self::stiffness(&state, bulk, shear, [h, slope]).along_fibers(along);
        modulus.lt(S::splat(0.0)) & matrix & fiber & volume
    }
}

/// The fibers now: F a₀ = λ a.
const SHOWN: &[Quantity] = &[
    Quantity::of_law(
        "fiber_direction",
        3,
        |p, out| {
            let (a, stretch) = fiber_now(p);
            simd::store(&[a[0] / stretch, a[1] / stretch, a[2] / stretch], &mut out[..3]);
        },
        "unit vector a along the fibers now",
    ),
    Quantity::of_law(
        "fiber_stretch",
        1,
        |p, out| fiber_now(p).1.store(&mut out[0]),
        "λ = |F a₀|: stretch of the fibers",
    ),
];

/// F a₀ and λ.
#[inline(always)]
fn fiber_now(p: &Tile) -> ([Eight; 3], Eight) {
    let (f, a) = (simd::load::<Eight, 9>(p.f), [0, 1, 2].map(|i| Eight::load(&p.history[i])));
    let fiber = [0, 3, 6].map(|row| f[row] * a[0] + f[row + 1] * a[1] + f[row + 2] * a[2]);
    let [x, y, z] = fiber;
    (fiber, (x * x + y * y + z * z).sqrt())
}

impl<F: Failure> Law for Tissue<F> {
    const HISTORY: &'static [Variable] = F::HISTORY;
    const SHOWN: &'static [Quantity] = SHOWN;
    const EVENTS: &'static [&'static str] = F::EVENTS;
    const COUNTS: &'static [&'static str] = F::COUNTS;

    fn initial(&self, reference: &Reference, history: &mut [f64]) {
        history.fill(0.0);
        history[..3].copy_from_slice(&reference.fiber);
    }

    #[inline(always)]
    fn update<S: Simd>(&self, k: &Kinematics<S>, history: &mut [S]) -> Response<S> {
        let fiber = [history[0], history[1], history[2]];
        let state = State::new(&k.f, k.j, &fiber);
        let Verdict { present, events } = F::judge(self, &state, k, history);
        self.respond(&state, present, events)
    }

    #[inline(always)]
    fn counts<S: Simd>(&self, k: &Kinematics<S>, history: &[S]) -> [Mask; MAX_COUNTS] {
        let mut counts = self.failure.counts(history);
        counts[F::COUNTS.len() - 1] = self.unstable(k, history);
        counts
    }

    #[inline(always)]
    fn energies<S: Simd>(&self, k: &Kinematics<S>, history: &[S]) -> Energies<S> {
        let state = State::new(&k.f, k.j, &[history[0], history[1], history[2]]);
        let strain = self.terms(&state).sum(self.failure.present(k.j, history));
        let fracture = self.failure.released(history);
        Energies { strain, plastic: S::splat(0.0), fracture }
    }

    fn moduli(&self) -> (f64, f64) {
        (self.bulk, 2.0 * self.c1)
    }
}

/// Positive nodes and weights of Gauss–Legendre quadrature with 16 points on (−1, 1). The toe's integral is
/// good to 1e-12 of its value for C₄ (λ* − 1) ≤ 20 (the paper's are below 9).
const GAUSS: [(f64, f64); 8] = [
    (0.095_012_509_837_637_44, 0.189_450_610_455_068_5),
    (0.281_603_550_779_258_9, 0.182_603_415_044_923_6),
    (0.458_016_777_657_227_4, 0.169_156_519_395_002_54),
    (0.617_876_244_402_643_7, 0.149_595_988_816_576_73),
    (0.755_404_408_355_003, 0.124_628_971_255_533_87),
    (0.865_631_202_387_831_7, 0.095_158_511_682_492_78),
    (0.944_575_023_073_232_6, 0.062_253_523_938_647_89),
    (0.989_400_934_991_649_9, 0.027_152_459_411_754_095),
];
