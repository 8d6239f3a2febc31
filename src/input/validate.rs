//! What a scene must fulfil as a whole: its matter lies in the domain, apart, and in memory.
use super::document::Node;
use super::error::{Fault, Outcome, Point, all, both};
use super::rigid;
use scene::geometry::{Bounds, Solid, overlap};
use scene::sampling::{self as lattice, Filling, cells, exposed_area, inside};
use scene::shown::ProbeOf;
use scene::{Body, Domain, Force, ForceKind, Region, Scene};
use std::collections::HashSet;
use std::ops::{ControlFlow, Range};

/// Bytes that a particle takes in a run, with its share of the nodes: an estimate for the check of memory.
pub const BYTES_PER_PARTICLE: usize = 700;

/// Checks what holds for the scene as a whole. `root` is the document, for places; `available`: bytes of memory, if known.
pub(super) fn scene(scene: &Scene, root: &Node, available: Option<usize>) -> Outcome<()> {
    bodies(scene, root, available)?;
    regions(scene, root)
}

/// Checks bodies one by one and against each other.
fn bodies(scene: &Scene, root: &Node, available: Option<usize>) -> Outcome<()> {
    let given = root.get("body");
    if scene.bodies.is_empty() {
        return Err(Fault::new(given.place, "the scene has no bodies").help("add a [[body]]"));
    }
    let most = available.map_or(usize::MAX, |bytes| bytes / BYTES_PER_PARTICLE);
    let mut particles = 0;
    let mut names = HashSet::new();
    let one = |(i, (body, node)): (usize, (&Body, &Node))| {
        if !names.insert(body.name.clone()) {
            let message = format!("there are two bodies named {:?}", body.name);
            return Err(Fault::new(node.get("name").place, message).help("give each body a name of its own"));
        }
        rigid::body(scene, i, node, root)?;
        if scene.materials[body.material].has_particles() {
            in_domain(scene, body, node, most)?;
            particles += counted(scene, body, node, particles, most)?;
        }
        Ok(())
    };
    let each = all(scene.bodies.iter().zip(given.items()).enumerate().map(one));
    let rigid = both(rigid::have_bodies(scene, root), rigid::tools_act(scene, root));
    let rigid = both(rigid, rigid::meets_what_is_held(scene, root));
    both(each, rigid)?;
    let meets = |(i, body): (usize, &Body)| {
        // tools may be in one another; and their lattices may be as large as the domain
        let filled = |body: &Body| scene.materials[body.material].has_particles();
        let mut others = scene.bodies[..i].iter().filter(|other| filled(body) || filled(other));
        others.try_for_each(|other| apart(&scene.domain, other, body, &given.items()[i]))
    };
    all(scene.bodies.iter().enumerate().map(meets)).map(drop)
}

/// Drives, forces and probes have particles, and some matter is there at all.
fn regions(scene: &Scene, root: &Node) -> Outcome<()> {
    if !scene.bodies.iter().any(|body| scene.materials[body.material].has_particles()) {
        return Err(Fault::new(root.get("body").place, "the scene has tools and no matter")
            .help("add a body of a material that deforms, or of a free rigid one"));
    }
    let drives = scene.drives.iter().map(|it| (it.material, &it.region)).zip(root.get("drive").items());
    let forces = scene.forces.iter().map(|it| (it.material, &it.region)).zip(root.get("force").items());
    let anywhere = Region::All;
    let probes = scene.probes.iter().map(|it| match &it.of {
        ProbeOf::Mean(region) | ProbeOf::Largest(region) | ProbeOf::Smallest(region) => (it.material, region),
        ProbeOf::Nearest(_) => (it.material, &anywhere),
    });
    let probes = probes.zip(root.get("probe").items());
    for ((material, region), node) in drives.chain(forces).chain(probes) {
        let mut bodies = scene.bodies.iter().enumerate().filter(|(_, body)| body.material == material);
        let holds = |(index, body): (usize, &Body)| match region {
            Region::All => true,
            Region::Body(of) => *of == index,
            Region::Solid(solid) => Filling::within(scene, body, solid).any().is_some(),
        };
        if !bodies.any(holds) {
            let place = node.find("region").or_else(|| node.find("body")).unwrap_or(node).place;
            let message = format!("no particle of {:?} lies in this region", scene.materials[material].name);
            return Err(
                Fault::new(place, message).help("move or enlarge the region, or name another material")
            );
        }
    }
    let pressed = scene.forces.iter().zip(root.get("force").items());
    pressed.filter(|(force, _)| !matches!(force.kind, ForceKind::Total(_))).try_for_each(|(force, node)| {
        let bodies = scene.bodies.iter().enumerate().filter(|(_, body)| body.material == force.material);
        if bodies.into_iter().any(|(index, body)| is_pressed(scene, force, index, body)) {
            return Ok(());
        }
        let message = "no particle in this region lies on the surface of its material, or not on this side";
        let place = node.find("side").or_else(|| node.find("region")).unwrap_or(node).place;
        Err(Fault::new(place, message).help("move or enlarge the region, or name another `side`"))
    })
}

