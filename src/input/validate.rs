//! What a scene must fulfil as a whole: its matter lies in the domain, apart, and in memory.
use super::document::Node;
use super::error::{Fault, Outcome, Point, all, both};
use super::rigid;
use grid::Level;
use scene::geometry::overlap;
use scene::sampling::{cells, exposed_area, inside, points, sample};
use scene::shown::ProbeOf;
use scene::{Body, Domain, ForceKind, Region, Scene};
use std::collections::HashSet;
use std::ops::Range;

/// Bytes that a particle takes in a run, with its share of the nodes: an estimate for the check of memory.
pub const BYTES_PER_PARTICLE: usize = 700;

/// Bytes that a block of 4x4x4 cells takes in lists of blocks, whether there are particles or not, and in those of each
/// material: an estimate for the check of memory.
const BYTES_PER_BLOCK: [f64; 2] = [16.0, 12.0];

/// Checks what holds for the scene as a whole. `root` is the document, for places; `available`: bytes of memory, if known.
pub(super) fn scene(scene: &Scene, root: &Node, available: Option<usize>) -> Outcome<()> {
    let fits = blocks(scene, root, available.map_or(f64::INFINITY, |bytes| bytes as f64));
    // who lies where is asked of bodies that are right
    both(fits, bodies(scene, root, available))?;
    regions(scene, root)
}

/// The domain is not so much larger than what is in it that lists of its blocks fill the memory.
fn blocks(scene: &Scene, root: &Node, available: f64) -> Outcome<()> {
    let [all, each] = BYTES_PER_BLOCK;
    let Domain { lower, cells, cell } = scene.domain;
    let blocks = Level { lower, cell, cells }.blocks().len() as f64;
    let bytes = blocks * (all + each * scene.materials.len() as f64);
    if bytes <= available {
        return Ok(());
    }
    let message = format!(
        "the domain does not fit into memory: lists of its {blocks:.1e} blocks of 4x4x4 cells take {:.1} GB, there are {:.1} GB",
        bytes / 1e9,
        available / 1e9
    );
    let help = "use larger cells, or a domain that reaches not so far beyond the bodies";
    Err(Fault::new(root.get("domain").get("cell").place, message).help(help))
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
        if !bodies.any(|(index, body)| sample(scene, body).any(|x| region.contains(index, x))) {
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
        let mut all = bodies.flat_map(|(index, body)| sample(scene, body).map(move |x| (index, x)));
        let bears = |index, x| {
            force.region.contains(index, x) && exposed_area(scene, index, x, force.sides) != [0.0; 3]
        };
        if all.any(|(index, x)| bears(index, x)) {
            return Ok(());
        }
        let message = "no particle in this region lies on the surface of its material, or not on this side";
        let place = node.find("side").or_else(|| node.find("region")).unwrap_or(node).place;
        Err(Fault::new(place, message).help("move or enlarge the region, or name another `side`"))
    })
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
    let is_out = |x: &[f64; 3]| {
        (0..3).any(|a| (x[a] < lower[a] && !goes_on[2 * a]) || (x[a] > upper[a] && !goes_on[2 * a + 1]))
    };
    points(domain, body.particles_per_cell, &body.solid, bounds)
        .find(is_out)
        .map_or(Ok(()), |x| Err(outside(x)))
}

/// The lattice around the body can be walked: it is not far larger than memory.
fn fits(domain: &Domain, body: &Body, node: &Node, most: usize) -> Outcome<()> {
    let lattice = size(&cells(domain, body.solid.bounds())) * particles_of_a_cell(body);
    if lattice > 16.0 * most as f64 { Err(too_many(body, node, lattice, most)) } else { Ok(()) }
}

/// The number of the body's particles, which is not zero and, with the `earlier` ones, at most `most`.
fn counted(scene: &Scene, body: &Body, node: &Node, earlier: usize, most: usize) -> Outcome<usize> {
    let count = sample(scene, body).take(most.saturating_add(1)).count();
    if earlier + count > most {
        let lattice = size(&cells(&scene.domain, body.solid.bounds())) * particles_of_a_cell(body);
        return Err(too_many(body, node, lattice, most));
    }
    if count == 0 {
        let h = scene.domain.cell;
        return Err(Fault::new(node.get("shape").place, format!("body {:?} has no particles", body.name))
            .help(format!(
                "no point of its lattice lies inside: enlarge it, or use cells smaller than {h} m"
            )));
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
    let meeting = |body: &Body, other: &Body| {
        points(domain, body.particles_per_cell, &body.solid, shared).find(|x| other.solid.contains(*x))
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
