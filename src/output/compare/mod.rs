//! Two runs beside each other, particle by particle: bit for bit, or within tolerances. Components of vectors and tensors
//! are compared one by one: a turned stress has the same norm.
pub mod history;
mod sources;
mod tolerances;

pub use sources::{checkpoint_particles, checkpoint_shared, frame_particles};
pub use tolerances::Tolerances;

use crate::output::frame::part_names;

/// A label of particles.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    /// Its name.
    pub label: String,
    /// Numbers a particle.
    pub components: usize,
    /// Particle by particle.
    pub values: Vec<f64>,
}

/// Particles of one side.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Particles {
    /// Identities.
    pub identities: Vec<u64>,
    /// Indices of materials.
    pub materials: Vec<usize>,
    /// Positions [m].
    pub positions: Vec<[f64; 3]>,
    /// What is compared.
    pub columns: Vec<Column>,
}

/// How one component of a label differs between two sides.
#[derive(Clone, Debug, PartialEq)]
pub struct Norms {
    /// The label.
    pub label: String,
    /// Which of its components, and how many it has.
    pub component: (usize, usize),
    /// Largest difference; infinite where only one side is a number.
    pub most: f64,
    /// Root of the mean square of the differences (the L2 norm over all particles).
    pub rms: f64,
    /// What is allowed; `None`: the same bits.
    pub allowed: Option<f64>,
    /// Particles that differ by more.
    pub differing: usize,
}

/// A particle that differs.
#[derive(Clone, Debug, PartialEq)]
pub struct Particle {
    /// Its identity.
    pub identity: u64,
    /// Index of its material.
    pub material: usize,
    /// Its position [m], on the first side.
    pub position: [f64; 3],
    /// The first label that differs, with the component, and the values of both sides.
    pub label: String,
    /// Which component.
    pub component: (usize, usize),
    /// On both sides.
    pub values: [f64; 2],
}

/// What a comparison found.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Comparison {
    /// Particles that only the first, and only the second side has.
    pub only: [Vec<u64>; 2],
    /// Labels that only one side has.
    pub unpaired: Vec<String>,
    /// Every component of every label of both sides.
    pub norms: Vec<Norms>,
    /// The differing particle with the smallest identity.
    pub first: Option<Particle>,
}

impl Comparison {
    /// Whether nothing differs by more than is allowed.
    pub fn same(&self) -> bool {
        self.only.iter().all(Vec::is_empty) && self.unpaired.is_empty() && self.first.is_none()
    }
}

/// `velocity.y`, `KirchhoffStress.xy`, `failure`
pub fn component_name(label: &str, (component, of): (usize, usize)) -> String {
    let names: &[&str] = match of {
        1 => return label.to_owned(),
        // row by row, as checkpoints have them
        6 => &["xx", "xy", "xz", "yy", "yz", "zz"],
        many => part_names(many),
    };
    names.get(component).map_or_else(|| format!("{label}.{component}"), |name| format!("{label}.{name}"))
}

/// Compares two sides.
pub fn compare(one: &Particles, other: &Particles, tolerances: &Tolerances) -> Comparison {
    let (pairs, only) = pair(one, other);
    let mut found = Comparison { only, ..Comparison::default() };
    for column in &one.columns {
        match other.columns.iter().find(|c| c.label == column.label && c.components == column.components) {
            Some(beside) => compare_columns(one, [column, beside], &pairs, tolerances, &mut found),
            None => found.unpaired.push(column.label.clone()),
        }
    }
    let known = |label: &String| one.columns.iter().any(|c| c.label == *label);
    let more = other.columns.iter().map(|column| column.label.clone()).filter(|label| !known(label));
    found.unpaired.extend(more);
    found
}

/// Rows of the same identity, ascending, and the identities of only one side.
fn pair(one: &Particles, other: &Particles) -> (Vec<[usize; 2]>, [Vec<u64>; 2]) {
    let order = |side: &Particles| {
        let mut rows: Vec<usize> = (0..side.identities.len()).collect();
        rows.sort_by_key(|&row| side.identities[row]);
        rows
    };
    let (mut pairs, mut only) = (Vec::new(), [Vec::new(), Vec::new()]);
    let (mut a, mut b) = (order(one).into_iter().peekable(), order(other).into_iter().peekable());
    loop {
        let ids = [a.peek().map(|&row| one.identities[row]), b.peek().map(|&row| other.identities[row])];
        match ids {
            [None, None] => return (pairs, only),
            [Some(x), Some(y)] if x == y => pairs.extend(a.next().zip(b.next()).map(|(i, j)| [i, j])),
            [Some(x), y] if y.is_none_or(|y| x < y) => {
                only[0].push(x);
                a.next();
            }
            [_, y] => {
                only[1].extend(y);
                b.next();
            }
        }
    }
}

fn compare_columns(
    one: &Particles,
    [a, b]: [&Column; 2],
    pairs: &[[usize; 2]],
    tolerances: &Tolerances,
    found: &mut Comparison,
) {
    let largest = a.values.iter().filter(|x| x.is_finite()).fold(0.0, |most: f64, x| most.max(x.abs()));
    let allowed = tolerances.allowed(&a.label, largest);
    for component in 0..a.components {
        let component = (component, a.components);
        let mut norms =
            Norms { label: a.label.clone(), component, most: 0.0, rms: 0.0, allowed, differing: 0 };
        for &[i, j] in pairs {
            let values = [a.values[i * a.components + component.0], b.values[j * a.components + component.0]];
            let difference = distance(values);
            norms.most = norms.most.max(difference);
            norms.rms += difference * difference;
            if tolerated(values, allowed) {
                continue;
            }
            norms.differing += 1;
            let identity = one.identities[i];
            if found.first.as_ref().is_none_or(|first| identity < first.identity) {
                let (material, position, label) = (one.materials[i], one.positions[i], a.label.clone());
                found.first = Some(Particle { identity, material, position, label, component, values });
            }
        }
        norms.rms = (norms.rms / pairs.len().max(1) as f64).sqrt();
        found.norms.push(norms);
    }
}

/// |a − b|; no distance between two that are no numbers, an infinite one between a number and what is none.
fn distance([a, b]: [f64; 2]) -> f64 {
    match (a.is_nan(), b.is_nan()) {
        (true, true) => 0.0,
        (false, false) if a == b => 0.0,
        (false, false) => (a - b).abs(),
        _ => f64::INFINITY,
    }
}

/// Whether two values differ by no more than is allowed; without an allowance by no bit.
pub fn tolerated(values: [f64; 2], allowed: Option<f64>) -> bool {
    match allowed {
        Some(allowed) => distance(values) <= allowed,
        None => values[0].to_bits() == values[1].to_bits(),
    }
}
