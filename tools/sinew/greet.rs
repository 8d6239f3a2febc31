//! What processes that were launched together tell one another first: they must be the same program, started with the same words.
use super::fail::Failure;
use super::ranks::lost;
use super::say::tell;
use engine::exec::ranks::words::{put, take};
use engine::exec::ranks::{Network, collective, launch};
use serde::{Deserialize, Serialize};
use simd::Isa;
use sinew::output::checkpoint::VERSION;
use twox_hash::XxHash3_128;

/// What a rank says of itself.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Greeting {
    version: String,
    /// Name of its machine.
    host: String,
    /// Digest of the program.
    build: String,
    /// What it was started with.
    words: String,
    /// Instruction sets of its machine, the best first.
    sets: Vec<String>,
    /// The one that its environment asks for.
    asked: Option<String>,
}

/// The instruction set that all ranks take: the best that all have, or the one that the environment asks for.
///
/// # Errors
/// Ranks that are different programs, were started with other words, or are asked for different sets: each is told once.
pub fn greet(network: &mut dyn Network) -> Result<Isa, Failure> {
    let mine = Isa::from_environment().map_err(Failure::usage);
    if network.size() == 1 {
        return mine;
    }
    let mine = super::ranks::agree(network, mine)?;
    let text = serde_json::to_string(&Greeting::mine(mine)).unwrap_or_default();
    let mut words = Vec::new();
    put(&mut words, text.as_bytes());
    let all = collective::share(network, &words).map_err(lost)?;
    let read = |words: &Vec<u64>| serde_json::from_slice(&take::<u8>(&mut &words[..])).unwrap_or_default();
    let all: Vec<Greeting> = all.iter().map(read).collect();
    all.iter().enumerate().skip(1).try_for_each(|(rank, other)| differs(&all[0], rank, other))?;
    let name = common_set(&all)?;
    if network.rank() == 0 && all.iter().any(|rank| rank.sets[0] != name && rank.asked.is_none()) {
        tell!("note: the machines have different instruction sets: all ranks take {name}");
    }
    let set = Isa::available().into_iter().find(|isa| isa.name() == name);
    set.ok_or_else(|| Failure::usage(format!("this machine has no {name}, which the other ranks take")))
}

impl Greeting {
    fn mine(isa: Isa) -> Self {
        let words: Vec<_> =
            std::env::args_os().skip(1).map(|word| word.to_string_lossy().into_owned()).collect();
        let program = std::fs::read("/proc/self/exe").or_else(|_| std::fs::read(std::env::current_exe()?));
        Self {
            version: VERSION.into(),
            host: launch::host(),
            build: format!("{:032x}", XxHash3_128::oneshot(&program.unwrap_or_default())),
            words: words.join(" "),
            sets: Isa::available().into_iter().map(|isa| isa.name().into()).collect(),
            asked: std::env::var("SINEW_ISA").ok().filter(|name| !name.is_empty()).map(|_| isa.name().into()),
        }
    }
}

/// Whether a rank is something else than rank 0.
fn differs(first: &Greeting, rank: usize, other: &Greeting) -> Result<(), Failure> {
    let rank = match other.host == first.host {
        true => format!("rank {rank}"),
        false => format!("rank {rank} (host {})", other.host),
    };
    let problem = if other.version != first.version {
        format!("{rank} is Sinew {}, rank 0 is Sinew {}", other.version, first.version)
    } else if other.build != first.build {
        format!(
            "{rank} is another build of Sinew {} than rank 0: results would have mixed bits",
            first.version
        )
    } else if other.words != first.words {
        format!("{rank} was started as `sinew {}`, rank 0 as `sinew {}`", other.words, first.words)
    } else {
        return Ok(());
    };
    Err(Failure::usage(format!("{problem}. Start all ranks with one program and one command line")))
}

/// The set that all take.
fn common_set(all: &[Greeting]) -> Result<String, Failure> {
    let asked = all.iter().enumerate().filter_map(|(rank, it)| Some((rank, it.asked.as_ref()?)));
    let asked: Vec<_> = asked.collect();
    let has_all = |name: &String| all.iter().all(|rank| rank.sets.contains(name));
    match asked[..] {
        [] => {
            let best = all[0].sets.iter().find(|name| has_all(name));
            best.cloned().ok_or_else(|| Failure::usage("the ranks have no instruction set in common"))
        }
        [(_, name), ..] if asked.len() == all.len() && asked.iter().all(|(_, other)| *other == name) => {
            Ok(name.clone())
        }
        [(rank, name), ..] => {
            let other = all.iter().position(|it| it.asked.as_ref() != Some(name)).unwrap_or(0);
            let says =
                all[other].asked.as_ref().map_or("nothing".to_owned(), |name| format!("SINEW_ISA={name}"));
            Err(Failure::usage(format!(
                "the environment of rank {rank} says SINEW_ISA={name}, that of rank {other} {says}: results would have mixed bits. \
                 Set it for all ranks (Open MPI: mpirun -x SINEW_ISA; MPICH: -genv), or for none"
            )))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rank(sets: &[&str], asked: Option<&str>) -> Greeting {
        let sets = sets.iter().map(|&set| set.into()).collect();
        Greeting { sets, asked: asked.map(Into::into), ..Greeting::default() }
    }

    #[test]
    fn all_ranks_take_the_best_set_that_all_have_or_the_one_that_all_are_asked_for() {
        let [new, old] = [&["avx512", "avx2", "baseline"][..], &["avx2", "baseline"]];
        let taken = |all: &[Greeting]| common_set(all).map_err(|failure| failure.message());
        assert_eq!(taken(&[rank(new, None), rank(new, None)]).as_deref(), Ok("avx512"));
        assert_eq!(taken(&[rank(new, None), rank(old, None)]).as_deref(), Ok("avx2"));
        assert_eq!(taken(&[rank(old, None), rank(new, None)]).as_deref(), Ok("avx2"));
        let asked = rank(new, Some("baseline"));
        assert_eq!(taken(&[asked.clone(), asked.clone()]).as_deref(), Ok("baseline"));
        for others in [rank(new, None), rank(new, Some("avx2"))] {
            let said = taken(&[asked.clone(), others]).expect_err("mixed bits");
            assert!(said.contains("rank 0 says SINEW_ISA=baseline") && said.contains("rank 1"), "{said}");
        }
    }

    #[test]
    fn a_rank_that_is_something_else_is_named() {
        let first =
            Greeting { version: "1".into(), build: "a".into(), words: "run a".into(), ..Greeting::default() };
        assert!(differs(&first, 3, &first).is_ok());
        for (other, fact) in [
            (Greeting { version: "2".into(), ..first.clone() }, "rank 3 is Sinew 2, rank 0 is Sinew 1"),
            (Greeting { build: "b".into(), ..first.clone() }, "another build"),
            (
                Greeting { build: "b".into(), host: "far".into(), ..first.clone() },
                "rank 3 (host far) is another build",
            ),
            (Greeting { words: "run b".into(), ..first.clone() }, "`sinew run b`, rank 0 as `sinew run a`"),
        ] {
            let said = differs(&first, 3, &other).expect_err("it differs").message();
            let said = said.split_whitespace().filter(|word| *word != "│").collect::<Vec<_>>().join(" ");
            assert!(said.contains(fact), "{said}");
        }
    }
}
