//! Random numbers that are the same in every run.
#![allow(dead_code)] // each test takes what it needs

/// Numbers in [0, 1) that are the same in every run (SplitMix64).
pub struct Random(pub u64);

impl Random {
    pub fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ self.0 >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ z >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ z >> 31) >> 11) as f64 / (1u64 << 53) as f64
    }
    /// In [-1, 1).
    pub fn sign(&mut self) -> f64 {
        2.0 * self.unit() - 1.0
    }
    pub fn vector(&mut self) -> [f64; 3] {
        std::array::from_fn(|_| self.sign())
    }
    pub fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }
}
