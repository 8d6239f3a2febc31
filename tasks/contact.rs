use crate::bonds::{common_velocity, each_group};
use crate::labels::{ContactImpulse, ContactSums, NodeMotion, NodeSums, Reactions};
use crate::node::{Driven, Impulse, Motion, Sums, Surface};
use crate::reactions::{NUMBERS, Reaction};
use engine::data::exact_sum::ExactSum;
use engine::data::fields::FieldId;
use engine::graph::task::{At, Body};
use grid::{Lattice, NODES};
use physics::contact::surface::SurfaceTable;
use physics::contact::{AnyContactLaw, ContactLaw, Exchange, HeldPair, Pair, Seen, dot};
use simd::Simd;

engine::task! {
    /// Contact of pairs of materials at the nodes that they share. Listed twice in the recipe: for the interpolated and
    /// for the integrated velocities.
    pub struct Contact {
        /// The pairs of fields, bonds first, and else in the order of the scene: impulses are exchanged pair by pair.
        pub pairs: Vec<FieldPair>,
        /// Where nodes are.
        pub lattice: Lattice,
        /// Mass below which a node carries nothing [kg].
        pub least_mass: f64,
        /// Where surfaces lie, for each material.
        pub surfaces: Vec<SurfaceTable>,
        /// Whether it meets the interpolated velocities, before forces act.
        pub interpolated: bool,
    }

    Nodes task {
        requires new { sums: NodeSums, surfaces: ContactSums }
        computes { reactions: Reactions }
        modifies { motion: NodeMotion, impulse: ContactImpulse }
    }
}

/// Area of a bond about a node, in faces of cells, below which the node does not decide whether the bond breaks. Nodes about a cell away
/// from the surface have next to none of it, and force over area is noise there; their bonds end with those of their particles.
const DECISIVE: f64 = 0.1;

/// Two velocity fields that touch.
#[derive(Clone, Copy, Debug)]
pub struct FieldPair {
    /// The fields; those of the two materials, in their order.
    pub between: [FieldId; 2],
    /// The law.
    pub law: AnyContactLaw,
    /// Contact acts only while the gap between the surfaces is below this many cells.
    pub gap: f64,
    /// Its tile of `Reactions`.
    pub tile: usize,
}

impl Body for Contact {
    #[inline(always)]
    fn run<S: Simd>(&self, at: &At<'_>, mut io: Io<'_>) {
        let Io { sums, surfaces, motion, impulse, reactions } = &mut io;
        let mut meeting = Meeting { sums, surfaces, driven: &[], motion, impulse, reactions };
        self.exchange_all(at, &mut meeting);
    }
}

/// What meets at the nodes of a block.
pub struct Meeting<'a> {
    /// `NodeSums`
    pub sums: &'a [Sums],
    /// `ContactSums`
    pub surfaces: &'a [Surface],
    /// `DriveSums`; nothing, where there are no drives.
    pub driven: &'a [Driven],
    /// `NodeMotion`
    pub motion: &'a mut [Motion],
    /// `ContactImpulse`
    pub impulse: &'a mut [Impulse],
    /// `Reactions`
    pub reactions: &'a mut [[ExactSum; NUMBERS]],
}

/// One material at one node.
struct Side<'a> {
    material: usize,
    sums: &'a Sums,
    surface: &'a Surface,
    velocity: [f64; 3],
    /// Along which axes drives hold it, whatever it receives.
    held: [bool; 3],
    /// How long ago its particles gave what the node knows of its surface [s].
    elapsed: f64,
}

impl Side<'_> {
    /// Goes with the drives that hold it; what it receives, they take at the end of its step (see `DriveNodes`).
    fn driven(mut self, driven: Option<&Driven>) -> Self {
        for a in 0..3 {
            if let Some(velocity) = driven.and_then(|driven| driven.velocity(a, self.sums.mass())) {
                (self.velocity[a], self.held[a]) = (velocity, true);
            }
        }
        self
    }

    /// Whether drives hold it along any axis.
    fn is_held(&self) -> bool {
        self.held.contains(&true)
    }

    /// Σ V ∇S: points out of the material.
    fn outward(&self) -> [f64; 3] {
        std::array::from_fn(|a| self.surface.outward(a))
    }
}

