//! A free rigid body turns: symmetric splitting of Euler's equations, which keeps the angular momentum exactly and the energy within a
//! bound (R. I. McLachlan, SIAM J. Sci. Comput. 16, 1995, 151–168; A. Dullweber et al., J. Chem. Phys. 107, 1997, 5840–5851).
use super::state::RigidState;
use nalgebra::{Matrix3, SymmetricEigen, Vector3};

/// R I Rᵀ: the inertia tensor about the center in the present orientation.
pub fn inertia(body: &RigidState) -> Matrix3<f64> {
    let rotation = Matrix3::from_row_slice(&body.rotation);
    rotation * Matrix3::from_row_slice(&body.inertia) * rotation.transpose()
}

/// The angular momentum about the center.
pub fn momentum(body: &RigidState) -> Vector3<f64> {
    inertia(body) * Vector3::from(body.angular)
}

/// The angular velocity [rad/s] that belongs to an angular momentum: ω_f = I_ff⁻¹ L_f about the axes that are not locked.
pub fn spin_of(body: &RigidState, l: Vector3<f64>, locked: [bool; 3]) -> [f64; 3] {
    let (mut tensor, mut l) = (inertia(body), l);
    for a in (0..3).filter(|&a| locked[a]) {
        tensor.row_mut(a).fill(0.0);
        tensor.column_mut(a).fill(0.0);
        (tensor[(a, a)], l[a]) = (1.0, 0.0);
    }
    tensor.try_inverse().map_or([0.0; 3], |inverse| (inverse * l).into())
}

/// Turns a body that is locked about some axes, with the angular momentum L_f about the others, which stays: the midpoint rule.
pub fn turn_locked(body: &mut RigidState, l: Vector3<f64>, dt: f64, locked: [bool; 3]) {
    let before = body.rotation;
    body.angular = spin_of(body, l, locked);
    turn_by(body, 0.5 * dt);
    body.angular = spin_of(body, l, locked);
    body.rotation = before;
    turn_by(body, dt);
    body.angular = spin_of(body, l, locked);
}

/// R ← e^(ω Δt) R: turns a body by what its angular velocity says.
pub fn turn_by(body: &mut RigidState, dt: f64) {
    let step = Matrix3::from_row_slice(&physics::motion::rotation(body.angular.map(|w| w * dt)));
    let rotation = step * Matrix3::from_row_slice(&body.rotation);
    body.rotation = std::array::from_fn(|n| rotation[(n / 3, n % 3)]);
}

/// Turns the body for a time `dt` [s] with the angular momentum `l`, which stays.
///
/// In the frame of the principal axes the energy is a sum of three terms, each of which turns the body about its axis by
/// t π_a / I_a while the others rest: half steps about x and y, a whole one about z, and half steps about y and x.
pub fn turn(body: &mut RigidState, l: Vector3<f64>, dt: f64) {
    let SymmetricEigen { eigenvalues, mut eigenvectors } =
        SymmetricEigen::new(Matrix3::from_row_slice(&body.inertia));
    if eigenvectors.determinant() < 0.0 {
        eigenvectors.column_mut(0).neg_mut();
    }
    let rotation = Matrix3::from_row_slice(&body.rotation);
    let mut frame = rotation * eigenvectors;
    let mut pi = frame.transpose() * l;
    for (axis, part) in [(0, 0.5), (1, 0.5), (2, 1.0), (1, 0.5), (0, 0.5)] {
        if eigenvalues[axis] > 0.0 {
            let (sin, cos) = (part * dt * pi[axis] / eigenvalues[axis]).sin_cos();
            let (b, c) = ((axis + 1) % 3, (axis + 2) % 3);
            let (u, v) = (frame.column(b).clone_owned(), frame.column(c).clone_owned());
            frame.set_column(b, &(cos * u + sin * v));
            frame.set_column(c, &(cos * v - sin * u));
            (pi[b], pi[c]) = (cos * pi[b] + sin * pi[c], cos * pi[c] - sin * pi[b]);
        }
    }
    let rotation: Matrix3<f64> = frame * eigenvectors.transpose();
    // rounding adds up: a step of Newton to the nearest rotation
    let excess: Matrix3<f64> = rotation.transpose() * rotation - Matrix3::identity();
    let rotation: Matrix3<f64> = rotation - 0.5 * rotation * excess;
    body.rotation = std::array::from_fn(|n| rotation[(n / 3, n % 3)]);
    if let Some(inverse) = inertia(body).try_inverse() {
        body.angular = (inverse * l).into();
    }
}
