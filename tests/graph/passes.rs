//! Programs of several graphs and nested loops as people and programs see them, in every form.

use crate::toy::*;
use engine::graph::traffic::{Between, Passing, Traffic};
use engine::program::{Delay, Program};
use roxmltree::{Document, Node};
use serde_json::Value;
use sinew::lab::diagram::{Chart, Kind};
use sinew::simulation::rates::{Cycle, StepAtRest};
use std::collections::{BTreeMap, BTreeSet};

struct Shown {
    program: Program,
    cycle: Cycle,
    traffic: Traffic,
}

/// The nested program on two patches of two ranks, which send each other what nodes have.
fn shown() -> Shown {
    let own = vec![StepAtRest { size: 1.0, ticks: 1 }; 2];
    let cycle = Cycle { most: None, tick: 1.0, fastest: 0, own };
    let each = || vec![vec![800, 400]; 2];
    let nodes = |count| Passing { adders: 1, added: [count, 0], read: [count, 0], whole: [count, 0] };
    let passing = || -> Between { [(0, 1), (1, 0)].map(|pair| (pair, vec![nodes(64), nodes(32)])).into() };
    let beside = [(0, 1), (1, 0)];
    let traffic = Traffic {
        ranks: 2,
        rank_of: vec![0, 1],
        particles: each(),
        near: each(),
        blocks: vec![vec![2, 1]; 2],
        nodes: each(),
        fields: vec![1; 2],
        between: passing(),
        to_rank: passing(),
        neighbors: beside.into(),
        reduction: beside.into(),
        ..Traffic::default()
    };
    Shown { program: nested(), cycle, traffic }
}

impl Shown {
    fn chart(&self, expanded: bool) -> Chart<'_> {
        Chart::new(&self.program, &self.cycle, &self.traffic, None, expanded)
    }
}

/// Ids of all items of all graphs.
fn ids<'a>(chart: &'a Chart<'_>) -> BTreeSet<&'a str> {
    let items = || chart.diagrams.iter().flat_map(|diagram| &diagram.items);
    let ids: BTreeSet<&str> = items().map(|item| item.id.as_str()).collect();
    assert_eq!(ids.len(), items().count(), "ids are unique in the program");
    ids
}

fn links(chart: &Chart<'_>) -> usize {
    chart.diagrams.iter().map(|diagram| diagram.links.len()).sum()
}

#[test]
fn text_has_the_outline_and_then_each_graph() {
    let shown = shown();
    let text = shown.chart(false).to_text();
    let outline = "program toy
  graph start: 3 tasks
  loop until Done, at most 5 rounds
    loop until Close, at most 20 rounds
      graph iterate: 4 tasks
    graph update: 1 tasks
  graph collect: 2 tasks
";
    assert!(text.starts_with(&outline.replace("1 tasks", "1 task")), "{text}");
    let sections: Vec<&str> = text.split("\n\ngraph ").skip(1).collect();
    let names: Vec<&str> = sections.iter().filter_map(|section| section.lines().next()).collect();
    assert_eq!(names, ["start", "iterate", "update", "collect"]);
    let has = |section: usize, line: &str| {
        assert!(sections[section].lines().any(|it| it.starts_with(line)), "{line}: {}", sections[section]);
    };
    has(1, "takes from graph start: Field");
    has(1, "takes from graph iterate in the round before: Field");
    has(2, "takes from graph iterate: Residual");
    has(3, "takes from graph iterate: Field");
    has(0, "takes from graph collect in the step before: Load");
    // costs are those of what runs once: a round, or a step
    ["its run in a step", "one round", "one round", "its run in a step"]
        .iter()
        .enumerate()
        .for_each(|(number, of)| has(number, &format!("critical path of {of}: ")));
    has(1, "messages a round, ");
    has(2, "  none: it needs nothing of other ranks");
    assert!(!text.contains("relocation"), "no particle moves");
    let expanded = shown.chart(true).to_text();
    assert!(expanded.contains("  Push[iron] on patch 1, rank 1 "), "{expanded}");
}

