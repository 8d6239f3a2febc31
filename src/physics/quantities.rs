//! What can be shown of a particle, each by its name: what its state holds, and what follows from that.
//!
//! Scenes choose among them (`output.fields`); frames, probes and pages take name, unit and meaning from here. A law adds
//! its own ([`Law::HISTORY`](super::law::Law::HISTORY), [`Law::SHOWN`](super::law::Law::SHOWN)).

use simd::{LANES, Simd, Wide};

/// Eight numbers, one of each particle of a tile. Their arithmetic is that of single numbers, whatever the instruction set.
pub type Eight = simd::Array;

/// The state of eight particles, a lane each. What their material does not have is not a number.
#[derive(Clone, Copy, Debug)]
pub struct Tile<'a> {
    /// Position x [m].
    pub position: &'a [Wide; 3],
    /// Where they were at the start, X [m].
    pub start: &'a [Wide; 3],
    /// Velocity [m/s].
    pub velocity: &'a [Wide; 3],
    /// Mass [kg].
    pub mass: &'a Wide,
    /// Volume [m³].
    pub volume: Wide,
    /// J = det F
    pub j: Wide,
    /// Deformation gradient F, row by row.
    pub f: &'a [Wide; 9],
    /// Kirchhoff stress τ = J σ [Pa]: xx, xy, xz, yy, yz, zz.
    pub kirchhoff: &'a [Wide; 6],
    /// What their law keeps.
    pub history: &'a [Wide],
}

/// As many numbers as a quantity has at most, each of eight particles.
pub type Numbers = [Wide; 9];

/// Of particles that have none.
pub const NONE: Numbers = [Wide([f64::NAN; LANES]); 9];

/// Puts down what a quantity has of eight particles, from the first number on.
pub type Value = fn(&Tile, &mut Numbers);

/// Who has a quantity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Of {
    /// Every particle.
    All,
    /// Particles that deform.
    Deformable,
    /// Particles whose law declares it.
    Law,
}

/// What something shown of particles is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shown {
    /// Its name in files and scenes.
    pub name: &'static str,
    /// SI unit.
    pub unit: &'static str,
    /// Numbers a particle: 1, a vector of 3, a symmetric tensor of 6 (xx, yy, zz, xy, yz, xz, as VTK has them), or a tensor
    /// of 9 (row by row).
    pub components: usize,
    /// What it is, in a line.
    pub meaning: &'static str,
    /// What its values mean, from 0 on, if they are codes.
    pub codes: &'static [&'static str],
    /// Whether a scene that names none gets it.
    pub usual: bool,
    /// Whether it needs to know where the particle was at the start.
    pub from_start: bool,
}

/// Something to show of a particle.
#[derive(Clone, Copy, Debug)]
pub struct Quantity {
    /// What it is.
    pub shown: Shown,
    /// Who has it.
    pub of: Of,
    /// Its value.
    pub value: Value,
}

/// A particle that is squeezed to less than this part of its volume has collapsed: it bears nothing any more, and σ = τ / J of so small a J
/// means nothing.
pub const COLLAPSED: f64 = 0.1;

const fn of_all(
    (name, unit): (&'static str, &'static str),
    components: usize,
    value: Value,
    meaning: &'static str,
) -> Quantity {
    let shown = Shown { name, unit, components, meaning, codes: &[], usual: false, from_start: false };
    Quantity { shown, of: Of::All, value }
}

const fn of_deformable(
    name: (&'static str, &'static str),
    components: usize,
    value: Value,
    meaning: &'static str,
) -> Quantity {
    Quantity { of: Of::Deformable, ..of_all(name, components, value, meaning) }
}

impl Quantity {
    /// One that a law alone has.
    pub const fn of_law(name: &'static str, components: usize, value: Value, meaning: &'static str) -> Self {
        Self { of: Of::Law, ..of_all((name, "1"), components, value, meaning) }
    }

