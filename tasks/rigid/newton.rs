//! Newton's method for the motion of a free rigid body that contact pushes.
//!
//! With U = (V, ω), A = diag(M 1, R I Rᵀ), U* the motion without contact, J_s = (1, −[r_s]×) and P_s(U) the impulse that a node s of the
//! matter receives if the body moves with U, it is the U for which
//!
//! A (U − U*) + Σ_s J_sᵀ P_s(U) = 0 :
//!
//! six equations, however many nodes. Their derivative is A + Σ_s J_sᵀ H_s J_s with H_s = −∂P_s/∂u_s, from the contact law; where it jumps,
//! any value at the jump serves (L. Qi, J. Sun, Mathematical Programming 58, 1993, 353–367).
use super::rotation::inertia;
use super::state::{RigidState, RigidTrial};
use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};

/// Numbers of [`Balance`].
pub const BALANCE: usize = 44;

/// Σ J_sᵀ P_s (6), Σ J_sᵀ H_s J_s (36, row by row), and how large its parts are: Σ p_s and Σ |r_s| p_s with p_s = |P_s| + m_s |v_s|/100.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Balance(pub [f64; BALANCE]);

impl Default for Balance {
    fn default() -> Self {
        Self([0.0; BALANCE])
    }
}

/// What is left of the balance when the motion is found, in parts of what pushes.
const TOLERANCE: f64 = 1e-12;
/// Of the momenta of the body and of nodes: where they just touch, or move along together, little pushes.
const OF_MOMENTUM: f64 = 0.01;
/// Rounds of Newton's method alone: two or three are usual, more where friction has to choose between sticking and slipping. A body
/// far lighter than what it touches may go round in circles then.
const PATIENCE: f64 = 8.0;
/// From then on, so many rounds by the secant of the contact law, with smaller and smaller steps, and two of Newton's method, …
const SPELL: f64 = 6.0;

/// How a round is made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Turn {
    /// By the secant stiffness, and not by the derivative.
    pub secant: bool,
    /// The part of the step that is taken.
    pub share: f64,
}

/// The round after so many.
pub fn turn(rounds: f64) -> Turn {
    let (spell, within) =
        (((rounds - PATIENCE) / (SPELL + 2.0)).floor(), (rounds - PATIENCE).rem_euclid(SPELL + 2.0));
    let secant = rounds >= PATIENCE && within < SPELL;
    Turn { secant, share: if secant { (0.7 * 0.8f64.powf(spell)).max(0.15) } else { 1.0 } }
}

impl Balance {
    /// Counts an impulse on the matter at an arm r from the center of the body, with its stiffness and the momentum m |v| of the matter.
    #[inline(always)]
    pub fn add(&mut self, r: [f64; 3], impulse: [f64; 3], stiffness: &[[f64; 3]; 3], moving: f64) {
        let (r, p) = (Vector3::from(r), Vector3::from(impulse));
        let (cross, h) = (r.cross_matrix(), Matrix3::from_fn(|i, j| stiffness[i][j]));
        let torque = r.cross(&p);
        let (vw, wv) = (-h * cross, cross * h);
        let ww = -wv * cross;
        for i in 0..3 {
            self.0[i] += p[i];
            self.0[3 + i] += torque[i];
            for j in 0..3 {
                self.0[6 + 6 * i + j] += h[(i, j)];
                self.0[9 + 6 * i + j] += vw[(i, j)];
                self.0[24 + 6 * i + j] += wv[(i, j)];
                self.0[27 + 6 * i + j] += ww[(i, j)];
            }
        }
        let size = p.norm() + OF_MOMENTUM * moving;
        self.0[42] += size;
        self.0[43] += r.norm() * size;
    }
}

