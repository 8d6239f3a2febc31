//! What the materials of a scene can show of their particles.
use crate::{Material, Region, Scene};
use physics::law::Declared;
use physics::quantities::{NONE, Numbers, Of, POSITION, QUANTITIES, Shown, Tile, Value};

/// Something shown of one particle, or of many, in time.
#[derive(Clone, Debug)]
pub struct Probe {
    /// Name in `history.csv`.
    pub name: String,
    /// Index of the material.
    pub material: usize,
    /// What is shown.
    pub shown: Shown,
    /// Of whom.
    pub of: ProbeOf,
    /// Simulated time between rows of its own in the history [s], besides those of all columns.
    pub interval: Option<f64>,
}

/// Of which particles a probe shows what.
#[derive(Clone, Debug)]
pub enum ProbeOf {
    /// Of the one that is nearest to a point [m] at the start.
    Nearest([f64; 3]),
    /// The mean by mass over those of a region.
    Mean(Region),
    /// The largest over those of a region.
    Largest(Region),
    /// The smallest over those of a region.
    Smallest(Region),
}

/// Where the numbers of something shown are.
#[derive(Clone, Copy, Debug)]
pub enum Source {
    /// Nowhere: the material has no such thing.
    Nowhere,
    /// They follow from the state of particles.
    Value(Value),
    /// A number that the law keeps.
    History(usize),
}

impl Source {
    /// The numbers of eight particles, from the first on; what is not there is not a number.
    pub fn of(self, tile: &Tile) -> Numbers {
        let mut numbers = NONE;
        self.put(tile, &mut numbers);
        numbers
    }

    /// The same in place of others; what it has no numbers for stays.
    #[inline]
    pub fn put(self, tile: &Tile, numbers: &mut Numbers) {
        match self {
            Source::Nowhere => *numbers = NONE,
            Source::Value(of) => of(tile, numbers),
            Source::History(number) => numbers[0] = tile.history[number],
        }
    }
}

/// All that some of these materials have: what every particle has, what those have that deform, and what their laws add.
pub fn available<'a>(materials: impl IntoIterator<Item = &'a Material>) -> Vec<Shown> {
    let materials: Vec<&Material> = materials.into_iter().collect();
    let deformable = materials.iter().any(|material| !material.is_rigid());
    let general = QUANTITIES.iter().filter(|q| q.of == Of::All || deformable).map(|q| q.shown);
    let mut all: Vec<Shown> = general.collect();
    for shown in materials.iter().flat_map(|material| of_law(&material.declared())) {
        if !all.iter().any(|other| other.name == shown.name) {
            all.push(shown);
        }
    }
    all
}

/// What a law adds.
pub fn of_law(law: &Declared) -> Vec<Shown> {
    let kept = law.history.iter().map(|v| Shown {
        name: v.name,
        unit: v.unit,
        components: 1,
        meaning: v.meaning,
        codes: v.codes,
        usual: v.usual,
        from_start: false,
    });
    law.shown.iter().map(|q| q.shown).chain(kept).collect()
}

impl Scene {
    /// Where the numbers of something shown are, in a material.
    pub fn source(&self, material: usize, name: &str) -> Source {
        let material = &self.materials[material];
        let law = material.declared();
        if let Some(q) = QUANTITIES.iter().chain(&[POSITION]).chain(law.shown).find(|q| q.shown.name == name)
        {
            let has = q.of != Of::Deformable || !material.is_rigid();
            return if has { Source::Value(q.value) } else { Source::Nowhere };
        }
        law.history.iter().position(|v| v.name == name).map_or(Source::Nowhere, Source::History)
    }
}
