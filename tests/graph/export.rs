//! The graph as people and programs see it: every form holds every task.

use crate::shown::shown;
use sinew::lab::diagram::{Diagram, Kind, MOST_DRAWN};
use std::collections::BTreeSet;

/// The elements of a class in a picture: their ids.
fn ids(document: &roxmltree::Document<'_>, class: &str) -> Vec<String> {
    let all = document
        .descendants()
        .filter(|n| n.attribute("class").is_some_and(|c| c.split(' ').any(|c| c == class)));
    all.map(|node| node.attribute("id").unwrap_or_default().to_owned()).collect()
}

#[test]
fn every_form_holds_every_item_and_link_once() {
    for (overrides, expanded) in
        [(&[][..], false), (&[][..], true), (&[("run.rates", "per-material")][..], false)]
    {
        let shown = shown("slab-quick", overrides, [2, 1, 2], 3);
        let diagram = shown.diagram(expanded);
        let names: BTreeSet<&str> = diagram.items.iter().map(|item| item.id.as_str()).collect();
        assert_eq!(names.len(), diagram.items.len(), "ids are unique");

        let chart = shown.chart(expanded);
        let svg = chart.to_svg().expect("a picture");
        let svg = roxmltree::Document::parse(&svg).unwrap_or_else(|e| panic!("{e}"));
        let drawn = ids(&svg, "item");
        assert_eq!(drawn.len(), names.len());
        assert_eq!(drawn.iter().map(String::as_str).collect::<BTreeSet<_>>(), names);
        let links = svg.descendants().filter_map(|n| n.attribute("data-links"));
        let mut links: Vec<usize> = links.flat_map(|l| l.split(' ').filter_map(|n| n.parse().ok())).collect();
        links.sort_unstable();
        assert_eq!(links, (0..diagram.links.len()).collect::<Vec<_>>());

        let dot = chart.to_dot();
        assert_eq!(dot.matches('{').count(), dot.matches('}').count());
        names.iter().for_each(|id| assert_eq!(dot.matches(&format!("  {id} [label=")).count(), 1, "{id}"));
        let within = dot.lines().filter(|line| line.contains(" -> ") && !line.contains("next round"));
        assert_eq!(within.count(), diagram.links.len());

        let json: serde_json::Value = serde_json::from_str(&chart.to_json().to_string()).expect("JSON");
        assert_eq!(json["items"].as_array().map(Vec::len), Some(names.len()));
        assert_eq!(json["links"].as_array().map(Vec::len), Some(diagram.links.len()));
        let ends = json["links"].as_array().expect("links").iter().flat_map(|l| [&l["from"], &l["to"]]);
        assert!(ends.filter_map(|id| id.as_str()).all(|id| names.contains(id)));

        let abouts = json["tasks"].as_array().expect("tasks").iter().map(|task| task["about"].as_str());
        assert!(abouts.into_iter().all(|about| about.is_some_and(|about| !about.is_empty())));

        let text = chart.to_text();
        for item in diagram.items.iter().filter(|_| expanded) {
            let title = format!("  {} ", diagram.title(item));
            assert!(text.lines().any(|line| line.starts_with(&title)), "{title}: {text}");
        }
    }
}

#[test]
fn the_page_is_well_formed_whatever_names_are_in_it_and_needs_no_network() {
    let mut shown = shown("slab-quick", &[], [2, 1, 1], 2);
    shown.program.graphs_mut()[0].recipe.materials[0] = "</script> & \"co\"".to_owned();
    let (collapsed, expanded) = (shown.chart(false), shown.chart(true));
    let page = collapsed.to_html("a <b> & c", Some(&expanded)).expect("a page");
    let body = page.strip_prefix("<!DOCTYPE html>\n").expect("the document type");
    let document = roxmltree::Document::parse(body).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(
        ids(&document, "item").len(),
        collapsed.diagrams[0].items.len() + expanded.diagrams[0].items.len()
    );
    let data = document.descendants().find(|n| n.attribute("id") == Some("data")).and_then(|n| n.text());
    let data: serde_json::Value = serde_json::from_str(data.expect("data")).expect("JSON");
    assert_eq!(data["forms"].as_array().map(Vec::len), Some(2));
    assert_eq!(data["tasks"][1]["material"], "</script> & \"co\"");
    assert_eq!(data["tasks"][1]["task"], "Weights");
    let about = data["tasks"][1]["about"].as_str().expect("a sentence");
    assert!(about.starts_with("The weights of the grid nodes around each particle"), "{about}");
    assert_eq!(data["labels"]["Deformation"]["meaning"], "deformation gradient F_p, row by row");
    for word in ["RequiresOld", "NearParticles", "Modifies"] {
        assert!(!page.contains(word), "{word} is no word of the field");
    }
    let outside = page.matches("http").count() - page.matches("http://www.w3.org/2000/svg").count();
    assert_eq!(outside, 0);
}

