//! Traces: what workers of several ranks record comes back from the file as sums, and the file is what Perfetto reads.

use crate::common;
use engine::exec::ranks::local::Local;
use engine::exec::ranks::{Alone, Network};
use engine::exec::recorder::{Recorder, Track};
use engine::exec::trace::{Event, Kind};
use engine::graph::build::TaskGraph;
use sinew::lab::diagram::{Diagram, Kind as Item, Source};
use sinew::lab::plan::plan;
use sinew::lab::scale::tally;
use sinew::output::trace::measured::{About, Measured};
use sinew::output::trace::{read, write};
use sinew::simulation::{rates, step_graph};
use std::path::Path;
use std::time::Duration;

fn graph() -> TaskGraph {
    step_graph(&common::problem("slab-quick", &[]), 2).unwrap_or_else(|e| panic!("{e}"))
}

/// Two steps of a rank as an executor would record them, with `many` events of a stage on worker 1.
fn record(graph: &TaskGraph, recorder: &Recorder, many: usize) {
    let nap = || std::thread::sleep(Duration::from_micros(200));
    let stage = &graph.phases[1].stages[0];
    for step in 1..3 {
        recorder.set_step(step);
        let began = recorder.now();
        nap();
        recorder.record(0, began, Event::stage(stage).on_patch(1).on_slab(0));
        let began = recorder.now();
        nap();
        recorder.record(0, began, Event::halo(2).sent(3, 4096));
        let began = recorder.now();
        recorder.record(0, began, Event::stage(&graph.phases[2].stages[0]));
        let began = recorder.now();
        recorder.record(0, began, Event::reduction(None).sent(1, 64));
        recorder.record(0, recorder.now(), Event::other(Kind::Relocate));
        recorder.record(0, recorder.now(), Event::other(Kind::Output));
        recorder.record(1, recorder.now(), Event::idle(stage));
        (0..many).for_each(|_| recorder.record(1, recorder.now(), Event::stage(stage)));
    }
}

/// Writes the trace of `ranks` ranks with two workers each; rank r records r times `many` more events.
fn traced(path: &Path, graph: &TaskGraph, ranks: usize, many: usize) {
    std::thread::scope(|scope| {
        for mut rank in Local::crew(ranks) {
            scope.spawn(move || {
                let recorder = Recorder::new(2, 100_000);
                record(graph, &recorder, many * rank.rank());
                write(path, "it", &[graph], &recorder, &mut rank).unwrap_or_else(|e| panic!("{e}"));
            });
        }
    });
}

fn json(path: &Path) -> serde_json::Value {
    serde_json::from_str(&std::fs::read_to_string(path).expect("a trace")).expect("JSON")
}

#[test]
fn the_file_is_in_the_trace_event_format() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (path, graph) = (folder.path().join("trace.json"), graph());
    traced(&path, &graph, 3, 5);
    let trace = json(&path);
    let events = trace["traceEvents"].as_array().expect("events");
    let mut names = 0;
    for event in events {
        let phase = event["ph"].as_str().expect("ph");
        assert!(event["name"].is_string() && event["pid"].is_u64() && event["tid"].is_u64(), "{event}");
        assert!(event["ts"].as_f64().is_some_and(|ts| ts >= 0.0), "{event}");
        match phase {
            "X" => {
                assert!(event["dur"].as_f64().is_some_and(|dur| dur >= 0.0), "{event}");
                assert!(event["cat"].is_string() && event["args"]["step"].is_u64(), "{event}");
            }
            "M" => {
                let known = ["process_name", "process_sort_index", "thread_name"];
                assert!(known.contains(&event["name"].as_str().expect("a name")), "{event}");
                names += usize::from(event["name"] == "thread_name");
            }
            "C" => assert!(event["args"]["bytes"].as_u64().is_some_and(|bytes| bytes > 0), "{event}"),
            other => panic!("{other}"),
        }
    }
    assert_eq!(names, 6, "each worker has a name");
    let complete = events.iter().filter(|event| event["ph"] == "X").count();
    assert_eq!(complete, 3 * 2 * 7 + 2 * 5 * (1 + 2));
    let has = |name: &str| events.iter().any(|event| event["name"] == name);
    for name in
        ["Weights … FoldSurfaces", "halo: NodeSums, ContactSums", "relocate", "output", "idle", "bytes sent"]
    {
        assert!(has(name), "{name}");
    }
}

