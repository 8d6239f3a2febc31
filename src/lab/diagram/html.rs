//! One page that needs nothing else: pictures, and a script that explains what is pointed at.
use super::svg::escape;
use super::{Diagram, ESTIMATE};
use serde_json::{Value, json};

const PAGE: &str = include_str!("page.html");

impl Diagram<'_> {
    /// A page with this diagram, and with another form of it to change to.
    ///
    /// # Errors
    /// More items than a picture can show.
    pub fn to_html(&self, title: &str, other: Option<&Diagram<'_>>) -> Result<String, String> {
        self.drawable()?;
        let forms: Vec<&Diagram<'_>> =
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
        let graph = self.shown().to_json();
        let data = json!({
            "tasks": graph["tasks"], "pruned": graph["pruned"], "carried": graph["carried"],
            "forms": forms.iter().map(|form| form.data()).collect::<Vec<_>>(),
        });
        // JSON that is neither markup nor the end of the script, whatever the scene's names are
        let data = data.to_string().replace('&', "\\u0026").replace('<', "\\u003c").replace('>', "\\u003e");
        let page = PAGE.replace("@TITLE@", &escape(title)).replace("@PICTURES@", &pictures);
        Ok(page.replace("@DATA@", &data))
    }

    /// What the page tells about a form.
    fn data(&self) -> Value {
        let path: Vec<&str> = self.path.iter().map(|&at| self.items[at].id.as_str()).collect();
        json!({
            "name": if self.expanded { "expanded: one node a task and patch" } else { "collapsed: one node a task" },
            "items": self.items.iter().map(|item| self.json_item(item)).collect::<Vec<_>>(),
            "links": self.links.iter().map(|link| self.json_link(link)).collect::<Vec<_>>(),
            "path": path, "path_ns": self.path_ns,
            "costs": if self.measured.is_some() { "measured, where the trace has it" } else { ESTIMATE },
            "report": self.report(),
        })
    }
}
