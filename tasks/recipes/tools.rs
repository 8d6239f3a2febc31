//! Tools and walls of a scene: what pushes matter, whatever the matter does.
use super::givers::{Giver, Givers};
use crate::timestep_size::Mover;
use crate::tool::{Meeting, Pose, Tool};
use physics::faces::{FaceCondition, Image};
use physics::motion::{Course, Motion};
use physics::solid::Solid;
use physics::table::Table;
use scene::sampling::reaches;
use scene::{Behavior, Region, RigidMotion, Scene};

/// All tools and walls: what is prescribed, and free rigid bodies.
pub fn tools(scene: &Scene, givers: &Givers) -> Vec<Tool> {
    let bodies = (0..scene.materials.len()).filter(|&m| scene.materials[m].is_rigid());
    let bodies = bodies.map(|m| Tool {
        shape: scene.shape(m),
        pose: Pose::Body(m),
        tile: givers.tile(Giver::Rigid(m)).unwrap_or(0),
        meets: meetings(scene, givers, m),
    });
    let walls = (0..6).filter_map(|face| {
        let wall = scene.faces[face].wall()?;
        let material = |material: usize| Meeting { material, law: wall.law, gap: 0.0, tile: None };
        Some(Tool {
            shape: outside(scene, face),
            pose: Pose::Course(wall.course.clone()),
            tile: givers.tile(Giver::Face(face)).unwrap_or(0),
            meets: scene.deformable().map(material).collect(),
        })
    });
    bodies.chain(walls).filter(|tool| !tool.meets.is_empty()).collect()
}

/// All that a free rigid body may meet, by who would hold it: rigid materials, and faces that matter does not pass, but for mirrors that
/// cut a free body, which is locked along them.
pub fn obstacles(scene: &Scene) -> Vec<(Giver, Tool)> {
    let tool = |shape, pose| Tool { shape, pose, tile: 0, meets: Vec::new() };
    let bodies = (0..scene.materials.len()).filter(|&m| scene.materials[m].is_rigid());
    let bodies = bodies.map(|m| (Giver::Rigid(m), tool(scene.shape(m), Pose::Body(m))));
    let faces = (0..6).filter(|&face| !is_open(scene, face) && !cuts_a_body(scene, face));
    let faces = faces.map(|face| {
        let course = scene.faces[face].wall().map_or_else(Course::rest, |wall| wall.course);
        (Giver::Face(face), tool(outside(scene, face), Pose::Course(course)))
    });
    bodies.chain(faces).collect()
}

fn is_open(scene: &Scene, face: usize) -> bool {
    let face = &scene.faces[face];
    !face.acts() && face.image().is_none() && face.wall().is_none()
}

fn cuts_a_body(scene: &Scene, face: usize) -> bool {
    let reaches = |m: usize| reaches(&scene.domain, scene.shape(m).bounds(), face);
    let mirror = scene.faces[face].image() == Some(Image::Mirror);
    mirror && (0..scene.materials.len()).any(|m| scene.materials[m].is_free() && reaches(m))
}

/// Whether tools, walls or rigid bodies may meet a material.
pub fn meets_tools(scene: &Scene, material: usize) -> bool {
    let walls = || scene.faces.iter().any(|face| face.wall().is_some());
    let contact = |c: &scene::Contact| {
        c.between.contains(&material) && c.between.iter().any(|&m| scene.materials[m].is_rigid())
    };
    !scene.materials[material].is_rigid() && (walls() || scene.contacts.iter().any(contact))
}

fn meetings(scene: &Scene, givers: &Givers, tool: usize) -> Vec<Meeting> {
    let contacts = scene.contacts.iter().enumerate().filter(|(_, c)| c.between.contains(&tool));
    let one = |(number, c): (usize, &scene::Contact)| {
        // forces of a contact are those on its first material
        let (material, sign) = if c.between[0] == tool { (c.between[1], -1.0) } else { (c.between[0], 1.0) };
        let tile = givers.tile(Giver::Contact(number)).map(|tile| (tile, sign));
        Meeting { material, law: c.law, gap: c.gap, tile }
    };
    contacts.map(one).collect()
}

/// What lies beyond a face.
fn outside(scene: &Scene, face: usize) -> Solid {
    let (axis, upper) = (face / 2, face % 2 == 1);
    let mut point = scene.domain.lower;
    let mut normal = [0.0; 3];
    normal[axis] = if upper { -1.0 } else { 1.0 };
    if upper {
        point[axis] += scene.domain.cell * scene.domain.cells[axis] as f64;
    }
    Solid::HalfSpace { point, normal }
}

/// What moves as prescribed: tools, walls and drives.
pub fn movers(scene: &Scene) -> Vec<Mover> {
    let met = |tool: usize| {
        let pairs = scene.contacts.iter().map(|c| c.between).filter(move |pair| pair.contains(&tool));
        pairs.map(move |[a, b]| if a == tool { b } else { a }).collect::<Vec<usize>>()
    };
    let tools = scene.materials.iter().enumerate().filter_map(|(m, material)| match &material.behavior {
        Behavior::Rigid(RigidMotion::Prescribed { course, spin, center, .. }) => {
            let (shape, center) = (scene.shape(m), center.unwrap_or_else(|| middle(&scene.shape(m))));
            let motion = Motion { course: course.clone(), spin: spin.clone(), center };
            Some(Mover { motion, radius: radius(scene, &shape, center), meets: met(m) })
        }
        _ => None,
    });
    let walls = scene.faces.iter().filter_map(|face| face.wall()).map(|wall| Mover {
        motion: Motion { course: wall.course, spin: Table::zero(), center: [0.0; 3] },
        radius: 0.0,
        meets: scene.deformable().collect(),
    });
    let drives = scene.drives.iter().map(|drive| {
        let shape = match &drive.region {
            Region::All => scene.shape(drive.material),
            Region::Body(body) => scene.bodies[*body].solid.clone(),
            Region::Solid(solid) => Solid::Intersection(vec![solid.clone(), scene.shape(drive.material)]),
        };
        let radius = radius(scene, &shape, drive.motion.center);
        Mover { motion: drive.motion.clone(), radius, meets: vec![drive.material] }
    });
    tools.chain(walls).chain(drives).collect()
}

/// The middle of the box around a shape; the origin, if it has no end.
pub fn middle(shape: &Solid) -> [f64; 3] {
    let (lower, upper) = shape.bounds();
    let middle: [f64; 3] = std::array::from_fn(|a| 0.5 * (lower[a] + upper[a]));
    if shape.is_bounded() { middle } else { [0.0; 3] }
}

/// How far the points of a shape that are in the domain are from a center, at most.
fn radius(scene: &Scene, shape: &Solid, center: [f64; 3]) -> f64 {
    let (lower, upper) = shape.bounds();
    let domain = scene.domain;
    let farthest = |a: usize| {
        let ends = if shape.is_bounded() {
            [lower[a], upper[a]]
        } else {
            [domain.lower[a], domain.lower[a] + domain.cell * domain.cells[a] as f64]
        };
        ends.map(|x| (x - center[a]).abs()).into_iter().fold(0.0, f64::max)
    };
    (0..3).map(|a| farthest(a).powi(2)).sum::<f64>().sqrt()
}
