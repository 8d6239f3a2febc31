//! From a completed document to a [`Scene`]: names become indices, tables become types.
use super::choose;
use super::document::{Node, dotted};
use super::error::{Fault, Outcome, all, both};
use super::fields::FACES;
use super::meetings::{contacts, drives, forces, motion};
use super::moved::RIGID;
use super::probes::probes;
use super::references::{self, material_index};
use super::shapes::{solid, unit_vector};
use physics::faces::AnyFaceCondition;
use physics::{faces, materials};
use scene::geometry::dot;
use scene::*;

/// The most cells along an axis; more is a wrong unit.
const MOST_CELLS: f64 = (1 << 20) as f64;

/// The scene of a completed document, without `name`, `lines` and `resolved`.
pub(super) fn scene(root: &Node) -> Outcome<Scene> {
    let named = root.get("material").entries();
    if let Some(entry) = named.get(MOST_MATERIALS) {
        let message = format!("there are {} materials; at most {MOST_MATERIALS} are possible", named.len());
        return Err(Fault::new(entry.place, message)
            .label("one too many")
            .help("let bodies share materials"));
    }
    let is_name =
        |key: &str| key.chars().all(|c| c.is_ascii_alphanumeric() || "-_".contains(c)) && !key.is_empty();
    if let Some(entry) = named.iter().find(|entry| !is_name(&entry.key)) {
        return Err(Fault::new(entry.place, format!("{:?} cannot name a material", entry.key))
            .help("use letters, digits, `-` and `_`: the name is used in files and dotted keys"));
    }
    let materials = all(named.iter().map(|e| material(&e.key, &e.node)));
    let parts = both(materials, domain(root.get("domain")));
    let (materials, domain) = parts.map_err(|fault| fault.and(without_materials(root)))?;
    let load = root.get("load");
    let bodies = all(root.get("body").items().iter().map(|node| body(node, &materials)));
    let contacts = contacts(root.get("contact"), &materials);
    let forces = forces(root.get("force"), &materials, root.get("body"));
    let drives = drives(root.get("drive"), &materials, root.get("body"));
    let probes = probes(root.get("probe"), &materials, root.get("body"), &domain);
    let faces = face_conditions(root.get("boundary"));
    let output = output(root.get("output"), &materials, domain.cell);
    let (((bodies, contacts), (forces, drives)), (faces, (output, probes))) =
        both(both(both(bodies, contacts), both(forces, drives)), both(faces, both(output, probes)))?;
    Ok(Scene {
        name: String::new(),
        title: root.get("title").word().to_owned(),
        domain,
        bodies,
        contacts,
        faces,
        forces,
        drives,
        probes,
        loads: Loads {
            gravity: choose::in_time(load.get("gravity")),
            damping: load.get("damping").number(),
            local_damping: load.get("local-damping").number(),
        },
        run: run(root.get("run")),
        output,
        lines: Default::default(),
        resolved: String::new(),
        materials,
    })
}

/// What can be told of a scene whose materials or domain are wrong.
fn without_materials(root: &Node) -> Outcome<()> {
    let shapes = all(root.get("body").items().iter().map(|body| solid(body.get("shape"))));
    let fibers = all(root.get("body").items().iter().map(|body| fibers(body.get("fibers"))));
    let parts =
        both(both(shapes, fibers), both(face_conditions(root.get("boundary")), references::check(root)));
    parts.map(drop)
}

