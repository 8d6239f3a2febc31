// Opens pages of `sinew graph --format html` in a browser without a window, and uses them as people do: with mouse, fingers and
// keys, on a desktop and on a phone. Node.js and playwright-core drive a Chromium that is on the machine.
//
// usage: node tests/browser/graph_page.mjs SINEW DRIVER FOLDER
// DRIVER has node_modules/playwright-core, SINEW makes the pages; pages and screenshots are left in FOLDER. CHROMIUM may name a browser.
import { execFileSync } from "node:child_process";
import { existsSync, mkdirSync, statSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { delimiter, dirname, join, resolve } from "node:path";
import { fileURLToPath, pathToFileURL } from "node:url";
import { Visitor, check, failures } from "./visitor.mjs";

const [sinew, driver, folder] = process.argv.slice(2).map(path => resolve(path));
if (!folder) throw new Error("usage: graph_page.mjs SINEW DRIVER FOLDER");
const { chromium } = createRequire(join(driver, "package.json"))("playwright-core");
const root = join(dirname(fileURLToPath(import.meta.url)), "../..");
const named = ["chromium", "chromium-browser", "google-chrome"].flatMap(name => process.env.PATH.split(delimiter).map(folder => join(folder, name)));
const executablePath = [process.env.CHROMIUM, ...named].find(path => path && existsSync(path));
if (!executablePath) throw new Error("there is no Chromium: install it, or let CHROMIUM name one");
mkdirSync(folder, { recursive: true });

const graph = (...args) => execFileSync(sinew, ["graph", ...args], { cwd: root, encoding: "utf8", maxBuffer: 1 << 28 });
function make(name, ...args) {
  const file = join(folder, `${name}.html`);
  writeFileSync(file, graph(...args, "--format", "html"));
  return pathToFileURL(file).href;
}
const slab = make("slab", "problems/slab");
const large = make("large", "problems/slab", "--expanded", "--patches", "4x4x4");
const rigid = make("rigid", "problems/slab-rigid");
const said = new Map(JSON.parse(graph("problems/slab", "--format", "json")).tasks.map(task => [task.task, task.about]));

// Chromium that speaks to nobody by itself
const args = ["--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync"];
const browser = await chromium.launch({ executablePath, args });
const visit = (url, options) => Visitor.open(browser, url, folder, options);
const desktop = { viewport: { width: 1280, height: 800 } };
const phone = { viewport: { width: 380, height: 740 }, hasTouch: true, isMobile: true, deviceScaleFactor: 2 };

async function desktopUse() {
  const it = await visit(slab, desktop);
  check("the picture fits the window", await it.fits());
  await it.shot("desktop");
  await it.page.setViewportSize({ width: 900, height: 640 });
  check("and another one", await it.fits());
  await it.page.setViewportSize(desktop.viewport);
  check("and the first one again", await it.fits());

  await it.page.keyboard.press("/");
  check("/ goes to the search", await it.page.locator("#find").evaluate(e => e === document.activeElement));
  await it.page.keyboard.type("gather");
  const first = await it.current();
  check("what is found is in view, so large that it can be read", (await it.inView(first)) && (await it.box(first)).height > 16);
  check("matches are counted", (await it.text("#count")) === "1 of 2", await it.text("#count"));
  await it.shot("search");
  await it.page.keyboard.press("Enter");
  check("Enter opens it", (await it.chosen()) === first && (await it.text("#details h2")).startsWith("Gather"));
  check("its sentence is there", await it.says(said.get("Gather")), await it.text("#details"));
  check("it is in view and marked", (await it.inView(first)) && (await it.isMarked(first)));
  await it.shot("opened");
  await it.page.keyboard.press("Enter");
  const second = await it.chosen();
  check("Enter goes on", second !== first && (await it.text("#count")).startsWith("2 of") && (await it.inView(second)));
  await it.page.keyboard.press("Shift+Enter");
  check("Shift+Enter goes back", (await it.chosen()) === first && (await it.text("#count")).startsWith("1 of"));
  await it.page.keyboard.press("Escape");
  check("Escape clears", (await it.text("#count")) === "" && (await it.page.locator(".found").count()) === 0);
  await it.page.locator("#find").fill("deformation gradient");
  check("words of the field find the tasks that work with it", (await it.page.locator(".item.found").count()) >= 2);
  await it.page.locator("#find").fill("no such thing");
  check("nothing is found where nothing is", (await it.text("#count")) === "none");
  await it.page.locator("#find").fill("");

  await it.page.locator("#fit").click();
  check("the button fits it again", await it.fits());
  const stress = await it.id("Stress", "tissue");
  await it.point(stress);
  check("what is pointed at is explained", (await it.text("#tip")).includes("Deforms the particles"), await it.text("#tip"));
  await it.shot("pointed");
  await it.click(stress);
  check("a click opens it", (await it.chosen()) === stress && (await it.says(said.get("Stress"))));
  check("with what is beside it", (await it.page.locator(".item.near").count()) > 4);
  await it.shot("clicked");

  const before = await it.box(stress), [x, y] = [before.x + before.width / 2, before.y + before.height / 2];
  await it.page.mouse.move(x, y);
  await it.page.mouse.wheel(0, -900);
  await it.settle();
  const after = await it.box(stress);
  check("the wheel zooms about the pointer", after.width > 2 * before.width && Math.abs(after.x + after.width / 2 - x) < 6 && Math.abs(after.y + after.height / 2 - y) < 6, JSON.stringify([before, after]));
  const below = await it.box(await it.id("Advance", "tissue")), [fromX, fromY] = [below.x + below.width / 2, below.y + below.height / 2];
  await it.page.mouse.move(fromX, fromY);
  await it.page.mouse.down();
  await it.page.mouse.move(fromX - 90, fromY - 30, { steps: 5 });
  await it.page.mouse.up();
  const drawn = await it.box(stress);
  check("it is moved by hand, and nothing is opened by that", Math.abs(after.x - drawn.x - 90) < 4 && Math.abs(after.y - drawn.y - 30) < 4 && (await it.chosen()) === stress);
  await it.page.locator("h1").click();
  await it.page.keyboard.press("0");
  check("0 fits it", await it.fits());
  const fitted = await it.box(stress);
  await it.page.keyboard.press("+");
  check("+ makes it larger", (await it.box(stress)).width > 1.2 * fitted.width);
  await it.page.keyboard.press("-");
  check("- makes it smaller", Math.abs((await it.box(stress)).width / fitted.width - 1) < 0.01);
  await it.page.locator("summary", { hasText: "Lines" }).click();
  await it.shot("lines");
  await it.page.locator("#lines input[value=war]").uncheck();
  check("kinds of lines can be left out", (await it.page.locator(".link.war:visible").count()) === 0 && (await it.page.locator(".link.flow:visible").count()) > 20);
  check("each task says what it does, in words of the field", (await it.strangeWords()).length === 0, JSON.stringify(await it.strangeWords()));
  await it.leave("desktop");
}

async function keyboardAlone() {
  const it = await visit(slab, desktop);
  for (let presses = 0; presses < 12 && !(await it.focused()); presses++) await it.page.keyboard.press("Tab");
  const first = await it.focused();
  check("Tab comes to a task", first !== null);
  await it.page.keyboard.press("ArrowRight");
  const second = await it.focused();
  check("an arrow key follows a line", second !== first && (await it.linked(first, second)) && (await it.inView(second)), `${first} ${second}`);
  check("what has the focus is explained", (await it.text("#tip")).length > 20);
  await it.page.keyboard.press("ArrowDown");
  const third = await it.focused();
  check("another goes down its column", third !== second && (await it.box(third)).y > (await it.box(second)).y);
  await it.shot("keyboard");
  await it.page.keyboard.press("Enter");
  check("Enter opens it", (await it.chosen()) === third && (await it.text("#details .about")).length > 20);
  for (let presses = 0; presses < 8 && !(await it.page.evaluate(() => document.activeElement.dataset?.go)); presses++) await it.page.keyboard.press("Tab");
  const next = await it.page.evaluate(() => document.activeElement.dataset.go);
  await it.page.keyboard.press("Enter");
  check("Tab and Enter go on to its neighbors", next && (await it.chosen()) === "f0-" + next, next);
  await it.page.keyboard.press("Escape");
  check("Escape goes back to the whole", (await it.chosen()) === null && (await it.focused()) === "f0-" + next);
  await it.leave("keyboard");
}

async function phoneUse() {
  const it = await visit(slab, phone);
  check("on a phone it fits", await it.fits());
  check("nothing is wider than the phone", (await it.tooWide()).length === 0, (await it.tooWide()).join());
  await it.shot("phone");
  await it.page.locator("#find").tap();
  await it.page.keyboard.type("Gather");
  await it.page.keyboard.press("Enter");
  const gather = await it.chosen();
  check("what is found opens below the picture", (await it.says(said.get("Gather"))) && (await it.inView(gather)), gather);
  check("and nothing is wider than the phone", (await it.tooWide()).length === 0, (await it.tooWide()).join());
  await it.shot("phone-opened");
  await it.page.locator("#details .close").tap();
  check("and closes", !(await it.page.locator("#panel").isVisible()));
  const mirror = await it.id("Mirror", "tissue");
  const at = await it.box(mirror), window = await it.box("pictures");
  const [x, y] = [Math.max(at.x, window.x) + 10, at.y + at.height / 2];
  await it.pinch(x, y, 40, 100);
  const wider = await it.box(mirror);
  check("two fingers zoom", wider.width > 2 * at.width && wider.width < 3 * at.width, `${at.width} ${wider.width}`);
  await it.page.touchscreen.tap(wider.x + wider.width / 2, wider.y + wider.height / 2);
  check("a tap opens a task", (await it.says(said.get("Mirror"))) && (await it.chosen()) === mirror, await it.chosen());
  await it.page.locator("#fit").tap();
  check("and the button fits it", await it.fits());
  await it.page.locator("summary", { hasText: "Lines" }).tap();
  check("a menu is no wider than the phone", (await it.tooWide()).length === 0, (await it.tooWide()).join());
  await it.shot("phone-lines");
  await it.leave("phone");
}

async function colors() {
  for (const colorScheme of ["light", "dark"]) {
    const it = await visit(slab, { ...desktop, colorScheme });
    const [contrast, where] = await it.leastContrast();
    check(`${colorScheme}: all names can be read`, contrast >= 4.5, `${contrast} ${where}`);
    await it.click(await it.id("Contact", ""));
    await it.shot(colorScheme);
    await it.leave(colorScheme);
  }
}

async function largest() {
  check("the largest page is no larger than 2 MB", statSync(fileURLToPath(large)).size < 2e6);
  const began = Date.now(), it = await visit(large, desktop);
  check("it opens within 5 s", Date.now() - began < 5000, `${Date.now() - began} ms`);
  check("it fits", await it.fits());
  await it.shot("large");
  await it.page.keyboard.press("/");
  await it.page.keyboard.type("SignalSpeed");
  await it.page.keyboard.press("Enter");
  check("what is found is in view", (await it.inView(await it.chosen())) && (await it.box(await it.chosen())).height > 16);
  await it.shot("large-opened");
  for (const [what, ms] of Object.entries(await it.delays())) check(`${what} takes less than half a second`, ms < 500, `${ms} ms`);
  await it.page.locator("#find").fill("");
  await it.page.locator("#form").selectOption("1");
  check("the other form fits, too", await it.fits());
  await it.shot("large-other");
  await it.leave("large");
}

async function severalGraphs() {
  const it = await visit(rigid, desktop);
  check("several graphs fit", await it.fits());
  await it.shot("rigid");
  const pass = it.page.locator("#details [data-pass]", { hasText: "onward" }).first();
  await pass.focus();
  await it.page.keyboard.press("Enter");
  check("what passes between graphs is reached by keys", (await it.text("#details")).includes("written by") && (await it.page.locator(".pass.chosen").count()) === 1);
  await it.shot("rigid-pass");
  await it.leave("rigid");
}

for (const part of [desktopUse, keyboardAlone, phoneUse, colors, largest, severalGraphs]) {
  console.log(`-- ${part.name}`);
  await part();
}
await browser.close();
console.log(failures.length ? `FAILED: ${failures.join("; ")}` : `all of it holds; screenshots are in ${folder}`);
process.exitCode = failures.length ? 1 : 0;
