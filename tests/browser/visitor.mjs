// Somebody who looks at a page: what is where, what it says, and what went wrong meanwhile.
import { join } from "node:path";

export const failures = [];

// Says whether something is so, and goes on.
export function check(what, holds, found = "") {
  console.log(`${holds ? "ok    " : "FAILED"} ${what}${holds || found === "" ? "" : `: ${found}`}`);
  if (!holds) failures.push(what);
}

// What a sentence looks like on the page: indices are lowered, code is set as code.
const plain = words => words.replace(/[`*_{}\s]/g, "");

export class Visitor {
  static async open(browser, url, folder, options) {
    const it = new Visitor();
    it.folder = folder;
    it.trouble = [];
    it.context = await browser.newContext(options);
    it.page = await it.context.newPage();
    it.page.setDefaultTimeout(10000);
    it.page.on("console", message => ["error", "warning"].includes(message.type()) && it.trouble.push(message.text()));
    it.page.on("pageerror", error => it.trouble.push(error.message));
    it.page.on("request", request => request.url() === url || request.url().startsWith("data:") || it.trouble.push(`asks for ${request.url()}`));
    await it.page.goto(url);
    await it.settle();
    return it;
  }

  // Ends a visit: nothing was asked of the network, and no error was reported.
  async leave(name) {
    check(`${name}: no error, and nothing asked of the network`, this.trouble.length === 0, this.trouble.join("; "));
    await this.context.close();
  }

  settle() { return this.page.evaluate(() => new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))); }
  async shot(name) { await this.settle(); await this.page.screenshot({ path: join(this.folder, `${name}.png`) }); }
  text(selector) { return this.page.locator(selector).first().innerText(); }
  async says(sentence) { return Boolean(sentence) && plain(await this.page.locator("#details").innerText()).includes(plain(sentence)); }

  // The box of what an id names; of an item, its rectangle.
  async box(id) {
    await this.settle();
    return this.page.evaluate(id => {
      const element = document.getElementById(id), { x, y, width, height } = (element.querySelector(":scope > rect") ?? element).getBoundingClientRect();
      return { x, y, width, height };
    }, id);
  }

  async id(task, material) {
    return this.page.evaluate(([task, material]) => "f0-" + data.forms[0].items.find(it => it.name === task && (it.material ?? "") === material).id, [task, material]);
  }

  // Whether the whole picture is in its window, and fills it in one direction.
  async fits() {
    await this.settle();
    return this.page.evaluate(() => {
      const window = document.getElementById("pictures").getBoundingClientRect(), svg = [...document.querySelectorAll(".picture svg")].find(e => e.getClientRects().length);
      const box = svg.getBoundingClientRect(), frames = [window, { left: 0, top: 0, right: innerWidth, bottom: innerHeight }];
      const inside = frames.every(frame => box.left >= frame.left && box.top >= frame.top && box.right <= frame.right && box.bottom <= frame.bottom);
      return inside && Math.max(box.width / window.width, box.height / window.height) > 0.9;
    });
  }

  async inView(id) {
    const box = await this.box(id), window = await this.box("pictures");
    return box.x >= window.x && box.y >= window.y && box.x + box.width <= window.x + window.width && box.y + box.height <= window.y + window.height;
  }

  current() { return this.page.evaluate(() => document.querySelector(".item.current")?.id ?? null); }
  chosen() { return this.page.evaluate(() => document.querySelector(".item.chosen")?.id ?? null); }
  focused() { return this.page.evaluate(() => document.activeElement.closest(".item")?.id ?? null); }
  linked(a, b) { return this.page.evaluate(([a, b]) => Boolean(document.querySelector(`.link[data-from="${a}"][data-to="${b}"]`)), [a, b]); }
  isMarked(id) { return this.page.evaluate(id => parseFloat(getComputedStyle(document.querySelector(`#${id} rect`)).strokeWidth) >= 3, id); }

  async point(id) {
    const { x, y, width, height } = await this.box(id);
    await this.page.mouse.move(x + width / 2, y + height / 2, { steps: 2 });
    await this.settle();
  }

  async click(id) {
    await this.point(id);
    await this.page.mouse.down();
    await this.page.mouse.up();
    await this.settle();
  }

  // Two fingers about a point, which part.
  async pinch(x, y, from, to) {
    const touch = await this.context.newCDPSession(this.page);
    const send = (type, reach) => touch.send("Input.dispatchTouchEvent", { type, touchPoints: reach === null ? [] : [{ x, y: y - reach, id: 1 }, { x, y: y + reach, id: 2 }] });
    await send("touchStart", from);
    for (let step = 1; step <= 6; step++) await send("touchMove", from + (to - from) * step / 6);
    await send("touchEnd", null);
    await this.settle();
  }

  // What reaches beyond the sides of the window, or makes it scroll.
  tooWide() {
    return this.page.evaluate(() => {
      const wide = [...document.querySelectorAll("header *, #zoom *, #panel, #panel *, #tip")].filter(e => {
        const box = e.getBoundingClientRect();
        return box.width > 0 && !e.closest("pre") && (box.right > innerWidth + 0.5 || box.left < -0.5);
      });
      const scrolls = document.documentElement.scrollWidth > innerWidth ? ["the page scrolls"] : [];
      return [...scrolls, ...wide.map(e => `${e.tagName} ${e.id} ${e.textContent.slice(0, 40)}`)];
    });
  }

  // Items that do not say what they do, or say it in words of the program.
  strangeWords() {
    return this.page.evaluate(() => [...document.querySelectorAll(".item")].filter(e => e.getClientRects().length).flatMap(element => {
      choose(element);
      const told = document.getElementById("details").innerText, about = document.querySelector("#details .about")?.innerText ?? "";
      const strange = told.match(/\b(Requires\w*|Computes|Modifies|Adapts|NearParticles|WriteAfter\w+|Home|Combine|Crossing|undefined|null|NaN)\b/);
      return strange || about.length < 20 ? [[element.id, strange?.[0] ?? about]] : [];
    }));
  }

  // The least contrast of a name against its box, after WCAG 2.
  leastContrast() {
    return this.page.evaluate(() => {
      const light = color => {
        const [r, g, b] = color.match(/[\d.]+/g).slice(0, 3).map(c => c / 255).map(c => c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4);
        return 0.2126 * r + 0.7152 * g + 0.0722 * b;
      };
      const all = [...document.querySelectorAll("#form0 .item")].map(item => {
        const [a, b] = [getComputedStyle(item.querySelector("rect")).fill, getComputedStyle(item.querySelector("text")).fill].map(light);
        return [(Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05), item.id];
      });
      return all.sort(([a], [b]) => a - b)[0];
    });
  }

  // How long the page is busy with what people do again and again [ms].
  async delays() {
    return this.page.evaluate(async () => {
      const frame = () => new Promise(done => requestAnimationFrame(() => setTimeout(done)));
      const item = [...document.querySelectorAll(".item")].find(e => e.getClientRects().length);
      const timed = async work => {
        const began = performance.now();
        work();
        await frame();
        return Math.round(performance.now() - began);
      };
      return {
        "fitting": await timed(() => fit()), "a step of the wheel": await timed(() => zoomTo(scale * 1.3)), "opening a task": await timed(() => choose(item)),
        "going back": await timed(() => choose(null)), "a letter of a search": await timed(() => { $("find").value = "s"; search(); }),
      };
    });
  }
}