#[test]
fn the_critical_path_is_the_longest() {
    for expanded in [false, true] {
        let shown = shown("slab-quick", &[], [2, 1, 1], 2);
        let diagram = shown.diagram(expanded);
        // all chains, shortest first, until nothing gets longer; a reduction waits for all its parts
        let mut end: Vec<f64> = diagram.items.iter().map(|item| item.cost).collect();
        loop {
            let before = end.clone();
            for link in &diagram.links {
                let to = link.to;
                end[to] = end[to].max(end[link.from] + diagram.items[to].cost);
            }
            for (a, item) in diagram.items.iter().enumerate() {
                for (b, other) in diagram.items.iter().enumerate() {
                    if matches!(item.kind, Kind::Reduction(_)) && item.kind == other.kind {
                        end[a] = end[a].max(end[b] - other.cost + item.cost);
                    }
                }
            }
            if before == end {
                break;
            }
        }
        let longest = end.into_iter().fold(0.0, f64::max);
        assert!((diagram.path_ns / longest - 1.0).abs() < 1e-12, "{} {longest}", diagram.path_ns);
        let marked: Vec<usize> = (0..diagram.items.len()).filter(|&at| diagram.items[at].critical).collect();
        let path: BTreeSet<usize> = diagram.path.iter().copied().collect();
        assert_eq!(marked, path.into_iter().collect::<Vec<_>>());
    }
}

#[test]
fn a_part_of_an_expanded_graph_is_a_patch_with_what_is_beside_it() {
    let shown = shown("slab-quick", &[], [2, 1, 2], 2);
    let all = shown.diagram(true);
    let mut chart = shown.chart(true);
    chart.keep(|item| item.patch == Some(1));
    let part = &chart.diagrams[0];
    let mine = |diagram: &Diagram<'_>| diagram.items.iter().filter(|item| item.patch == Some(1)).count();
    assert!(mine(part) == mine(&all) && part.items.len() < all.items.len());
    assert!(part.items.iter().any(|item| matches!(item.kind, Kind::Halo(_))));
    assert!(part.links.iter().all(|l| [l.from, l.to].iter().any(|&at| part.items[at].patch == Some(1))));
    roxmltree::Document::parse(&chart.to_svg().expect("a picture")).unwrap_or_else(|e| panic!("{e}"));
}

#[test]
fn what_nobody_can_look_at_is_not_drawn() {
    let shown = shown("slab-quick", &[("domain.cell", "0.5 mm")], [12, 22, 12], 2);
    let chart = shown.chart(true);
    assert!(chart.diagrams[0].items.len() > MOST_DRAWN);
    let error = chart.to_svg().expect_err("too large");
    assert!(error.contains("--patch P") && error.contains("json"), "{error}");
    assert!(shown.chart(false).to_html("t", Some(&chart)).is_ok(), "the small form alone");
}

#[test]
fn why_answers_for_labels_and_edges() {
    let shown = shown("slab-quick", &[], [1, 1, 1], 1);
    let label = shown.graph().why_label("nodemotion").join("\n");
    for word in
        ["NodeMotion [m/s, kg]", "Requires by Gather[lead] with 3 ghost layers", "Modifies by Boundary"]
    {
        assert!(label.contains(word), "{label}");
    }
    let edge = shown.graph().why_edge("Weights[lead]", "Scatter[lead]");
    assert_eq!(edge, ["Weights[lead] -> Scatter[lead]: flow, Weights of lead"]);
    assert!(shown.graph().why_edge("Advance", "Weights[lead]").is_empty(), "not in this order");
    assert!(shown.graph().why_label("Nonsense").is_empty() && shown.graph().why_edge("A", "B").is_empty());
}

#[test]
fn each_task_says_what_it_does_in_a_sentence() {
    for problem in
        ["slab", "slab-rigid", "cantilever", "taylor-rod", "tension", "two-spheres", "sliding-block"]
    {
        let shown = shown(problem, &[], [1, 1, 1], 1);
        for node in shown.program.graphs().iter().flat_map(|graph| graph.graph.node_weights()) {
            let (name, about) = (node.declaration.name, node.declaration.about);
            let first = about.split(' ').next().unwrap_or_default();
            assert!(about.ends_with(['.', ')']) && about.starts_with(char::is_uppercase), "{name}: {about}");
            assert!(
                first.chars().all(char::is_alphabetic) && !about.contains("  "),
                "{name} begins with words: {about}"
            );
            assert_eq!(shown.program.graphs().iter().find_map(|graph| graph.about(name)), Some(about));
        }
    }
}

#[test]
fn a_sentence_of_several_lines_is_one_line() {
    use crate::toy::Load;
    use engine::graph::task::Runnable;
    engine::task! {
        /// Says it in words:
        /// and goes on.
        ///
        /// With a paragraph, and "quotes".
        pub struct Says;

        Particles task {
            modifies { load: Load }
        }
    }
    impl engine::graph::task::Body for Says {
        fn run<S: simd::Simd>(&self, _at: &engine::graph::task::At<'_>, _io: Io<'_>) {}
    }
    let declaration = Says.declaration();
    assert_eq!(declaration.name, "Says");
    assert_eq!(declaration.about, "Says it in words: and goes on. With a paragraph, and \"quotes\".");
}
