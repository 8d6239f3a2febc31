//! Several ranks stop and go on.
use crate::command::timeless;
use crate::*;

/// Runs `work` on each of `size` ranks.
pub fn together<T: Send>(size: usize, work: impl Fn(Box<dyn Network>) -> T + Sync) -> Vec<T> {
    std::thread::scope(|scope| {
        let crew = Local::crew(size).into_iter();
        let ranks: Vec<_> = crew.map(|rank| scope.spawn(|| work(Box::new(rank)))).collect();
        ranks.into_iter().map(|rank| rank.join().expect("a rank ends")).collect()
    })
}

#[test]
fn any_number_of_ranks_takes_over_the_state_and_writes_it_again() {
    let (folder, scene) = (folder(), laid_out(scene(CLOUD, &[]), ([3, 2, 2], 1)));
    let path = stopped(scene.clone(), LAYOUTS[3], 40, folder.path());
    let hash = restored(scene.clone(), LAYOUTS[0], &path).state_hash();
    let records = |path: &Path| {
        let reader = ok(Reader::open(path));
        let mut records = Vec::new();
        for (m, material) in reader.head.materials.iter().enumerate() {
            let columns = ok(reader.columns(m, &(0..material.rows)));
            let mut row = 0;
            for block in ok(reader.blocks(m)) {
                let rows = row..row + block.count as usize;
                row = rows.end;
                let columns = columns.iter().zip(&material.labels);
                let bits = columns
                    .map(|(c, (_, w))| c[rows.start * w..rows.end * w].iter().map(|x| x.to_bits()).collect());
                records.push((
                    m,
                    block.index,
                    block.extent.map(f64::to_bits),
                    bits.collect::<Vec<Vec<u64>>>(),
                ));
            }
        }
        records.sort();
        (reader.head.shared, reader.head.ledger.iter().map(|x| x.to_bits()).collect::<Vec<_>>(), records)
    };
    for ranks in [1, 2, 3, 5] {
        let out = self::folder();
        let hashes = together(ranks, |mut network| {
            let (reader, _) = ok(last_checkpoint(&mut *network, folder.path()));
            let mut simulation = ok(Simulation::restore(network, scene.clone(), Isa::detect(), &reader));
            ok(simulation.write_checkpoint(out.path(), reader.head.recorded));
            (simulation.state_hash(), simulation.steps())
        });
        assert_eq!(hashes, vec![(hash, 40); ranks]);
        assert_eq!(records(&checkpoint::path(out.path(), 40)), records(&path), "{ranks} ranks");
    }
}

#[test]
fn frames_and_checkpoints_of_several_ranks_hold_every_particle_once() {
    let (folder, scene) = (folder(), laid_out(scene(CLOUD, &[]), ([3, 2, 2], 1)));
    let path = stopped(scene.clone(), LAYOUTS[0], 40, folder.path());
    let frames = [1, 3].map(|ranks| {
        let out = self::folder();
        let summaries = together(ranks, |mut network| {
            let (reader, _) = ok(last_checkpoint(&mut *network, folder.path()));
            let mut simulation = ok(Simulation::restore(network, scene.clone(), Isa::detect(), &reader));
            let recorder = ok(Recorder::create(out.path(), &mut simulation));
            ok(recorder.finish(&mut simulation, End::Completed))
        });
        let read = ok(Summary::read(&out.path().join("summary.json")));
        assert!(summaries.iter().all(|summary| summary.state_hash == read.state_hash));
        assert_eq!(read.ranks, ranks);
        let reader = ok(sinew::output::vtkhdf::Reader::open(&out.path().join("particles.vtkhdf")));
        let frame = ok(reader.frame(0));
        assert_eq!(read.particles, frame.identities.len() as u64);
        let mut rows: Vec<_> = (0..frame.identities.len())
            .map(|i| {
                let numbers = frame.columns.iter().flat_map(|(field, values)| {
                    values[i * field.components..][..field.components].iter().map(|x| x.to_bits())
                });
                let place = frame.positions[i].map(f32::to_bits);
                (frame.identities[i], frame.materials[i], place, numbers.collect::<Vec<u32>>())
            })
            .collect();
        rows.sort();
        (read.state_hash, read.more["updates"].clone(), rows)
    });
    assert_eq!(frames[0], frames[1]);
    assert!(path.exists());
}

