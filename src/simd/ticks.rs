//! A clock fine enough for work of a tenth of a microsecond.
#![allow(unsafe_code)]

/// Ticks of a counter with a constant, unknown rate: compare with a clock to learn it. Reading it takes some nanoseconds
/// and does not wait for what was begun before, so work shorter than that is smeared over its neighbors.
#[inline(always)]
pub fn ticks() -> u64 {
    #[cfg(target_arch = "x86_64")]
    // SAFETY: every x86-64 processor has the time-stamp counter.
    unsafe {
        std::arch::x86_64::_rdtsc()
    }
    #[cfg(not(target_arch = "x86_64"))]
    {
        use std::sync::LazyLock;
        use std::time::Instant;
        static BEGAN: LazyLock<Instant> = LazyLock::new(Instant::now);
        BEGAN.elapsed().as_nanos() as u64
    }
}