/// Takes a step towards the motion that the balance asks for; whether it is found. What is locked stays as it was sought first.
pub fn seek(body: &RigidState, trial: &mut RigidTrial, balance: &Balance, locked: [bool; 6]) -> bool {
    let mut a = Matrix6::zeros();
    (0..3).for_each(|i| a[(i, i)] = body.mass);
    a.fixed_view_mut::<3, 3>(3, 3).copy_from(&inertia(body));
    let (start, now) = (Vector6::from(trial.start), Vector6::from(trial.now));
    let change = a * (now - start);
    let mut left = change + Vector6::from_iterator(balance.0[..6].iter().copied());
    let mut k = a + Matrix6::from_row_slice(&balance.0[6..42]);
    for i in (0..6).filter(|&i| locked[i]) {
        k.row_mut(i).fill(0.0);
        k.column_mut(i).fill(0.0);
        (k[(i, i)], left[i]) = (1.0, 0.0);
    }
    let momentum = a * start;
    let part = |v: &Vector6<f64>, first: usize| v.fixed_rows::<3>(first).norm();
    // an arm, to compare momenta with angular ones
    let gyration = (inertia(body).trace() / (2.0 * body.mass)).sqrt();
    let whole = part(&momentum, 0) + part(&momentum, 3) / gyration;
    let small = |first: usize, arm: f64, pushes: f64| {
        part(&left, first) <= TOLERANCE * (pushes + part(&change, first) + OF_MOMENTUM * whole * arm)
    };
    let found = small(0, 1.0, balance.0[42]) && small(3, gyration, balance.0[43]);
    let share = turn(trial.rounds).share;
    (trial.rounds, trial.found) = (trial.rounds + 1.0, f64::from(u8::from(found)));
    if found {
        return true;
    }
    // A is positive, and so is what pushing back adds to it: there is an inverse unless a number is none
    if let Some(step) = k.lu().solve(&left) {
        trial.now = (now - share * step).into();
    }
    false
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;
    use physics::contact::friction::{Criterion, Friction};
    use physics::contact::{ContactLaw, Pair};

    /// A body that falls askew on some nodes: the motion that is found keeps momentum, and frictions are in their cones.
    #[test]
    fn a_body_on_a_few_nodes_balances_in_few_rounds() {
        let mut body = RigidState { mass: 2.0, angular: [3.0, -1.0, 0.5], ..RigidState::zeroed() };
        (0..3).for_each(|a| (body.rotation[4 * a], body.inertia[4 * a]) = (1.0, 0.1 + 0.05 * a as f64));
        let start = [0.4, 0.1, -1.5, 3.0, -1.0, 0.5];
        let law = Friction { coefficient: 0.3, criterion: Criterion::Approach };
        let nodes: Vec<([f64; 3], f64)> = (0..12)
            .map(|n| {
                (
                    [0.3 * f64::from(n % 4) - 0.5, 0.2 * f64::from(n / 4) - 0.2, -0.4],
                    0.05 + 0.01 * f64::from(n),
                )
            })
            .collect();
        let mut trial = RigidTrial { start, now: start, ..RigidTrial::zeroed() };
        let mut rounds = 0;
        loop {
            let mut balance = Balance::default();
            for &(r, m) in &nodes {
                let surface = trial.velocity_at(r);
                let pair = Pair {
                    relative: surface.map(|v| -v),
                    reduced_mass: m,
                    normal: [0.0, 0.0, -1.0],
                    traction: 0.0,
                };
                // the matter lies below: its outward normal is up
                let pair = Pair { normal: [0.0, 0.0, 1.0], ..pair };
                let given = law.exchange(&pair);
                let p = std::array::from_fn(|a| given.normal[a] + given.friction[a]);
                balance.add(r, p, &law.stiffness(&pair), 0.0);
            }
            if seek(&body, &mut trial, &balance, [false; 6]) {
                let gained: f64 = body.mass * (trial.now[2] - start[2]);
                assert!((gained + balance.0[2]).abs() < 1e-12 && gained > 0.1, "{gained}");
                break;
            }
            rounds += 1;
            assert!(rounds < 10, "{trial:?}");
        }
        println!("{rounds} rounds");
    }
}
