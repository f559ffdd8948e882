"use strict";
// A plane of the workspace, coarse to fine, split among engines.
function sliceMap({ state, live, paint, load, open }) {
  const STEPS = [7, 15, 31, 63];
  const TASK = 24;
  let engines = null;
  let setting = null;
  let generation = 0;
  let pointed = null;
  const UNITS = { displacement: () => "mm", correction: () => live.view.machine.drives[0].unit, force: () => live.view.machine.drives[0].force_unit, conditioning: () => "" };
  const countsOf = (step) => {
    const [low, high] = live.view.machine.workspace;
    const [a, b] = [high[0] - low[0], high[1] - low[1]];
    const most = Math.max(a, b, 1e-9);
    return [a, b].map((length) => Math.max(1, Math.round(1 + (step - 1) * (length / most))));
  };
  async function start() {
    if (!engines) {
      const count = Math.max(1, Math.min(4, (navigator.hardwareConcurrency || 2) - 1));
      engines = Promise.all(Array.from({ length: count }, async () => {
        const engine = await Engine.start();
        await engine.ask({ call: "open", ...open() });
        if (setting) await engine.ask(setting);
        return engine;
      }));
    }
    return engines;
  }
  async function restart() {
    const own = ++generation;
    const wanted = JSON.stringify([state.level, state.wrench, state.set]);
    if (live.map?.wanted === wanted && live.map.done) { paint(); return; }
    try {
      const workers = await start();
      for (const step of STEPS) {
        const counts = countsOf(step);
        const total = counts[0] * counts[1];
        const made = { wanted, counts, level: state.level, values: {}, failures: [], known: 0, total, done: false };
        for (const key of Object.keys(UNITS)) made.values[key] = new Array(total).fill(null);
        const tasks = Array.from({ length: Math.ceil(total / TASK) }, (_, i) => [i * TASK, Math.min(total, (i + 1) * TASK)]);
        await Promise.all(workers.map(async (engine) => {
          for (let task = tasks.shift(); task && own === generation; task = tasks.shift()) {
            const { answer } = await engine.ask({ call: "slice", axis: 2, level: state.level, counts, nodes: task, load: load() });
            for (const key of Object.keys(UNITS)) answer[key].forEach((value, i) => { made.values[key][task[0] + i] = value; });
            made.failures.push(...answer.failures);
            made.known += answer.conditioning.length;
          }
        }));
        if (own !== generation) return;
        made.done = step === STEPS.at(-1);
        live.map = made;
        paint();
      }
    } catch (fault) {
      if (own !== generation) return;
      live.fault = fault.message;
      paint();
    }
  }
  const numbers = () => live.map.values[state.quantity].filter((v) => v !== null);
  const node = (i, j) => {
    const [low, high] = live.view.machine.workspace;
    const along = (k, axis, count) => (count > 1 ? low[axis] + ((high[axis] - low[axis]) * k) / (count - 1) : low[axis]);
    return [along(i, 0, live.map.counts[0]), along(j, 1, live.map.counts[1])];
  };
  function draw(view) {
    if (!live.map) return;
    const [low, high] = live.view.machine.workspace;
    const { counts, values } = live.map;
    const own = values[state.quantity];
    const known = numbers();
    const [least, most] = [Math.min(...known), Math.max(...known)];
    const half = [0, 1].map((axis) => (high[axis] - low[axis]) / Math.max(counts[axis] - 1, 1) / 2);
    for (let j = 0; j < counts[1]; j++) {
      for (let i = 0; i < counts[0]; i++) {
        const value = own[j * counts[0] + i];
        const [x, y] = node(i, j);
        const fill = value === null ? Theme.colour("panel") : heat((value - least) / Math.max(most - least, 1e-300));
        view.cell([x - half[0], y - half[1], live.map.level], [x + half[0], y + half[1], live.map.level], fill);
      }
    }
  }
  function point(view, x, y) {
    if (!live.map) return;
    const [low, high] = live.view.machine.workspace;
    const way = view.way(x - view.canvas.clientWidth / 2, y - view.canvas.clientHeight / 2);
    const at = [view.centre[0] + way[0], view.centre[1] + way[1]];
    const index = [0, 1].map((axis) => Math.round(((at[axis] - low[axis]) / Math.max(high[axis] - low[axis], 1e-9)) * (live.map.counts[axis] - 1)));
    pointed = index.every((k, axis) => k >= 0 && k < live.map.counts[axis]) ? index : null;
    paint();
  }
  function headline() {
    if (!live.map) return "The map is being computed.";
    const known = numbers();
    if (!known.length) return `At z = ${Data.number(live.map.level)} mm the machine can be loaded nowhere.`;
    const unit = UNITS[state.quantity]();
    const words = { displacement: "the tool moves by", correction: "drives must be corrected by up to", force: "drives carry up to", conditioning: "the distance to singularity is" };
    return `At z = ${Data.number(live.map.level)} mm ${words[state.quantity]} ${Data.number(Math.min(...known))} to ${Data.withUnit(Math.max(...known), unit)}, dark to light.`;
  }
  function facts() {
    if (!live.map) return [];
    const { counts, total, failures, done } = live.map;
    const list = [["nodes", `${counts[0]} × ${counts[1]}${done ? "" : ", becoming finer"}`]];
    if (failures.length) list.push(["without an answer", `${failures.length} of ${total}, such as: ${failures[0][1].reason.replace(/[&<>]/g, " ")}`]);
    if (pointed) {
      const value = live.map.values[state.quantity][pointed[1] * counts[0] + pointed[0]];
      const [x, y] = node(...pointed ?? []);
      list.push([`at (${Data.number(x)}, ${Data.number(y)}) mm`, value === null ? "no answer" : Data.withUnit(value, UNITS[state.quantity]())]);
    }
    return list;
  }
  async function set(call) {
    setting = call;
    generation++;
    if (engines) await Promise.all((await engines).map((engine) => engine.ask(call)));
  }
  return { restart, draw, point, headline, facts, set };
}