/// Names of clusters with those around them.
fn clusters(dot: &str) -> BTreeMap<&str, Vec<&str>> {
    let (mut around, mut clusters): (Vec<&str>, _) = (Vec::new(), BTreeMap::new());
    for line in dot.lines().skip(1).map(str::trim) {
        if let Some(rest) = line.strip_prefix("subgraph ") {
            let name = rest.split(' ').next().unwrap_or_default();
            assert!(clusters.insert(name, around.clone()).is_none(), "{name} twice");
            around.push(name);
        } else if line == "}" {
            around.pop();
        }
    }
    clusters
}

#[test]
fn dot_has_clusters_of_loops_and_graphs_and_edges_between_them() {
    for expanded in [false, true] {
        let shown = shown();
        let chart = shown.chart(expanded);
        let dot = chart.to_dot();
        assert!(dot.starts_with("digraph \"toy\" {\n"));
        assert_eq!(dot.matches('{').count(), dot.matches('}').count());
        let clusters = clusters(&dot);
        for (name, around) in [
            ("cluster_loop0", &[][..]),
            ("cluster_loop1", &["cluster_loop0"]),
            ("cluster_graph0", &[]),
            ("cluster_graph1", &["cluster_loop0", "cluster_loop1"]),
            ("cluster_graph2", &["cluster_loop0"]),
            ("cluster_graph3", &[]),
        ] {
            assert_eq!(clusters[name], around, "{name}");
        }
        assert!(dot.contains("cluster_loop1 { label=\"loop until Close, at most 20 rounds\""));
        let ids = ids(&chart);
        ids.iter().for_each(|id| assert_eq!(dot.matches(&format!("  {id} [label=")).count(), 1, "{id}"));
        let ends = dot.lines().filter_map(|line| line.trim().split_once(" -> "));
        for (from, rest) in ends {
            let to = rest.split(' ').next().unwrap_or_default();
            assert!(ids.contains(from) && ids.contains(to), "{from} -> {to}");
        }
    }
}

#[test]
fn dot_leads_from_the_last_writer_to_the_first_reader() {
    let shown = shown();
    let chart = shown.chart(false);
    let dot = chart.to_dot();
    let id = |graph: usize, name: &str, material: Option<usize>| {
        let mut items = chart.diagrams[graph].items.iter();
        let item = items.find(|item| item.name.starts_with(name) && item.material == material);
        item.map(|item| item.id.clone()).unwrap_or_else(|| panic!("no {name}"))
    };
    let edge = |from: String, to: String| {
        let start = format!("{from} -> {to} [");
        let found = dot.lines().find(|line| line.trim().starts_with(&start));
        found.unwrap_or_else(|| panic!("no {start} in {dot}")).to_owned()
    };
    let onward = edge(id(0, "Solve", None), id(1, "Push", Some(WOOD)));
    assert!(onward.contains("label=\"Field\"") && !onward.contains("dashed"), "{onward}");
    let back = edge(id(1, "Correct", None), id(1, "Push", Some(IRON)));
    assert!(back.contains("label=\"Field\"") && back.contains("style=dashed"), "{back}");
    // ghosts come through the halo before the reader, which belongs to the graph that reads
    edge(id(0, "Solve", None), id(1, "Halo", None));
    edge(id(1, "Halo", None), id(1, "Push", Some(IRON)));
    // a reduction that is complete at the end of a graph
    edge(id(1, "Correct", None), id(2, "Finish", None));
}

