//! Checks of rigid bodies.
use super::document::Node;
use super::error::{Fault, Outcome};
use physics::contact::ContactLaw;
use physics::faces::{FaceCondition, Image};
use scene::sampling::{inside, reaches};
use scene::{Behavior, Body, Material, RigidMotion, Scene};

/// Rigid materials have bodies.
pub(super) fn have_bodies(scene: &Scene, root: &Node) -> Outcome<()> {
    for (m, material) in scene.materials.iter().enumerate() {
        if material.is_rigid() && scene.bodies_of(m).next().is_none() {
            let place = root.get("material").entries()[m].place;
            let message = format!("the rigid material {:?} has no body", material.name);
            return Err(Fault::new(place, message).help("add a [[body]] of it, or remove it"));
        }
    }
    Ok(())
}

/// Tools meet something, or are to be seen.
pub(super) fn tools_act(scene: &Scene, root: &Node) -> Outcome<()> {
    for (m, material) in scene.materials.iter().enumerate().filter(|(_, m)| m.is_tool() && !m.has_particles())
    {
        let meets = scene.contacts.iter().any(|contact| contact.between.contains(&m));
        if !meets && !scene.materials.iter().any(Material::is_free) {
            let message = format!("the tool {:?} meets nothing", material.name);
            return Err(Fault::new(root.get("material").entries()[m].place, message)
                .help("add a [[contact]] between it and a material that deforms, or remove it"));
        }
    }
    Ok(())
}

/// Free rigid bodies meet no matter that drives hold along some axes alone: what stops the body there makes the matter slip, and the search for
/// its motion would go in circles.
pub(super) fn meets_what_is_held(scene: &Scene, root: &Node) -> Outcome<()> {
    for (drive, node) in scene.drives.iter().zip(root.get("drive").items()) {
        if drive.components == [true; 3] {
            continue;
        }
        let bonded = |m: &usize, n: usize| {
            scene
                .contacts
                .iter()
                .any(|c| c.law.bond().is_some() && c.between.contains(m) && c.between.contains(&n))
        };
        // with all that is bonded to it
        let mut held = vec![drive.material];
        while let Some(more) = (0..scene.materials.len()).find(|&n| {
            !scene.materials[n].is_rigid() && !held.contains(&n) && held.iter().any(|m| bonded(m, n))
        }) {
            held.push(more);
        }
        let free = |m: &&usize| scene.materials[**m].is_free();
        let met = scene.contacts.iter().filter(|c| c.between.iter().any(|m| held.contains(m)));
        if let Some(&rigid) = met.flat_map(|c| &c.between).find(free) {
            let message = format!(
                "the drive {:?} holds matter along some axes alone, which the free rigid body of {:?} meets: that is not modelled",
                drive.name, scene.materials[rigid].name
            );
            return Err(Fault::new(node.get("components").place, message).help(format!(
                "set `components = \"xyz\"`, or make {:?} a prescribed tool or a material that deforms",
                scene.materials[rigid].name
            )));
        }
    }
    Ok(())
}

/// A body, if it is rigid.
pub(super) fn body(scene: &Scene, index: usize, node: &Node, root: &Node) -> Outcome<()> {
    let body = &scene.bodies[index];
    rigid_start(scene, index, node)?;
    if scene.materials[body.material].is_tool() {
        turns_about(scene, body, node)?;
    }
    keeps_still(scene, body, root)?;
    moves_with_its_images(scene, body, root)
}

/// What is locked does not move at the start.
fn keeps_still(scene: &Scene, body: &Body, root: &Node) -> Outcome<()> {
    let material = &scene.materials[body.material];
    let Behavior::Rigid(RigidMotion::Free { locked, locked_turns, angular_velocity, .. }) = material.behavior
    else {
        return Ok(());
    };
    let moves = |v: [f64; 3], locked: [bool; 3]| (0..3).find(|&a| locked[a] && v[a] != 0.0);
    let place = root.get("material").entries()[body.material].place;
    let fault =
        |message: String| Err(Fault::new(place, message).help("unlock it, or let it start without that"));
    if let Some(a) = moves(body.velocity, locked) {
        return fault(format!(
            "body {:?} starts with a velocity along {}, and is locked along it",
            body.name, AXES[a]
        ));
    }
    if let Some(a) = moves(angular_velocity, locked_turns) {
        return fault(format!(
            "body {:?} starts turning about {}, and is locked about it",
            body.name, AXES[a]
        ));
    }
    Ok(())
}

const AXES: [&str; 3] = ["x", "y", "z"];

/// The faces beyond which a body goes on as its image: mirrors, for those that are rigid.
pub(super) fn goes_on(scene: &Scene, body: &Body) -> [bool; 6] {
    let rigid = scene.materials[body.material].is_rigid();
    scene.faces.each_ref().map(|face| rigid && face.image() == Some(Image::Mirror))
}

/// A free rigid body that a mirror cuts moves as its image does: along the mirror, and about its normal.
fn moves_with_its_images(scene: &Scene, body: &Body, root: &Node) -> Outcome<()> {
    let material = &scene.materials[body.material];
    let Behavior::Rigid(RigidMotion::Free { locked, locked_turns, .. }) = material.behavior else {
        return Ok(());
    };
    for (face, _) in goes_on(scene, body).iter().enumerate().filter(|(_, mirror)| **mirror) {
        let a = face / 2;
        let cut = reaches(&scene.domain, body.solid.bounds(), face);
        let (along, about) = (AXES[a], ["yz", "xz", "xy"][a]);
        let turns = (0..3).filter(|&b| b != a).all(|b| locked_turns[b]);
        if cut && !(locked[a] && turns) {
            let message = format!(
                "a mirror cuts the free rigid body {:?}, which may leave it or turn from it",
                body.name
            );
            let place = root.get("material").entries()[body.material].place;
            let help = format!(
                "lock it along {along} (`locked`) and about {about} (`locked-turns`), as its image is, or keep it off the face"
            );
            return Err(Fault::new(place, message).help(help));
        }
    }
    Ok(())
}

/// A tool that turns and has no end, or ends beyond the domain, says about what.
fn turns_about(scene: &Scene, body: &Body, node: &Node) -> Outcome<()> {
    let material = &scene.materials[body.material];
    let Behavior::Rigid(RigidMotion::Prescribed { spin, center: None, .. }) = &material.behavior else {
        return Ok(());
    };
    let (lower, upper) = body.solid.bounds();
    let (from, to) = inside(&scene.domain);
    let within = (0..3).all(|a| from[a] <= lower[a] && upper[a] <= to[a]);
    if within || !spin.acts() {
        return Ok(());
    }
    let message =
        format!("body {:?} turns and is not wholly in the domain: about what does it turn?", body.name);
    Err(Fault::new(node.get("shape").place, message).help(format!("set `material.{}.center`", material.name)))
}

/// Bodies of one free rigid material start with one velocity.
fn rigid_start(scene: &Scene, index: usize, node: &Node) -> Outcome<()> {
    let body = &scene.bodies[index];
    let material = &scene.materials[body.material];
    let first = scene.bodies.iter().find(|other| other.material == body.material).unwrap_or(body);
    match material.behavior {
        Behavior::Rigid(RigidMotion::Free { .. }) if first.velocity != body.velocity => {
            let message = format!(
                "bodies {:?} and {:?} of the rigid material {:?} start with different velocities",
                first.name, body.name, material.name
            );
            Err(Fault::new(node.get("velocity").place, message).help(
                "they are one rigid body: give both the same velocity, or the second a material of its own",
            ))
        }
        _ => Ok(()),
    }
}