#[test]
fn rank_0_that_cannot_write_stops_all_ranks() {
    let (folder, scene) = (folder(), laid_out(scene(CLOUD, &[]), ([3, 2, 2], 1)));
    let path = stopped(scene.clone(), LAYOUTS[0], 1, folder.path());
    let nowhere = folder.path().join("no/such/folder");
    let errors = together(3, |network| {
        let reader = ok(Reader::open_verified(&path));
        let mut simulation = ok(Simulation::restore(network, scene.clone(), Isa::detect(), &reader));
        simulation.write_checkpoint(&nowhere, Recorded::default()).expect_err("nowhere to write").to_string()
    });
    assert!(errors[0].starts_with("cannot create") && errors[0].contains("no/such/folder"), "{errors:?}");
    assert!(errors[1..].iter().all(|error| error.starts_with("rank 0: cannot create")), "{errors:?}");
    let errors = together(3, |network| {
        let reader = ok(Reader::open_verified(&path));
        let mut simulation = ok(Simulation::restore(network, scene.clone(), Isa::detect(), &reader));
        let created = Recorder::create(&path.join("below a file"), &mut simulation);
        created.map(|_| ()).expect_err("nowhere to write").to_string()
    });
    assert!(errors.iter().all(|error| error.contains("below a file")), "{errors:?}");
}
/// Runs to the end on some ranks, from a checkpoint if there is one, and writes one after `stop` steps.
fn on_ranks(ranks: usize, scene: &Scene, folder: &Path, stop: Option<u64>) -> Vec<(u64, String, u64, u64)> {
    together(ranks, |mut network| {
        let mut simulation = match stop {
            Some(_) => ok(Simulation::on(network, scene.clone(), Isa::detect())),
            None => {
                let (reader, _) = ok(last_checkpoint(&mut *network, folder));
                ok(Simulation::restore(network, scene.clone(), Isa::detect(), &reader))
            }
        };
        while stop.is_some_and(|stop| simulation.steps() < stop) {
            assert!(ok(simulation.step()), "the run ends too early");
        }
        if stop.is_some() {
            ok(simulation.write_checkpoint(folder, Recorded::default()));
        }
        let (hash, report, _, ticks) = end(&mut simulation);
        (hash, report, 0, ticks)
    })
}

#[test]
fn runs_on_other_numbers_of_ranks_go_on_with_the_same_bits() {
    for rates in ["common", "per-material"] {
        let scene = laid_out(scene(CLOUD, &[("run.rates", rates)]), ([3, 2, 2], 1));
        let (hash, report, _, ticks) = end(&mut ok(Simulation::new(scene.clone(), Isa::detect())));
        for (before, after) in [(1, 3), (3, 1), (2, 5), (5, 2)] {
            let folder = folder();
            for result in [
                on_ranks(before, &scene, folder.path(), Some(37)),
                on_ranks(after, &scene, folder.path(), None),
            ] {
                assert!(
                    result.iter().all(|r| *r == (hash, report.clone(), 0, ticks)),
                    "{before} and {after}"
                );
            }
        }
    }
}

#[test]
fn the_files_of_several_ranks_are_those_of_one() {
    // rows of all columns now and then, those of a probe with every step
    let probe = "[{ name = 'all', material = 'a', field = 'velocity', interval = 1e-12 }]";
    let every = [
        ("output.checkpoint.steps", "30"),
        ("output.frames", "4000"),
        ("output.history-every", "7"),
        ("output.period", "[{ frames-every = 1e-12, to = 1e-3 }]"),
        ("probe", probe),
    ];
    let scene = laid_out(scene(CLOUD, &every), ([3, 2, 2], 1));
    let folder = folder();
    let folders = [1, 3].map(|ranks| {
        let out = folder.path().join(ranks.to_string());
        together(ranks, |network| {
            let mut simulation = ok(Simulation::on(network, scene.clone(), Isa::detect()));
            let mut recorder = ok(Recorder::create(&out, &mut simulation));
            while ok(simulation.step()) {
                assert_eq!(ok(recorder.step(&mut simulation, false)), Next::Go);
            }
            ok(recorder.finish(&mut simulation, End::Completed));
        });
        out
    });
    let [one, several] = folders.each_ref().map(|folder| Summary { ranks: 0, ..timeless(folder) });
    assert_eq!(one, several);
    let output = sinew(&["compare", text(&folders[0]), text(&folders[1])]);
    assert!(output.status.success(), "{}", words(&output));
    assert_eq!(checkpoint::list(&folders[1]).len(), 2);
    let [one, several] = folders.each_ref().map(|out| ok(std::fs::read_to_string(out.join("history.csv"))));
    assert!(one == several, "rows of a probe alone, too");
    let alone = ok(Table::read(&folders[1].join("history.csv"))).column("residual_j").unwrap_or_default();
    assert!(alone.iter().filter(|x| x.is_nan()).count() > alone.len() / 2);
}

#[test]
fn a_signal_on_any_rank_stops_all_of_them() {
    let scene = laid_out(scene(CLOUD, &[]), ([3, 2, 2], 1));
    let folder = folder();
    let summaries = together(3, |network| {
        let mut simulation = ok(Simulation::on(network, scene.clone(), Isa::detect()));
        let mut recorder = ok(Recorder::create(folder.path(), &mut simulation));
        let mut next = Next::Go;
        while next == Next::Go && ok(simulation.step()) {
            let caught = simulation.network().rank() == 2 && simulation.steps() == 7;
            next = ok(recorder.step(&mut simulation, caught));
        }
        ok(recorder.finish(&mut simulation, End::Interrupted)).steps
    });
    assert_eq!(summaries, [7, 7, 7]);
    assert_eq!(ok(last_whole(folder.path())).path, checkpoint::path(folder.path(), 7));
}
