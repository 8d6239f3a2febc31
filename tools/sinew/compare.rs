//! `sinew compare`: do two runs say the same?
use super::fail::Failure;
use sinew::output::checkpoint::{self, Reader as Checkpoint};
use sinew::output::compare::{
    Comparison, Norms, Tolerances, checkpoint_particles, checkpoint_shared, compare, component_name,
    frame_particles, history, tolerated,
};
use sinew::output::vtkhdf::Reader as Frames;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Compare two runs: bit for bit, particle by particle, or within tolerances
///
/// Compared are history.csv, all frames of particles.vtkhdf (single precision), and the last checkpoints of the same step
/// (every bit of every label), as far as both have them. Exit status: 0 the same, 1 different, 2 bad usage, or a file that
/// cannot be read.
#[derive(clap::Args)]
pub struct Args {
    /// Folder of a run, or its particles.vtkhdf, history.csv or a checkpoint
    a: PathBuf,
    /// The same of the other
    b: PathBuf,
    /// What may differ: NUMBER, over the largest value of each label and column, or LABEL=NUMBER in the label's unit
    /// (`history`: over the largest value of each column); labels without a tolerance must have the same bits
    #[arg(long = "tolerance", value_name = "[LABEL=]NUMBER")]
    tolerances: Vec<String>,
}

/// What has been found so far.
struct Verdict {
    tolerances: Tolerances,
    /// Things that were compared, and whether all were the same.
    compared: usize,
    same: bool,
    /// Labels and columns that were met.
    met: BTreeSet<String>,
}

/// Runs the subcommand.
pub fn run(args: &Args) -> Result<(), Failure> {
    let tolerances = Tolerances::parse(&args.tolerances).map_err(Failure::usage)?;
    let mut verdict =
        Verdict { tolerances, compared: 0, same: true, met: BTreeSet::from(["history".into()]) };
    for path in [&args.a, &args.b] {
        if !path.exists() {
            return Err(Failure::usage(format!("{} does not exist", path.display())));
        }
    }
    let sides = [args.a.as_path(), args.b.as_path()];
    if let Some(files) = both(sides, "history.csv", "csv")? {
        verdict.history(files)?;
    }
    if let Some(files) = both(sides, "particles.vtkhdf", "vtkhdf")? {
        verdict.frames(files)?;
    }
    if let Some(files) = checkpoints(sides)? {
        verdict.checkpoints(files)?;
    }
    if verdict.compared == 0 {
        return Err(Failure::usage(
            "there is nothing that both have: name two folders of runs, or two files of one kind",
        ));
    }
    if let Some(unknown) = verdict.tolerances.absolute.keys().find(|label| !verdict.met.contains(*label)) {
        let labels: Vec<&str> = verdict.met.iter().map(String::as_str).collect();
        return Err(Failure::usage(format!("--tolerance {unknown}=…: there are {}", labels.join(", "))));
    }
    match verdict.same {
        true => Ok(()),
        false => Err(Failure::Run("the runs differ".into())),
    }
}

/// What cannot be read is neither the same nor different.
fn read<T>(result: sinew::output::Result<T>) -> Result<T, Failure> {
    result.map_err(Failure::usage)
}

/// The files of that name of two folders, or two files of that kind.
fn both(sides: [&Path; 2], name: &str, kind: &str) -> Result<Option<[PathBuf; 2]>, Failure> {
    let file = |side: &Path| match side.is_dir() {
        true => side.join(name),
        false => side.to_owned(),
    };
    let files = sides.map(file);
    if let Some(odd) = files.iter().find(|file| file.ends_with(name) && file.exists() && !file.is_file()) {
        return Err(Failure::usage(format!("cannot read {}: it is no file", odd.display())));
    }
    let there = files.each_ref().map(|f| f.is_file() && f.extension().is_some_and(|e| e == kind));
    if there[0] != there[1] && sides.iter().all(|side| side.is_dir()) {
        println!("{name:<14} only one of the two has it: not compared");
    }
    Ok(there.iter().all(|&there| there).then_some(files))
}

