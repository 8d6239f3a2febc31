use physics::viscosity::Viscosity;
use simd::{Isa, Job, Simd};

struct Pressure(Viscosity, [f64; 4]);

impl Job for Pressure {
    type Output = f64;
    fn run<S: Simd>(self) -> f64 {
        let [density, speed, rate, length] = self.1.map(S::splat);
        self.0.pressure(density, speed, rate, length).lanes()[0]
    }
}

#[test]
fn viscosity_resists_compression_only() {
    let viscosity = Viscosity { linear: 0.2, quadratic: 2.0 };
    let pressure = |rate| Isa::detect().dispatch(Pressure(viscosity, [1000.0, 10.0, rate, 1e-3]));
    assert_eq!((pressure(0.0), pressure(5.0)), (0.0, 0.0));
    let expected = 1000.0 * 1e-3 * (0.2 * 10.0 * 50.0 + 2.0 * 1e-3 * 50.0 * 50.0);
    assert!((pressure(-50.0) - expected).abs() < 1e-12 * expected);
}

struct Hurry(Viscosity, [f64; 3]);
impl Job for Hurry {
    type Output = f64;
    fn run<S: Simd>(self) -> f64 {
        let [c, rate, cell] = self.1.map(S::splat);
        self.0.hurry(c, rate, cell).lanes()[0]
    }
}

/// The largest amplification of x and v by v ← v − Δt (ω² x + 2 ξ ω v), x ← x + Δt v.
fn amplification(omega: f64, xi: f64, dt: f64) -> f64 {
    let (a, b) = (-dt * omega * omega, 1.0 - 2.0 * xi * omega * dt);
    let (trace, determinant) = (1.0 + dt * a + b, (1.0 + dt * a) * b - a * dt * b);
    let root = trace * trace - 4.0 * determinant;
    if root < 0.0 { determinant.sqrt() } else { 0.5 * (trace.abs() + root.sqrt()) }
}

#[test]
fn steps_heed_the_stiffness_of_viscosity() {
    let viscosity = Viscosity { linear: 0.3, quadratic: 1.5 };
    let (c, cell) = (40.0, 1e-3);
    for rate in [-1e-9, -3e3, -1e5] {
        let hurry = Isa::detect().dispatch(Hurry(viscosity, [c, rate, cell]));
        // the shortest wave of a lattice, and its damping by dq/dD = ρ l (c₁ c + 2 c₂ l |D|)
        let omega = 2.0 * c / cell;
        let xi = 0.5 * omega * cell * (0.3 * c + 2.0 * 1.5 * cell * -rate) / (c * c);
        let limit = 2.0 / omega / hurry;
        assert!(amplification(omega, xi, 0.999 * limit) <= 1.0 + 1e-12, "{rate}");
        assert!(amplification(omega, xi, 1.001 * limit) > 1.0, "{rate}");
    }
    assert_eq!(Isa::detect().dispatch(Hurry(viscosity, [c, 1e3, cell])), 1.0);
}