/// Whether a force acts on a part of the surface of a body's particles.
fn is_pressed(scene: &Scene, force: &Force, index: usize, body: &Body) -> bool {
    let filling = match &force.region {
        Region::Body(of) if *of != index => return false,
        Region::Solid(solid) => Filling::within(scene, body, solid),
        _ => Filling::of(scene, body),
    };
    let size = body.particles_per_cell.map(|n| scene.domain.cell / n as f64);
    // where the body goes on beyond all neighbors, nothing is exposed
    let covered = |(lower, upper): Bounds| {
        let wider = (
            std::array::from_fn(|a| lower[a] - 1.001 * size[a]),
            std::array::from_fn(|a| upper[a] + 1.001 * size[a]),
        );
        body.solid.holds(wider) == Some(true)
    };
    let bears = |_, x| match exposed_area(scene, index, x, force.sides) {
        [0.0, 0.0, 0.0] => ControlFlow::Continue(()),
        _ => ControlFlow::Break(()),
    };
    filling.search(filling.span(), &covered, &mut { bears }).is_break()
}

/// All particles of the body are in the domain.
fn in_domain(scene: &Scene, body: &Body, node: &Node, most: usize) -> Outcome<()> {
    let domain = &scene.domain;
    let name = &body.name;
    let fault = |message: String| Fault::new(node.get("shape").place, message);
    if !body.solid.is_bounded() {
        let help = "intersect it with a box or another bounded shape";
        return Err(fault(format!("body {name:?} is unbounded")).help(help));
    }
    let (lower, upper) = inside(domain);
    let outside = |x: [f64; 3]| {
        fault(format!("body {name:?} is outside of the domain at {}", Point(x))).help(format!(
            "the domain reaches from {} to {}: move or shrink the body, or enlarge the domain",
            Point(lower),
            Point(upper)
        ))
    };
    let bounds = body.solid.bounds();
    let touched = cells(domain, bounds);
    if (0..3).all(|a| touched[a].start >= 0 && touched[a].end <= domain.cells[a] as i64) {
        return fits(domain, body, node, most);
    }
    // Bounds of turned solids are wide, so that only a particle outside proves the fault; but far too wide is too far.
    if size(&touched) > 8.0 * domain.cells.iter().map(|&n| n as f64 + 2.0).product::<f64>() {
        return Err(outside(bounds.0));
    }
    fits(domain, body, node, most)?;
    let goes_on = rigid::goes_on(scene, body);
    let reach: Bounds = (
        std::array::from_fn(|a| if goes_on[2 * a] { f64::NEG_INFINITY } else { lower[a] }),
        std::array::from_fn(|a| if goes_on[2 * a + 1] { f64::INFINITY } else { upper[a] }),
    );
    let within = |(from, to): Bounds| (0..3).all(|a| reach.0[a] <= from[a] && to[a] <= reach.1[a]);
    let filling = Filling::new(domain, body.particles_per_cell, body.solid.clone(), bounds);
    let is_out = |_, x| if within((x, x)) { ControlFlow::Continue(()) } else { ControlFlow::Break(x) };
    match filling.search(filling.span(), &within, &mut { is_out }) {
        ControlFlow::Break(x) => Err(outside(x)),
        ControlFlow::Continue(()) => Ok(()),
    }
}