/// The last checkpoints of the same step.
fn checkpoints(sides: [&Path; 2]) -> Result<Option<[PathBuf; 2]>, Failure> {
    if sides.iter().all(|side| side.is_file() && side.extension().is_some_and(|e| e == "h5")) {
        return Ok(Some(sides.map(Path::to_owned)));
    }
    if !sides.iter().all(|side| side.is_dir()) {
        return Ok(None);
    }
    let [one, other] = sides.map(checkpoint::list);
    let beside = |path: &PathBuf| other.iter().find(|o| o.file_name() == path.file_name()).cloned();
    let common = one.iter().find_map(|path| Some([path.clone(), beside(path)?]));
    if common.is_none() && !(one.is_empty() && other.is_empty()) {
        println!("checkpoints    there are none of the same step: not compared");
    }
    Ok(common)
}

impl Verdict {
    fn history(&mut self, files: [PathBuf; 2]) -> Result<(), Failure> {
        let [one, other] = files.map(|file| {
            let text = std::fs::read_to_string(&file);
            text.map_err(|error| Failure::usage(format!("cannot read {}: {error}", file.display())))
        });
        let found = history::compare(&one?, &other?, &self.tolerances);
        self.met.extend(found.columns);
        self.compared += 1;
        match &found.first {
            None => println!("history        {} rows {}", found.rows, self.word()),
            Some(cell) if cell.column.is_empty() => {
                println!("history        only one of the two has row {} (step {})", cell.row, cell.step);
            }
            Some(cell) => {
                let (row, [a, b]) = (cell.row, &cell.values);
                println!(
                    "history        differs first in row {row} (step {}): {} is {a} and {b}",
                    cell.step, cell.column
                );
            }
        }
        self.same &= found.first.is_none();
        Ok(())
    }

    fn frames(&mut self, files: [PathBuf; 2]) -> Result<(), Failure> {
        let names = materials(&files[0]);
        let open = |file: &PathBuf| read(Frames::open(file));
        let [one, other] = [open(&files[0])?, open(&files[1])?];
        self.compared += 1;
        let mut worst: Vec<Norms> = Vec::new();
        for k in 0..one.frames().min(other.frames()) {
            let [a, b] = [read(one.frame(k))?, read(other.frame(k))?];
            let when = format!("frame {k} (step {}, t = {:e} s)", a.step, a.time);
            if self.tolerances.none() && (a.step, a.time.to_bits()) != (b.step, b.time.to_bits()) {
                println!(
                    "frames         differ first in {when}: the other is of step {}, t = {:e} s",
                    b.step, b.time
                );
                self.same = false;
                return Ok(());
            }
            let found = compare(&frame_particles(a), &frame_particles(b), &self.tolerances);
            if !self.accept(&found, &format!("frames         differ first in {when}"), &names) {
                return Ok(());
            }
            for (i, norms) in found.norms.into_iter().enumerate() {
                match worst.get_mut(i) {
                    Some(known) if known.most >= norms.most => {}
                    Some(known) => *known = norms,
                    None => worst.push(norms),
                }
            }
        }
        if one.frames() != other.frames() {
            println!("frames         one has {} of them, the other {}", one.frames(), other.frames());
            self.same = false;
        } else {
            println!("frames         {} {}", one.frames(), self.word());
            self.table(&worst);
        }
        Ok(())
    }