fn sum<'a>(measured: &'a Measured, about: &About) -> &'a sinew::output::trace::measured::Sum {
    measured.sum(about).unwrap_or_else(|| panic!("{about:?} is not in {measured:?}"))
}

#[test]
fn what_is_written_is_read_and_more_than_one_message_arrives() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (path, graph) = (folder.path().join("trace.json"), graph());
    traced(&path, &graph, 2, 20_000);
    let measured = read(&path).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!((measured.steps, measured.lost), (2, 0));
    let tasks = [
        "Weights",
        "MassFlow",
        "StressFlow",
        "Scatter",
        "ContactFlow",
        "ContactScatter",
        "Fold",
        "FoldSurfaces",
    ];
    let tissue = (tasks.map(str::to_owned).to_vec(), Some("tissue".to_owned()));
    let stage = sum(&measured, &About::Stage(tissue.0.clone(), tissue.1.clone()));
    assert_eq!(stage.events, 4 + 2 * 20_000);
    assert!(stage.ns >= 4.0 * 200e3);
    let halo = sum(&measured, &About::Halo(2));
    assert_eq!((halo.events, halo.messages, halo.bytes), (4, 12, 4 * 4096));
    assert_eq!(sum(&measured, &About::Reduction(None)).messages, 4);
    assert_eq!(sum(&measured, &About::Idle(tissue.0, tissue.1)).events, 4);
    assert_eq!(
        measured.workers.iter().map(|w| (w.rank, w.thread)).collect::<Vec<_>>(),
        [(0, 0), (0, 1), (1, 0), (1, 1)]
    );
    for worker in &measured.workers {
        let all = worker.busy_ns + worker.wait_ns + worker.idle_ns;
        assert!((all - measured.span_ns).abs() < 1.0 || all > measured.span_ns, "{worker:?}");
        assert_eq!(worker.wait_ns > 0.0, worker.thread == 0);
    }
}

#[test]
fn a_diagram_takes_its_times_from_the_trace() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (path, graph) = (folder.path().join("trace.json"), graph());
    traced(&path, &graph, 1, 0);
    let measured = read(&path).unwrap_or_else(|e| panic!("{e}"));
    let scene = common::problem("slab-quick", &[]);
    let (plan, cycle) = (plan(&scene, 2, 1).expect("a plan"), rates::at_rest(&scene));
    for expanded in [false, true] {
        let make = if expanded { Diagram::expanded } else { Diagram::collapsed };
        let diagram = make(&graph, &cycle, &plan.traffic, Some(&measured));
        let nodes = graph.phases[1].stages[0].nodes.iter();
        let of_stage: Vec<_> = nodes.flat_map(|&n| diagram.of(Item::Task(n))).collect();
        let costs: f64 = of_stage.iter().map(|item| item.cost).sum();
        assert!(
            !of_stage.is_empty()
                && of_stage.iter().all(|item| item.source == Source::Split && item.idle.is_some())
        );
        let tasks: Vec<String> = graph.phases[1].stages[0]
            .nodes
            .iter()
            .map(|&n| graph.graph[n].declaration.name.to_owned())
            .collect();
        let whole = sum(&measured, &About::Stage(tasks, Some("tissue".to_owned()))).ns / 2.0;
        assert!((costs / whole - 1.0).abs() < 1e-9, "tasks share the time of their stage: {costs} {whole}");
        let lead = graph.phases[1].stages[1].nodes[0];
        assert!(
            diagram.of(Item::Task(lead)).all(|item| item.source == Source::Estimated && item.cost > 0.0),
            "an estimate"
        );
    }
    let text = Diagram::collapsed(&graph, &cycle, &plan.traffic, Some(&measured)).report();
    for words in ["mean times a step", "rank thread", "waits ", "(estimated)", "(split)", "2 steps"] {
        assert!(text.contains(words), "{words}: {text}");
    }
}

