//! How far the particles of Sinew are from those of the reference.
use crate::step::Particle;
use std::fmt;
use std::ops::Range;

/// Largest difference of a field over all particles of a material, over its denominator: for x the edge of a cell, for the others
/// the largest component of the field in any particle of that material in the reference. Fields of the history are those that
/// [`parts`] names. Of the two materials the worse one counts.
#[derive(Clone, Copy, Debug, Default)]
pub struct Errors {
    pub x: f64,
    pub v: f64,
    pub f: f64,
    pub kirchhoff: f64,
    pub volume: f64,
    pub history: f64,
    /// Particles whose failure code differs; summed over materials and steps.
    pub codes: usize,
}

impl Errors {
    pub fn worst(&self) -> f64 {
        [self.x, self.v, self.f, self.kirchhoff, self.volume, self.history].into_iter().fold(0.0, largest)
    }
    pub fn and(self, other: Self) -> Self {
        Self {
            x: largest(self.x, other.x),
            v: largest(self.v, other.v),
            f: largest(self.f, other.f),
            kirchhoff: largest(self.kirchhoff, other.kirchhoff),
            volume: largest(self.volume, other.volume),
            history: largest(self.history, other.history),
            codes: self.codes + other.codes,
        }
    }
}

impl fmt::Display for Errors {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { x, v, f: deformation, kirchhoff, volume, history, codes } = self;
        write!(f, "x {x:.1e}, v {v:.1e}, F {deformation:.1e}, tau {kirchhoff:.1e}, V {volume:.1e}, ")?;
        write!(f, "history {history:.1e}, {codes} codes differ")
    }
}

/// The larger one; a NaN stays.
fn largest(a: f64, b: f64) -> f64 {
    if a.is_nan() || a > b { a } else { b }
}

/// The fields of a law's history, by its length: b̄ᵉ and α; a₀, failure and released energy; nothing.
fn parts(history: usize) -> &'static [Range<usize>] {
    match history {
        7 => &[0..6, 6..7],
        5 => &[0..3, 3..4, 4..5],
        _ => &[],
    }
}

pub fn compare(h: f64, sinew: &[Particle], reference: &[Particle]) -> Errors {
    let same = |(a, b): (&Particle, &Particle)| a.identity == b.identity && a.material == b.material;
    assert!(sinew.len() == reference.len() && sinew.iter().zip(reference).all(same));
    let of_material = |m: usize| {
        let pairs: Vec<_> = sinew.iter().zip(reference).filter(|(a, _)| a.material == m).collect();
        compare_material(h, &pairs)
    };
    of_material(0).and(of_material(1))
}

fn compare_material(h: f64, pairs: &[(&Particle, &Particle)]) -> Errors {
    let field = |numbers: &dyn Fn(&Particle) -> &[f64], scale: Option<f64>| {
        let (mut apart, mut size) = (0.0, 0.0);
        for (a, b) in pairs {
            for (a, b) in numbers(a).iter().zip(numbers(b)) {
                apart = largest(apart, (a - b).abs());
                size = largest(size, b.abs());
            }
        }
        // fields that agree may be zero everywhere
        if apart == 0.0 { 0.0 } else { apart / scale.unwrap_or(size) }
    };
    let length = pairs[0].0.history.len();
    let history = parts(length).iter().map(|part| field(&|p| &p.history[part.clone()], None));
    Errors {
        x: field(&|p| p.x.as_slice(), Some(h)),
        v: field(&|p| p.v.as_slice(), None),
        f: field(&|p| p.f.as_slice(), None),
        kirchhoff: field(&|p| p.kirchhoff.as_slice(), None),
        volume: field(&|p| std::slice::from_ref(&p.volume), None),
        history: history.fold(0.0, largest),
        codes: pairs.iter().filter(|(a, b)| length == 5 && a.history[3] != b.history[3]).count(),
    }
}
