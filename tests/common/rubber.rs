//! A block of rubber that fills its domain.
use super::Overrides;

/// 12 x 4 x 4 mm of K = 1 MPa, μ = 0.5 MPa, ρ = 1000 kg/m³, between free faces.
pub const RUBBER: &str = r#"
[domain]
lower = [0, 0, 0]
upper = ["12 mm", "4 mm", "4 mm"]
cell = "1 mm"
[material.rubber]
law = "neo-hookean"
density = 1000
bulk-modulus = "1 MPa"
shear-modulus = "0.5 MPa"
[[body]]
name = "block"
material = "rubber"
shape = { box = { lower = [0, 0, 0], upper = ["12 mm", "4 mm", "4 mm"] } }
[run]
until = "1 ms"
cfl = 0.4
"#;

/// The same between mirrors.
pub const MIRRORS: Overrides<'_> = &[
    ("boundary.x-min", "symmetric"),
    ("boundary.x-max", "symmetric"),
    ("boundary.y-min", "symmetric"),
    ("boundary.y-max", "symmetric"),
    ("boundary.z-min", "symmetric"),
    ("boundary.z-max", "symmetric"),
];

/// The same between mirrors, stretched by 1.2 along x at the start.
pub fn pulled() -> Vec<(&'static str, &'static str)> {
    [MIRRORS, &[("body.block.stretch", "[1.2, 1, 1]")]].concat()
}

/// σ of a stretch by λ along x alone [Pa], along x and across: K/2 (J − 1/J) + μ J^(−5/3) dev b, with J = λ and b = diag (λ², 1, 1).
pub fn stress_of(l: f64) -> [f64; 2] {
    let deviator = 0.5e6 * l.powf(-5.0 / 3.0) * (l * l - 1.0) / 3.0;
    let mean = 0.5 * 1e6 * (l - 1.0 / l);
    [mean + 2.0 * deviator, mean - deviator]
}