    fn checkpoints(&mut self, files: [PathBuf; 2]) -> Result<(), Failure> {
        let open = |file: &PathBuf| read(Checkpoint::open(file));
        let [one, other] = [open(&files[0])?, open(&files[1])?];
        self.compared += 1;
        let when = format!("checkpoints    of step {} and {}", one.head.steps, other.head.steps);
        let names: Vec<String> = one.head.materials.iter().map(|m| m.name.clone()).collect();
        if names != other.head.materials.iter().map(|m| m.name.clone()).collect::<Vec<_>>() {
            println!("{when} have other materials");
            self.same = false;
            return Ok(());
        }
        let mut all = Vec::new();
        for material in 0..names.len() {
            let side = |reader: &Checkpoint| read(checkpoint_particles(reader, material));
            let sides = [side(&one)?, side(&other)?];
            let found = compare(&sides[0], &sides[1], &self.tolerances);
            if !self.accept(&found, &format!("{when} differ in {}", names[material]), &names) {
                return Ok(());
            }
            let named = |n: Norms| Norms { label: format!("{} {}", names[material], n.label), ..n };
            all.extend(found.norms.into_iter().map(named));
        }
        let by_value = !self.tolerances.none();
        let beside = checkpoint_shared(&other, by_value);
        for ((name, a), (_, b)) in checkpoint_shared(&one, by_value).iter().zip(&beside) {
            let largest = a.iter().filter(|x| x.is_finite()).fold(0.0, |most: f64, x| most.max(x.abs()));
            let allowed = self.tolerances.allowed(name, largest);
            let differs = a.len() != b.len() || a.iter().zip(b).any(|(&a, &b)| !tolerated([a, b], allowed));
            self.met.insert(name.clone());
            if differs {
                println!("{when} differ in {name}");
                self.same = false;
                return Ok(());
            }
        }
        println!("{when}: {}", self.word());
        self.table(&all);
        Ok(())
    }

    /// Says what differs, if anything does.
    fn accept(&mut self, found: &Comparison, where_: &str, materials: &[String]) -> bool {
        self.met.extend(found.norms.iter().map(|norms| norms.label.clone()));
        if found.same() {
            return true;
        }
        self.same = false;
        println!("{where_}");
        for (only, side) in found.only.iter().zip(["first", "second"]).filter(|(only, _)| !only.is_empty()) {
            const SHOWN: usize = 10;
            let some: Vec<String> = only.iter().take(SHOWN).map(u64::to_string).collect();
            let more = if only.len() > SHOWN { ", …" } else { "" };
            println!("  only the {side} has {} particles: {}{more}", only.len(), some.join(", "));
        }
        if !found.unpaired.is_empty() {
            println!("  only one has {}", found.unpaired.join(", "));
        }
        if let Some(first) = &found.first {
            let material = materials.get(first.material).map_or("?", String::as_str);
            let [x, y, z] = first.position.map(|x| 1e3 * x);
            let name = component_name(&first.label, first.component);
            let (identity, [a, b]) = (first.identity, first.values);
            println!(
                "  first particle {identity} of {material} at ({x:.4}, {y:.4}, {z:.4}) mm: {name} is {a:e} and {b:e}"
            );
        }
        let differing = found.norms.iter().filter(|norms| norms.differing > 0).cloned().collect::<Vec<_>>();
        self.table(&differing);
        false
    }

    /// Largest and root mean square differences, where there is one.
    fn table(&self, norms: &[Norms]) {
        let shown: Vec<&Norms> = norms.iter().filter(|n| n.most > 0.0 || n.differing > 0).collect();
        if shown.is_empty() {
            return;
        }
        println!(
            "  {:<28} {:>12} {:>12} {:>12} {:>10}",
            "label", "largest", "rms (L2)", "allowed", "particles"
        );
        for n in shown {
            let allowed = n.allowed.map_or("no bit".to_owned(), |allowed| format!("{allowed:.4e}"));
            let name = component_name(&n.label, n.component);
            println!("  {name:<28} {:>12.4e} {:>12.4e} {allowed:>12} {:>10}", n.most, n.rms, n.differing);
        }
    }

    fn word(&self) -> &'static str {
        if self.tolerances.none() { "the same, bit for bit" } else { "the same within the tolerances" }
    }
}

/// Names of materials, from the scene beside a particle file.
fn materials(particles: &Path) -> Vec<String> {
    let scene = particles.parent().map(|folder| folder.join("scene.toml"));
    let text = scene.and_then(|scene| std::fs::read_to_string(scene).ok()).unwrap_or_default();
    let table: toml::Table = text.parse().unwrap_or_default();
    let named = table.get("material").and_then(toml::Value::as_table);
    named.map_or_else(Vec::new, |named| named.keys().cloned().collect())
}