#[test]
fn json_has_the_tree_and_all_graphs_by_number() {
    for expanded in [false, true] {
        let shown = shown();
        let chart = shown.chart(expanded);
        let json: Value = serde_json::from_str(&chart.to_json().to_string()).expect("JSON");
        let tree = serde_json::json!({ "name": "toy", "nodes": [
            { "kind": "graph", "name": "start", "graph": 0 },
            { "kind": "loop", "until": "Done", "most": 5, "body": [
                { "kind": "loop", "until": "Close", "most": 20, "body": [
                    { "kind": "graph", "name": "iterate", "graph": 1 },
                ] },
                { "kind": "graph", "name": "update", "graph": 2 },
            ] },
            { "kind": "graph", "name": "collect", "graph": 3 },
        ] });
        assert_eq!(json["program"], tree);
        let graphs = json["graphs"].as_array().expect("graphs");
        let names: Vec<_> = graphs.iter().map(|graph| graph["name"].as_str()).collect();
        assert_eq!(names, ["start", "iterate", "update", "collect"].map(Some));
        let spans: Vec<_> = graphs.iter().map(|graph| graph["critical_path"]["of"].as_str()).collect();
        assert_eq!(spans, ["its run in a step", "one round", "one round", "its run in a step"].map(Some));
        let all =
            |key: &str| graphs.iter().filter_map(|graph| graph[key].as_array()).map(Vec::len).sum::<usize>();
        assert_eq!((all("items"), all("links")), (ids(&chart).len(), links(&chart)));
        let passes = json["passes"].as_array().expect("passes");
        assert_eq!(passes.len(), chart.passes.len());
        let round = passes.iter().find(|pass| pass["when"] == "next round" && pass["material"] == "wood");
        let round = round.expect("Field goes on to the next round");
        assert_eq!((&round["from"], &round["to"], &round["label"]), (&1.into(), &1.into(), &"Field".into()));
        let task = |id: &Value| graphs[1]["tasks"].as_array().and_then(|t| t.iter().find(|t| t["id"] == *id));
        assert_eq!(task(&round["writers"][0]).map(|task| &task["task"]), Some(&"Correct".into()));
    }
}

#[derive(Clone, Copy, Debug)]
struct Area([f64; 4]);

impl Area {
    /// The rectangle of a node, moved.
    fn of(node: Node<'_, '_>, (dx, dy): (f64, f64)) -> Self {
        let rect = node.children().find(|child| child.has_tag_name("rect")).expect("a rectangle");
        let [x, y, w, h] = ["x", "y", "width", "height"]
            .map(|key| rect.attribute(key).expect(key).parse::<f64>().expect(key));
        Self([x + dx, y + dy, x + dx + w, y + dy + h])
    }
    fn holds(&self, other: &Area) -> bool {
        let ([a, b, c, d], [e, f, g, h]) = (self.0, other.0);
        a <= e && b <= f && g <= c && h <= d
    }
    fn apart(&self, other: &Area) -> bool {
        let ([a, b, c, d], [e, f, g, h]) = (self.0, other.0);
        c <= e || g <= a || d <= f || h <= b
    }
}

fn has_class(node: &Node<'_, '_>, class: &str) -> bool {
    node.attribute("class").is_some_and(|all| all.split(' ').any(|it| it == class))
}