    const fn usual(self) -> Self {
        Self { shown: Shown { usual: true, ..self.shown }, ..self }
    }

    const fn needs_start(self) -> Self {
        Self { shown: Shown { from_start: true, ..self.shown }, ..self }
    }
}

/// Where a particle is, which frames show in any case.
pub const POSITION: Quantity = of_all(("position", "m"), 3, |p, out| put(out, p.position), "position x");

/// All that does not depend on the law.
pub const QUANTITIES: &[Quantity] = &[
    of_all(("displacement", "m"), 3, displacement, "x − X: how far it is from where it was at the start")
        .usual()
        .needs_start(),
    of_all(("velocity", "m/s"), 3, |p, out| put(out, p.velocity), "velocity v").usual(),
    of_deformable(
        ("volume_ratio", "1"),
        1,
        |p, out| out[0] = p.j,
        "J = det F: volume over that of the unstretched matter",
    )
    .usual(),
    of_deformable(("pressure", "Pa"), 1, pressure, "−tr σ / 3, above zero under compression").usual(),
    of_deformable(("von_mises", "Pa"), 1, von_mises, "√(3/2 s : s), s the deviator of σ").usual(),
    of_deformable(
        ("stress", "Pa"),
        6,
        |p, out| store(out, &vtk_order(&cauchy(p))),
        "Cauchy stress σ = τ / J",
    ),
    of_deformable(
        ("kirchhoff_stress", "Pa"),
        6,
        |p, out| put(out, &vtk_order(p.kirchhoff)),
        "Kirchhoff stress τ = J σ",
    ),
    of_deformable(("deformation_gradient", "1"), 9, |p, out| put(out, p.f), "deformation gradient F = ∂x/∂X"),
    of_deformable(
        ("strain", "1"),
        6,
        |p, out| store(out, &vtk_order(&green_lagrange(p.f))),
        "Green-Lagrange strain E = (FᵀF − 1) / 2",
    ),
    of_deformable(
        ("shear_strain", "1"),
        1,
        |p, out| store(out, &[largest_shear(&green_lagrange(p.f))]),
        "largest shear of E: half the span of its principal values",
    ),
    of_all(("reference_position", "m"), 3, |p, out| put(out, p.start), "X: where it was at the start")
        .needs_start(),
    of_all(("mass", "kg"), 1, |p, out| out[0] = *p.mass, "mass m"),
    of_all(("volume", "m^3"), 1, |p, out| out[0] = p.volume, "volume V = J V₀"),
    of_all(
        ("radius", "m"),
        1,
        |p, out| out[0] = Wide(p.volume.0.map(|v| (0.75 / std::f64::consts::PI * v).cbrt())),
        "radius of a ball of its volume",
    ),
];

fn put(out: &mut Numbers, numbers: &[Wide]) {
    out[..numbers.len()].copy_from_slice(numbers);
}

#[inline(always)]
fn store(out: &mut Numbers, numbers: &[Eight]) {
    simd::store(numbers, &mut out[..numbers.len()]);
}

fn displacement(p: &Tile, out: &mut Numbers) {
    let [x, start]: [[Eight; 3]; 2] = [simd::load(p.position), simd::load(p.start)];
    store(out, &[x[0] - start[0], x[1] - start[1], x[2] - start[2]]);
}

fn pressure(p: &Tile, out: &mut Numbers) {
    let s = cauchy(p);
    store(out, &[-(s[0] + s[3] + s[5]) / Eight::splat(3.0)]);
}

fn von_mises(p: &Tile, out: &mut Numbers) {
    store(out, &[(Eight::splat(3.0) * invariants(&cauchy(p))[1]).sqrt()]);
}

