//! How much random tests try.

/// How often as many cases as usual: `SINEW_TEST_CASES`, or 1.
pub fn times() -> u32 {
    std::env::var("SINEW_TEST_CASES").ok().and_then(|times| times.parse().ok()).unwrap_or(1)
}
