// Opens report pages in Firefox: another browser lays out, refuses and reports otherwise than Chromium, in which check_pages.py looks.
//   npm ci --prefix tests/page/firefox
//   node tests/page/firefox.mjs PAGE.html...
// At 1280 and 400 px width, light and dark: no console error, nothing asked for beyond the file itself, nothing wider than the page,
// no text or control over another, neither on the page nor within a figure, contrast, no NaN or the like in what is read. The headline
// is seen, says what report.json beside the page says, and its numbers are those of `data-found`; a comparison, which has no
// report.json, shows those of `data-checks`, and one of places, where these are objectives, the same number in headline and below it.
// A control is used with the keyboard and changes the drawing. What to try starts its engine. A view in three dimensions is drawn, or
// says that there is no WebGL: Firefox without a display often has none.
//
// Needs Firefox as Debian has it (apt-get install --no-install-recommends firefox-esr), led through WebDriver BiDi without a driver of
// its own. BiDi has no command for light and dark in this Firefox, so that a setting of its profile says it, one browser for each.
// puppeteer-core 24 is the last that runs in Node 20.
import { accessSync, constants, readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { delimiter, dirname, join, resolve } from "node:path";
import { pathToFileURL } from "node:url";

const WIDTHS = [1280, 400];
const HEIGHT = 900;
const SCHEMES = { light: 1, dark: 0 };
const CHECKS = readFileSync(new URL("checks.js", import.meta.url), "utf8");
const LAYOUT = { overlaps: "overlap", wide: "wider than the page", contrasts: "contrast", unnamed: "no name" };
// From the unit of a column, as its name ends, to the unit that is shown.
const FACTORS = { "mm>mm": 1, "mm>µm": 1e3, "deg>°": 1, ">": 1, ">×": 1, ">%": 100 };

const pause = (ms) => new Promise((done) => setTimeout(done, ms));
const plain = (text) => text.replace(/\s+/g, " ").trim();

function stop(words) {
  console.error(words);
  process.exit(2);
}

function browserPath() {
  const folders = (process.env.PATH ?? "").split(delimiter);
  const found = ["firefox-esr", "firefox"].flatMap((name) => folders.map((folder) => join(folder, name))).find((path) => {
    try {
      accessSync(path, constants.X_OK);
      return true;
    } catch {
      return false;
    }
  });
  return found ?? stop("no Firefox: apt-get install --no-install-recommends firefox-esr");
}

function puppeteer() {
  try {
    return createRequire(new URL("firefox/package.json", import.meta.url))("puppeteer-core");
  } catch (fault) {
    return stop(`no puppeteer-core (${fault.code}): npm ci --prefix tests/page/firefox`);
  }
}

// ---- What follows up to the next line of this kind runs in the page.

// What is read, by eye or aloud, and is no number.
function unreadable() {
  const wrong = /(?<![\w.])(NaN|undefined|Infinity|∞|inf)(?![\w.])|\[object \w+\]/;
  const found = new Set();
  const look = (text, where) => {
    const at = text.search(wrong);
    if (at >= 0) found.add(`${where} "${text.slice(Math.max(0, at - 30), at + 30).replace(/\s+/g, " ").trim()}"`);
  };
  const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  while (walker.nextNode()) {
    const element = walker.currentNode.parentElement;
    if (["SCRIPT", "STYLE", "NOSCRIPT"].includes(element.tagName)) continue;
    // An option is seen once its list is opened.
    if ((element.closest("select") ?? element).checkVisibility({ visibilityProperty: true })) look(walker.currentNode.textContent, "reads");
  }
  for (const element of document.querySelectorAll("[alt], [aria-label], [aria-valuetext], [title]")) {
    for (const name of ["alt", "aria-label", "aria-valuetext", "title"]) look(element.getAttribute(name) ?? "", name);
  }
  for (const field of document.querySelectorAll("input, textarea")) look(field.value, "field");
  for (const image of document.querySelectorAll('img[src^="data:image/svg+xml;base64,"]')) {
    const bytes = Uint8Array.from(atob(image.src.split(",")[1]), (letter) => letter.charCodeAt(0));
    const parsed = new DOMParser().parseFromString(new TextDecoder().decode(bytes), "image/svg+xml");
    parsed.querySelectorAll("text").forEach((text) => look(text.textContent, `figure ${image.alt.slice(0, 40)}:`));
  }
  return [...found].slice(0, 10);
}

function missingPictures() {
  const images = [...document.images].filter((image) => !image.complete || image.naturalWidth === 0);
  return images.map((image) => `${image.src.slice(0, 60)} "${image.alt.slice(0, 40)}"`).slice(0, 10);
}

// Files beside the page: Firefox reads them without telling of a request.
function otherFiles() {
  const parts = [...document.querySelectorAll("[src], [srcset], [poster], [data], link[href], image, use, iframe")];
  const names = ["src", "srcset", "poster", "data", "href", "xlink:href"];
  const addresses = parts.flatMap((element) => names.map((name) => element.getAttribute(name) ?? ""));
  return [...new Set(addresses)].filter((address) => address && !/^(data:|blob:|#)/.test(address)).map((address) => address.slice(0, 100));
}

function headline() {
  const visible = { visibilityProperty: true, opacityProperty: true };
  const seen = (element) => element.checkVisibility(visible) && element.innerText.trim() !== "";
  const title = document.querySelector(".answer > h1, .first h1");
  if (!title) return null;
  const words = document.createRange();
  words.selectNodeContents(title);
  // The first line may be short, so that its middle is looked at, not that of the box.
  const line = [...words.getClientRects()].find((box) => box.width > 1 && box.height > 1);
  const onTop = line && document.elementFromPoint(line.left + line.width / 2, line.top + line.height / 2);
  const texts = (element, name) => element.querySelector(name)?.innerText ?? "";
  return {
    isSeen: seen(title) && line !== undefined && line.bottom <= window.innerHeight && title.contains(onTop),
    sentence: title.innerText,
    checks: JSON.parse(title.dataset.checks ?? "[]"),
    isComparison: title.dataset.checks !== undefined,
    answer: title.parentElement.innerText,
    numbers: [...document.querySelectorAll(".numbers > .number")].map((number) => ({
      isSeen: seen(number),
      value: texts(number, ".value"),
      unit: texts(number, ".unit"),
      what: texts(number, ".what"),
      found: JSON.parse(number.dataset.found ?? "null"),
    })),
  };
}

// Whether two texts of a chart are apart although their boxes meet: those of Firefox are 1 px larger than the text on each side, and
// labels of an axis that are turned aslant lie side by side in boxes that meet.
function apart(...texts) {
  if (!texts.every((text) => text instanceof SVGTextElement)) return false;
  const corners = texts.map((text) => {
    const { x, y, width, height } = text.getBBox();
    const own = [[x, y], [x + width, y], [x + width, y + height], [x, y + height]];
    const place = text.getScreenCTM();
    return own.map(([a, b]) => new DOMPoint(a, b).matrixTransform(place));
  });
  const along = corners.flatMap(([a, b, , d]) => [[b.x - a.x, b.y - a.y], [d.x - a.x, d.y - a.y]]);
  return along.some(([x, y]) => {
    const ends = corners.map((four) => four.map((corner) => (corner.x * x + corner.y * y) / Math.hypot(x, y)));
    return Math.min(...ends.map((all) => Math.max(...all))) - Math.max(...ends.map((all) => Math.min(...all))) <= 1.5;
  });
}

// Views in three dimensions that are neither drawn nor say that there is no WebGL. A chart leaves an empty canvas where there is none.
function blankSpaces() {
  const canvas = document.createElement("canvas");
  const hasWebGl = Boolean(canvas.getContext("webgl2") || canvas.getContext("webgl"));
  const told = (space) => (hasWebGl ? space.querySelector(".plot canvas") : space.querySelector(".missing")?.checkVisibility());
  const blank = [...document.querySelectorAll(".chart.space")].filter((space) => !told(space));
  return blank.map(() => (hasWebGl ? "with WebGL" : "without WebGL"));
}

// A control of a view that has another value to take.
function usable() {
  const free = (control) => (control.matches("select")
    ? [...control.options].filter((option) => !option.disabled && !option.hidden).length > 1
    : Number(control.max) > Number(control.min));
  return [...document.querySelectorAll(".explorer select, .explorer input[type=range]")]
    .find((control) => control.checkVisibility({ visibilityProperty: true }) && !control.disabled && free(control)) ?? null;
}

function aboutControl(control) {
  const options = [...(control.options ?? [])];
  const isSelect = control.matches("select");
  const isLast = isSelect
    ? !options.slice(control.selectedIndex + 1).some((option) => !option.disabled && !option.hidden)
    : Number(control.value) === Number(control.max);
  const keys = isSelect ? ["ArrowDown", "ArrowUp"] : ["ArrowRight", "ArrowLeft"];
  const name = control.closest("label")?.querySelector("span")?.textContent ?? control.tagName;
  return { key: keys[isLast ? 1 : 0], name, value: control.value };
}

// What a view shows: shapes, colours and words, without the names that a chart drawn anew gets.
function drawing(control) {
  const kept = ["d", "href", "x", "y", "width", "height", "transform", "style"];
  const parts = [...control.closest(".explorer").querySelectorAll(".plot svg *")].map((element) => {
    const attributes = kept.map((name) => element.getAttribute(name) ?? element.getAttributeNS("http://www.w3.org/1999/xlink", name));
    return [element.tagName, ...attributes, element.childElementCount ? "" : element.textContent].join(" ");
  });
  return parts.filter((part) => !part.includes("url(")).join("\n");
}

// ---- What is shown of a number, held against it.

// Whether `text` is `value`, rounded to the digits that it shows.
function isRounded(text, value) {
  const parts = text.replaceAll("−", "-").match(/^(less than )?([+-]?\d+(?:\.(\d+))?)(?:e([+-]?\d+))?$/);
  if (!parts) return null;
  const power = 10 ** Number(parts[4] ?? 0);
  const shown = Number(parts[2]) * power;
  if (parts[1]) return Math.abs(value) < shown;
  const half = 0.5 * power / 10 ** (parts[3]?.length ?? 0);
  return Math.abs(value - shown) <= half * (1 + 1e-9);
}

function numberFault({ value, unit, found }) {
  const column = found.columns[0].match(/_(mm|deg)$/)?.[1] ?? "";
  const factor = FACTORS[`${column}>${unit}`];
  const same = factor === undefined ? null : isRounded(value, found.value * factor);
  if (same === null) return `"${value} ${unit}" cannot be held against ${found.value} of ${found.columns}`;
  return same ? null : `shows ${value} ${unit} for ${found.value} of ${found.columns} in ${found.file}`;
}

function* headlineFaults(found, file) {
  if (!found) return yield "has no headline";
  if (!found.isSeen) yield "the headline is not seen on the first screen";
  if (plain(found.sentence) === "") yield "the headline is empty";
  for (const number of found.numbers) {
    if (!number.isSeen) yield `the number ${number.value} is not seen`;
    if (number.found) {
      const fault = numberFault(number);
      if (fault) yield fault;
    }
  }
  if (found.isComparison) {
    const shown = found.answer.match(/[+−-]?\d+(?:\.\d+)?(?:e[+−-]?\d+)?/g) ?? [];
    // A best place is the one of the least objective, which is not shown; the headline and the number below it say what it costs.
    const quoted = found.checks.filter((check) => check.columns.join() !== "objective");
    for (const check of quoted) {
      // Of fewer digits than a comparison shows, nearly every number is some other one, rounded.
      const isShown = shown.some((text) => text.replace(/e.*|\D/g, "").replace(/^0+/, "").length >= 3 && isRounded(text, check.value));
      if (!isShown) yield `nowhere shows ${check.value}, the ${check.rule} of ${check.columns} in ${check.file}`;
    }
    if (found.checks.length === 0) yield "names no number that its headline quotes: the headline cannot be checked";
    else if (quoted.length === 0) {
      const [read, [first]] = [plain(found.sentence), found.numbers.map(({ value, unit }) => plain(`${value} ${unit}`))];
      if (!first || !read.includes(first)) yield `the headline reads "${read}", the number below it ${first}`;
    }
    return;
  }
  let told;
  try {
    told = JSON.parse(readFileSync(join(dirname(file), "report.json"), "utf8")).headline;
  } catch (fault) {
    return yield `report.json beside it cannot be read, so that the headline cannot be checked: ${fault.message}`;
  }
  const [read, said] = [plain(found.sentence), plain(told.sentence)];
  if (read !== said) yield `the headline reads "${read}", report.json says "${said}"`;
  const words = (numbers) => numbers.map(({ value, unit, what }) => plain([value, unit, what].join(" "))).join("; ");
  const [shown, given] = [words(found.numbers), words(told.numbers)];
  if (shown !== given) yield `shows the numbers "${shown}", report.json has "${given}"`;
}

class Page {
  constructor(tab, file, width, scheme, fault) {
    Object.assign(this, { tab, file, width, scheme, fault, address: pathToFileURL(resolve(file)).href });
    tab.on("console", (message) => { if (message.type() === "error") fault(`console: ${message.text().slice(0, 200)}`); });
    tab.on("pageerror", (error) => fault(`script error: ${String(error?.message ?? error).slice(0, 200)}`));
    tab.on("requestfailed", (request) => fault(`request failed: ${request.url().slice(0, 100)}`));
    tab.on("request", (request) => {
      const [url] = request.url().split("#");
      if (url !== this.address && !/^(data|blob):/.test(url)) fault(`asks for ${url.slice(0, 100)}`);
    });
  }

  // A function of checks.js, called in the page.
  ask(name) {
    return this.tab.evaluate(`(${CHECKS}).${name}(${name === "overlaps" ? apart : ""})`);
  }

  expect(holds, words) {
    if (!holds) this.fault(words);
    return holds;
  }

  async until(condition, seconds) {
    for (const ends = Date.now() + 1000 * seconds; Date.now() < ends; await pause(50)) {
      if (await this.tab.evaluate(condition)) return true;
    }
    return false;
  }

  // Opened, unfolded and scrolled through: views that are drawn when they come into sight are drawn.
  async open() {
    await this.tab.setViewport({ width: this.width, height: HEIGHT });
    await this.tab.goto(this.address);
    const given = await this.tab.evaluate("[window.innerWidth, matchMedia('(prefers-color-scheme: dark)').matches ? 'dark' : 'light']");
    const isGiven = given[0] === this.width && given[1] === this.scheme;
    if (!this.expect(isGiven, `cannot be looked at: Firefox shows it ${given.join(" px wide, ")}`)) return false;
    const isReady = await this.until("document.documentElement.dataset.ready === 'true'", 60);
    if (!this.expect(isReady, "its scripts do not get ready")) return false;
    const theme = await this.tab.evaluate("document.documentElement.dataset.theme");
    this.expect(theme === this.scheme, `is ${theme} where the system is ${this.scheme}`);
    await this.headline();
    await this.tab.evaluate("document.querySelectorAll('details').forEach((fold) => { fold.open = true; })");
    await this.ask("settled");
    const height = await this.tab.evaluate("document.documentElement.scrollHeight");
    for (let y = 0; y < height; y += 600) {
      await this.tab.evaluate(`window.scrollTo({ top: ${y}, behavior: "instant" })`);
      await this.ask("settled");
    }
    await this.tab.evaluate("window.scrollTo({ top: 0, behavior: 'instant' })");
    await this.ask("settled");
    return true;
  }

  async headline() {
    for (const fault of headlineFaults(await this.tab.evaluate(headline), this.file)) this.fault(fault);
  }

  async layout() {
    const [needed, given] = await this.ask("overflow");
    this.expect(needed <= given, `is ${needed} px wide in a window of ${given} px`);
    for (const [name, kind] of Object.entries(LAYOUT)) {
      for (const found of await this.ask(name)) this.fault(`${kind}: ${found}`);
    }
    for (const found of await this.tab.evaluate(unreadable)) this.fault(found);
  }

  async pictures() {
    for (const found of await this.tab.evaluate(otherFiles)) this.fault(`holds a part that is not in it: ${found}`);
    for (const found of await this.tab.evaluate(missingPictures)) this.fault(`a picture is missing: ${found}`);
    for (const found of await this.ask("figureTexts")) this.fault(`overlap in a ${found}`);
    for (const found of await this.tab.evaluate(blankSpaces)) this.fault(`${found}, a view in three dimensions shows nothing`);
  }

  async engine() {
    if (!await this.tab.evaluate("Boolean(document.getElementById('try') && document.getElementById('engine'))")) return;
    const isThere = await this.until("['ready', 'failed'].includes(document.documentElement.dataset.engine)", 60);
    const state = await this.tab.evaluate("document.documentElement.dataset.engine");
    const told = await this.tab.evaluate("document.querySelector('#try [data-part=status]').textContent");
    this.expect(isThere && state === "ready", `the engine did not start: ${state}, ${told}`);
  }

  // A control is used as without a mouse.
  async control() {
    const control = await this.tab.evaluateHandle(usable);
    if (!this.expect(await control.evaluate((found) => found !== null), "has no control to use")) return;
    await control.evaluate((found) => found.scrollIntoView({ block: "center", behavior: "instant" }));
    await this.ask("settled");
    const { key, name, value } = await control.evaluate(aboutControl);
    const before = await control.evaluate(drawing);
    this.expect(before.length > 0, `the view of "${name}" shows no drawing`);
    await control.focus();
    await this.tab.keyboard.press(key);
    for (let tries = 0; tries < 20 && await control.evaluate(drawing) === before; tries++) await this.ask("settled");
    this.expect(await control.evaluate((found) => found.value) !== value, `"${name}" does not heed ${key}`);
    this.expect(await control.evaluate(drawing) !== before, `"${name}", used by ${key}, does not change the drawing`);
  }
}

async function look(browser, file, width, scheme, fault) {
  const tab = await browser.newPage();
  const page = new Page(tab, file, width, scheme, fault);
  try {
    if (!await page.open()) return;
    await page.engine();
    await page.layout();
    await page.pictures();
    await page.control();
    await page.layout();
  } finally {
    await tab.close();
  }
}

const files = process.argv.slice(2);
if (files.length === 0) stop("usage: node tests/page/firefox.mjs PAGE.html...");
const path = browserPath();
const { launch } = puppeteer();
// Of each page, what is wrong with it, and where that was seen.
const faults = new Map(files.map((file) => [file, new Map()]));
for (const [scheme, override] of Object.entries(SCHEMES)) {
  const extraPrefsFirefox = { "layout.css.prefers-color-scheme.content-override": override };
  const browser = await launch({ browser: "firefox", executablePath: path, headless: true, defaultViewport: null, extraPrefsFirefox });
  for (const file of files) {
    for (const width of WIDTHS) {
      const own = faults.get(file);
      const fault = (words) => {
        const line = plain(words);
        own.set(line, (own.get(line) ?? new Set()).add(`${width} px ${scheme}`));
      };
      await look(browser, file, width, scheme, fault).catch((problem) => fault(`cannot be looked at: ${problem.message.slice(0, 200)}`));
    }
  }
  await browser.close();
}
for (const [file, own] of faults) {
  console.log(`${file}: ${own.size} faults`);
  for (const [words, where] of own) console.error(`FAULT ${file}: ${words} (${[...where].join(", ")})`);
}
process.exitCode = [...faults.values()].some((own) => own.size > 0) ? 1 : 0;
