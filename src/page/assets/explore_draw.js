"use strict";
// Machine, workpiece, path and load on one view.
function drawScene(view, { state, live, scene, frame, map }) {
  const colour = Object.fromEntries(["ink", "muted", "line", "accent", "accent-soft", "warn", "ground", "panel", "zero", "c1", "c2", "c3", "c4"].map((name) => [name, Theme.colour(name)]));
  const { machine, workpiece } = live.view;
  const marks = {};
  live.marks = { ...live.marks, [view.name]: marks };
  view.clear();
  if (state.mode === "map" && view.name === "above") map.draw(view);
  if (state.mode !== "map" || view.name !== "above") drawReach(view, live, colour);
  view.edges(Space.corners(machine.workspace), colour.zero, 1, [5, 4]);
  for (const [name, ends] of workpiece?.forbidden ?? []) {
    const c = workpiece.clearance_mm;
    view.area(Space.corners([ends[0].map((v) => v - c), ends[1].map((v) => v + c)]), null, colour.warn, 1, [3, 3]);
    view.area(Space.corners(ends), colour.warn + "33", colour.warn, 1.5);
    view.text(ends[1], name, colour.warn, -30, 14);
  }
  // The machine, bent: where the tool is pulled, or where it leaves the part's path by most; else at home.
  const tool = state.mode === "tool" ? live.tool : null;
  const there = state.mode === "part" ? live.part?.machine : null;
  const stands = tool?.commanded ?? there?.commanded ?? machine.home;
  lines(view, machine.carrier, colour.muted, 1);
  lines(view, stands, state.mode === "part" && !there ? colour.line : colour.muted, 2.5);
  if (there) marks.machine = there.commanded.tool_tip_mm;
  if (tool?.commanded && tool.loaded) {
    live.factor = amplification(view, tool);
    const moved = bent(tool.commanded, tool.loaded, live.factor);
    lines(view, moved, colour.c2, 2.5);
    // Draws beside the nominal tip: from where the tool is now, of a cloud that may be that of a place just left.
    if (live.cloud?.displacements.length) {
      const from = Space.add(moved.tool_tip_mm, tool.displacement ?? [0, 0, 0], -live.factor);
      const isPale = (way) => Math.hypot(...way) > live.cloud.p95;
      live.cloud.displacements.forEach((way) => view.dot(Space.add(from, way, live.factor), 1.6, colour.c4 + (isPale(way) ? "50" : "b0")));
      view.dot(moved.tool_tip_mm, 2.5, colour.ink);
    }
  }
  if (workpiece && frame) {
    if (scene.best) {
      const best = Space.frameOf(scene.best.place, workpiece.base);
      view.area(Space.corners(workpiece.extent).map((p) => Space.at(best, p)), null, colour.c3, 1.5, [4, 4]);
      view.text(Space.at(best, workpiece.extent[1]), scene.best.name, colour.c3);
    }
    const corners = Space.corners(workpiece.extent).map((p) => Space.at(frame, p));
    marks.part = view.area(corners, colour.accent + "22", colour.accent, 2);
    for (const feature of workpiece.features) view.line(feature.points.map((p) => Space.at(frame, p)), colour.muted, 1);
    if (state.mode === "part") errors(view, live, frame, colour);
    if (there) lines(view, bent(there.commanded, there.loaded, live.magnified), colour.c2, 2.5);
    marks.origin = frame[3];
    const reach = 0.62 * Math.max(...[0, 1].map((i) => workpiece.extent[1][i] - workpiece.extent[0][i]), 70 / view.scale);
    if (state.mode === "part") {
      view.dot(frame[3], 4, colour.accent);
      if (view.name === "above") {
        marks.handle = Space.add(frame[3], frame[0], reach);
        view.line([frame[3], marks.handle], colour.accent, 1.5);
        view.dot(marks.handle, 7, colour.ground, colour.accent);
      }
    }
  }
  if (tool || state.mode === "map") {
    const tip = tool?.commanded?.tool_tip_mm ?? Space.add(state.tool.slice(0, 3), machine.tool[3]);
    marks.tool = tip;
    const force = state.wrench.slice(0, 3);
    const size = Math.hypot(...force);
    // Newtons as lengths: the same for all views, so that the arrow can be drawn out.
    if (view.name === "above" || !live.newton) live.newton = 0.35 / view.scale;
    view.dot(tip, 7, colour.c1);
    if (tool?.commanded && machine.turns) {
      const { side, axis } = toolFrame({ state, live });
      const [out] = Space.turned([side], axis, 2.4);
      const reach = 44 / view.scale;
      view.line(Array.from({ length: 49 }, (_, k) => Space.add(tip, Space.turned([out], axis, (k * Math.PI) / 24)[0], reach)), colour.c1, 1, [3, 3]);
      marks.spin = Space.add(tip, out, reach);
      view.dot(marks.spin, 6, colour.ground, colour.c1);
    }
    if (size > 0) {
      marks.arrow = Space.add(tip, force, live.newton);
      view.arrow(tip, marks.arrow, colour.c1);
    }
  }
}

