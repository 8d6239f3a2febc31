// Search: what is found is marked, counted, and brought into the window.
let matches = [], at = -1, opened = false;

// How well an item fits some words: by its name, then by what it works with, then by what it does; 0: not at all.
function fits(it, word) {
  const has = texts => texts.some(one => one && one.toLowerCase().includes(word)), name = nameOf(it).toLowerCase(), task = taskOf(it);
  if (name === word || it.title.toLowerCase() === word) return 5;
  if (name.startsWith(word)) return 4;
  if (has([name, it.title, it.name])) return 3;
  const labels = [...it.labels ?? [], ...task ? task.access.map(a => a.label) : []];
  if (has([it.material, ...labels, ...labels.map(label => data.labels[label]?.meaning)])) return 2;
  return has([aboutOf(it)]) ? 1 : 0;
}

function search() {
  const word = $("find").value.trim().toLowerCase();
  picture().querySelectorAll(".found,.current").forEach(e => e.classList.remove("found", "current"));
  const found = word ? now().items.map(it => [fits(it, word), it]).filter(([how]) => how) : [];
  found.sort(([a], [b]) => b - a);
  matches = found.map(([, it]) => $(`f${form}-${it.id}`));
  matches.forEach(element => element.classList.add("found"));
  opened = false;
  show(matches.length ? 0 : -1);
}

// Brings a match into the window.
function show(number) {
  matches[at]?.classList.remove("current");
  at = number;
  const word = $("find").value.trim();
  $("count").textContent = !word ? "" : matches.length ? `${at + 1} of ${matches.length}` : "none";
  if (at < 0) return;
  matches[at].classList.add("current");
  revealReadable(matches[at].querySelector("rect"));
}

// The first time opens what is shown, then goes on to the next, or back.
function go_on(step) {
  if (!matches.length) return;
  if (opened) show((at + step + matches.length) % matches.length);
  opened = true;
  choose(matches[at]);
  revealReadable(matches[at].querySelector("rect"));
}

function clearSearch() {
  $("find").value = "";
  search();
}

$("find").addEventListener("input", search);
$("find").addEventListener("keydown", e => {
  if (e.key === "Enter") go_on(e.shiftKey ? -1 : 1);
  else if (e.key === "Escape") {
    clearSearch();
    (chosen?.classList.contains("item") ? chosen : picture().querySelector(".item[tabindex='0']"))?.focus({preventScroll: true});
  } else return;
  e.preventDefault();
});
$("next").addEventListener("click", () => go_on(1));
$("previous").addEventListener("click", () => go_on(-1));

// Which lines are drawn, and which form.
document.querySelectorAll(".kind").forEach(box => box.addEventListener("change", () => pictures.classList.toggle("no-" + box.value, !box.checked)));
const select = $("form");
data.forms.forEach((one, n) => select.add(new Option(one.name, n)));
select.hidden = data.forms.length < 2;
select.addEventListener("change", () => {
  choose(null);
  $("form" + form).hidden = true;
  form = Number(select.value);
  $("form" + form).hidden = false;
  prepare(form);
  dock();
  fit();
  choose(null);
  search();
});

togglePanel(true);
prepare(form);
dock();
fit();
tellAll();