fn domain(given: &Node) -> Outcome<Domain> {
    let (lower, upper): ([f64; 3], [f64; 3]) = (given.get("lower").vector(), given.get("upper").vector());
    let cell = given.get("cell").number();
    let mut cells = [0; 3];
    for (a, axis) in ["x", "y", "z"].into_iter().enumerate() {
        let exact = (upper[a] - lower[a]) / cell;
        let whole = exact.round();
        let place = given.get("upper").items()[a].place;
        if exact.is_nan() || exact <= 0.0 {
            let message = format!("the domain is empty: along {axis}, `upper` is not above `lower`");
            return Err(Fault::new(place, message).help("swap the corners or enlarge the domain"));
        }
        if (exact - whole).abs() > 1e-6 || whole < 1.0 {
            let (below, above) = (exact.floor(), exact.ceil());
            let at = |n: f64| format!("{:.6e} m ({n} cells)", lower[a] + n * cell);
            let help = match below {
                0.0 => format!("set `upper` along {axis} to {}", at(above)),
                _ => format!("set `upper` along {axis} to {} or {}", at(below), at(above)),
            };
            let message =
                format!("the domain must be a whole number of cells, but is {exact:.6} of them along {axis}");
            return Err(Fault::new(place, message).help(help));
        }
        if whole > MOST_CELLS {
            let message =
                format!("the domain has {whole:e} cells along {axis}; at most {MOST_CELLS} are possible");
            let help = "is a unit missing? A bare number is in meters";
            return Err(Fault::new(given.get("cell").place, message).help(help));
        }
        cells[a] = whole as usize;
    }
    Ok(Domain { lower, cells, cell })
}

fn material(name: &str, given: &Node) -> Outcome<Material> {
    let behavior = match choose::entry(materials::LAWS, given.get("law").word()) {
        Some(entry) => Behavior::Deformable(choose::build(entry, given, &dotted("material", name))?),
        None => Behavior::Rigid(rigid_motion(name, given)?),
    };
    Ok(Material { name: name.to_owned(), density: given.get("density").number(), behavior })
}

fn rigid_motion(name: &str, given: &Node) -> Outcome<RigidMotion> {
    debug_assert_eq!(given.get("law").word(), RIGID);
    let spin = given.get("angular-velocity");
    if given.get("motion").word() != "free" {
        let Motion { course, spin, .. } = motion(given)?;
        let center = given.find("center").map(Node::vector);
        for key in ["locked", "locked-turns"] {
            if given.get(key).word() != "none" {
                let message = format!("`material.{name}.{key}` has no meaning for a prescribed motion");
                return Err(Fault::new(given.get(key).place, message).help("its motion says where it goes"));
            }
        }
        if choose::in_time(given.get("force")).acts() {
            let message = format!("`material.{name}.force` has no meaning for a prescribed motion");
            return Err(
                Fault::new(given.get("force").place, message).help("set `motion = \"free\"`: then it pushes")
            );
        }
        return Ok(RigidMotion::Prescribed { course, spin, center, visible: given.get("visible").flag() });
    }
    for key in ["velocity", "displacement", "center"] {
        if let Some(value) = given.find(key) {
            let message = format!("`material.{name}.{key}` has no meaning for a free motion");
            return Err(Fault::new(value.place, message)
                .help("give the velocity at the start to the body, or set `motion = \"prescribed\"`"));
        }
    }
    match &choose::in_time(spin).0[..] {
        &[(_, angular_velocity)] => {
            let [locked, locked_turns] = ["locked", "locked-turns"]
                .map(|key| ["x", "y", "z"].map(|axis| given.get(key).word().contains(axis)));
            let force = choose::in_time(given.get("force"));
            Ok(RigidMotion::Free { angular_velocity, locked, locked_turns, force })
        }
        _ => Err(Fault::new(spin.place, format!("`material.{name}.angular-velocity` is given in time"))
            .help("a free body has one at the start: give one vector, or set `motion = \"prescribed\"`")),
    }
}

