//! The laws, in matrices, eigenvalues and functions of the standard library.
use crate::step::{M3, V3};
use nalgebra::SymmetricEigen;

#[derive(Clone, Copy, Debug)]
pub enum Law {
    /// Simo & Hughes (1998), section 9.2.
    NeoHookean { bulk: f64, shear: f64 },
    /// Simo & Hughes (1998), box 9.1.
    J2 { bulk: f64, shear: f64, yield_stress: f64, hardening: f64 },
    /// Weiss, Maker & Govindjee (1996), failing as in Ionescu et al. (2006).
    Tissue(Tissue),
}

#[derive(Clone, Copy, Debug)]
pub struct Tissue {
    pub c1: f64,
    pub c3: f64,
    pub c4: f64,
    pub c5: f64,
    pub straight: f64,
    pub bulk: f64,
    pub fiber_limit: f64,
    pub matrix_limit: f64,
}

pub struct Response {
    pub kirchhoff: M3,
    /// The particle keeps the F that it had before the step.
    pub frozen: bool,
}

impl Law {
    /// Stress and new history at the end of a step with F_new = increment F_old.
    pub fn respond(&self, f: &M3, increment: &M3, history: &mut [f64]) -> Response {
        let flowing = |kirchhoff| Response { kirchhoff, frozen: false };
        match *self {
            Law::NeoHookean { bulk, shear } => {
                let pressure = M3::identity() * pressure(bulk, admissible(f));
                flowing(pressure + shear * deviator(&isochoric(f)))
            }
            Law::J2 { bulk, shear, yield_stress, hardening } => {
                let s = return_map(shear, yield_stress, hardening, increment, history);
                flowing(M3::identity() * pressure(bulk, admissible(f)) + s)
            }
            Law::Tissue(tissue) => tissue.respond(f, history),
        }
    }
}

/// J, which has to be positive.
fn admissible(f: &M3) -> f64 {
    let j = f.determinant();
    assert!(j > 0.0, "J = {j}");
    j
}

fn deviator(t: &M3) -> M3 {
    t - M3::identity() * (t.trace() / 3.0)
}

/// b̃ = J^(−2/3) F Fᵀ
fn isochoric(f: &M3) -> M3 {
    f * f.transpose() * f.determinant().powf(-2.0 / 3.0)
}

/// J U′(J) of U = K/2 (½ (J² − 1) − ln J): Simo & Hughes (1998), section 9.2.
fn pressure(bulk: f64, j: f64) -> f64 {
    0.5 * bulk * (j * j - 1.0)
}

/// Box 9.1 of Simo & Hughes (1998): dev τ, and history: b̄ᵉ (xx, xy, xz, yy, yz, zz) and α.
fn return_map(shear: f64, yield_stress: f64, hardening: f64, increment: &M3, history: &mut [f64]) -> M3 {
    let old = M3::new(
        history[0], history[1], history[2], history[1], history[3], history[4], history[2], history[4],
        history[5],
    );
    let root = (2.0_f64 / 3.0).sqrt();
    // 1. elastic predictor
    let increment = increment * increment.determinant().powf(-1.0 / 3.0);
    let trial = increment * old * increment.transpose();
    let s_trial = shear * deviator(&trial);
    // 2. check for plastic loading
    let excess = s_trial.norm() - root * (yield_stress + hardening * history[6]);
    let (s, b) = if excess <= 0.0 {
        (s_trial, trial)
    } else {
        // 3. return mapping
        let shear_bar = shear * trial.trace() / 3.0;
        let flow = excess / (2.0 * shear_bar) / (1.0 + hardening / (3.0 * shear_bar));
        let s = s_trial - 2.0 * shear_bar * flow * s_trial / s_trial.norm();
        history[6] += root * flow;
        // 5. the intermediate configuration, with the trace that makes det b̄ᵉ = 1
        let strain = s / shear;
        (s, strain + M3::identity() * trace_of_unimodular(&strain))
    };
    history[..6].copy_from_slice(&[b.m11, b.m12, b.m13, b.m22, b.m23, b.m33]);
    s
}