impl Contact {
    /// Exchanges impulses at all nodes of a block, pair by pair.
    #[inline(never)]
    pub fn exchange_all(&self, at: &At<'_>, io: &mut Meeting<'_>) {
        if at.fields.len() < 2 {
            return;
        }
        let bonds = self.pairs.iter().any(|pair| pair.law.bond().is_some());
        if bonds {
            io.impulse.iter_mut().for_each(|impulse| impulse.set_group(0));
        }
        // what is one begins as one, and then meets others
        let rubs = self.pairs.iter().position(|pair| pair.law.bond().is_none()).unwrap_or(self.pairs.len());
        let (bonded, others) = self.pairs.split_at(rubs);
        bonded.iter().for_each(|pair| self.exchange_pair(pair, at, io));
        if rubs > 0 && self.interpolated && at.fields.len() > 2 {
            begin_as_one(at, io);
        }
        others.iter().for_each(|pair| self.exchange_pair(pair, at, io));
    }

    /// Exchanges impulses of a pair at all nodes of a block.
    fn exchange_pair(&self, pair: &FieldPair, at: &At<'_>, io: &mut Meeting<'_>) {
        let bonds = pair.law.bond().is_some();
        let slot = |field: FieldId| at.fields.iter().position(|f| f.field == field);
        let [Some(a), Some(b)] = pair.between.map(slot) else { return };
        let materials = [at.fields[a].material, at.fields[b].material];
        let elapsed = [at.fields[a].elapsed, at.fields[b].elapsed];
        let begin = at.fields[a].begins && at.fields[b].begins;
        let mut reaction = Reaction::default();
        for n in 0..NODES {
            let lines = [NODES * a + n, NODES * b + n];
            if lines.iter().any(|&line| io.sums[line].mass() <= self.least_mass) {
                continue;
            }
            let node = self.lattice.position(at.node_of(n));
            let both = self.interpolated && begin;
            // two that are one begin with a velocity that counts the matter of both, driven or not
            let as_one = both && pair.law.bond().is_some();
            let sides = [0, 1].map(|i| {
                let side = Side {
                    material: materials[i],
                    sums: &io.sums[lines[i]],
                    surface: &io.surfaces[lines[i]],
                    velocity: io.motion[lines[i]].velocity(),
                    held: [false; 3],
                    elapsed: elapsed[i],
                };
                side.driven(io.driven.get(lines[i]).filter(|_| !as_one))
            });
            let given = lines[0];
            let time = if both { 0.0 } else { at.fields[a].elapsed + at.fields[a].tick };
            let past = Past { impulse: &io.impulse[given], time };
            let Some((exchange, bond)) = self.exchange(pair, &sides, node, &past) else {
                continue;
            };
            if bonds && bond.holds() {
                join(io.impulse, at.fields.len(), n, [a, b]);
            }
            if bond.holds() && time == 0.0 {
                // what is one body has one velocity at a node, and nothing is exchanged for that
                let all = exchange.all();
                for (i, sign) in [(0, 1.0), (1, -1.0)] {
                    let impulse = all.map(|p| sign * p);
                    io.motion[lines[i]].begin_with(impulse.map(|p| p / sides[i].sums.mass()));
                }
                continue;
            }
            match bond {
                Bond::Breaks => lines.iter().for_each(|&line| io.impulse[line].break_bond()),
                Bond::HoldsAside => lines.iter().for_each(|&line| io.impulse[line].hold_aside()),
                Bond::None | Bond::Holds => {}
            }
            let masses = sides.each_ref().map(|side| side.sums.mass());
            let given = exchange.all();
            // how the matter moves meanwhile is known at the end of the step: see `ContactPower`
            reaction.add(node, given, [0.0; 3]);
            for (i, sign) in [(0, 1.0), (1, -1.0)] {
                let impulse = given.map(|p| sign * p);
                io.impulse[lines[i]].add(sign, exchange.normal, exchange.friction);
                io.motion[lines[i]].add(impulse.map(|p| p / masses[i]));
            }
        }
        reaction.store(&mut io.reactions[pair.tile]);
    }