fn body(given: &Node, materials: &[Material]) -> Outcome<Body> {
    let material = material_index(given.get("material"), materials)?;
    let velocity = given.get("velocity").vector();
    if let Behavior::Rigid(RigidMotion::Prescribed { .. }) = materials[material].behavior
        && velocity != [0.0; 3]
    {
        let name = &materials[material].name;
        let message =
            format!("the motion of material {name:?} is prescribed, so its bodies have no `velocity`");
        return Err(Fault::new(given.get("velocity").place, message)
            .help(format!("set `material.{name}.velocity`, or `motion = \"free\"` there")));
    }
    Ok(Body {
        name: given.get("name").word().to_owned(),
        material,
        solid: solid(given.get("shape"))?,
        particles_per_cell: given.get("particles-per-cell").counts(),
        velocity,
        angular_velocity: given.get("angular-velocity").vector(),
        stretch: stretch(given, &materials[material])?,
        fibers: fibers(given.get("fibers"))?,
    })
}

/// How far a body is stretched at the start. A rigid one is not, and turns as its material says.
fn stretch(given: &Node, material: &Material) -> Outcome<[f64; 3]> {
    let (stretch, spin): ([f64; 3], [f64; 3]) =
        (given.get("stretch").vector(), given.get("angular-velocity").vector());
    let refused =
        |key: &str, message: String, help: String| Err(Fault::new(given.get(key).place, message).help(help));
    let Behavior::Rigid(_) = material.behavior else {
        if let Some(factor) = stretch.iter().find(|factor| **factor <= 0.0) {
            let message = format!("a stretch of {factor} would turn the body inside out");
            return refused("stretch", message, "stretches are above 0; 1 is as it was".into());
        }
        return Ok(stretch);
    };
    let name = &material.name;
    if stretch != [1.0; 3] {
        let message = format!("material {name:?} is rigid: its bodies cannot be stretched");
        return refused("stretch", message, "leave `stretch` out".into());
    }
    if spin != [0.0; 3] {
        let message = format!("all bodies of the rigid material {name:?} turn as one");
        return refused("angular-velocity", message, format!("set `material.{name}.angular-velocity`"));
    }
    Ok(stretch)
}

fn fibers(given: &Node) -> Outcome<FiberField> {
    let Some(("turning", turning)) = given.case() else {
        return unit_vector(given.get("uniform")).map(FiberField::Uniform);
    };
    let (start, axis) = (unit_vector(turning.get("start"))?, unit_vector(turning.get("axis"))?);
    if dot(start, axis).abs() > 1e-9 {
        let degrees = dot(start, axis).clamp(-1.0, 1.0).acos().to_degrees();
        let message = format!(
            "`start` must be perpendicular to `axis`, but there are {degrees:.3} degrees between them"
        );
        return Err(Fault::new(turning.get("start").place, message));
    }
    let [from, to, angle] = ["from", "to", "angle"].map(|key| turning.get(key).number());
    if from == to {
        let message = format!("the fibers turn between two planes, but `from` and `to` are both {from} m");
        return Err(Fault::new(turning.get("to").place, message));
    }
    Ok(FiberField::Turning { start, axis, from, to, angle })
}

/// Of the faces in the order of `Scene::faces`.
fn face_conditions(given: &Node) -> Outcome<[AnyFaceCondition; 6]> {
    let condition = |face| choose::either(faces::CONDITIONS, given.get(face), &dotted("boundary", face));
    let found = all(FACES.map(condition))?;
    let whole = <[_; 6]>::try_from(found);
    Ok(whole.unwrap_or_else(|_| unreachable!("there are as many conditions as faces")))
}

fn run(given: &Node) -> Run {
    let viscosity = |given: &Node| Viscosity {
        linear: given.get("linear").number(),
        quadratic: given.get("quadratic").number(),
    };
    Run {
        until: given.get("until").number(),
        steps: given.find("steps").map(Node::count),
        cfl: given.get("cfl").number(),
        rates: match given.get("rates").word() {
            "per-material" => Rates::PerMaterial { most: given.get("most-substeps").count() },
            _ => Rates::Common,
        },
        smallest_step: given.get("smallest-step").number(),
        shape: match given.get("shape").word() {
            "linear" => ShapeFunction::Linear,
            _ => ShapeFunction::Gimp,
        },
        pic: given.get("pic").number(),
        pic_rate: given.get("pic-rate").number(),
        viscosity: given.find("viscosity").map(viscosity),
        leaving: match given.get("leaving").word() {
            "delete" => Leaving::Delete,
            "reflect" => Leaving::Reflect,
            _ => Leaving::Error,
        },
        rebalance_every: given.get("rebalance-every").count(),
        patches: given.find("patches").map(patches),
        threads: given.find("threads").map(Node::count),
    }
}

