//! How random tests are run.
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};

/// Runs so many random cases, `SINEW_TEST_CASES` times as many if that is set; the same each time.
pub fn runner(cases: u32) -> TestRunner {
    let times = std::env::var("SINEW_TEST_CASES").ok().and_then(|times| times.parse().ok()).unwrap_or(1);
    let config = Config {
        cases: cases * times,
        max_global_rejects: u32::MAX,
        failure_persistence: None,
        ..Config::default()
    };
    TestRunner::new_with_rng(config, TestRng::deterministic_rng(RngAlgorithm::ChaCha))
}
