// What is chosen, what is pointed at, and how keys go from one to another.
let chosen = null;
const beside = new Map();

// The lines at each item of a form, and its box in the picture.
function around(number) {
  if (!beside.has(number)) {
    const at = new Map();
    for (const element of $("form" + number).querySelectorAll(".item")) {
      const rect = element.querySelector("rect"), shift = element.parentNode.transform?.baseVal.consolidate()?.matrix;
      const [x, y] = ["x", "y"].map(name => Number(rect.getAttribute(name)));
      at.set(element.id, {element, x: x + (shift?.e ?? 0), y: y + (shift?.f ?? 0), after: [], before: [], links: []});
    }
    for (const link of $("form" + number).querySelectorAll(".link")) {
      const from = at.get(link.dataset.from), to = at.get(link.dataset.to);
      from.after.push({link, other: to});
      to.before.push({link, other: from});
      from.links.push(link);
      to.links.push(link);
    }
    beside.set(number, at);
  }
  return beside.get(number);
}
const nearBy = element => around(form).get(element.id);

// Keys reach the items, screen readers say what they are.
function prepare(number) {
  if (beside.has(number)) return;
  for (const {element} of around(number).values()) {
    const it = items[number].get(strip(element.id));
    element.setAttribute("role", "button");
    element.setAttribute("tabindex", "-1");
    element.setAttribute("aria-label", [nameOf(it), it.material, placeOf(it), aboutOf(it)].filter(Boolean).join(". "));
  }
  around(number).values().next().value?.element.setAttribute("tabindex", "0");
}

// Makes an item the one that Tab comes to.
function stop(element) {
  picture().querySelectorAll(".item[tabindex='0']").forEach(e => e.setAttribute("tabindex", "-1"));
  element.setAttribute("tabindex", "0");
}

function mark(target) {
  const svg = picture();
  svg.querySelectorAll(".chosen,.near").forEach(e => e.classList.remove("chosen", "near"));
  svg.classList.toggle("focused", Boolean(target) && !target.classList.contains("pass"));
  if (!target) return;
  const isItem = target.classList.contains("item"), links = isItem ? nearBy(target).links : target.classList.contains("link") ? [target] : [];
  for (const link of links) {
    link.classList.add("chosen");
    for (const id of [link.dataset.from, link.dataset.to]) $(id).classList.add("near");
  }
  target.classList.add("chosen", "near");
}

// Opens an item, a line, or (null) the whole.
function choose(target) {
  chosen = target;
  mark(target);
  hideTip();
  details.scrollTop = panel.scrollTop = 0;
  if (!target) return tellAll();
  if (target.classList.contains("item")) {
    tellItem(strip(target.id));
    stop(target);
  } else if (target.classList.contains("link")) tellLink(target);
  else tellPass(target.dataset.passes.split(" "));
  togglePanel(true);
  if (!target.classList.contains("pass")) reveal(target.querySelector("rect,path"));
}

const what = e => e.target.closest?.(".item,.link,.pass");

function tip(target, x, y) {
  const box = $("tip");
  if (target.classList.contains("item")) {
    const it = item(strip(target.id));
    const kind = [it.material, placeOf(it), `${time(it.cost_ns)} ${it.cost_is}`].filter(Boolean).join(", ");
    box.innerHTML = `<b>${text(nameOf(it))}</b> <small>${text(kind)}</small><p>${prose(aboutOf(it))}</p>`;
  } else if (target.classList.contains("link")) {
    const links = linksOf(target);
    box.innerHTML = `<b>${text(nameOf(item(links[0].from)))} → ${text(nameOf(item(links[0].to)))}</b> <small>${text(data.why[links[0].why])}</small><p>${links.map(linkWords).join("<br/>")}</p>`;
  } else return hideTip();
  box.hidden = false;
  const {width, height} = box.getBoundingClientRect();
  box.style.left = Math.max(8, Math.min(x + 14, innerWidth - width - 8)) + "px";
  box.style.top = (y + 18 + height > innerHeight ? Math.max(8, y - height - 14) : y + 18) + "px";
}
function hideTip() { $("tip").hidden = true; }

