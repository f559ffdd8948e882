// The deflected machine at a point, for a page that can compute it: `at` is a function of a place, a source and a tool angle, `along` of a point of a path, its length along it, and where the path is.
const Bending = {
  at: null,
  along: null,
  draw: null,
  waiting: [],
  connect(at, along) {
    [Bending.at, Bending.along] = [at, along];
    Bending.waiting.forEach((begin) => begin());
  },
};

// A point of a map that the reader has picked: all its numbers, and the command that explains it.
function chosenPoint(article, view) {
  const { data, cases } = view;
  const box = document.createElement("section");
  box.className = "chosen";
  box.hidden = true;
  box.setAttribute("aria-label", "The point that was picked");
  article.querySelector(".charts").after(box);
  const results = cases.filter((one) => !one.is_difference);

  function value(one, quantity, group, at) {
    const values = Data.unpack(one.series[quantity][group]);
    return values ? values[view.node(one, at)] : NaN;
  }
  function table(place) {
    const byCase = results.length > 1;
    const heads = byCase ? results.map((one) => one.name) : data.groups.length ? data.groups : [""];
    const table = document.createElement("table");
    const row = (part, cells, tag) => {
      const line = part.insertRow();
      cells.forEach((text, index) => {
        const cell = document.createElement(index === 0 ? "th" : tag);
        cell.scope = index === 0 && tag === "td" ? "row" : tag === "th" ? "col" : "";
        if (!cell.scope) cell.removeAttribute("scope");
        if (index > 0) cell.className = "number";
        cell.textContent = text;
        line.append(cell);
      });
    };
    row(table.createTHead(), ["quantity", ...heads], "th");
    const body = table.createTBody();
    data.labels.forEach((label, quantity) => {
      const numbers = byCase
        ? results.map((one) => value(one, quantity, view.state.group, view.placeAt(one, place)))
        : heads.map((_, group) => value(results[0], quantity, group, view.placeAt(results[0], place)));
      if (numbers.some(Number.isFinite)) row(body, [label, ...numbers.map((number) => Data.withUnit(number, data.units[quantity]))], "td");
    });
    return table;
  }
  function notes(place) {
    return results.flatMap((one) => {
      const at = view.node(one, view.placeAt(one, place));
      return one.flags.flatMap((flags, group) => flags.filter(([node]) => node === at).map(([, note]) => (data.groups[group] ? data.groups[group] + ": " : "") + one.notes[note]));
    });
  }
  // The command of this source, its blanks filled.
  function command(place) {
    const template = data.commands?.[view.state.group];
    if (!template) return null;
    const at = view.placeAt(results[0], place);
    const exact = place.slice(0, 3).map((_, axis) => results[0].axes[axis][at[axis]]);
    const phi = template.phi === null ? NaN : value(results[0], template.phi, view.state.group, at);
    if (template.text.includes("{phi}") && !Number.isFinite(phi)) return null;
    return template.text.replace("{position}", exact.map((number) => String(Number(number.toPrecision(12)))).join(",")).replace("{phi}", String(phi));
  }
  function copier(text) {
    const line = document.createElement("div");
    line.className = "command";
    const code = document.createElement("code");
    code.textContent = text;
    line.append(code);
    Controls.button(line, "Copy", "Copy the command", async (event) => {
      const button = event.currentTarget;
      try {
        await navigator.clipboard.writeText(text);
        button.textContent = "Copied";
      } catch (fault) {
        // Not every browser lets a file reach the clipboard: then the text is selected, to be copied by hand.
        getSelection().selectAllChildren(code);
        button.textContent = "Selected: press Ctrl+C";
      }
    });
    return line;
  }
  // What the engine is asked at a place; null where it cannot be.
  function question(place) {
    const source = data.sources?.[view.state.group];
    if (!source || results.length > 1) return null;
    const at = view.placeAt(results[0], place);
    const position = place.slice(0, 3).map((_, axis) => results[0].axes[axis][at[axis]]);
    return [position, source, data.phi === null ? NaN : value(results[0], data.phi, view.state.group, at)];
  }
  const pictures = document.createElement("div");
  pictures.className = "bent";
  let paint = [];
  Theme.onChange(() => paint.forEach((own) => own()));
  function words(text) {
    const line = document.createElement("p");
    line.textContent = text;
    line.setAttribute("role", "status");
    return line;
  }
  // Says that the machine is being computed, what came of it, or nothing.
  function showBent(found) {
    paint = [];
    pictures.replaceChildren();
    delete pictures.dataset.moved;
    if (!found) return;
    if (found.words) return pictures.append(words(found.words));
    const { answer, factor } = found;
    const source = data.groups[view.state.group] ? ` (${data.groups[view.state.group]})` : "";
    if (!answer.loaded) return pictures.append(words(`The machine cannot be drawn here${source}: ${answer.reason}`));
    const moved = Math.hypot(...answer.displacement);
    const angle = answer.phi_deg === null ? "" : ` at tool angle ${Data.withUnit(answer.phi_deg, "°")}`;
    const larger = factor > 1 ? `, drawn ${Data.number(factor)} times as large` : ", drawn as it is";
    pictures.append(words(`The deflected machine here${source}: its tool moves by ${Data.withUnit(moved, "mm")}${angle}${larger}. Grey: before.`));
    pictures.dataset.moved = moved;
    const views = document.createElement("div");
    views.className = "bent-views";
    pictures.append(views);
    const s = Math.SQRT1_2;
    paint = [["From aside", [s, -s, 0], [0.35, 0.35, 0.87]], ["From the front", [1, 0, 0], [0, 0, 1]]].map(([name, right, up]) => {
      const figure = document.createElement("figure");
      const canvas = document.createElement("canvas");
      canvas.setAttribute("role", "img");
      canvas.setAttribute("aria-label", `${name}: the machine before and deflected, ${larger.slice(2)}`);
      const caption = document.createElement("figcaption");
      caption.textContent = name;
      figure.append(canvas, caption);
      views.append(figure);
      return Bending.draw(canvas, right, up, found);
    });
  }
  function show(place) {
    box.hidden = !place;
    if (!place) return;
    const heading = document.createElement("h4");
    heading.textContent = "At " + place.map((value, axis) => view.along(axis, value)).join(", ");
    const scroll = document.createElement("div");
    scroll.className = "scroll";
    scroll.tabIndex = 0;
    scroll.setAttribute("role", "region");
    scroll.setAttribute("aria-label", "All numbers of the point");
    scroll.append(table(place));
    const remarks = notes(place).map((text) => {
      const remark = document.createElement("p");
      remark.className = "remark";
      remark.textContent = text;
      return remark;
    });
    const text = command(place);
    const parts = [heading, ...remarks, pictures, scroll];
    if (text) {
      const words = document.createElement("p");
      words.className = "small";
      words.textContent = (data.command_note ? data.command_note + " " : "") + "The command for this point:";
      parts.push(words, copier(text));
    }
    const close = document.createElement("div");
    Controls.button(close, "Close", "Close the point", () => view.choose(null));
    box.replaceChildren(...parts, close);
  }
  return { show, question, showBent };
}
