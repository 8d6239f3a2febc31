//! Instruction sets: which there are, and code compiled for each.
use super::counting::Counting;
use super::{Array, Simd};
use std::fmt;

/// Instruction set, chosen once at run time. Only [`Isa::available`] makes those that need detection, and outside this
/// crate nobody can name their vectors: that is what makes `dispatch` sound.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Isa(Level);

#[derive(Clone, Copy, PartialEq, Eq)]
enum Level {
    #[cfg(target_arch = "x86_64")]
    Avx512,
    #[cfg(target_arch = "x86_64")]
    Avx2,
    #[cfg(target_arch = "aarch64")]
    Neon,
    Baseline,
    Counting,
}

impl Isa {
    /// Plain arrays: runs on every machine.
    pub const BASELINE: Isa = Isa(Level::Baseline);

    /// Counts operations instead of being fast (see [`counting::take`]). Nobody gets it who does not ask for it here.
    pub const COUNTING: Isa = Isa(Level::Counting);

    /// The sets of this machine, the best first.
    pub fn available() -> Vec<Self> {
        let mut sets = Vec::new();
        #[cfg(target_arch = "x86_64")]
        {
            macro_rules! all {
                ($($feature:tt)*) => { $(is_x86_feature_detected!($feature))&&* };
            }
            if all!("avx512f" "avx512bw" "avx512dq" "avx512vl" "fma" "bmi1" "bmi2" "lzcnt") {
                sets.push(Isa(Level::Avx512));
            }
            if all!("avx2" "fma" "bmi1" "bmi2" "lzcnt") {
                sets.push(Isa(Level::Avx2));
            }
        }
        #[cfg(target_arch = "aarch64")]
        sets.push(Isa(Level::Neon));
        sets.push(Isa::BASELINE);
        sets
    }

    /// The best set of this machine.
    pub fn detect() -> Self {
        Self::available()[0]
    }

    /// The set named by the environment variable `SINEW_ISA` (`avx512`, `avx2`, `neon`, `baseline`), else the best.
    ///
    /// # Errors
    /// An unknown name, or a set that this machine lacks: the message names the choices.
    pub fn from_environment() -> Result<Self, String> {
        let available = Self::available();
        let Some(name) = std::env::var("SINEW_ISA").ok().filter(|name| !name.is_empty()) else {
            return Ok(available[0]);
        };
        available.iter().copied().find(|isa| isa.name() == name).ok_or_else(|| {
            let names: Vec<&str> = available.iter().map(|isa| isa.name()).collect();
            format!("SINEW_ISA={name}: this machine offers {}", names.join(", "))
        })
    }

    /// `avx512`, `avx2`, `neon` or `baseline`; `counting` counts.
    pub fn name(self) -> &'static str {
        match self.0 {
            #[cfg(target_arch = "x86_64")]
            Level::Avx512 => "avx512",
            #[cfg(target_arch = "x86_64")]
            Level::Avx2 => "avx2",
            #[cfg(target_arch = "aarch64")]
            Level::Neon => "neon",
            Level::Baseline => "baseline",
            Level::Counting => "counting",
        }
    }

    /// Runs `job` compiled for this instruction set.
    #[inline]
    #[allow(unsafe_code)]
    pub fn dispatch<J: Job>(self, job: J) -> J::Output {
        match self.0 {
            // SAFETY: only `available` makes this value, and only where all these features exist.
            #[cfg(target_arch = "x86_64")]
            Level::Avx512 => unsafe { with_avx512(job) },
            // SAFETY: as above.
            #[cfg(target_arch = "x86_64")]
            Level::Avx2 => unsafe { with_avx2(job) },
            #[cfg(target_arch = "aarch64")]
            Level::Neon => job.run::<super::neon::Neon>(),
            Level::Baseline => job.run::<Array>(),
            Level::Counting => counted(job),
        }
    }
}

impl fmt::Debug for Isa {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// Work that is compiled once per instruction set: `run` and all it inlines see `S`'s features.
pub trait Job {
    /// What `run` returns.
    type Output;
    /// The work. Mark it, and what it calls per particle, `#[inline(always)]`.
    fn run<S: Simd>(self) -> Self::Output;
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,fma,bmi1,bmi2,lzcnt")]
fn with_avx512<J: Job>(job: J) -> J::Output {
    job.run::<super::avx512::Avx512>()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt")]
fn with_avx2<J: Job>(job: J) -> J::Output {
    job.run::<super::avx2::Avx2>()
}

#[cold]
#[inline(never)]
fn counted<J: Job>(job: J) -> J::Output {
    job.run::<Counting>()
}