let pointed = [];
pictures.addEventListener("pointermove", e => {
  const target = e.pointerType === "mouse" && !pictures.classList.contains("moving") ? what(e) : null;
  pointed.forEach(link => link.classList.remove("pointed"));
  pointed = !target || chosen ? [] : target.classList.contains("item") ? nearBy(target).links : [target];
  pointed.forEach(link => link.classList.add("pointed"));
  if (target) tip(target, e.clientX, e.clientY); else hideTip();
});
pictures.addEventListener("pointerleave", hideTip);
pictures.addEventListener("click", e => { if (!moved) choose(what(e)); });
pictures.addEventListener("focusin", e => {
  const target = what(e);
  if (!target?.matches(":focus-visible")) return;
  stop(target);
  reveal(target.querySelector("rect"));
  const box = target.getBoundingClientRect();
  tip(target, box.left, box.bottom - 12);
});
pictures.addEventListener("focusout", hideTip);

// The item to which an arrow key goes: along lines that are shown, or to the next box of the column.
function toward(element, key) {
  const here = nearBy(element);
  if (key === "ArrowLeft" || key === "ArrowRight") {
    const lines = key === "ArrowRight" ? here.after : here.before;
    const shown = lines.filter(({link}) => getComputedStyle(link).display !== "none");
    const far = ({link, other}) => Math.abs(other.x - here.x) + 2 * Math.abs(other.y - here.y) + (link.classList.contains("flow") ? 0 : 1e5);
    return shown.sort((a, b) => far(a) - far(b))[0]?.other.element;
  }
  const sign = key === "ArrowDown" ? 1 : -1;
  const column = [...around(form).values()].filter(other => Math.abs(other.x - here.x) < 20 && sign * (other.y - here.y) > 0);
  return column.sort((a, b) => sign * (a.y - b.y))[0]?.element;
}

// Opens an item from the panel or by a key, and lets keys go on there.
function go(id) {
  const element = $(`f${form}-${id}`);
  if (!element) return;
  choose(element);
  details.focus();
}

function back() {
  const last = chosen;
  choose(null);
  if (narrow.matches) togglePanel(false);
  if (last?.classList.contains("item") && details.contains(document.activeElement)) last.focus();
}

details.addEventListener("click", e => {
  const button = e.target.closest("button");
  if (button?.dataset.go) go(button.dataset.go);
  if (button?.dataset.pass) {
    const [first] = button.dataset.pass.split(" "), lines = [...picture().querySelectorAll(".pass")];
    const line = lines.find(pass => pass.dataset.passes.split(" ").includes(first));
    if (line) choose(line); else tellPass(button.dataset.pass.split(" "));
    details.focus();
  }
  if (button?.dataset.close) back();
});

// A menu closes where something else is touched.
addEventListener("pointerdown", e => { if (!$("lines").contains(e.target)) $("lines").open = false; });

addEventListener("keydown", e => {
  if (e.ctrlKey || e.metaKey || e.altKey || e.target.matches("input,select,textarea")) return;
  const element = e.target.closest?.(".item");
  if (e.key.startsWith("Arrow")) {
    if (!element && e.target !== document.body) return;
    const next = element ? toward(element, e.key) : picture().querySelector(".item[tabindex='0']");
    next?.focus({focusVisible: true, preventScroll: true});
  } else if ((e.key === "Enter" || e.key === " ") && element) {
    choose(element);
    if (e.key === "Enter" && narrow.matches) details.focus();
  } else if (e.key === "+" || e.key === "=") zoomTo(scale * 1.3);
  else if (e.key === "-" || e.key === "_") zoomTo(scale / 1.3);
  else if (e.key === "0") fit();
  else if (e.key === "/") $("find").focus();
  else if (e.key === "Escape") {
    $("lines").open = false;
    clearSearch();
    back();
  } else return;
  e.preventDefault();
});
