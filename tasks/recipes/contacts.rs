//! The lines of contact, of bonds and of tools.
use super::builder::{Builder, fields, half_size, spacing};
use super::givers::Giver;
use super::tools::{meets_tools, tools};
use crate::bond_flow::BondFlow;
use crate::bonds::Bonds;
use crate::break_bond::BreakBond;
use crate::contact::{Contact, FieldPair};
use crate::contact_begin::ContactBegin;
use crate::contact_flow::ContactFlow;
use crate::contact_power::ContactPower;
use crate::contact_scatter::ContactScatter;
use crate::drive_bonds::DriveBonds;
use crate::driven_contact::DrivenContact;
use crate::hold_bonds::HoldBonds;
use crate::tool_scatter::ToolScatter;
use crate::tools::{BondedTools, Tools};
use engine::data::fields::FieldId;
use physics::contact::ContactLaw;
use physics::contact::surface::SurfaceTable;
use physics::faces::FaceCondition;

impl<'a> Builder<'a> {
    /// Whether the particles of a material meet those of others.
    pub(super) fn touches(&self, material: usize) -> bool {
        self.meetings().any(|(_, c)| c.between.contains(&material))
    }

    /// Whether a material has a bond that may break.
    fn may_part(&self, material: usize) -> bool {
        let parts = |c: &scene::Contact| c.law.bond().is_some_and(|strength| strength.is_finite());
        self.meetings().any(|(_, c)| c.between.contains(&material) && parts(c))
    }

    pub(super) fn break_bond(&mut self, material: usize) {
        if self.may_part(material) {
            self.add(material, "contact", BreakBond);
        }
    }

    /// Contacts between deformable materials, with their numbers.
    fn meetings(&self) -> impl Iterator<Item = (usize, &'a scene::Contact)> + use<'a> {
        let scene = self.scene;
        let rigid = move |m: &usize| scene.materials[*m].is_rigid();
        scene.contacts.iter().enumerate().filter(move |(_, c)| !c.between.iter().any(rigid))
    }

    /// What the particles of a material tell of its surface, where something is near.
    pub(super) fn surfaces(&mut self, material: usize) {
        let (touches, tools) = (self.touches(material), meets_tools(self.scene, material));
        match self.may_part(material) {
            true => self.add(material, "contact", BondFlow),
            false if touches || tools => self.add(material, "contact", ContactFlow),
            false => {}
        }
        if touches {
            self.add(material, "contact", ContactScatter);
        }
        if tools {
            self.add(material, "contact", ToolScatter);
        }
    }

    pub(super) fn tools(&mut self) {
        let mut tools = tools(self.scene, &self.givers);
        tools.retain(|tool| !tool.body().is_some_and(|m| self.scene.materials[m].is_free()));
        if !tools.is_empty() {
            let (lattice, least_mass, surfaces) = (self.lattice, self.least_mass, self.surface_tables());
            let task = Tools { tools, lattice, least_mass, surfaces };
            match self.bonds() {
                None => self.all("contact", task),
                Some(_) => self.all("contact", BondedTools(task)),
            }
        }
    }

    /// Where the surface of each material lies.
    pub(super) fn surface_tables(&self) -> Vec<SurfaceTable> {
        let table = |m: usize| {
            let mean = |numbers: [f64; 3]| numbers.iter().sum::<f64>() / 3.0;
            SurfaceTable::new(0.5 * mean(spacing(self.scene, m)), mean(half_size(self.scene, m)))
        };
        (0..self.scene.materials.len()).map(table).collect()
    }

    pub(super) fn contact_begin(&mut self) {
        if self.meetings().next().is_some() {
            self.all("contact", ContactBegin);
        }
    }

    /// Bonds between deformable materials, if something may move one side of them alone.
    pub(super) fn bonds(&self) -> Option<Bonds> {
        let fields = fields(self.scene);
        let bonded: Vec<_> = self.meetings().filter(|(_, c)| c.law.bond().is_some()).collect();
        let pairs = bonded.iter().map(|(number, c)| {
            let tile = self.givers.tile(Giver::Contact(*number)).unwrap_or(0);
            (c.between.map(|m| FieldId::new(fields.of(m).start)), tile)
        });
        let is_bonded = |m: usize| bonded.iter().any(|(_, c)| c.between.contains(&m));
        let alone = |m: usize| {
            let meets = self.scene.contacts.iter().filter(|c| c.between.contains(&m)).count() > 1;
            is_bonded(m) && (meets || self.scene.drives.iter().any(|drive| drive.material == m))
        };
        let walls = self.scene.faces.iter().any(|face| face.wall().is_some());
        let asked = !bonded.is_empty() && (walls || (0..self.scene.materials.len()).any(alone));
        asked.then(|| Bonds { pairs: pairs.collect(), lattice: self.lattice })
    }

    /// At the end of a tick bonds hold.
    pub(super) fn hold_bonds(&mut self) {
        if let Some(bonds) = self.bonds() {
            self.all("contact", HoldBonds(bonds));
        }
    }

    /// And take along what is bonded to driven matter.
    pub(super) fn drive_bonds(&mut self) {
        if let Some(bonds) = self.bonds().filter(|_| !self.scene.drives.is_empty()) {
            self.all("drive", DriveBonds(bonds));
        }
    }

    pub(super) fn contact_power(&mut self) {
        if self.meetings().next().is_some() {
            self.all("contact", ContactPower);
        }
    }

    /// Contact at nodes: of the interpolated velocities, or of those on which forces have acted.
    pub(super) fn contact(&mut self, interpolated: bool) {
        if self.meetings().next().is_none() {
            return;
        }
        let task = Contact {
            pairs: self.field_pairs(),
            lattice: self.lattice,
            least_mass: self.least_mass,
            surfaces: self.surface_tables(),
            interpolated,
        };
        let touches = |drive: &scene::Drive| self.touches(drive.material);
        match self.scene.drives.iter().any(touches) {
            false => self.all("contact", task),
            true => self.all("contact", DrivenContact(task)),
        }
    }

    /// The pairs of fields that touch: of two materials in contact, each field of one and each of the other.
    fn field_pairs(&self) -> Vec<FieldPair> {
        let (fields, mut pairs) = (fields(self.scene), Vec::new());
        for (number, contact) in self.meetings() {
            let tile = self.givers.tile(Giver::Contact(number)).unwrap_or(0);
            let [first, second] = contact.between.map(|m| fields.of(m));
            for between in first.flat_map(|a| second.clone().map(move |b| [a, b])) {
                let (between, law, gap) = (between.map(FieldId::new), contact.law, contact.gap);
                pairs.push(FieldPair { between, law, gap, tile });
            }
        }
        pairs.sort_by_key(|pair| pair.law.bond().is_none());
        pairs
    }
}
