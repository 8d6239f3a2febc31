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