#[test]
fn estimates_take_the_pace_that_was_measured() {
    let (graph, scene) = (graph(), common::problem("slab-quick", &[]));
    let (plan, cycle) = (plan(&scene, 2, 1).expect("a plan"), rates::at_rest(&scene));
    let mut diagram = Diagram::collapsed(&graph, &cycle, &plan.traffic, None);
    let (work, path) = (diagram.work_ns(), diagram.path_ns);
    let others = path
        - diagram
            .path
            .iter()
            .map(|&at| &diagram.items[at])
            .filter(|item| matches!(item.kind, Item::Task(_)))
            .map(|item| item.cost)
            .sum::<f64>();
    diagram.set_pace(3.0, "measured somewhere");
    assert!((diagram.work_ns() / work - 3.0).abs() < 1e-9);
    // what is no task keeps its time
    assert!(((diagram.path_ns - others) / (path - others) - 3.0).abs() < 1e-9, "{path} {}", diagram.path_ns);
    assert!(diagram.report().contains("measured somewhere"));
}

#[test]
fn events_that_do_not_fit_are_counted_to_the_end() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (path, graph) = (folder.path().join("trace.json"), graph());
    let recorder = Recorder::new(2, 4);
    record(&graph, &recorder, 10);
    write(&path, "it", &[&graph], &recorder, &mut Alone).unwrap_or_else(|e| panic!("{e}"));
    let measured = read(&path).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(measured.lost, 2 * 6 - 4 + 2 * 11 - 4);
    assert!(measured.table().contains("did not fit"));
    assert_eq!(recorder.take(), [Track::default(), Track::default()], "written once");
}

#[test]
fn what_is_no_trace_is_refused_in_words() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("trace.json");
    let problem = |text: &str| {
        std::fs::write(&path, text).expect("a file");
        read(&path).expect_err("no trace").to_string()
    };
    assert!(problem("no JSON").contains("sinew run --trace"));
    assert!(problem("{\"traceEvents\": []}").contains("holds no events"));
    let missing = read(&folder.path().join("none.json")).expect_err("no file").to_string();
    assert!(missing.contains("cannot open") && missing.contains("none.json"), "{missing}");
    let graph = graph();
    let unwritable =
        write(&folder.path().join("no/such/trace.json"), "it", &[&graph], &Recorder::new(1, 1), &mut Alone);
    assert!(unwritable.expect_err("no folder").to_string().contains("cannot create"));
}

/// A file may say anything: of more ranks than a list of them has room for, and of more bytes than can be counted.
#[test]
fn traces_that_no_run_wrote_are_refused_or_summed_up() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("trace.json");
    let event = |more: &str| format!(r#"{{"ph":"X","cat":"halo wait","ts":1,"dur":1,{more}}}"#);
    let write = |lines: &[String]| {
        std::fs::write(&path, format!(r#"{{"traceEvents":[{}]}}"#, lines.join(","))).expect("a file");
    };
    for place in ["\"pid\":18446744073709551615", "\"pid\":1099511627776", "\"tid\":18446744073709551615"] {
        write(&[event(place), event("\"args\":{\"step\":1}")]);
        for error in [read(&path).map(drop), tally::read(&path, 0).map(drop)] {
            let error = error.expect_err("no such rank").to_string();
            assert!(error.contains("trace.json: not a trace"), "{error}");
        }
    }
    let many =
        event("\"args\":{\"step\":1,\"bytes\":18446744073709551615,\"messages\":18446744073709551615}");
    write(&[many.clone(), many, event("\"args\":{\"step\":2}")]);
    let measured = read(&path).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(measured.sums[0].1.bytes, u64::MAX);
    assert_eq!(tally::read(&path, 0).unwrap_or_else(|e| panic!("{e}")).ranks[0].bytes, u64::MAX);
}
