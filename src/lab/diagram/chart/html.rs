//! One page that needs nothing else: pictures, and a script that explains what is pointed at.
use super::Chart;
use crate::lab::diagram::ESTIMATE;
use crate::lab::diagram::svg::escape;
use serde_json::{Value, json};

const PAGE: &str = include_str!("page.html");

impl Chart<'_> {
    /// A page with this chart, and with another form of it to change to.
    ///
    /// # Errors
    /// More items than a picture can show.
    pub fn to_html(&self, title: &str, other: Option<&Chart<'_>>) -> Result<String, String> {
        self.drawable()?;
        let forms: Vec<&Chart<'_>> =
            std::iter::once(self).chain(other.filter(|o| o.drawable().is_ok())).collect();
        let pictures: String = forms
            .iter()
            .enumerate()
            .map(|(number, form)| {
                let hidden = if number > 0 { " hidden=\"hidden\"" } else { "" };
                format!(
                    "<div class=\"picture\" id=\"form{number}\"{hidden}>{}</div>\n",
                    form.draw(&format!("f{number}-"))
                )
            })
            .collect();
        let (tasks, graphs): (Vec<_>, Vec<_>) =
            (0..self.diagrams.len()).map(|it| self.graph_data(it)).unzip();
        let data = json!({
            "tasks": tasks.concat(), "graphs": graphs, "passes": self.json_passes(), "outline": self.program.to_string(),
            "forms": forms.iter().map(|form| form.data()).collect::<Vec<_>>(),
        });
        // JSON that is neither markup nor the end of the script, whatever the scene's names are
        let data = data.to_string().replace('&', "\\u0026").replace('<', "\\u003c").replace('>', "\\u003e");
        let title = escape(title);
        Ok(fill(PAGE, &[("TITLE@", &title), ("PICTURES@", &pictures), ("DATA@", &data)]))
    }

    /// The tasks of a graph, and what else the page tells about it in any form.
    fn graph_data(&self, number: usize) -> (Vec<Value>, Value) {
        let json = self.diagrams[number].shown().to_json();
        let mut tasks = json["tasks"].as_array().cloned().unwrap_or_default();
        tasks.iter_mut().for_each(|task| task["graph"] = json!(number));
        (tasks, json!({ "name": self.name(number), "pruned": json["pruned"] }))
    }

    /// What the page tells about a form.
    fn data(&self) -> Value {
        let (mut items, mut links, mut graphs) = (Vec::new(), Vec::new(), Vec::new());
        for (number, it) in self.diagrams.iter().enumerate() {
            items.extend(it.items.iter().map(|item| {
                let mut json = it.json_item(item);
                json["graph"] = json!(number);
                json
            }));
            links.extend(it.links.iter().map(|link| it.json_link(link)));
            graphs.push(json!({ "span": it.span(), "path_ns": it.path_ns, "report": it.report() }));
        }
        let (expanded, measured) =
            self.diagrams.first().map_or((false, false), |it| (it.expanded, it.measured.is_some()));
        json!({
            "name": if expanded { "expanded: one node a task and patch" } else { "collapsed: one node a task" },
            "items": items, "links": links, "graphs": graphs,
            "costs": if measured { "measured, where the trace has it" } else { ESTIMATE },
        })
    }
}

/// Puts texts into the places of a page: what a text says is no place.
fn fill(page: &str, places: &[(&str, &str)]) -> String {
    let (mut filled, mut rest) = (String::new(), page);
    while let Some((before, after)) = rest.split_once('@') {
        filled += before;
        match places.iter().find(|(name, _)| after.starts_with(name)) {
            Some((name, text)) => {
                filled += text;
                rest = &after[name.len()..];
            }
            None => {
                filled.push('@');
                rest = after;
            }
        }
    }
    filled + rest
}
