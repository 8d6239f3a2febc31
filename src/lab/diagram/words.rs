//! What the graph holds, in the words of the field.
use super::Kind;
use engine::graph::recipe::Why;
use engine::graph::task::{Access, Domain, Mode};
use engine::schema::{Combine, Home, LabelId, Life};

/// What a task runs over.
pub(super) fn over(domain: Domain) -> &'static str {
    match domain {
        Domain::Particles => "particles",
        Domain::NearParticles => "particles of blocks where another body is near",
        Domain::Buffers => "blocks of particles, with the grid nodes around them",
        Domain::Nodes => "grid nodes",
        Domain::Once => "the whole run, once",
    }
}

/// How a task uses a label.
pub(super) fn mode(access: &Access) -> &'static str {
    match access.mode {
        Mode::RequiresOld => "reads, as it was when the step began",
        Mode::RequiresNew => "reads, as this step has computed it",
        Mode::Requires => "reads, as it is at this place",
        Mode::Adapts => "reads, and adapts its own copy",
        Mode::Computes if access.label.combine().is_sum() => "adds to it",
        Mode::Computes if access.reduces() => "contributes to it",
        Mode::Computes => "computes",
        Mode::Modifies => "changes",
        Mode::Scratch => "works in it",
    }
}

/// Layers of ghosts; empty for none.
pub(super) fn ghosts(layers: u8) -> String {
    match layers {
        0 => String::new(),
        1 => "1 ghost layer of grid nodes".to_owned(),
        n => format!("{n} ghost layers of grid nodes"),
    }
}

/// Where a label lives, for how long it is kept, and how contributions to it come together.
pub(super) fn label(label: LabelId) -> String {
    let home = match label.home() {
        Home::Particle | Home::Chunk => "one a particle",
        Home::Node => "one a grid node",
        Home::Block => "one a block of particles",
        Home::Material => "one a material",
        Home::Run => "one for the run",
    };
    let life = match label.life() {
        Life::Chunk => ", for a moment",
        Life::Stage | Life::Tick => "",
        Life::Step => ", kept until the step ends",
        Life::Carried => ", kept from step to step",
    };
    let combine = match (label.combine(), label.home()) {
        (Combine::None, _) => "",
        (Combine::Sum | Combine::Exact, Home::Node) => "; a sum over the particles around",
        (Combine::Max, Home::Node | Home::Block) => "; the largest of the particles there",
        (Combine::Sum | Combine::Exact, _) => "; an exact sum, by a reduction",
        (Combine::Max, _) => "; the largest counts, by a reduction",
        (Combine::First, _) => "; the first counts, by a reduction",
    };
    format!("{home}{life}{combine}")
}

/// Why one thing waits for another.
pub(super) fn why(why: Why) -> &'static str {
    match why {
        Why::Flow => "takes its data",
        Why::WriteAfterRead => "waits: overwrites what it reads",
        Why::WriteAfterWrite => "waits: overwrites what it writes",
    }
}

/// When a task runs, where materials take steps of their own: as [`super::export::Shown::to_json`] says it, and in words.
pub(super) const WHEN: [(&str, &str); 3] = [
    ("tick", "in every tick"),
    ("begin", "when the step of its material begins"),
    ("end", "when the step of its material ends"),
];

/// What an item is.
pub(super) fn kind(kind: Kind) -> &'static str {
    match kind {
        Kind::Task(_) => "Task",
        Kind::Halo(_) => "Halo exchange",
        Kind::Reduction(_) => "Reduction",
        Kind::Relocation => "Relocation",
    }
}

/// What is done by an item that is no task.
pub(super) fn about(kind: Kind) -> &'static str {
    match kind {
        Kind::Task(_) => "",
        Kind::Halo(_) => {
            "Ranks send each other what their blocks have on grid nodes that others need: sums that particles beyond the border added \
to, or values that particles there read."
        }
        Kind::Reduction(_) => {
            "All blocks, threads and ranks bring together what each contributes, and everybody has the result."
        }
        Kind::Relocation => {
            "Particles that have moved go to the block where they are now, and with it to its patch and rank."
        }
    }
}
