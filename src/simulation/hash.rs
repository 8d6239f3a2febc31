//! A fingerprint of the state.
use engine::data::warehouse::Warehouse;
use engine::schema::Label;
use tasks::labels;

/// Mixes a word into a running hash (the finalizer of MurmurHash3 between additions).
fn mix(hash: u64, word: u64) -> u64 {
    let mut h = hash.wrapping_add(word).wrapping_add(0x9E37_79B9_7F4A_7C15);
    h = (h ^ h >> 33).wrapping_mul(0xFF51_AFD7_ED55_8CCD);
    h = (h ^ h >> 33).wrapping_mul(0xC4CE_B9FE_1A85_EC53);
    h ^ h >> 33
}

/// The sum of a hash of each particle of this rank, its state and its identity: order, patches and threads do not
/// show. Sums of ranks add up (wrapping).
pub fn particles(warehouse: &Warehouse) -> u64 {
    let mut total = 0u64;
    for (material, block) in warehouse.blocks() {
        let layout = &warehouse.materials[material].layout;
        for particle in 0..block.count {
            let identity = block.get(layout, labels::Identity::ID, particle, 0).to_bits();
            let components = |label| (0..layout.width(label)).map(move |component| (label, component));
            let numbers = layout.state_labels().flat_map(components);
            let bits =
                numbers.map(|(label, component)| block.get(layout, label, particle, component).to_bits());
            total = total.wrapping_add(bits.fold(mix(identity, material as u64), mix));
        }
    }
    total
}

/// The hash of the state, from the sum over all particles.
pub fn state(total: u64, warehouse: &Warehouse) -> u64 {
    let shared = warehouse.shared.column(labels::RigidMotion::ID).iter().flat_map(|line| line.0);
    shared.fold(total, |h, x| mix(h, x.to_bits()))
}