/// σ = τ / J: xx, xy, xz, yy, yz, zz; not a number where the particle has collapsed.
#[inline(always)]
fn cauchy(p: &Tile) -> [Eight; 6] {
    let (j, t) = (Eight::load(&p.j), simd::load::<Eight, 6>(p.kirchhoff));
    let j = Eight::select(j.lt(Eight::splat(COLLAPSED)), Eight::splat(f64::NAN), j);
    [t[0] / j, t[1] / j, t[2] / j, t[3] / j, t[4] / j, t[5] / j]
}

/// E = (FᵀF − 1) / 2: xx, xy, xz, yy, yz, zz.
#[inline(always)]
fn green_lagrange(f: &[Wide; 9]) -> [Eight; 6] {
    let f: [Eight; 9] = simd::load(f);
    let c = |i: usize, k: usize| f[i] * f[k] + f[3 + i] * f[3 + k] + f[6 + i] * f[6 + k];
    let e = |i: usize, k: usize| Eight::splat(0.5) * (c(i, k) - Eight::splat(f64::from(i == k)));
    [e(0, 0), e(0, 1), e(0, 2), e(1, 1), e(1, 2), e(2, 2)]
}

/// Half the span of the principal values: with the angle θ of Lode, √J₂ cos(θ − π/6), 0 ≤ θ ≤ π/3.
fn largest_shear(a: &[Eight; 6]) -> Eight {
    let [_, j2, j3] = invariants(a).map(Simd::lanes);
    let of = |lane: usize| {
        let (j2, j3) = (j2[lane], j3[lane]);
        if j2 <= 0.0 {
            return 0.0;
        }
        let cosine = (1.5 * 3f64.sqrt() * j3 / j2.powf(1.5)).clamp(-1.0, 1.0);
        j2.sqrt() * (cosine.acos() / 3.0 - std::f64::consts::FRAC_PI_6).cos()
    };
    Eight::load(&Wide(std::array::from_fn::<f64, LANES, _>(of)))
}

/// tr A / 3, and J₂ = ½ s : s and J₃ = det s of the deviator s.
#[inline(always)]
fn invariants(a: &[Eight; 6]) -> [Eight; 3] {
    let mean = (a[0] + a[3] + a[5]) / Eight::splat(3.0);
    let [x, xy, xz, y, yz, z] = [a[0] - mean, a[1], a[2], a[3] - mean, a[4], a[5] - mean];
    let j2 = Eight::splat(0.5) * (x * x + y * y + z * z) + xy * xy + xz * xz + yz * yz;
    let j3 = x * (y * z - yz * yz) - xy * (xy * z - yz * xz) + xz * (xy * yz - y * xz);
    [mean, j2, j3]
}

