//! One explicit step of the material point method, particle by particle and node by node.
//!
//! Sulsky, Chen & Schreyer (1994) with the weights of Bardenhagen & Kober (2004); stresses are updated last. Each material has
//! a grid of its own, so that materials do not feel each other.
use crate::laws::Law;
use nalgebra::{Matrix3, Vector3};
use std::collections::HashMap;

pub type M3 = Matrix3<f64>;
pub type V3 = Vector3<f64>;

#[derive(Clone, Debug)]
pub struct Particle {
    pub identity: u64,
    pub material: usize,
    pub mass: f64,
    pub initial_volume: f64,
    pub volume: f64,
    pub x: V3,
    pub v: V3,
    pub f: M3,
    pub kirchhoff: M3,
    pub history: Vec<f64>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Face {
    Free,
    Fixed,
    Symmetric,
}

#[derive(Clone, Debug)]
pub struct Material {
    pub law: Law,
    pub density: f64,
    /// Half the edges of an undeformed particle [m].
    pub half_size: V3,
}

/// What does not change from step to step.
#[derive(Clone, Debug)]
pub struct Model {
    pub lower: V3,
    pub cells: [i32; 3],
    /// Edge of a cell [m].
    pub h: f64,
    /// Uniform GIMP, or hats.
    pub gimp: bool,
    /// Lower and upper face of each axis.
    pub faces: [[Face; 2]; 3],
    pub gravity: V3,
    /// Rate of the mass-proportional damping [1/s].
    pub damping: f64,
    /// Share of PIC in the velocity update.
    pub pic: f64,
    /// c₂ of the artificial viscosity.
    pub viscosity: f64,
    pub materials: Vec<Material>,
}

/// Number of a node along each axis; 0 is on the lower face.
type Index = [i32; 3];

#[derive(Clone, Debug)]
struct Node {
    mass: f64,
    momentum: V3,
    force: V3,
    /// Velocity at the end of the step.
    v: V3,
    /// Its change in the step.
    dv: V3,
}

/// A node that a particle touches: S and grad S at the particle.
struct Weight {
    node: Index,
    s: f64,
    gradient: V3,
}

/// S and dS/dx of uniform GIMP at distance x from the node, for particles of half-size l: Bardenhagen & Kober (2004), the
/// weighting functions for particles that stay as they are (contiguous, l ≤ h/2).
fn gimp(x: f64, h: f64, l: f64) -> (f64, f64) {
    let d = x.abs();
    let (s, slope) = if d < l {
        (1.0 - (d * d + l * l) / (2.0 * h * l), -d / (h * l))
    } else if d < h - l {
        (1.0 - d / h, -1.0 / h)
    } else if d < h + l {
        ((h + l - d).powi(2) / (4.0 * h * l), -(h + l - d) / (2.0 * h * l))
    } else {
        (0.0, 0.0)
    };
    (s, slope * x.signum())
}

/// S and dS/dx of a hat.
fn hat(x: f64, h: f64) -> (f64, f64) {
    let d = x.abs();
    if d < h { (1.0 - d / h, -x.signum() / h) } else { (0.0, 0.0) }
}

/// All nodes that a particle at x touches.
fn weights(model: &Model, material: &Material, x: V3) -> Vec<Weight> {
    let on_axis = |axis: usize| -> Vec<(i32, f64, f64)> {
        let cell = ((x[axis] - model.lower[axis]) / model.h).floor() as i32;
        let mut found = Vec::new();
        for i in cell - 1..=cell + 2 {
            let distance = x[axis] - (model.lower[axis] + f64::from(i) * model.h);
            let (s, slope) = match model.gimp {
                true => gimp(distance, model.h, material.half_size[axis]),
                false => hat(distance, model.h),
            };
            if s > 0.0 {
                found.push((i, s, slope));
            }
        }
        found
    };
    let [xs, ys, zs] = [0, 1, 2].map(on_axis);
    let mut all = Vec::new();
    for &(i, sx, gx) in &xs {
        for &(j, sy, gy) in &ys {
            for &(k, sz, gz) in &zs {
                let gradient = V3::new(gx * sy * sz, sx * gy * sz, sx * sy * gz);
                all.push(Weight { node: [i, j, k], s: sx * sy * sz, gradient });
            }
        }
    }
    all
}

/// Takes one step of size dt [s].
pub fn step(model: &Model, particles: &mut [Particle], dt: f64) {
    for (index, material) in model.materials.iter().enumerate() {
        let of_material = particles.iter_mut().filter(|p| p.material == index);
        step_material(model, material, of_material.collect(), dt);
    }
}

fn step_material(model: &Model, material: &Material, particles: Vec<&mut Particle>, dt: f64) {
    let weights: Vec<Vec<Weight>> = particles.iter().map(|p| weights(model, material, p.x)).collect();

    // particles to nodes: Sulsky, Chen & Schreyer (1994)
    let mut grid: HashMap<Index, Node> = HashMap::new();
    for (p, weights) in particles.iter().zip(&weights) {
        for w in weights {
            let zero = V3::zeros();
            let empty = Node { mass: 0.0, momentum: zero, force: zero, v: zero, dv: zero };
            let (index, turned) = within(model, w.node);
            let node = grid.entry(index).or_insert(empty);
            node.mass += w.s * p.mass;
            node.momentum += turned.component_mul(&(w.s * p.mass * p.v));
            // V σ = V0 τ
            node.force -= turned.component_mul(&(p.initial_volume * p.kirchhoff * w.gradient));
        }
    }

    let lightest = model.materials.iter().map(|m| m.density).fold(f64::INFINITY, f64::min);
    for (index, node) in &mut grid {
        if node.mass <= 1e-14 * lightest * model.h.powi(3) {
            continue; // it rests
        }
        let mut before = node.momentum / node.mass;
        hold(model, index, &mut before);
        // what solves dv/dt = f/m + g - alpha v from the velocity before
        let decay = f64::exp(-model.damping * dt);
        let worth = if model.damping == 0.0 { dt } else { (1.0 - decay) / model.damping };
        node.v = decay * before + worth * (node.force / node.mass + model.gravity);
        hold(model, index, &mut node.v);
        node.dv = node.v - before;
    }

    // nodes to particles
    for (p, weights) in particles.into_iter().zip(&weights) {
        let (mut v, mut dv, mut l) = (V3::zeros(), V3::zeros(), M3::zeros());
        for w in weights {
            let (index, turned) = within(model, w.node);
            let node = &grid[&index];
            v += w.s * turned.component_mul(&node.v);
            dv += w.s * turned.component_mul(&node.dv);
            l += turned.component_mul(&node.v) * w.gradient.transpose();
        }
        p.v = (1.0 - model.pic) * (p.v + dv) + model.pic * v;
        p.x += dt * v;

        let increment = M3::identity() + dt * l;
        let f = increment * p.f;
        let response = material.law.respond(&f, &increment, &mut p.history);
        p.kirchhoff = response.kirchhoff;
        if !response.frozen {
            p.f = f;
            p.volume = f.determinant() * p.initial_volume;
        }
        // von Neumann & Richtmyer (1950): the pressure q = ρ c₂ (h tr D)² resists compression; J ρ = m/V0
        if l.trace() < 0.0 {
            let q = model.viscosity * (model.h * l.trace()).powi(2) * p.mass / p.initial_volume;
            p.kirchhoff -= M3::identity() * q;
        }
    }
}

/// The image within the domain of a node behind faces, and by what its vectors are multiplied to make those behind the faces: a
/// mirror turns what is normal to it, matter that sticks to a face turns all.
fn within(model: &Model, node: Index) -> (Index, V3) {
    let (mut image, mut turned) = (node, V3::repeat(1.0));
    for axis in 0..3 {
        for (face, plane) in model.faces[axis].into_iter().zip([0, model.cells[axis]]) {
            let behind = if plane == 0 { node[axis] < 0 } else { node[axis] > plane };
            if !behind || face == Face::Free {
                continue;
            }
            image[axis] = 2 * plane - node[axis];
            match face {
                Face::Fixed => turned *= -1.0,
                _ => turned[axis] *= -1.0,
            }
        }
    }
    (image, turned)
}

/// What the faces do to the velocity of a node on or behind them.
fn hold(model: &Model, index: &Index, v: &mut V3) {
    for axis in 0..3 {
        let at = [index[axis] <= 0, index[axis] >= model.cells[axis]];
        for (face, at) in model.faces[axis].into_iter().zip(at) {
            match face {
                Face::Fixed if at => *v = V3::zeros(),
                Face::Symmetric if at => v[axis] = 0.0,
                _ => {}
            }
        }
    }
}
