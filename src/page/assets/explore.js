"use strict";
// The machine and the workpiece, moved by hand. Numbers come from the engine; here they are asked for and drawn.
function explore(section) {
  const scene = JSON.parse(document.getElementById("scene-to-try").textContent);
  const find = (name) => section.querySelector(`[data-part="${name}"]`);
  const COORDINATES = [["x", "mm"], ["y", "mm"], ["z", "mm"], ["yaw", "°"], ["pitch", "°"], ["roll", "°"]];
  const FORCES = [["force along x", "N"], ["force along y", "N"], ["force along z", "N"], ["moment about x", "N·mm"], ["moment about y", "N·mm"], ["moment about z", "N·mm"]];
  const TOOL = [["x", "mm"], ["y", "mm"], ["z", "mm"], ["roll", "°"], ["pitch", "°"], ["yaw", "°"]];
  const state = { mode: "tool", place: null, tool: null, wrench: section.dataset.wrench?.split(",").map(Number) ?? [100, 0, 0, 0, 0, 0], set: {}, level: 0, quantity: "displacement" };
  const live = { view: null, part: null, tool: null, exact: false, map: null, reach: {}, cloud: null, factor: 1, fault: null, spent: [], drawn: [], clouds: [] };
  const say = (words) => { find("status").textContent = words; };
  const number = Data.number;
  const shown = (v) => String(Number(v.toFixed(6)));

  // ---- Questions: one engine follows the hand, another computes what rests.
  let quick = null;
  let whole = null;
  let busy = false;
  let stale = false;
  let rest = 0;
  let version = 0;
  // Most points that can be looked at while something is dragged, from the time the last took.
  let most = 24;
  const BUDGET_MS = 11;
  const REST_MS = 140;

  const load = () => ({ wrench: state.wrench });
  const toolAt = () => (live.view.machine.turns ? { pose: state.tool } : { position: state.tool.slice(0, 3) });
  const question = () => (state.mode === "part"
    ? { call: "place", place: state.place, most }
    : { call: "tool", at: toolAt(), load: load() });

  async function follow() {
    if (!quick) return;
    if (busy) { stale = true; return; }
    busy = true;
    const asked = version;
    const mode = state.mode;
    try {
      const { answer, ms } = await quick.ask(question());
      live.spent.push(ms);
      if (mode === "part") {
        const looked = answer.features.reduce((sum, points) => sum + points.length, 0);
        const one = ms / Math.max(looked, 1);
        most = Math.max(6, Math.min(5000, Math.floor(BUDGET_MS / one)));
        if (asked === version || !live.exact) { live.part = answer; live.exact = answer.stride === 1; }
      } else live.tool = answer;
      live.fault = null;
    } catch (fault) { live.fault = fault.message; }
    busy = false;
    paint();
    if (stale) { stale = false; follow(); }
  }
  // Where the tool may be, by the other engine: a frame of the tool does not wait for it, and a hand that is faster skips clouds.
  let clouded = false;
  let overtaken = false;
  async function spread() {
    if (!whole || state.mode !== "tool" || !live.view?.uncertain_by) return;
    if (clouded) { overtaken = true; return; }
    clouded = true;
    try {
      const { answer, ms } = await whole.ask({ call: "cloud", at: toolAt(), load: load() });
      live.clouds.push(ms);
      live.cloud = answer;
    } catch (fault) { live.cloud = { displacements: [], reason: fault.message }; }
    clouded = false;
    paint();
    if (overtaken) { overtaken = false; spread(); }
  }
  // All points, once the hand rests.
  async function settle() {
    write();
    if (state.mode === "map") { map.restart(); return; }
    if (state.mode !== "part" || live.exact || !whole) { reach.restart(); return; }
    const asked = version;
    try {
      const { answer } = await whole.ask({ call: "place", place: state.place });
      if (asked !== version || state.mode !== "part") return;
      live.part = answer;
      live.exact = true;
      live.fault = null;
      reach.restart();
    } catch (fault) { live.fault = fault.message; }
    paint();
  }
  function changed() {
    version++;
    live.exact = false;
    follow();
    spread();
    paint();
    clearTimeout(rest);
    rest = setTimeout(settle, REST_MS);
  }

  // ---- Pictures.
  let awaited = null;
  // All of it, or only the view that is turned.
  function paint(only) {
    const all = only?.canvas ? [only] : views;
    if (awaited) {
      if (awaited[0] !== all[0]) awaited = views;
      return;
    }
    awaited = all;
    requestAnimationFrame(() => {
      const drawn = awaited;
      awaited = null;
      const began = performance.now();
      if (live.view) {
        const frame = live.view.workpiece && Space.frameOf(state.place, live.view.workpiece.base);
        drawn.forEach((view) => drawScene(view, { state, live, scene, frame, map }));
      }
      if (live.view && drawn === views) {
        drawChart(find("chart"), { state, live });
        report();
        controls.forEach((control) => control.refresh());
      }
      live.drawn.push(performance.now() - began);
    });
  }

  // ---- Words and numbers.
  const size = (v) => (v ? Math.hypot(...v) : NaN);
  const rows = (list) => list.map(([name, value]) => `<div><dt>${name}</dt><dd>${value}</dd></div>`).join("");
  const escape = (text) => text.replace(/[&<>"]/g, (c) => ({ "&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;" })[c]);
  function drivesTable(columns) {
    const drives = live.view.machine.drives;
    const head = columns.map(([name]) => `<th scope="col" class="number">${name}</th>`).join("");
    const body = drives.map((drive, i) => {
      const cells = columns.map(([, values, unit]) => `<td class="number">${values ? Data.withUnit(values[i], unit(drive)) : "–"}</td>`);
      return `<tr><th scope="row">${escape(drive.label)}</th>${cells.join("")}</tr>`;
    });
    return `<table class="plain"><thead><tr><th scope="col">drive</th>${head}</tr></thead><tbody>${body.join("")}</tbody></table>`;
  }
  // Where P is outside the declared box: what is computed there is said all the same.
  function beyond() {
    const [low, high] = live.view.machine.workspace;
    const axis = [0, 1, 2].find((i) => state.tool[i] < low[i] - 1e-9 || state.tool[i] > high[i] + 1e-9);
    return axis === undefined ? "" : ` ${"xyz"[axis]} = ${number(state.tool[axis])} mm is outside the workspace box, ${number(low[axis])} to ${number(high[axis])} mm.`;
  }
  function report() {
    const headline = find("headline");
    const facts = find("facts");
    const drives = find("drives");
    if (live.fault) {
      headline.textContent = live.fault;
      return;
    }
    if (state.mode === "map") {
      headline.textContent = map.headline();
      facts.innerHTML = rows(map.facts());
      drives.innerHTML = "";
      return;
    }
    if (state.mode === "tool") {
      const answer = live.tool;
      if (!answer) return;
      const moved = size(answer.displacement);
      const cloud = answer.displacement && live.cloud;
      // Errors of chains and lengths move it without load as well.
      const likely = cloud?.p95 != null ? `The tool is ${number(cloud.p95)} mm off with 95 % probability, ${number(cloud.nominal)} mm nominally (an estimate${cloud.assumed.length ? " that rests on assumptions" : ""}, not checked by draws of the engine)` : `The load moves the tool by ${number(moved)} mm${cloud ? " nominally" : ""}`;
      headline.textContent = answer.displacement
        ? `${likely}; the picture shows it ${number(live.factor)} times as large.${beyond()}`
        : `The machine cannot be loaded here: ${answer.reason || answer.status}`;
      const list = [];
      if (answer.displacement) list.push(["along x, y, z", answer.displacement.map(number).join(", ") + " mm"]);
      const spread = cloud && ["where the tool may be", cloud.p95 != null
        ? `a dot for each of ${cloud.displacements.length} machines and forces, pale beyond 95 %; how uncertain they are stands in ${escape(live.view.uncertain_by)}${cloud.assumed.length ? `, but by a default for ${escape(cloud.assumed.join(", "))}` : ""}` : `no cloud can be drawn: ${escape(cloud.reason || cloud.status)}`];
      if (answer.stiffness) list.push(["stiffness of the tool tip", `${number(answer.stiffness[0])} to ${number(answer.stiffness[2])} N/mm`]);
      if (answer.conditioning !== null) list.push(["distance to singularity", number(answer.conditioning)]);
      if (answer.branch) list.push(["branch", answer.branch]);
      if (answer.displacement && answer.not_compensated) list.push(["no compensation", escape(answer.not_compensated.reason)]);
      facts.innerHTML = rows(spread ? [...list, spread] : list);
      drives.innerHTML = answer.displacement ? drivesTable([
        ["position", answer.drives, (d) => d.unit], ["force", answer.forces, (d) => d.force_unit], ["correction", answer.corrections, (d) => d.unit],
      ]) : "";
      return;
    }
    const answer = live.part;
    if (!answer) return;
    const metric = (name) => answer.metrics.find((m) => m.name === name);
    const points = answer.features.flat();
    const worst = metric("worst_deflection");
    const tolerance = Math.min(...live.view.workpiece.features.map((f) => f.tolerance_mm));
    const seen = points.filter((p) => p.before);
    const least = live.exact ? "" : "at least ";
    const off = worst && seen.length ? `the tool leaves its path by ${answer.failure ? "at least " : least}${number(worst.value)} mm` : "";
    const judged = `${off}${worst?.value > tolerance ? `, more than the ${number(tolerance)} mm allowed` : `, within the ${number(tolerance)} mm allowed`}`;
    if (answer.failure) headline.textContent = `Here the workpiece cannot be cut: ${answer.failure.reason}${off ? `; where it can, ${off}` : ""}.`;
    else if (answer.outside_workspace) headline.textContent = `Here ${judged}, and the path leaves the workspace box: ${answer.outside_workspace.reason}.`;
    else headline.textContent = `Here ${judged}.`;
    const list = answer.metrics.map((m) => [escape(m.words), least + (m.unit ? Data.withUnit(m.value, m.unit) : number(100 * m.value) + " %")]);
    if (!live.exact) list.splice(0, 0, ["points looked at", `${points.length}, one of every ${answer.stride}: the rest follows when you let go`]);
    if (answer.objective !== null) {
      list.push(["objective, clamped exactly there: " + escape(live.view.workpiece.objective), number(answer.objective)]);
      if (scene.best) {
        const share = 100 * (answer.objective / scene.best.objective - 1);
        const words = Math.abs(share) < 0.05 ? "the same as" : `${number(Math.abs(share))} % ${share > 0 ? "worse" : "better"} than`;
        list.push([`against “${escape(scene.best.name)}”`, scene.best.objective > 0 ? `${words} ${number(scene.best.objective)}` : number(scene.best.objective)]);
      }
    }
    facts.innerHTML = rows(list);
    const most = (key) => live.view.machine.drives.map((_, i) => Math.max(...seen.filter((p) => p[key]).map((p) => Math.abs(p[key][i])), -Infinity));
    drives.innerHTML = seen.some((p) => p.forces) ? drivesTable([
      ["largest correction", most("corrections"), (d) => d.unit], ["largest force", most("forces"), (d) => d.force_unit],
    ]) : "";
  }

  // ---- Controls.
  const controls = [];
  const views = [];
  function control(parent, [label, unit], read, put, range, step) {
    const wrapper = document.createElement("label");
    const name = document.createElement("span");
    name.textContent = `${label} [${unit}]`;
    const pair = document.createElement("span");
    pair.className = "pair";
    const slider = Object.assign(document.createElement("input"), { type: "range", min: range[0], max: range[1], step });
    const field = Object.assign(document.createElement("input"), { type: "number", step: "any" });
    slider.setAttribute("aria-label", `${label}, ${unit}, slider`);
    field.setAttribute("aria-label", `${label}, ${unit}`);
    pair.append(slider, field);
    wrapper.append(name, pair);
    parent.append(wrapper);
    const take = (text) => {
      const value = Number(text);
      if (text === "" || !Number.isFinite(value)) return;
      put(value);
      changed();
    };
    slider.addEventListener("input", () => take(slider.value));
    field.addEventListener("change", () => take(field.value));
    controls.push({
      refresh: () => {
        slider.value = read();
        if (document.activeElement !== field) field.value = shown(read());
      },
    });
  }
  function make() {
    const { machine, workpiece } = live.view;
    const [low, high] = machine.workspace;
    const span = Math.max(...[0, 1, 2].map((i) => high[i] - low[i]));
    if (workpiece) {
      COORDINATES.forEach((coordinate, i) => {
        if (i > 3 && !workpiece.tilts[5 - i]) return;
        const middle = state.place[i];
        const range = i < 3 ? [middle - 0.6 * span, middle + 0.6 * span] : [-180, 180];
        control(find("part-controls"), coordinate, () => state.place[i], (v) => { state.place[i] = v; }, range, i < 3 ? span / 2000 : 0.25);
      });
    }
    TOOL.forEach((coordinate, i) => {
      if (i > 2 && !machine.turns) return;
      const range = i < 3 ? [Math.min(low[i], state.tool[i]), Math.max(high[i], state.tool[i])] : [-180, 180];
      control(find("tool-controls"), coordinate, () => state.tool[i], (v) => { state.tool[i] = v; }, range, i < 3 ? span / 2000 : 0.25);
    });
    FORCES.forEach((force, i) => control(find("force-controls"), force, () => state.wrench[i], (v) => { state.wrench[i] = v; }, i < 3 ? [-1000, 1000] : [-1e5, 1e5], i < 3 ? 1 : 100));
    control(find("map-controls"), ["height z", "mm"], () => state.level, (v) => { state.level = v; }, [low[2], high[2] > low[2] ? high[2] : low[2] + 1], Math.max(high[2] - low[2], 1) / 100);
    const words = { displacement: "displacement of the tool", correction: "largest drive correction", force: "largest drive force", conditioning: "distance to singularity" };
    const pick = find("quantity");
    Object.entries(words).forEach(([key, text]) => pick.add(new Option(text, key)));
    pick.value = state.quantity;
    pick.addEventListener("change", () => { state.quantity = pick.value; paint(); write(); });
    parameters();
  }
  // Numbers of the machine, stiffnesses first.
  function parameters() {
    const pick = find("parameter");
    const list = [...live.view.parameters].sort((a, b) => b.name.includes("stiffness") - a.name.includes("stiffness"));
    list.forEach((p) => pick.add(new Option(`${p.name}${p.unit ? ` [${p.unit}]` : ""}`, p.name)));
    const start = Object.fromEntries(list.map((p) => [p.name, p.value]));
    const field = find("value");
    const slider = find("factor");
    const show = () => {
      const value = state.set[pick.value] ?? start[pick.value];
      field.value = value;
      slider.value = start[pick.value] ? Math.log2(value / start[pick.value]) : 0;
      const names = Object.keys(state.set);
      find("set").textContent = names.length ? "Changed: " + names.map((n) => `${n} = ${number(state.set[n])}`).join(", ") : "As in the machine file.";
      find("reset").disabled = !names.length;
    };
    const put = async (value) => {
      if (!Number.isFinite(value)) return;
      const before = { ...state.set };
      if (value === start[pick.value]) delete state.set[pick.value];
      else state.set[pick.value] = value;
      if (!(await send())) state.set = before;
      show();
      changed();
    };
    pick.addEventListener("change", show);
    field.addEventListener("change", () => put(Number(field.value)));
    slider.addEventListener("input", () => put(start[pick.value] * 2 ** Number(slider.value)));
    find("reset").addEventListener("click", async () => { state.set = {}; await send(); show(); changed(); });
    show();
  }
  // Tells every engine which numbers the machine has.
  async function send() {
    const call = { call: "set", parameters: Object.entries(state.set) };
    try {
      await Promise.all([quick, whole].map((engine) => engine.ask(call)));
      map.set(call);
      say("");
      return true;
    } catch (fault) {
      say(fault.message);
      return false;
    }
  }
  const MODES = {
    part: "Drag the part, or turn it by its round handle. Arrow keys move it, Page Up and Page Down raise and lower it, [ and ] turn it; Shift for larger steps.",
    tool: "Drag the tool, or its force by the arrow's end, or turn it about its own axis by the round handle. Arrow keys, Page Up and Page Down move the tool, [ and ] turn it; Shift for larger steps.",
    map: "The map shows what the force does to the tool at each place at this height. It begins coarse and becomes finer.",
  };
  function choose(mode) {
    if (mode === "part" && !live.view.workpiece) return;
    state.mode = mode;
    section.dataset.mode = mode;
    section.querySelectorAll("[data-mode-button]").forEach((button) => button.setAttribute("aria-pressed", String(button.dataset.modeButton === mode)));
    find("help").textContent = MODES[mode];
    changed();
  }
  section.querySelectorAll("[data-mode-button]").forEach((button) => button.addEventListener("click", () => choose(button.dataset.modeButton)));
  find("best").addEventListener("click", () => {
    if (state.mode === "part") state.place = [...(scene.best?.place ?? start.place)];
    else [state.tool, state.wrench] = [[...start.tool], [...start.wrench]];
    changed();
  });

  // ---- What is taken along: the address, a study file, a command.
  const start = { place: null, tool: null, wrench: [...state.wrench] };
  let touched = false;
  function write() {
    if (!touched) return;
    const parts = { m: state.mode, t: state.tool.join(","), w: state.wrench.join(","), z: state.level, q: state.quantity };
    if (state.place) parts.p = state.place.join(",");
    const set = Object.entries(state.set).map(([name, value]) => `${name}=${value}`).join(";");
    if (set) parts.s = set;
    history.replaceState(null, "", "#try&" + new URLSearchParams(parts));
  }
  function readAddress() {
    if (!location.hash.startsWith("#try&")) return;
    const parts = new URLSearchParams(location.hash.slice(5));
    const list = (key, length) => {
      const values = (parts.get(key) ?? "").split(",").map(Number);
      return values.length === length && values.every(Number.isFinite) ? values : null;
    };
    state.place = state.place && (list("p", 6) ?? state.place);
    state.tool = list("t", 6) ?? state.tool;
    state.wrench = list("w", 6) ?? state.wrench;
    if (Number.isFinite(Number(parts.get("z") ?? NaN))) state.level = Number(parts.get("z"));
    if (["displacement", "correction", "force", "conditioning"].includes(parts.get("q"))) state.quantity = parts.get("q");
    for (const pair of (parts.get("s") ?? "").split(";")) {
      const [name, value] = pair.split("=");
      if (live.view.parameters.some((p) => p.name === name) && Number.isFinite(Number(value))) state.set[name] = Number(value);
    }
    if (parts.get("m") in MODES) state.mode = parts.get("m");
    touched = true;
  }
  async function copy(text, what) {
    const field = find("copied");
    field.hidden = false;
    field.value = text;
    try {
      await navigator.clipboard.writeText(text);
      say(`${what} is in the clipboard.`);
    } catch {
      field.focus();
      field.select();
      say(`${what} is selected below: copy it with Ctrl+C.`);
    }
  }
  const quoted = (word) => (/^[\w.,=+\-/:]+$/.test(word) ? word : `'${word.replaceAll("'", "'\\''")}'`);
  function command() {
    const { machine } = live.view;
    const place = machine.turns ? ["--pose", state.tool.join(",")] : ["--position", state.tool.slice(0, 3).join(",")];
    const set = Object.entries(state.set).flatMap(([name, value]) => ["--set", `${name}=${value}`]);
    const words = ["kinetostat", "point", "--machine", machine.name, ...place, "--wrench", state.wrench.join(","), ...machine.options, ...set];
    return words.map(quoted).join(" ");
  }
  find("copy-study").addEventListener("click", async () => {
    try {
      copy((await whole.ask({ call: "study_file", place: state.place })).answer, "The study file");
    } catch (fault) { say(fault.message); }
  });
  find("copy-command").addEventListener("click", () => copy(command(), "The command"));
  find("copy-link").addEventListener("click", () => { touched = true; write(); copy(location.href, "The address of this page as it is now"); });

  // ---- Hands.
  const box = () => {
    const { machine, workpiece } = live.view;
    const places = Space.corners(machine.workspace);
    const points = [...places, ...places.map((p) => Space.add(p, machine.tool[3]))];
    machine.home.chains.forEach((chain) => chain.links.forEach((line) => points.push(...line)));
    if (workpiece) points.push(...Space.corners(workpiece.extent).map((p) => Space.at(Space.frameOf(start.place, workpiece.base), p)));
    return [0, 1].map((end) => [0, 1, 2].map((i) => Math[end ? "max" : "min"](...points.map((p) => p[i]))));
  };
  // What is near a place on a canvas: part, handle, tool, arrow; null where nothing can be taken hold of.
  function held(view, x, y, reach) {
    const far = (p) => Math.hypot(view.to(p)[0] - x, view.to(p)[1] - y);
    const near = (p) => far(p) < reach;
    const marks = live.marks?.[view.name] ?? {};
    if (state.mode === "part") {
      if (marks.handle && near(marks.handle) && far(marks.handle) < far(marks.origin)) return "handle";
      if (marks.part && Space.inside(marks.part, [x, y])) return "part";
      return marks.origin && near(marks.origin) ? "part" : null;
    }
    if (marks.arrow && near(marks.arrow)) return "arrow";
    if (marks.spin && near(marks.spin)) return "spin";
    return marks.tool && near(marks.tool) ? "tool" : null;
  }
  // The tool turned about its own axis, its tip where it is.
  function spin(degrees) {
    const { columns, tip, axis } = toolFrame({ state, live });
    const angle = (degrees * Math.PI) / 180;
    const [arm] = Space.turned([Space.add(state.tool, tip, -1)], axis, angle);
    state.tool = [...Space.add(tip, arm), ...Space.angles(Space.turned(columns, axis, angle))];
  }
  // A way in O as a way of the coordinates of the place, which may be those of a carrier.
  const ofBase = (way) => live.view.workpiece.base.slice(0, 3).map((axis) => Space.dot(axis, way));
  function move(view, what, dx, dy, x, y) {
    touched = true;
    const way = view.way(dx, dy);
    if (what === "turn") {
      const angle = 0.01 * dx;
      const [r, u] = [view.right, view.up];
      const about = (v) => [v[0] * Math.cos(angle) - v[1] * Math.sin(angle), v[0] * Math.sin(angle) + v[1] * Math.cos(angle), v[2]];
      view.right = about(r);
      view.up = about(u);
      paint(view);
      return;
    }
    if (what === "part") ofBase(way).forEach((v, i) => { state.place[i] += v; });
    if (what === "tool") way.forEach((v, i) => { state.tool[i] += v; });
    if (what === "arrow") way.forEach((v, i) => { state.wrench[i] += v / live.newton; });
    if (what === "spin") {
      const { tip, axis } = toolFrame({ state, live });
      const arm = Space.add(live.marks[view.name].spin, tip, -1);
      const [ahead] = Space.turned([arm], axis, 0.01);
      const [a, b] = [view.to(Space.add(tip, arm)), view.to(Space.add(tip, ahead))];
      const way = [b[0] - a[0], b[1] - a[1]];
      const square = way[0] ** 2 + way[1] ** 2;
      if (square > 1e-6) spin((0.01 * (dx * way[0] + dy * way[1]) * 180) / square / Math.PI);
    }
    if (what === "handle") {
      const middle = view.to(live.marks[view.name].origin);
      const before = Math.atan2(y - dy - middle[1], x - dx - middle[0]);
      const turned = Math.atan2(y - middle[1], x - middle[0]) - before;
      const round = ((turned + 3 * Math.PI) % (2 * Math.PI)) - Math.PI;
      state.place[3] = wrap(state.place[3] - (round * 180) / Math.PI);
    }
    changed();
  }
  const wrap = (degrees) => ((((degrees + 180) % 360) + 360) % 360) - 180;
  function listen(view) {
    const { canvas } = view;
    let hand = null;
    const at = (event) => {
      const rect = canvas.getBoundingClientRect();
      return [event.clientX - rect.left, event.clientY - rect.top];
    };
    const take = (x, y, coarse) => held(view, x, y, coarse ? 32 : 16) ?? (view.name === "turned" ? "turn" : null);
    // A finger beside what can be dragged scrolls the page.
    canvas.addEventListener("touchstart", (event) => {
      if (event.touches.length === 1 && take(...at(event.touches[0]), true)) event.preventDefault();
    }, { passive: false });
    canvas.addEventListener("pointerdown", (event) => {
      const [x, y] = at(event);
      const what = take(x, y, event.pointerType === "touch");
      if (!what) return;
      hand = { what, x: event.clientX, y: event.clientY };
      canvas.setPointerCapture(event.pointerId);
    });
    canvas.addEventListener("pointermove", (event) => {
      const [x, y] = at(event);
      if (!hand) {
        canvas.style.cursor = take(x, y, false) ? "grab" : "";
        if (state.mode === "map" && view.name === "above") map.point(view, x, y);
        return;
      }
      // Of the window: words that grow may push the picture down.
      move(view, hand.what, event.clientX - hand.x, event.clientY - hand.y, x, y);
      [hand.x, hand.y] = [event.clientX, event.clientY];
    });
    const drop = () => { hand = null; };
    canvas.addEventListener("pointerup", drop);
    canvas.addEventListener("pointercancel", drop);
    canvas.addEventListener("keydown", (event) => {
      const { key, shiftKey } = event;
      const step = shiftKey ? 10 : 1;
      const up = view.name === "front" ? 2 : 1;
      const moves = {
        ArrowLeft: [0, -step], ArrowRight: [0, step], ArrowUp: [up, step], ArrowDown: [up, -step],
        PageUp: [2, step], PageDown: [2, -step], "[": [3, 1], "]": [3, -1], "{": [3, 10], "}": [3, -10],
      };
      const way = moves[key];
      if (!way || event.ctrlKey || event.metaKey || event.altKey) return;
      event.preventDefault();
      touched = true;
      const [axis, by] = way;
      if (state.mode === "part") state.place[axis] = axis === 3 ? wrap(state.place[3] + by) : state.place[axis] + by;
      else if (state.mode === "tool" && axis === 3 && live.view.machine.turns) spin(by);
      else if (state.mode === "tool" && axis < 3) state.tool[axis] += by;
      else if (state.mode === "map" && axis === 2) state.level += by;
      changed();
    });
    new ResizeObserver(paint).observe(canvas);
  }

  const map = sliceMap({ state, live, find, paint, load, open: () => scene });
  const reach = reachMap({ state, live, find, paint, load, views, ask: (question) => whole.ask(question) });
  async function open() {
    say("The engine is being started.");
    [quick, whole] = await Promise.all([Engine.start(), Engine.start()]);
    const [{ answer: view }] = await Promise.all([quick, whole].map((engine) => engine.ask({ call: "open", ...scene })));
    live.view = view;
    const { machine, workpiece } = view;
    start.tool = [...machine.home_pose];
    const inside = machine.home_pose.slice(0, 3).every((v, i) => v >= machine.workspace[0][i] && v <= machine.workspace[1][i]);
    if (!inside) [0, 1, 2].forEach((i) => { start.tool[i] = 0.5 * (machine.workspace[0][i] + machine.workspace[1][i]); });
    state.tool = [...start.tool];
    state.level = state.tool[2];
    if (workpiece) {
      start.place = scene.best?.place ?? workpiece.candidates[0]?.[1] ?? workpiece.bounds[0].map((v, i) => 0.5 * (v + workpiece.bounds[1][i]));
      state.place = [...start.place];
      state.mode = "part";
    }
    readAddress();
    if (state.mode === "part" && !workpiece) state.mode = "tool";
    const seen = box();
    const s = Math.SQRT1_2;
    for (const [name, right, up] of [["above", [1, 0, 0], [0, 1, 0]], ["front", [1, 0, 0], [0, 0, 1]], ["turned", [s, -s, 0], [0.35, 0.35, 0.87]]]) {
      const own = Object.assign(Space.view(find(name), right, up, seen), { name });
      views.push(own);
      listen(own);
    }
    find("part-button").hidden = !workpiece;
    find("copy-study").hidden = !workpiece;
    find("uncontrolled").textContent = machine.uncontrolled ? `The drives do not control everything: ${machine.uncontrolled}.` : "";
    make();
    if (Object.keys(state.set).length) await send();
    say(quick.inPage ? "This browser makes no workers for a page from disk: the page itself computes, and may be slow to follow." : "");
    find("panel").hidden = false;
    Theme.onChange(paint);
    choose(state.mode);
    document.documentElement.dataset.engine = "ready";
  }
  // For tests, and for whoever wants the numbers.
  const resting = () => !busy && !stale && !clouded && !live.reach.busy && (state.mode !== "part" || live.exact || live.fault !== null);
  window.kinetostat = { state, live, map, views, resting, ask: (question) => whole.ask(question), changed, command };
  open().catch((fault) => {
    say(`The engine does not run here: ${fault.message}`);
    document.documentElement.dataset.engine = "failed";
  });
}

{
  const section = document.getElementById("try");
  // Only when it comes into sight: a page is read first.
  new IntersectionObserver((entries, observer) => {
    if (!entries.some((entry) => entry.isIntersecting)) return;
    observer.disconnect();
    setTimeout(() => explore(section), 0);
  }, { rootMargin: "200px" }).observe(section);
}