/// Symmetric tensors as VTK has them: xx, yy, zz, xy, yz, xz.
#[inline(always)]
fn vtk_order<T: Copy>([xx, xy, xz, yy, yz, zz]: &[T; 6]) -> [T; 6] {
    [*xx, *yy, *zz, *xy, *yz, *xz]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A particle of which a tile has several.
    #[derive(Clone, Copy)]
    struct Particle {
        position: [f64; 3],
        start: [f64; 3],
        velocity: [f64; 3],
        mass: f64,
        volume: f64,
        j: f64,
        f: [f64; 9],
        kirchhoff: [f64; 6],
    }

    /// The numbers of a quantity of a particle that is in every second lane, among particles at rest.
    fn value(name: &str, particle: &Particle) -> [f64; 9] {
        let lanes = |x: f64, other: f64| Wide(std::array::from_fn(|l| if l % 2 == 0 { x } else { other }));
        let quantity = QUANTITIES.iter().find(|q| q.shown.name == name).expect("there is one");
        let mut out = NONE;
        let tile = Tile {
            position: &particle.position.map(|x| lanes(x, 0.0)),
            start: &particle.start.map(|x| lanes(x, 0.0)),
            velocity: &particle.velocity.map(|x| lanes(x, 0.0)),
            mass: &lanes(particle.mass, 1.0),
            volume: lanes(particle.volume, 1.0),
            j: lanes(particle.j, 1.0),
            f: &std::array::from_fn(|c| lanes(particle.f[c], f64::from(c % 4 == 0))),
            kirchhoff: &particle.kirchhoff.map(|t| lanes(t, 0.0)),
            history: &[],
        };
        (quantity.value)(&tile, &mut out);
        let of = |lane: usize| out.map(|line| line.0[lane]);
        assert!(of(0)[quantity.shown.components..].iter().all(|x| x.is_nan()), "{name}");
        assert!((2..LANES).all(|l| of(l).map(f64::to_bits) == of(l - 2).map(f64::to_bits)), "{name}");
        of(0)
    }

    /// Simple shear by γ of matter that is stretched by λ along x before.
    fn sheared(gamma: f64, stretch: f64) -> Particle {
        Particle {
            position: [1.0, 2.0, 4.0],
            start: [1.0, 1.5, 5.0],
            velocity: [3.0, -1.0, 0.5],
            mass: 2.0,
            volume: 4.0 / 3.0 * std::f64::consts::PI * 27.0,
            j: stretch,
            f: [stretch, gamma, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
            kirchhoff: [0.0; 6],
        }
    }

    #[test]
    fn strains_of_simple_shear_are_those_of_books() {
        let p = sheared(0.4, 1.0);
        // E = [0, γ/2; γ/2, γ²/2]
        assert_eq!(value("strain", &p)[..6], [0.0, 0.5 * (0.4 * 0.4 + 1.0 - 1.0), 0.0, 0.2, 0.0, 0.0]);
        let span = (0.25f64 * 0.08 * 0.08 + 0.2 * 0.2).sqrt();
        assert!((value("shear_strain", &p)[0] - span).abs() < 1e-15, "{}", value("shear_strain", &p)[0]);
        // uniaxial: E₁ = (λ² − 1) / 2, the others 0
        let pulled = value("shear_strain", &sheared(0.0, 1.5))[0];
        assert!((pulled - 0.5 * 0.625).abs() < 1e-8, "{pulled}");
        assert_eq!(value("shear_strain", &sheared(0.0, 1.0))[0], 0.0);
        assert_eq!(value("displacement", &p)[..3], [0.0, 0.5, -1.0]);
        assert!((value("radius", &p)[0] - 3.0).abs() < 1e-14);
    }

    #[test]
    fn stresses_follow_from_kirchhoff_s() {
        let p = Particle { kirchhoff: [3.0, 1.0, 2.0, -6.0, 4.0, 9.0], ..sheared(0.0, 0.5) };
        assert_eq!(value("stress", &p)[..6], [6.0, -12.0, 18.0, 2.0, 8.0, 4.0]);
        assert_eq!(value("pressure", &p)[0], -4.0);
        let [x, y, z, xy, yz, xz] = [6.0, -12.0, 18.0, 2.0, 8.0, 4.0f64];
        let squares = (x - y).powi(2) + (y - z).powi(2) + (z - x).powi(2);
        let mises = (0.5 * squares + 3.0 * (xy * xy + yz * yz + xz * xz)).sqrt();
        assert!((value("von_mises", &p)[0] / mises - 1.0).abs() < 1e-15);
    }

    #[test]
    fn what_has_collapsed_shows_no_stress() {
        let p = Particle { kirchhoff: [-1e6; 6], ..sheared(0.0, 2e-6) };
        assert!(value("von_mises", &p)[0].is_nan() && value("pressure", &p)[0].is_nan());
        assert_eq!(value("kirchhoff_stress", &p)[0], -1e6);
        assert_eq!(value("volume_ratio", &p)[0], 2e-6);
    }

    #[test]
    fn names_are_unique() {
        for (i, one) in QUANTITIES.iter().enumerate() {
            assert!(
                QUANTITIES[..i].iter().all(|other| other.shown.name != one.shown.name),
                "{}",
                one.shown.name
            );
        }
    }
}