// The tool as it is commanded: columns of its rotation, its tip, and its axis upwards.
function toolFrame({ state, live }) {
  const { machine } = live.view;
  const rotation = ([, , , roll, pitch, yaw]) => Space.frameOf([0, 0, 0, yaw, pitch, roll], [[1, 0, 0], [0, 1, 0], [0, 0, 1], [0, 0, 0]]);
  const [home, now] = [rotation(machine.home_pose), rotation(state.tool)];
  // From O at home to O as it is turned now.
  const turn = (v) => Space.at(now, [0, 1, 2].map((i) => Space.dot(home[i], v)));
  const [side, , axis] = machine.tool.slice(0, 3).map(turn);
  const offset = turn(machine.tool[3]);
  return { columns: now.slice(0, 3), side, axis: axis.map((v) => (axis[2] < 0 ? -v : v)), offset, tip: Space.add(state.tool, offset) };
}

function lines(view, skeleton, colour, width) {
  for (const chain of skeleton?.chains ?? []) {
    chain.links.forEach((line) => view.line(line, colour, width));
    (chain.springs ?? []).forEach((line) => view.line(line, colour, 1, [2, 2]));
    chain.joints.filter((joint) => joint.is_drive).forEach((joint) => view.dot(joint.position_mm, 3, colour));
  }
  if (skeleton) view.line([skeleton.platform_mm, skeleton.tool_tip_mm], colour, width + 1);
}

// A round number by which displacements are drawn larger: the tool's as a sixteenth of the picture.
function amplification(view, { commanded, loaded }) {
  const moved = Math.hypot(...Space.add(loaded.tool_tip_mm, commanded.tool_tip_mm, -1));
  return Data.larger(view.canvas.clientWidth / 16 / view.scale / moved);
}

function bent(from, to, factor) {
  const between = (a, b) => Space.add(a, Space.add(b, a, -1), factor);
  return {
    chains: to.chains.map((chain, c) => ({
      links: chain.links.map((line, l) => line.map((p, i) => between(from.chains[c].links[l][i], p))),
      springs: (chain.springs ?? []).map((line, l) => line.map((p, i) => between(from.chains[c].springs[l][i], p))),
      joints: chain.joints.map((joint, j) => ({ ...joint, position_mm: between(from.chains[c].joints[j].position_mm, joint.position_mm) })),
    })),
    platform_mm: between(from.platform_mm, to.platform_mm),
    tool_tip_mm: between(from.tool_tip_mm, to.tool_tip_mm),
  };
}

// The path where the tool really goes, errors drawn larger, coloured by their share of the largest.
function errors(view, live, frame, colour) {
  const part = live.part;
  if (!part) return;
  // The answer may be that of a place just left: it is drawn where the part is now.
  const moved = (p) => Space.at(frame, [0, 1, 2].map((i) => Space.dot(part.workpiece[i], Space.add(p, part.workpiece[3], -1))));
  const turned = (v) => Space.add(moved(Space.add(part.workpiece[3], v)), moved(part.workpiece[3]), -1);
  const points = part.features.flat();
  const worst = Math.max(...points.filter((p) => p.before).map((p) => Math.hypot(...p.before)), 1e-12);
  const factor = Data.larger(view.canvas.clientWidth / 30 / view.scale / worst);
  live.magnified = factor;
  for (const feature of part.features) {
    for (let i = 1; i < feature.length; i++) {
      const [a, b] = [feature[i - 1], feature[i]];
      const bad = a.failure || b.failure;
      const at = (p) => Space.add(moved(p.wanted), p.before ? turned(p.before) : [0, 0, 0], factor);
      const share = b.before ? Math.hypot(...b.before) / worst : 0;
      view.line([at(a), at(b)], bad ? colour.warn : heat(share), 2.2);
    }
    feature.filter((p) => p.failure).slice(0, 200).forEach((p) => view.dot(moved(p.wanted), 3.5, colour.warn));
  }
}