/// The p with det(d + p I) = 1 and d + p I positive, by bisection. For a deviator d the p is the mean of three numbers whose
/// product is 1: not below 1.
fn trace_of_unimodular(d: &M3) -> f64 {
    let values = SymmetricEigen::new(*d).eigenvalues;
    let mut low = f64::max(1.0, -values.min());
    let mut high = 2.0 - values.min(); // all three numbers are at least 2
    loop {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            return middle;
        }
        if values.iter().map(|value| value + middle).product::<f64>() >= 1.0 {
            high = middle;
        } else {
            low = middle;
        }
    }
}

impl Tissue {
    /// h = λ̃ F₂′(λ̃): Weiss, Maker & Govindjee (1996); Ionescu et al. (2006), eq. 5 with the −1 in its place.
    fn fiber_stress(&self, stretch: f64) -> f64 {
        let toe = |stretch: f64| self.c3 * ((self.c4 * (stretch - 1.0)).exp() - 1.0);
        if stretch < 1.0 {
            0.0
        } else if stretch <= self.straight {
            toe(stretch)
        } else {
            let c6 = toe(self.straight) - self.c5 * self.straight;
            self.c5 * stretch + c6
        }
    }

    /// F₂ = ∫ h(x)/x dx from 1 to λ̃. In the toe ∫ exp(C₄ x)/x dx = ln x + Σ (C₄ x)^k / (k k!), the series of the exponential
    /// integral (Abramowitz & Stegun 1964, eq. 5.1.10).
    fn fiber_energy(&self, stretch: f64) -> f64 {
        if stretch < 1.0 {
            return 0.0;
        }
        let end = stretch.min(self.straight);
        let mut integral = end.ln();
        let mut power = 1.0; // C₄^k / k!
        for k in 1..400 {
            power *= self.c4 / f64::from(k);
            integral += power * (end.powi(k) - 1.0) / f64::from(k);
        }
        let toe = self.c3 * ((-self.c4).exp() * integral - end.ln());
        let c6 = self.fiber_stress(self.straight) - self.c5 * self.straight;
        toe + self.c5 * (stretch - end) + c6 * (stretch / end).ln()
    }

    /// History: a₀ (3), failure (0 none, 1 matrix, 2 fibers, 3 both), energy released by failure.
    fn respond(&self, f: &M3, history: &mut [f64]) -> Response {
        if history[3] == 3.0 {
            return Response { kirchhoff: M3::zeros(), frozen: true };
        }
        let j = admissible(f);
        let fiber = f * V3::new(history[0], history[1], history[2]);
        let stretch = fiber.norm();
        let isochoric_stretch = j.powf(-1.0 / 3.0) * stretch;
        let b = isochoric(f);

        // Ionescu et al. (2006), eqs. 6 to 8; what failed stays failed
        let had_matrix = history[3] == 0.0 || history[3] == 2.0;
        let had_fibers = history[3] == 0.0 || history[3] == 1.0;
        let strain = (f.transpose() * f - M3::identity()) / 2.0;
        let values = SymmetricEigen::new(strain).eigenvalues;
        let matrix = had_matrix && (values.max() - values.min()) / 2.0 < self.matrix_limit;
        let fibers = had_fibers && stretch - 1.0 < self.fiber_limit;
        history[3] = f64::from(u8::from(!matrix) + 2 * u8::from(!fibers));

        // a term that goes sets its energy free; the volume term goes with the matrix
        if had_matrix && !matrix {
            history[4] += self.c1 * (b.trace() - 3.0) + self.bulk / 2.0 * j.ln().powi(2);
        }
        if had_fibers && !fibers {
            history[4] += self.fiber_energy(isochoric_stretch);
        }

        let mut kirchhoff = M3::zeros();
        if matrix {
            kirchhoff += 2.0 * self.c1 * deviator(&b) + M3::identity() * (self.bulk * j.ln());
        }
        if fibers {
            let a = fiber / stretch;
            kirchhoff += self.fiber_stress(isochoric_stretch) * deviator(&(a * a.transpose()));
        }
        Response { kirchhoff, frozen: !matrix && !fibers }
    }
}
