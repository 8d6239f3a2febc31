// What is said about a task, an exchange, a line, and the whole.
const tasks = new Map(data.tasks.map(task => [task.graph + "/" + task.id, task]));
const taskOf = it => tasks.get(it.graph + "/" + it.task);
const items = data.forms.map(one => new Map(one.items.map(it => [it.id, it])));
const item = id => items[form].get(id);
const strip = id => id.replace(/^f\d+-/, "");
const now = () => data.forms[form];

const text = value => String(value ?? "").replace(/[&<>"]/g, c => ({"&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;"})[c]);
// Words with `code`, *names* and indices such as S_Ip.
const prose = value => text(value).split(/(`[^`]*`)/).map(part => part.startsWith("`") ? `<code>${part.slice(1, -1)}</code>`
  : part.replace(/_\{([^}]+)\}|_([A-Za-z]+)/g, (_, a, b) => `<sub>${a ?? b}</sub>`).replace(/\*([^*]+)\*/g, "<i>$1</i>")).join("");
const number = n => n.toLocaleString("en-US");
const bytes = n => n < 1e3 ? n + " B" : n < 1e6 ? (n / 1e3).toFixed(1) + " kB" : n < 1e9 ? (n / 1e6).toFixed(1) + " MB" : (n / 1e9).toFixed(2) + " GB";
const time = ns => ns < 1e3 ? ns.toFixed(0) + " ns" : ns < 1e6 ? (ns / 1e3).toFixed(1) + " µs" : ns < 1e9 ? (ns / 1e6).toFixed(2) + " ms" : (ns / 1e9).toFixed(2) + " s";
const row = (name, value) => value === undefined || value === null || value === "" ? "" : `<dt>${text(name)}</dt><dd>${value}</dd>`;
const section = (title, rows, look = "") => rows.length ? `<section><h3>${text(title)}</h3><ul class="${look}">${rows.join("")}</ul></section>` : "";
const chip = words => words ? `<span class="chip">${text(words)}</span>` : "";
const head = (title, ...chips) => `<h2>${text(title)}${chips.map(chip).join("")}<button type="button" class="close" data-close="1" aria-label="Back to the whole graph">✕</button></h2>`;

const aboutOf = it => taskOf(it)?.about ?? it.about ?? "";
const nameOf = it => it.task === undefined ? it.kind_words : it.name;
const placeOf = it => it.patch !== undefined ? `patch ${it.patch}, rank ${it.rank}` : it.to_rank !== undefined ? `rank ${it.rank} to rank ${it.to_rank}` :
  it.rank !== undefined ? `rank ${it.rank}` : "";

const first = words => words.slice(0, words.search(/[.:]( |$)/) + 1 || words.length);

// Words first, and larger; then formulas and the rest.
function about(words) {
  const end = first(words).length;
  return words ? `<p class="about"><b>${prose(words.slice(0, end))}</b>${prose(words.slice(end))}</p>` : "";
}

// What a label is, in few words: without its parts.
const short = name => prose((data.labels[name]?.meaning ?? name).split(/[:,=]/)[0].trim());

function labelWords(name, ghost) {
  const label = data.labels[name];
  return `${prose(label?.meaning ?? name)} <small>[${text(label?.unit).replace(/\^(\d)/g, "<sup>$1</sup>")}] <code>${text(name)}</code></small>` + (ghost ? `<br/><small>${text(ghost)}</small>` : "");
}

function accessRow(a) {
  return `<li>${labelWords(a.label, a.ghosts)}<br/><small>${text(a.how)}; ${text(data.labels[a.label]?.kept)}</small></li>`;
}

// What passes to or from each other item, with a way to go there.
function neighbors(links, end) {
  const others = new Map();
  for (const link of links) others.set(link[end], [...others.get(link[end]) ?? [], link]);
  return [...others].map(([id, links]) => {
    const it = item(id), lines = links.map(link => link.why === "flow"
      ? `${short(link.label)}${link.ghost ? `, ${link.ghost} ghost layers` : ""}${link.bytes ? ", " + bytes(link.bytes) : ""}`
      : `${text(data.why[link.why])}: ${short(link.label)}`);
    const place = [it.material, placeOf(it)].filter(Boolean).join(", ");
    return `<li><button type="button" data-go="${text(id)}">${text(nameOf(it))}</button> <small>${text(place)}<br/>${lines.join("<br/>")}</small></li>`;
  });
}

function tellItem(id) {
  const it = item(id), task = taskOf(it);
  let facts = row("graph", data.graphs.length > 1 ? text(data.graphs[it.graph].name) : "") + row("where", text(placeOf(it)));
  if (task) {
    facts += row("runs over", `${text(task.over)}${it.work > 1 ? ` (${number(it.work)})` : ""}`) + row("when", text(data.when[task.when])) +
      row("because of", text(it.because || "every step has it"));
  } else {
    facts += row("messages", `${number(it.messages ?? 0)}, ${bytes(it.bytes ?? 0)}`);
  }
  facts += row(it.cost_is, `${time(it.cost_ns)} in ${text(now().graphs[it.graph].span)}`) +
    row("idle beside it", it.idle_ns === undefined ? "" : time(it.idle_ns)) + row("critical path", it.critical ? "yes: the step waits for it" : "no");
  const reads = task ? task.access.filter(a => !a.writes) : [], writes = task ? task.access.filter(a => a.writes) : [];
  const from = now().links.filter(link => link.to === id), to = now().links.filter(link => link.from === id);
  details.innerHTML = head(nameOf(it), it.kind === "task" ? "task" : "", it.material) + `<div class="parts"><section>${about(aboutOf(it))}<dl>${facts}</dl></section>` +
    section("Reads", reads.map(accessRow)) + section("Writes", writes.map(accessRow)) +
    section("Brings", (it.labels ?? []).map(label => `<li>${labelWords(label)}</li>`)) +
    "<div>" + section("Comes after", neighbors(from, "from")) + section("Comes before", neighbors(to, "to")) + "</div></div>";
}

const linksOf = element => element.dataset.links.split(" ").map(n => now().links[n]);
const linkWords = link => `${short(link.label)}${link.material ? " of " + text(link.material) : ""}` +
  `${link.ghost ? `, with ${link.ghost} ghost layers of grid nodes` : ""}${link.bytes ? ", " + bytes(link.bytes) : ""}`;

function tellLink(element) {
  const links = linksOf(element), end = (title, id) => `<section><h3>${title}</h3><ul><li><button type="button" data-go="${text(id)}">${text(nameOf(item(id)))}</button>` +
    `${about(aboutOf(item(id)))}</li></ul></section>`;
  details.innerHTML = head(`${nameOf(item(links[0].from))} → ${nameOf(item(links[0].to))}`) + `<div class="parts">` +
    section(data.why[links[0].why], links.map(link => `<li>${labelWords(link.label, link.ghost ? link.ghost + " ghost layers of grid nodes" : "")}` +
      `<br/><small>${text(link.material)} ${link.bytes ? bytes(link.bytes) : ""}</small></li>`)) + end("from", links[0].from) + end("to", links[0].to) + "</div>";
}

function tellPass(numbers) {
  const passes = numbers.map(n => data.passes[n]);
  const names = (graph, ids) => ids.map(id => tasks.get(graph + "/" + id).task).join(", ");
  details.innerHTML = head(`${data.graphs[passes[0].from].name} → ${data.graphs[passes[0].to].name}`, passes[0].when) + `<div class="parts">` +
    section("Passes on", passes.map(pass => `<li>${labelWords(pass.label)} ${chip(pass.material)}<br/><small>written by ${text(names(pass.from, pass.writers))}, ` +
      `read by ${text(names(pass.to, pass.readers))}</small></li>`)) + "</div>";
}

const KEYS = `<dl><dt><kbd>/</kbd></dt><dd>find; <kbd>Enter</kbd> opens, then goes on; <kbd>Shift</kbd> <kbd>Enter</kbd> back</dd>
<dt><kbd>←</kbd> <kbd>→</kbd></dt><dd>along the lines, to what comes before and after</dd><dt><kbd>↑</kbd> <kbd>↓</kbd></dt><dd>to the tasks above and below</dd>
<dt><kbd>Enter</kbd></dt><dd>opens a task; <kbd>Esc</kbd> goes back</dd><dt><kbd>+</kbd> <kbd>-</kbd> <kbd>0</kbd></dt><dd>larger, smaller, fit; wheel and two fingers, too</dd></dl>`;

function tellAll() {
  const one = now(), path = one.items.filter(it => it.critical);
  let facts = "", kept = "", report = "", passes = new Map();
  one.graphs.forEach((graph, n) => {
    const {name, pruned} = data.graphs[n], of = data.graphs.length > 1 ? name + ": " : "";
    const begins = new Set(data.passes.filter(pass => pass.to === n && pass.when === "next step").map(pass => short(pass.label)));
    facts += row(of + "critical path", `${time(graph.path_ns)} in ${text(graph.span)}`);
    kept += row(of + "from the step before", [...begins].join("; ")) + row(of + "left out", pruned.length ? text(pruned.join(", ")) + ": nobody needs it" : "");
    report += (of ? "graph " + name + "\n" : "") + graph.report;
  });
  data.passes.forEach((pass, n) => {
    const key = `${data.graphs[pass.from].name} → ${data.graphs[pass.to].name}, ${pass.when}`;
    passes.set(key, [...passes.get(key) ?? [], n]);
  });
  const each = new Map();
  for (const it of one.items) {
    const key = it.graph + nameOf(it) + aboutOf(it), known = each.get(key) ?? {it, materials: new Set()};
    each.set(key, known);
    if (it.material) known.materials.add(it.material);
  }
  const count = one.items.filter(it => it.kind === "task").length;
  details.innerHTML = `<h2>${number(count)} tasks${one.expanded ? " and patches" : ""}, and what passes between them</h2><div class="parts"><section>
<p class="about">A click, a tap or keys open a box or a line.</p><dl>${facts}</dl>` + section("The longest chain", path.map(it => `<li><button type="button" data-go="${text(it.id)}">${text(nameOf(it))}</button> <small>${[text(it.material), time(it.cost_ns)].filter(Boolean).join(", ")}</small></li>`), "chain") + "</section>" +
    (data.graphs.length > 1 ? section("From graph to graph", [...passes].map(([words, numbers]) => `<li><button type="button" data-pass="${numbers.join(" ")}">${text(words)}</button></li>`)) : "") +
    section("What each does", [...each.values()].map(({it, materials}) => `<li><button type="button" data-go="${text(it.id)}">${text(nameOf(it))}</button> ` +
      `<small>${text([...materials].join(", "))}<br/>${prose(first(aboutOf(it)).replace(/:$/, "."))}</small></li>`)) +
    `<section><h3>From where, and how long</h3><dl>${kept}${row("times", text(one.costs))}</dl></section><section class="keys"><h3>Keys</h3>${KEYS}</section></div><details class="report"><summary>Program, messages and times as text</summary><pre>${text(data.outline)}\n${text(report)}</pre></details>`;
}
