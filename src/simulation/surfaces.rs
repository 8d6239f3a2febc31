//! Which particles forces act on, and with which part of the surface.
use super::fault::RunError;
use scene::sampling::{exposed_area, sample};
use scene::{ForceKind, Scene};

/// Forces on particles at the start.
pub struct Surfaces<'a> {
    scene: &'a Scene,
    /// For each force, the part of its total that a particle bears.
    shares: Vec<f64>,
}

impl<'a> Surfaces<'a> {
    /// Those of a scene.
    pub fn of(scene: &'a Scene) -> Self {
        let share = |force: &scene::Force| {
            let bodies = scene.bodies.iter().enumerate().filter(|(_, body)| body.material == force.material);
            let particles = bodies.flat_map(|(index, body)| sample(scene, body).map(move |x| (index, x)));
            let count = particles.filter(|(index, x)| force.region.contains(*index, *x)).count();
            if count > 0 { 1.0 / count as f64 } else { 0.0 }
        };
        let shares = scene.forces.iter().map(|force| match force.kind {
            ForceKind::Total(_) => share(force),
            _ => 0.0,
        });
        Self { scene, shares: shares.collect() }
    }

    /// The force that acts on a particle of a body at `x` [m] at the start, and its `SurfaceArea`.
    ///
    /// # Errors
    /// Two forces that act on the same particle.
    pub fn on(&self, body: usize, x: [f64; 3]) -> Result<Option<(usize, [f64; 3])>, RunError> {
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
                let names = [other, number].map(|number| self.scene.forces[number].name.clone());
                return Err(RunError::TwoForces { names, position: x });
            }
            found = Some((number, area));
        }
        Ok(found)
    }
}
