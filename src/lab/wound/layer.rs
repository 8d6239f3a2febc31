//! One layer of the slab, looked at along the shot on a raster of half a particle spacing.
use super::{Scale, Tissue, code};
use serde::Serialize;
use std::f64::consts::{PI, TAU};

/// Sectors for the failed reach.
const SECTORS: usize = 36;
/// Share of a sector's failed particles inside the reach.
const REACH: f64 = 0.9;

/// Principal axes of a region.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Ellipse {
    /// Center, from the point of entry along the two lateral axes [m].
    pub center_m: [f64; 2],
    /// Major axis over minor axis.
    pub ratio: f64,
    /// From the first lateral axis to the major axis, −90 to 90 [degrees].
    pub angle_deg: f64,
}

/// Measures of a layer.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Layer {
    /// Depth of its middle at the start [m].
    pub depth_m: f64,
    /// Diameter of the cavity [m]; 0 if there is none.
    pub cavity_m: f64,
    /// Diameter of cavity and connected failed tissue [m].
    pub failed_layer_m: f64,
    /// Diameter of the failed reach [m].
    pub failed_reach_m: f64,
    /// Failed particles over particles, loose ones included.
    pub failed_fraction: f64,
    /// Shape of the cavity.
    pub cavity: Option<Ellipse>,
    /// Shape of the cloud of failed, attached particles.
    pub failed: Option<Ellipse>,
}

impl Layer {
    pub(super) fn measure(
        tissue: &Tissue,
        attached: &[bool],
        members: &[usize],
        depth: f64,
        scale: Scale,
    ) -> Self {
        let failed = |i: &usize| tissue.failure[*i] != code::NONE;
        let lateral = |i: usize| [tissue.now[i][0], tissue.now[i][1]];
        let mut raster = Raster::around(members.iter().map(|&i| tissue.start[i]), scale.spacing);
        for &i in members.iter().filter(|&&i| attached[i]) {
            raster.stamp(lateral(i), failed(&i));
        }
        let seed = (0.5 * scale.caliber).max(scale.spacing);
        let opening = raster.opening(seed);
        let cavity = raster.grown(&opening);
        let layer = raster.failed_around(&opening, seed);
        let joined: Vec<bool> = layer.iter().zip(&cavity).map(|(a, b)| a | b).collect();
        let shape = ellipse(raster.centers(&cavity));

        let ours = members.iter().filter(|&i| attached[*i] && failed(i));
        let cloud: Vec<_> = ours.map(|&i| lateral(i)).collect();
        let diameter = raster.diameter(&cavity);
        let center = shape.map_or([0.0; 2], |s| s.center_m);
        Self {
            depth_m: depth,
            cavity_m: diameter,
            failed_layer_m: raster.diameter(&joined),
            failed_reach_m: reach(&cloud, center, 0.5 * diameter),
            failed_fraction: members.iter().filter(|i| failed(i)).count() as f64
                / members.len().max(1) as f64,
            cavity: shape,
            failed: ellipse(cloud.into_iter()),
        }
    }
}

/// Square cells of half a spacing over the layer, with the attached particles near each cell counted.
struct Raster {
    low: [f64; 2],
    size: [usize; 2],
    pitch: f64,
    near: Vec<u16>,
    near_failed: Vec<u16>,
}

impl Raster {
    /// Distance within which a particle fills the raster, in cells: 1.5 spacings.
    const FILL: f64 = 3.0;
    /// How far an opening reaches past the cells that nothing fills: up to half a spacing from the particles.
    const GROW: i64 = 2;

    fn around(points: impl Iterator<Item = [f64; 3]>, spacing: f64) -> Self {
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for x in points {
            low = [low[0].min(x[0]), low[1].min(x[1])];
            high = [high[0].max(x[0]), high[1].max(x[1])];
        }
        let pitch = 0.5 * spacing;
        let size =
            [0, 1].map(|a| if low[a] <= high[a] { ((high[a] - low[a]) / pitch) as usize + 1 } else { 0 });
        let cells = size[0] * size[1];
        Self { low, size, pitch, near: vec![0; cells], near_failed: vec![0; cells] }
    }

    /// Counts a particle in all cells whose center it is near.
    fn stamp(&mut self, x: [f64; 2], failed: bool) {
        let [u, v] = [0, 1].map(|a| (x[a] - self.low[a]) / self.pitch - 0.5);
        let range = |center: f64, size: usize| {
            let first = (center - Self::FILL).ceil().max(0.0) as usize;
            first..((center + Self::FILL).floor().max(-1.0) + 1.0).min(size as f64) as usize
        };
        for j in range(v, self.size[1]) {
            for i in range(u, self.size[0]) {
                if (i as f64 - u).powi(2) + (j as f64 - v).powi(2) <= Self::FILL * Self::FILL {
                    let cell = i + self.size[0] * j;
                    self.near[cell] = self.near[cell].saturating_add(1);
                    self.near_failed[cell] = self.near_failed[cell].saturating_add(u16::from(failed));
                }
            }
        }
    }

    fn center(&self, cell: usize) -> [f64; 2] {
        let (i, j) = (cell % self.size[0], cell / self.size[0]);
        [self.low[0] + (i as f64 + 0.5) * self.pitch, self.low[1] + (j as f64 + 0.5) * self.pitch]
    }

