//! Which particles forces act on, and with which part of the surface.
use super::start::Roll;
use engine::exec::ranks::{Network, NetworkError};
use scene::sampling::exposed_area;
use scene::{ForceKind, Scene};

/// Forces on particles at the start.
pub struct Surfaces<'a> {
    scene: &'a Scene,
    /// For each force, the part of its total that a particle bears.
    shares: Vec<f64>,
}

impl<'a> Surfaces<'a> {
    /// Those of a scene. All ranks call it.
    ///
    /// # Errors
    /// If a rank is gone.
    pub fn of(scene: &'a Scene, roll: &Roll, network: &mut dyn Network) -> Result<Self, NetworkError> {
        let mut share = |force: &scene::Force| {
            let ForceKind::Total(_) = force.kind else { return Ok(0.0) };
            let members = roll.members(scene, force.material, &force.region, network)?;
            let count: u64 = members.iter().map(|range| range.end - range.start).sum();
            Ok(if count > 0 { 1.0 / count as f64 } else { 0.0 })
        };
        let shares = scene.forces.iter().map(&mut share).collect::<Result<_, NetworkError>>()?;
        Ok(Self { scene, shares })
    }

    /// The force that acts on a particle of a body at `x` [m] at the start, and its `SurfaceArea`.
    ///
    /// # Errors
    /// Two forces that act on the same particle, by their numbers.
    pub fn on(&self, body: usize, x: [f64; 3]) -> Result<Option<(usize, [f64; 3])>, [usize; 2]> {
        let material = self.scene.bodies[body].material;
        let mut found: Option<(usize, [f64; 3])> = None;
        let forces = self.scene.forces.iter().enumerate();
        for (number, force) in forces.filter(|(_, it)| it.material == material && it.region.contains(body, x))
        {
            let area = match force.kind {
                ForceKind::Total(_) => [self.shares[number], 0.0, 0.0],
                _ => exposed_area(self.scene, body, x, force.sides),
            };
            if area == [0.0; 3] {
                continue;
            }
            if let Some((other, _)) = found {
                return Err([other, number]);
            }
            found = Some((number, area));
        }
        Ok(found)
    }
}