/// The lattice around the body can be walked: it is not far larger than memory.
fn fits(domain: &Domain, body: &Body, node: &Node, most: usize) -> Outcome<()> {
    let lattice = size(&cells(domain, body.solid.bounds())) * particles_of_a_cell(body);
    if lattice > 16.0 * most as f64 { Err(too_many(body, node, lattice, most)) } else { Ok(()) }
}

/// The number of the body's particles, which is not zero and, with the `earlier` ones, at most `most`. Counted are they if that is
/// in doubt: otherwise the number is that of the lattice around the body.
fn counted(scene: &Scene, body: &Body, node: &Node, earlier: u64, most: usize) -> Outcome<u64> {
    let filling = Filling::of(scene, body);
    if filling.any().is_none() {
        let h = scene.domain.cell;
        return Err(Fault::new(node.get("shape").place, format!("body {:?} has no particles", body.name))
            .help(format!(
                "no point of its lattice lies inside: enlarge it, or use cells smaller than {h} m"
            )));
    }
    let lattice = lattice::size(filling.span());
    let count = if earlier + lattice > most as u64 { filling.count(filling.span()) } else { lattice };
    if earlier + count > most as u64 {
        return Err(too_many(body, node, lattice as f64, most));
    }
    Ok(count)
}

fn too_many(body: &Body, node: &Node, lattice: f64, most: usize) -> Fault {
    let gigabytes = |particles: f64| particles * BYTES_PER_PARTICLE as f64 / 1e9;
    let message = format!(
        "the particles do not fit into memory: with body {:?} there are more than {most}, all that {:.1} GB hold",
        body.name,
        gigabytes(most as f64)
    );
    let help = format!(
        "the box around the body has {lattice:.1e} particles ({:.1} GB): use larger cells or fewer particles a cell",
        gigabytes(lattice)
    );
    Fault::new(node.get("shape").place, message).help(help)
}

fn size(cells: &[Range<i64>; 3]) -> f64 {
    cells.iter().map(|range| range.end.saturating_sub(range.start).max(0) as f64).product()
}

fn particles_of_a_cell(body: &Body) -> f64 {
    body.particles_per_cell.iter().product::<usize>() as f64
}

/// No particle of either body lies in the other.
fn apart(domain: &Domain, a: &Body, b: &Body, node: &Node) -> Outcome<()> {
    let shared = overlap(overlap(a.solid.bounds(), b.solid.bounds()), inside(domain));
    // of many bodies, most are far from one another
    if size(&cells(domain, shared)) == 0.0 {
        return Ok(());
    }
    let meeting = |body: &Body, other: &Body| {
        let both = Solid::Intersection(vec![body.solid.clone(), other.solid.clone()]);
        Filling::new(domain, body.particles_per_cell, both, shared).any()
    };
    match meeting(a, b).or_else(|| meeting(b, a)) {
        Some(x) => {
            let message = format!("bodies {:?} and {:?} overlap at {}", a.name, b.name, Point(x));
            let help = "move one of them, or cut it with `shape = { difference = [...] }`";
            Err(Fault::new(node.get("shape").place, message).help(help))
        }
        None => Ok(()),
    }
}

/// Bytes of memory that new work can take, where the system tells.
pub fn available_memory() -> Option<usize> {
    let text = std::fs::read_to_string("/proc/meminfo").ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    line.trim().strip_suffix("kB")?.trim().parse::<usize>().ok()?.checked_mul(1024)
}