fn patches(given: &Node) -> Patches {
    if given.items().is_empty() { Patches::Total(given.count()) } else { Patches::Grid(given.counts()) }
}

fn output(given: &Node, materials: &[Material], cell: f64) -> Outcome<Output> {
    Ok(Output {
        frames: given.get("frames").count(),
        fields: super::shown::fields(given.find("fields"), materials)?,
        history_every: given.get("history-every").count(),
        periods: all(given.get("period").items().iter().map(|it| period(it, given)))?,
        checkpoint: checkpoint(given.get("checkpoint")),
        wound: given.find("wound").map(|given| wound(given, materials, cell)).transpose()?,
    })
}

fn period(given: &Node, output: &Node) -> Outcome<Period> {
    let (from, to) = (given.get("from").number(), given.find("to").map_or(f64::INFINITY, Node::number));
    let frames_every = given.find("frames-every").map(Node::number);
    let history_every = given.find("history-every").map(Node::count);
    if to <= from {
        let message = format!("the period ends at {to} s, and begins at {from} s");
        return Err(Fault::new(given.place, message).help("let `to` be later than `from`"));
    }
    if frames_every.is_none() && history_every.is_none() {
        let message = "the period changes nothing";
        return Err(Fault::new(given.place, message).help("say `frames-every` or `history-every`"));
    }
    if let (Some(given), 0) = (given.find("frames-every"), output.get("frames").count::<usize>()) {
        let message = "there are no frames at all: output.frames is 0";
        return Err(Fault::new(given.place, message).help("let output.frames be 1, for one at the end"));
    }
    Ok(Period { from, to, frames_every, history_every })
}

fn checkpoint(given: &Node) -> Checkpoint {
    Checkpoint {
        steps: given.find("steps").map(Node::count),
        time: given.find("time").map(Node::number),
        wall: given.get("wall").number(),
        at_end: given.get("final").flag(),
        kept: given.get("kept").count(),
    }
}

fn wound(given: &Node, materials: &[Material], cell: f64) -> Outcome<Wound> {
    let axis = given.get("axis").word();
    let direction = if axis.starts_with('-') { -1.0 } else { 1.0 };
    let surfaces = ["entry", "exit"].map(|key| given.get(key).number());
    if direction * (surfaces[1] - surfaces[0]) <= 0.0 {
        let [entry, exit] = surfaces;
        let message =
            format!("a shot along {axis} does not pass from the entry at {entry} m to the exit at {exit} m");
        return Err(
            Fault::new(given.get("exit").place, message).help("swap `entry` and `exit`, or turn `axis`")
        );
    }
    // it is measured layer by layer
    let thickness = (surfaces[1] - surfaces[0]).abs() / cell;
    if thickness > MOST_CELLS {
        let message = format!(
            "from `entry` to `exit` there are {thickness:.1e} cells; at most {MOST_CELLS} are possible"
        );
        let help = "is a unit missing? A bare number is in meters";
        return Err(Fault::new(given.get("exit").place, message).help(help));
    }
    let [target, projectile] = ["target", "projectile"].map(|key| material_index(given.get(key), materials));
    let (target, projectile) = (target?, projectile?);
    if target == projectile {
        let message = "the target and the projectile are the same material";
        return Err(Fault::new(given.get("projectile").place, message));
    }
    let axis = ["x", "y", "z"].iter().position(|name| axis.ends_with(name)).unwrap_or_default();
    Ok(Wound { target, projectile, axis, direction, surfaces, center: given.get("center").vector() })
}