    fn centers<'a>(&'a self, region: &'a [bool]) -> impl Iterator<Item = [f64; 2]> + Clone + 'a {
        (0..region.len()).filter(|&cell| region[cell]).map(|cell| self.center(cell))
    }

    fn within(&self, cell: usize, radius: f64) -> bool {
        let [u, v] = self.center(cell);
        u * u + v * v <= radius * radius
    }

    fn diameter(&self, region: &[bool]) -> f64 {
        let area = region.iter().filter(|&&inside| inside).count() as f64 * self.pitch * self.pitch;
        2.0 * (area / PI).sqrt()
    }

    /// The largest connected region that nothing fills, of those that come nearer than `radius` to the axis.
    fn opening(&self, radius: f64) -> Vec<bool> {
        let free = |cell: usize| self.near[cell] == 0;
        let mut best = vec![false; self.near.len()];
        let (mut most, mut seen) = (0, best.clone());
        for seed in (0..self.near.len()).filter(|&cell| free(cell) && self.within(cell, radius)) {
            if !seen[seed] {
                let region = self.flood(&[seed], free);
                region.iter().zip(&mut seen).for_each(|(inside, seen)| *seen |= inside);
                let size = region.iter().filter(|&&inside| inside).count();
                if size > most {
                    (best, most) = (region, size);
                }
            }
        }
        best
    }

    /// What is connected to the opening, or to the axis if there is none, and mostly failed or empty.
    fn failed_around(&self, opening: &[bool], radius: f64) -> Vec<bool> {
        let passes = |cell: usize| 2 * u32::from(self.near_failed[cell]) >= u32::from(self.near[cell]);
        let mut seeds: Vec<_> = (0..opening.len()).filter(|&cell| opening[cell]).collect();
        if seeds.is_empty() {
            seeds = (0..opening.len()).filter(|&cell| passes(cell) && self.within(cell, radius)).collect();
        }
        self.flood(&seeds, passes)
    }

    fn flood(&self, seeds: &[usize], passes: impl Fn(usize) -> bool) -> Vec<bool> {
        let [width, height] = self.size;
        let mut region = vec![false; self.near.len()];
        let mut open = seeds.to_vec();
        while let Some(cell) = open.pop() {
            if region[cell] || !passes(cell) {
                continue;
            }
            region[cell] = true;
            let (i, j) = (cell % width, cell / width);
            open.extend((i > 0).then(|| cell - 1));
            open.extend((i + 1 < width).then_some(cell + 1));
            open.extend((j > 0).then(|| cell - width));
            open.extend((j + 1 < height).then_some(cell + width));
        }
        region
    }

    fn grown(&self, region: &[bool]) -> Vec<bool> {
        let [width, height] = self.size.map(|n| n as i64);
        let mut grown = region.to_vec();
        let disc = (-Self::GROW..=Self::GROW).flat_map(|b| (-Self::GROW..=Self::GROW).map(move |a| (a, b)));
        let disc: Vec<_> = disc.filter(|(a, b)| a * a + b * b <= Self::GROW * Self::GROW).collect();
        for cell in (0..region.len()).filter(|&cell| region[cell]) {
            let (i, j) = (cell as i64 % width, cell as i64 / width);
            for &(a, b) in &disc {
                if (0..width).contains(&(i + a)) && (0..height).contains(&(j + b)) {
                    grown[(i + a + width * (j + b)) as usize] = true;
                }
            }
        }
        grown
    }
}

/// Diameter of the circle with the area that the sectors' reaches enclose, each at least `least` [m].
fn reach(cloud: &[[f64; 2]], center: [f64; 2], least: f64) -> f64 {
    let mut sectors = vec![Vec::new(); SECTORS];
    for x in cloud {
        let [u, v] = [x[0] - center[0], x[1] - center[1]];
        let turn = v.atan2(u) / TAU + 0.5;
        sectors[((turn * SECTORS as f64) as usize).min(SECTORS - 1)].push(u.hypot(v));
    }
    let squares: f64 = sectors
        .iter_mut()
        .map(|radii| {
            radii.sort_by(f64::total_cmp);
            let index = (REACH * radii.len() as f64) as usize;
            radii.get(index).map_or(least, |r| r.max(least)).powi(2)
        })
        .sum();
    2.0 * (squares / SECTORS as f64).sqrt()
}

/// Second moments of points; none for fewer than five points, or for points on a line.
fn ellipse(points: impl Iterator<Item = [f64; 2]> + Clone) -> Option<Ellipse> {
    let n = points.clone().count();
    let mean = |f: &dyn Fn([f64; 2]) -> f64| points.clone().map(f).sum::<f64>() / n as f64;
    if n < 5 {
        return None;
    }
    let center = [mean(&|x| x[0]), mean(&|x| x[1])];
    let uu = mean(&|x| (x[0] - center[0]).powi(2));
    let vv = mean(&|x| (x[1] - center[1]).powi(2));
    let uv = mean(&|x| (x[0] - center[0]) * (x[1] - center[1]));
    let (middle, half) = (0.5 * (uu + vv), (0.5 * (uu - vv)).hypot(uv));
    let minor = middle - half;
    if minor <= 1e-9 * middle {
        return None;
    }
    let angle_deg = (0.5 * (2.0 * uv).atan2(uu - vv)).to_degrees();
    Some(Ellipse { center_m: center, ratio: ((middle + half) / minor).sqrt(), angle_deg })
}