    /// What the pair exchanges at a node, and whether its bond breaks; `None`: the surfaces do not touch.
    fn exchange(
        &self,
        pair: &FieldPair,
        sides: &[Side<'_>; 2],
        node: [f64; 3],
        past: &Past<'_>,
    ) -> Option<(Exchange, Bond)> {
        let [a, b] = sides;
        let direction = normal(sides);
        let bond = pair.law.bond().filter(|strength| !strength.is_finite() || holds(sides, past));
        // in the midst of two bodies that are one, there is no surface: any direction will do
        let (normal, area) =
            if bond.is_some() { direction.unwrap_or(([0.0, 0.0, 1.0], 0.0)) } else { direction? };
        // the internal force of a uniformly stressed surface is −σ Σ V ∇S
        let traction = (dot(b.sums.force(), normal) - dot(a.sums.force(), normal)) / area;
        let seen = seen(sides, normal, traction);
        let mut state = Bond::None;
        if let Some(strength) = bond {
            let exchange = seen.exchange(&pair.law);
            let (area, held) = self.bearing(sides, 0.5 * area);
            let decides = past.time > 0.0 && area > DECISIVE * self.lattice.cell.powi(2);
            let (tension, shear) = past.tractions(&exchange, normal, area);
            if !decides || !strength.is_exceeded(tension, shear) {
                return Some((exchange, held));
            }
            state = Bond::Breaks;
        }
        if self.gap(a, b, node) > pair.gap {
            return (state == Bond::Breaks).then(|| (Exchange::default(), state));
        }
        let rubs = pair.law.bond().is_some();
        Some((if rubs { seen.broken(&pair.law) } else { seen.exchange(&pair.law) }, state))
    }

    /// The area [m²] whose traction a node bears: that of the surface there. A surface at a distance of d cells from a node has S(d) = 1 − d of its
    /// area on it, and on the next one the rest. But a drive that holds one side holds what is bonded to it on both planes of nodes about the
    /// surface, and nothing is strained between them. Particles as wide as δ, of which x lies there, bear the part 1 − x/δ of the stress σ and
    /// give x (1 − x/δ) σ to the plane within the driven side; the one beyond has the rest, of the whole area, and decides for both.
    fn bearing(&self, sides: &[Side<'_>; 2], area: f64) -> (f64, Bond) {
        let (free, held) = match sides.each_ref().map(Side::is_held) {
            [false, true] => (&sides[0], &sides[1]),
            [true, false] => (&sides[1], &sides[0]),
            _ => return (area, Bond::Holds),
        };
        // what lies behind a plane at d fills ½ (1 − d)² of the node
        let volume = held.sums.volume() + free.sums.volume();
        let part = held.sums.volume() / volume;
        if part >= 0.5 {
            return (area, if part > 0.5 + 1e-6 { Bond::HoldsAside } else { Bond::Holds });
        }
        let width = self.surfaces[free.material].spacing();
        let x = (1.0 - (2.0 * part).sqrt()) % width;
        ((1.0 - x * (1.0 - x / width)) * volume / self.lattice.cell, Bond::Holds)
    }

    /// Gap between the surfaces near the node [cells], along the mean of the two unit normals: where edges of two bodies
    /// lie in one plane, a normal weighted by what is there leans out of it, and takes sides for surfaces that touch.
    fn gap(&self, a: &Side<'_>, b: &Side<'_>, node: [f64; 3]) -> f64 {
        // in the midst of a body Σ V ∇S is rounding, and has no direction
        let least = |side: &Side<'_>| 1e-9 * side.sums.volume() / self.lattice.cell;
        let (from, to) = (unit(a.outward(), least(a)), unit(b.outward(), least(b)));
        let mean = unit(std::array::from_fn(|i| from[i] - to[i]), 0.0);
        self.before_surface(a, node, mean) + self.before_surface(b, node, mean.map(|n| -n))
    }

    /// Distance from a side's surface to the node along its outward direction `n` [cells].
    fn before_surface(&self, side: &Side<'_>, node: [f64; 3], n: [f64; 3]) -> f64 {
        // the center of mass goes on with the node while the particles wait
        let moved = |a: usize| side.surface.moment(a) / side.sums.mass() + side.elapsed * side.velocity[a];
        let center: [f64; 3] = std::array::from_fn(|a| node[a] - moved(a));
        self.surfaces[side.material].surface(dot(n, center) / self.lattice.cell)
    }
}

/// More than two that are one begin with one velocity, which pair by pair they do not find.
fn begin_as_one(at: &At<'_>, io: &mut Meeting<'_>) {
    each_group(at.fields.len(), io.impulse, |n, members, _| {
        if members.len() < 3 || !members.iter().all(|&slot| at.fields[slot].begins) {
            return;
        }
        let velocity = common_velocity(members.iter().map(|slot| &io.motion[NODES * slot + n]));
        for &slot in members {
            let motion = &mut io.motion[NODES * slot + n];
            let v = motion.velocity();
            motion.begin_with([0, 1, 2].map(|a| velocity[a] - v[a]));
        }
    });
}

/// Two fields at node n of a block, by their places, are one from here on, with all with which they are one.
fn join(impulse: &mut [Impulse], fields: usize, n: usize, pair: [usize; 2]) {
    let [a, b] = pair.map(|slot| match impulse[NODES * slot + n].group() {
        0 => 1 + slot,
        group => group,
    });
    for slot in 0..fields {
        let one = &mut impulse[NODES * slot + n];
        if pair.contains(&slot) || one.group() == a || one.group() == b {
            one.set_group(a.min(b));
        }
    }
}

/// Unit normal from a to b, and |Σ V ∇S of a − Σ V ∇S of b|: an area.
fn normal([a, b]: &[Side<'_>; 2]) -> Option<([f64; 3], f64)> {
    let difference: [f64; 3] = std::array::from_fn(|i| a.outward()[i] - b.outward()[i]);
    let area = dot(difference, difference).sqrt();
    if area > 0.0 && (a.is_held() || b.is_held()) {
        // What is held pushes without end of mass, though little of it is at the node; to the matter that fills the node, the
        // surface has no direction but that of rounding and of uneven spacing.
        let less = if a.sums.volume() < b.sums.volume() { a.outward() } else { b.outward().map(|n| -n) };
        return Some((unit(less, 0.0), area));
    }
    (area > 0.0).then(|| (difference.map(|d| d / area), area))
}

/// Σ 1/m along the normal, of that of the sides, below which both are held along it: what is left of it there is a corner.
const HELD: f64 = 0.01;

/// What a contact law sees of two sides.
fn seen(sides: &[Side<'_>; 2], normal: [f64; 3], traction: f64) -> Seen {
    let [a, b] = sides;
    let relative: [f64; 3] = std::array::from_fn(|i| a.velocity[i] - b.velocity[i]);
    let masses = [a.sums.mass(), b.sums.mass()];
    if !sides.iter().any(Side::is_held) {
        let reduced_mass = masses[0] * masses[1] / (masses[0] + masses[1]);
        return Seen::Free(Pair { relative, reduced_mass, normal, traction });
    }
    let free = |side: &Side<'_>, axis: usize| if side.held[axis] { 0.0 } else { 1.0 / side.sums.mass() };
    let mobility = [0, 1, 2].map(|axis| sides.iter().map(|side| free(side, axis)).sum());
    let least = HELD * (1.0 / masses[0] + 1.0 / masses[1]);
    Seen::Held(HeldPair { relative, mobility, least, normal, traction })
}

/// Whether the bond of two sides still holds: most of what both have at the node is bonded.
fn holds(sides: &[Side<'_>; 2], past: &Past<'_>) -> bool {
    !past.impulse.is_broken() && sides.iter().all(|side| side.surface.bonded() > 0.5)
}

/// What became of the bond of a pair at a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Bond {
    /// There is none, or it was broken before.
    None,
    /// It makes one body of two.
    Holds,
    /// It does, and others bear its stress: see [`Contact::bearing`].
    HoldsAside,
    /// It breaks now.
    Breaks,
}

impl Bond {
    fn holds(self) -> bool {
        matches!(self, Bond::Holds | Bond::HoldsAside)
    }
}

/// What contact has given to the first material of a pair at a node so far in its step, and how long that took [s]; no time where
/// both steps begin, and forces have not acted yet.
struct Past<'a> {
    impulse: &'a Impulse,
    time: f64,
}

impl Past<'_> {
    /// Tension and shear on an area [m²] that makes for these impulses and one more [Pa].
    fn tractions(&self, more: &Exchange, normal: [f64; 3], area: f64) -> (f64, f64) {
        let (n, t) = (self.impulse.normal(), self.impulse.friction());
        let all: [f64; 3] = std::array::from_fn(|a| n[a] + t[a] + more.normal[a] + more.friction[a]);
        let pull = dot(all, normal);
        let across: [f64; 3] = std::array::from_fn(|a| all[a] - pull * normal[a]);
        let per = 1.0 / (self.time * area);
        (pull * per, dot(across, across).sqrt() * per)
    }
}

/// g/|g|, or zero where |g| is not above `least`.
fn unit(g: [f64; 3], least: f64) -> [f64; 3] {
    let length = dot(g, g).sqrt();
    if length > least { g.map(|x| x / length) } else { [0.0; 3] }
}
