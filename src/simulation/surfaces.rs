//! Which particles forces act on, and with which part of the surface.
use super::fault::RunError;
use physics::faces::FaceCondition;
use scene::sampling::{inside, sample};
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
                _ => self.area(body, x, force.sides),
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

    /// N₀: the faces of a particle that no other covers, as far as they count.
    fn area(&self, body: usize, x: [f64; 3], sides: [bool; 6]) -> [f64; 3] {
        let (scene, it) = (self.scene, &self.scene.bodies[body]);
        let size = it.particles_per_cell.map(|n| scene.domain.cell / n as f64);
        let mut area = [0.0; 3];
        for face in (0..6).filter(|&face| sides[face]) {
            let (axis, sign) = (face / 2, if face % 2 == 1 { 1.0 } else { -1.0 });
            let mut beside = x;
            beside[axis] += sign * size[axis];
            if self.is_matter(it.material, beside) {
                continue;
            }
            let across = size[(axis + 1) % 3] * size[(axis + 2) % 3];
            // a = J F^(−T) N₀ with F = diag λ: N₀ = a λ / J
            let j: f64 = it.stretch.iter().product();
            area[axis] += sign * across * it.stretch[axis] / j;
        }
        area
    }

    /// Whether there is matter of a material, or its image beyond a face.
    fn is_matter(&self, material: usize, x: [f64; 3]) -> bool {
        let (lower, upper) = inside(&self.scene.domain);
        let beyond = (0..6).any(|face| {
            let axis = face / 2;
            let out = if face % 2 == 0 { x[axis] < lower[axis] } else { x[axis] > upper[axis] };
            out && self.scene.faces[face].image().is_some()
        });
        beyond || self.scene.bodies_of(material).any(|body| body.solid.contains(x))
    }
}
