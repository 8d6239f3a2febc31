"use strict";
// The picture in its window: it fits at first, and is moved and zoomed by mouse, fingers and keys.
const $ = id => document.getElementById(id);
const data = JSON.parse($("data").textContent);
const pictures = $("pictures"), main = document.querySelector("main"), panel = $("panel"), details = $("details");
const narrow = matchMedia("(max-width: 760px)");
const LEAST = .02, MOST = 4, READABLE = .75;
let form = 0, scale = 1, fitted = true;

const picture = () => $("form" + form).querySelector("svg");
const size = svg => svg.getAttribute("viewBox").split(" ").slice(2).map(Number);

function setScale(wanted) {
  const svg = picture(), [w, h] = size(svg);
  scale = Math.min(MOST, Math.max(LEAST, wanted));
  svg.style.width = w * scale + "px";
  svg.style.height = h * scale + "px";
  pictures.classList.toggle("far", scale < READABLE);
  pictures.classList.toggle("map", scale < .22);
}

// Zooms, and keeps the point of the picture that is at (x, y) of the window.
function zoomTo(wanted, x, y) {
  const svg = picture(), window = pictures.getBoundingClientRect();
  x ??= window.left + window.width / 2;
  y ??= window.top + window.height / 2;
  const before = svg.getBoundingClientRect(), u = (x - before.left) / before.width, v = (y - before.top) / before.height;
  setScale(wanted);
  const after = svg.getBoundingClientRect();
  pictures.scrollLeft += after.left + u * after.width - x;
  pictures.scrollTop += after.top + v * after.height - y;
  fitted = false;
  hideTip();
}

function fit() {
  const [w, h] = size(picture()), window = pictures.getBoundingClientRect();
  setScale(Math.min((window.width - 18) / w, (window.height - 18) / h, 1.4));
  pictures.scrollTo(0, 0);
  fitted = true;
  hideTip();
}

// A wide picture has its details below, and as much room as it needs; a tall one has them beside it.
function dock() {
  const [w, h] = size(picture()), {clientWidth: width, clientHeight: height} = main;
  main.classList.toggle("below", !narrow.matches && w > 1.9 * h);
  main.style.setProperty("--graph", Math.min(.62 * height, Math.max(.36 * height, (width - 18) * h / w + 60)) + "px");
}

// Brings an element into the window: to its middle, or only if it is not there.
function reveal(element, always) {
  const window = pictures.getBoundingClientRect(), box = element.getBoundingClientRect(), edge = 24;
  const inside = box.left > window.left + edge && box.right < window.right - edge && box.top > window.top + edge && box.bottom < window.bottom - edge;
  if (inside && !always) return;
  pictures.scrollLeft += box.left + box.width / 2 - window.left - window.width / 2;
  pictures.scrollTop += box.top + box.height / 2 - window.top - window.height / 2;
}

// The same, so large that it can be read.
function revealReadable(element) {
  if (scale < READABLE) zoomTo(1);
  reveal(element, true);
}

function togglePanel(open) {
  panel.hidden = !open;
  $("toggle").setAttribute("aria-expanded", String(open));
}

$("toggle").addEventListener("click", () => togglePanel(panel.hidden));
$("in").addEventListener("click", () => zoomTo(scale * 1.3));
$("out").addEventListener("click", () => zoomTo(scale / 1.3));
$("fit").addEventListener("click", fit);

pictures.addEventListener("wheel", e => {
  if (e.shiftKey) return;
  e.preventDefault();
  const step = e.deltaMode === 1 ? 20 : 1;
  zoomTo(scale * Math.exp(-e.deltaY * step * (e.ctrlKey ? .01 : .0016)), e.clientX, e.clientY);
}, {passive: false});
pictures.addEventListener("dblclick", e => { if (!what(e)) zoomTo(scale * 2, e.clientX, e.clientY); });

// One pointer moves the picture, two zoom it; what has not moved was a click.
const pointers = new Map();
let moved = false;
const middle = () => {
  const all = [...pointers.values()], n = all.length;
  const x = all.reduce((sum, p) => sum + p.x, 0) / n, y = all.reduce((sum, p) => sum + p.y, 0) / n;
  return {x, y, reach: n > 1 ? Math.hypot(all[0].x - all[1].x, all[0].y - all[1].y) : 0};
};
pictures.addEventListener("pointerdown", e => {
  if (e.button !== 0) return;
  // a scroll bar is no part of the picture
  const box = pictures.getBoundingClientRect();
  if (e.clientX - box.left > pictures.clientWidth || e.clientY - box.top > pictures.clientHeight) return;
  if (pointers.size === 0) moved = false;
  pointers.set(e.pointerId, {x: e.clientX, y: e.clientY});
});
addEventListener("pointermove", e => {
  const pointer = pointers.get(e.pointerId);
  if (!pointer || !moved && pointers.size === 1 && Math.hypot(e.clientX - pointer.x, e.clientY - pointer.y) < 5) return;
  const before = middle();
  pointer.x = e.clientX;
  pointer.y = e.clientY;
  const after = middle();
  moved = true;
  pictures.classList.add("moving");
  if (before.reach > 0) zoomTo(scale * after.reach / before.reach, after.x, after.y);
  pictures.scrollLeft -= after.x - before.x;
  pictures.scrollTop -= after.y - before.y;
  fitted = false;
  hideTip();
});
for (const name of ["pointerup", "pointercancel"]) addEventListener(name, e => {
  pointers.delete(e.pointerId);
  if (!pointers.size) pictures.classList.remove("moving");
});

// A window of another size: what fitted still fits, and what is chosen is still seen.
new ResizeObserver(dock).observe(main);
new ResizeObserver(() => {
  if (fitted) fit(); else if (chosen) reveal(chosen);
}).observe(pictures);