// Where the machine can stand with the tool as it is turned, in a plane of each view: asked of the engine point by point, on a coarse grid.
function reachMap({ state, live, find, paint, load, views, ask }) {
  const ALONG = 15;
  const PLANES = { above: [0, 1, 2], front: [0, 2, 1] };
  let generation = 0;
  async function restart() {
    const own = ++generation;
    const { turns } = live.view.machine;
    const isPart = state.mode === "part";
    // The tip at the height of the part, or where the tool is pulled.
    const offset = toolFrame({ state, live }).offset;
    const tip = isPart ? Space.frameOf(state.place, live.view.workpiece.base)[3] : Space.add(state.tool, offset);
    live.reach.busy = true;
    for (const [name, [a, b, across]] of Object.entries(PLANES)) {
      const wanted = JSON.stringify([tip[across], state.tool.slice(3), isPart, !isPart && state.wrench, state.set]);
      if (live.reach[name]?.wanted === wanted) continue;
      // All of the picture, so that an edge within it is one of the machine.
      const view = views.find((one) => one.name === name);
      const half = [view.canvas.clientWidth, view.canvas.clientHeight].map((length) => length / 2 / view.scale);
      const step = (2 * Math.max(...half)) / ALONG;
      const counts = half.map((length) => Math.max(1, Math.ceil((2 * length) / step)));
      const low = half.map((length, i) => view.centre[i] - length);
      const found = { wanted, step, counts, low, level: tip[across], axes: [a, b, across], reached: [] };
      for (let k = 0; k < counts[0] * counts[1]; k++) {
        const at = [...tip];
        at[a] = low[0] + step * ((k % counts[0]) + 0.5);
        at[b] = low[1] + step * (Math.floor(k / counts[0]) + 0.5);
        const place = Space.add(at, offset, -1);
        const question = { call: "tool", at: turns ? { pose: [...place, ...state.tool.slice(3)] } : { position: place }, load: isPart ? { wrench: [0, 0, 0, 0, 0, 0] } : load() };
        const { answer } = await ask(question).catch(() => ({ answer: {} }));
        if (own !== generation) return;
        if (answer.displacement) found.reached.push(at);
      }
      live.reach[name] = found;
      find("reach-" + name).textContent = `. Shaded: where the machine reaches at ${"xyz"[across]} = ${Data.number(Number(found.level.toFixed(3)))} mm, coarse, every ${Data.number(Math.round(step))} mm`;
      paint();
    }
    live.reach.busy = false;
  }
  return { restart };
}
function drawReach(view, live, colour) {
  for (const [name, plane] of Object.entries(live.reach)) {
    if (!plane?.reached || (view.name !== name && view.name !== "turned")) continue;
    const [a, b] = plane.axes;
    for (const at of plane.reached) {
      if (view.name === "turned") { view.dot(at, 1.2, colour.line); continue; }
      const [low, high] = [[...at], [...at]];
      for (const axis of [a, b]) [low[axis], high[axis]] = [at[axis] - plane.step / 2, at[axis] + plane.step / 2];
      view.cell(low, high, colour["accent-soft"]);
    }
  }
}