// Viridis.
const VIRIDIS = [[68, 1, 84], [59, 82, 139], [33, 145, 140], [94, 201, 98], [253, 231, 37]];
function heat(share) {
  const x = Math.min(Math.max(share, 0), 1) * 4;
  const i = Math.min(Math.floor(x), 3);
  const [a, b] = [VIRIDIS[i], VIRIDIS[i + 1]];
  return `rgb(${a.map((v, k) => Math.round(v + (x - i) * (b[k] - v))).join(",")})`;
}

// Error along the path, before and after the correction, with the tolerance.
function drawChart(canvas, { state, live }) {
  if (state.mode !== "part" || !live.part) return;
  const ratio = window.devicePixelRatio || 1;
  const [width, height] = [canvas.clientWidth, canvas.clientHeight];
  canvas.width = Math.round(width * ratio);
  canvas.height = Math.round(height * ratio);
  const context = canvas.getContext("2d");
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, width, height);
  const colour = (name) => Theme.colour(name);
  const { features } = live.view.workpiece;
  let offset = 0;
  const before = [];
  const after = [];
  live.part.features.forEach((points, f) => {
    for (const point of points) {
      const x = offset + features[f].arc_length[point.index];
      before.push([x, point.before ? Math.hypot(...point.before) : NaN]);
      after.push([x, point.after ? Math.hypot(...point.after) : NaN]);
    }
    offset += features[f].arc_length.at(-1) ?? 0;
  });
  const tolerance = Math.min(...features.map((f) => f.tolerance_mm));
  const top = 1.08 * Math.max(tolerance, ...before.map(([, y]) => (Number.isFinite(y) ? y : 0)));
  const [left, right, low, high] = [52, width - 10, height - 34, 28];
  const at = ([x, y]) => [left + ((right - left) * x) / Math.max(offset, 1e-9), low - ((low - high) * y) / top];
  context.font = "12px system-ui, sans-serif";
  context.fillStyle = colour("muted");
  context.strokeStyle = colour("grid");
  context.lineWidth = 1;
  for (let k = 0; k <= 4; k++) {
    const [, y] = at([0, (top * k) / 4]);
    context.beginPath();
    context.moveTo(left, y);
    context.lineTo(right, y);
    context.stroke();
    context.textAlign = "right";
    context.fillText(Data.number((top * k) / 4), left - 6, y + 4);
  }
  context.textAlign = "left";
  context.fillText("error [mm]", 4, 11);
  context.textAlign = "right";
  context.fillText(`way along the path, 0 to ${Data.number(offset)} mm`, right, height - 8);
  const curve = (points, stroke, dash, wide) => {
    context.beginPath();
    let open = false;
    for (const point of points) {
      if (!Number.isFinite(point[1])) { open = false; continue; }
      context[open ? "lineTo" : "moveTo"](...at(point));
      open = true;
    }
    context.setLineDash(dash);
    context.strokeStyle = stroke;
    context.lineWidth = wide;
    context.stroke();
    context.setLineDash([]);
  };
  curve([[0, tolerance], [offset, tolerance]], colour("warn"), [6, 4], 1.5);
  curve(before, colour("c2"), [], 2);
  curve(after, colour("c3"), [], 2);
  context.textAlign = "left";
  [["as programmed", "c2"], ["compensated", "c3"], ["tolerance", "warn"]].reduce((x, [words, name]) => {
    context.fillStyle = colour(name);
    context.fillText(words, x, 11);
    return x + context.measureText(words).width + 14;
  }, 84);
}