#[test]
fn pictures_put_graphs_into_the_boxes_of_their_loops() {
    for expanded in [false, true] {
        let shown = shown();
        let chart = shown.chart(expanded);
        let svg = chart.to_svg().expect("a picture");
        let svg = Document::parse(&svg).unwrap_or_else(|e| panic!("{e}"));
        let of = |class: &'static str| svg.descendants().filter(move |node| has_class(node, class));
        let frames = |class| of(class).map(|node| Area::of(node, (0.0, 0.0))).collect::<Vec<_>>();
        let captions: Vec<_> = of("caption").filter_map(|node| node.text()).collect();
        let loops = ["loop until Done, at most 5 rounds", "loop until Close, at most 20 rounds"];
        assert!(loops.iter().all(|title| captions.contains(title)), "{captions:?}");
        let (rounds, graphs) = (frames("loop"), frames("graph"));
        assert_eq!((rounds.len(), graphs.len()), (2, 4));
        assert!(rounds[0].holds(&rounds[1]) && rounds[1].holds(&graphs[1]) && rounds[0].holds(&graphs[2]));
        assert!(rounds.iter().all(|it| it.apart(&graphs[0]) && it.apart(&graphs[3])));
        assert!(rounds[1].apart(&graphs[2]));
        for (a, b) in (0..4).flat_map(|a| (0..a).map(move |b| (a, b))) {
            assert!(graphs[a].apart(&graphs[b]), "graphs {a} and {b} overlap");
        }

        let mut drawn = BTreeSet::new();
        for node in of("item") {
            let id = node.attribute("id").expect("an id");
            let graph = id[1..2].parse::<usize>().expect("a graph");
            let moved = node.parent().and_then(|it| it.attribute("transform")).expect("a place");
            let moved: Vec<f64> =
                moved["translate(".len()..moved.len() - 1].split(' ').flat_map(str::parse).collect();
            assert!(graphs[graph].holds(&Area::of(node, (moved[0], moved[1]))), "{id} leaves its box");
            assert!(drawn.insert(id), "{id} twice");
        }
        assert_eq!(drawn, ids(&chart));
        let mut numbers: Vec<usize> = svg
            .descendants()
            .filter_map(|node| node.attribute("data-links"))
            .flat_map(|list| list.split(' ').flat_map(str::parse))
            .collect();
        numbers.sort_unstable();
        assert_eq!(numbers, (0..links(&chart)).collect::<Vec<_>>());
        // what passes within a step, and no line of text upon another
        let within = chart.passes.iter().filter(|pass| pass.delay != Delay::NextStep).count();
        let shown =
            of("pass").filter_map(|node| node.attribute("data-passes")).flat_map(|list| list.split(' '));
        assert_eq!(shown.count(), within);
        let texts = of("pass").flat_map(|node| node.children()).filter(|node| node.has_tag_name("text"));
        let mut heights: Vec<f64> = texts.filter_map(|node| node.attribute("y")?.parse().ok()).collect();
        heights.sort_by(f64::total_cmp);
        assert!(heights.windows(2).all(|pair| pair[1] - pair[0] >= 12.0), "{heights:?}");
    }
}

#[test]
fn a_page_knows_all_graphs_and_what_passes_between_them() {
    let shown = shown();
    let (collapsed, expanded) = (shown.chart(false), shown.chart(true));
    let page = collapsed.to_html("toy", Some(&expanded)).expect("a page");
    let page = page.strip_prefix("<!DOCTYPE html>\n").expect("the document type");
    let page = Document::parse(page).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(page.descendants().filter(|node| has_class(node, "loop")).count(), 4);
    let data = page.descendants().find(|n| n.attribute("id") == Some("data")).and_then(|n| n.text());
    let data: Value = serde_json::from_str(data.expect("data")).expect("JSON");
    let list = |value: &Value| value.as_array().map_or(0, Vec::len);
    assert_eq!((list(&data["graphs"]), list(&data["forms"]), list(&data["tasks"])), (4, 2, 10));
    assert_eq!(list(&data["passes"]), collapsed.passes.len());
    for (form, chart) in [&collapsed, &expanded].into_iter().enumerate() {
        let items = data["forms"][form]["items"].as_array().expect("items");
        assert_eq!((items.len(), list(&data["forms"][form]["links"])), (ids(chart).len(), links(chart)));
        // each task's item leads to the task of its own graph
        for item in items.iter().filter(|item| item["kind"] == "task") {
            let mine = |task: &&Value| (&task["graph"], &task["id"]) == (&item["graph"], &item["task"]);
            let task = data["tasks"].as_array().and_then(|tasks| tasks.iter().find(mine)).expect("a task");
            assert_eq!(task["task"], item["name"]);
        }
    }
}

#[test]
fn a_part_of_a_program_keeps_what_is_beside_it_in_every_graph() {
    let shown = shown();
    let mut part = shown.chart(true);
    let all = links(&part);
    part.keep(|item| item.patch == Some(1));
    for diagram in &part.diagrams {
        let beside =
            |item: &&sinew::lab::diagram::Item| item.patch != Some(1) && matches!(item.kind, Kind::Task(_));
        assert!(
            diagram.items.iter().filter(beside).all(|item| item.patch.is_none()),
            "{}",
            diagram.graph.name
        );
    }
    assert!(links(&part) < all);
    Document::parse(&part.to_svg().expect("a picture")).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(clusters(&part.to_dot())["cluster_graph1"], ["cluster_loop0", "cluster_loop1"]);
}
