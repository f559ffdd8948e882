// A grid of values: slices as colour maps, and the workspace in three dimensions.
function gridView(article, data) {
  const charts = article.querySelector(".charts");
  const readout = article.querySelector(".readout");
  const controls = article.querySelector(".controls");
  const cases = data.cases;
  const first = cases[0];
  const coordinates = data.coordinates;
  const lengths = (one) => one.axes.map((axis) => axis.length);
  const spatial = [2, 1, 0].filter((axis) => axis < coordinates.length && coordinates.length > 2);
  const state = { quantity: 0, group: 0, normal: 2, place: coordinates.map(() => 0), machine: false };
  const usable = spatial.filter((axis) => [0, 1, 2].filter((other) => other !== axis).every((other) => first.axes[other].length > 1));
  state.normal = usable.includes(2) ? 2 : usable[0] ?? 2;
  const middle = (axis) => first.axes[axis][Math.floor(first.axes[axis].length / 2)];
  state.place = coordinates.map((_, axis) => middle(axis));

  // Position on an axis nearest to a coordinate.
  function nearest(axis, value) {
    let best = 0;
    axis.forEach((other, index) => {
      if (Math.abs(other - value) < Math.abs(axis[best] - value)) best = index;
    });
    return best;
  }
  const node = (one, at) => {
    let index = 0;
    for (let axis = at.length - 1; axis >= 0; axis--) index = index * one.axes[axis].length + at[axis];
    return index;
  };
  const series = (one) => Data.unpack(one.series[state.quantity][state.group]);
  const label = () => data.labels[state.quantity];
  const unit = () => data.units[state.quantity];
  const groupName = () => data.groups[state.group] ?? "";
  function notesOf(one) {
    one.noteMaps = one.noteMaps ?? [];
    one.noteMaps[state.group] = one.noteMaps[state.group] ?? new Map(one.flags[state.group] ?? []);
    return one.noteMaps[state.group];
  }
  // One colour scale for all results; differences have their own around zero.
  function range(difference) {
    const packed = cases.filter((one) => one.is_difference === difference).map((one) => one.series[state.quantity][state.group]).filter(Boolean);
    if (packed.length === 0) return [0, 1];
    const low = Math.min(...packed.map((p) => p.low));
    const high = Math.max(...packed.map((p) => p.high));
    if (difference) {
      const most = Math.max(Math.abs(low), Math.abs(high)) || 1;
      return [-most, most];
    }
    return high > low ? [low, high] : [low - 0.5, high + 0.5];
  }
  const along = (axis, value) => coordinates[axis].label + " = " + Data.withUnit(value, coordinates[axis].unit);
  function hover(one, at, value) {
    const note = notesOf(one).get(node(one, at));
    const lines = at.map((index, axis) => [axis, index]).filter(([axis]) => one.axes[axis].length > 1).map(([axis, index]) => along(axis, one.axes[axis][index]));
    lines.push("<b>" + Chart.text(label()) + " " + (Number.isFinite(value) ? Data.withUnit(value, unit()) : "no number") + "</b>");
    if (note !== undefined) {
      const words = one.notes[note];
      lines.push(Chart.text(words.length > 90 ? words.slice(0, 88) + "\u2026" : words));
    }
    return lines.join("<br>");
  }

  // The values of a plane: `rows` and `columns` are axes, `at` the position on the others.
  function plane(one, columns, rows, at) {
    const values = series(one);
    const z = [];
    const text = [];
    for (let r = 0; r < one.axes[rows].length; r++) {
      const line = [];
      const words = [];
      for (let c = 0; c < one.axes[columns].length; c++) {
        const here = at.slice();
        here[columns] = c;
        here[rows] = r;
        const value = values ? values[node(one, here)] : NaN;
        line.push(Number.isFinite(value) ? value : null);
        words.push(hover(one, here, value));
      }
      z.push(line);
      text.push(words);
    }
    return { z, text };
  }
  const placeOf = (one) => state.place.map((value, axis) => nearest(one.axes[axis], value));

  const panels = cases.map((one) => ({ one, ...Controls.chart(charts, one.name) }));
  function drawSlice({ one, plot, heading }) {
    const [columns, rows] = [0, 1, 2].filter((axis) => axis !== state.normal);
    const at = placeOf(one);
    const { z, text } = plane(one, columns, rows, at);
    const [low, high] = range(one.is_difference);
    const cut = at.map((index, axis) => [axis, index]).filter(([axis]) => axis !== columns && axis !== rows && (one.axes[axis].length > 1 || axis === state.normal));
    const words = cut.map(([axis, index]) => along(axis, one.axes[axis][index])).join(", ");
    const sense = one.is_difference ? " (orange: " + one.name.charAt(0) + " is larger)" : "";
    heading.textContent = (cases.length > 1 ? one.name + ", " : "Slice at ") + words + sense;
    const x = one.axes[columns];
    const y = one.axes[rows];
    const traces = [{
      type: "heatmap", x, y, z, text, hovertemplate: "%{text}<extra></extra>", zmin: low, zmax: high,
      colorscale: one.is_difference ? DIVERGING : "Viridis",
      colorbar: Chart.bar(Data.labelled(one.is_difference ? "difference of " + label() : label(), unit())), xgap: 0, ygap: 0,
    }];
    // Marks of this slice: off the plane by at most half a step.
    const isNear = (mark) => at.every((index, axis) => {
      const level = one.axes[axis];
      if (axis === columns || axis === rows || level.length < 2) return true;
      return Math.abs(mark.position[axis] - level[index]) <= 0.5 * Math.abs(level[1] - level[0]) + 1e-9;
    });
    const marks = data.marks.filter(isNear);
    traces.push({
      type: "scatter", mode: "markers+text", hoverinfo: "skip", cliponaxis: false,
      x: marks.map((mark) => mark.position[columns]), y: marks.map((mark) => mark.position[rows]),
      text: marks.map((mark) => "<b>" + Chart.text(mark.label) + "</b>"), textposition: marks.map((mark) => textPosition(mark, columns, rows, x, y)),
      textfont: { color: "#000", shadow: "0 0 3px #fff, 0 0 3px #fff, 0 0 3px #fff" },
      marker: { size: 9, color: "#fff", line: { width: 2.5, color: "#000" } },
    });
    const axis = (index, values, more) => Chart.axis(Data.labelled(coordinates[index].label, coordinates[index].unit), Object.assign({ zeroline: false, showgrid: false }, more));
    const alike = coordinates[columns].unit === coordinates[rows].unit && x.length > 1 && y.length > 1;
    const layout = Chart.layout({
      margin: { l: 62, r: 22, t: 14, b: 112 },
      xaxis: axis(columns, x, { constrain: "domain" }),
      yaxis: axis(rows, y, alike ? { scaleanchor: "x", constrain: "domain" } : {}),
    });
    // Axes of equal scale keep the ranges of the slice before.
    const draw = plot.dataset.normal === String(state.normal) ? Plotly.react : Plotly.newPlot;
    plot.dataset.normal = state.normal;
    draw(plot, traces, layout, Chart.config);
    plot.setAttribute("aria-label", "Colour map of " + label() + " " + groupName() + ", " + words);
  }
  // Labels stay on the map.
  function textPosition(mark, columns, rows, x, y) {
    const side = (value, axis) => (value - axis[0]) / (axis[axis.length - 1] - axis[0] || 1);
    const across = side(mark.position[columns], x);
    const up = side(mark.position[rows], y);
    return (up > 0.85 ? "bottom" : "top") + " " + (across > 0.85 ? "left" : across < 0.15 ? "right" : "center");
  }

  function describe() {
    const parts = cases.filter((one) => !one.is_difference).map((one) => {
      const [columns, rows] = [0, 1, 2].filter((axis) => axis !== state.normal);
      const values = plane(one, columns, rows, placeOf(one)).z.flat().filter((value) => value !== null);
      const all = one.axes[columns].length * one.axes[rows].length;
      const name = cases.length > 1 ? one.name + ": " : "";
      if (values.length === 0) return name + "no numbers on this slice";
      const mean = values.reduce((sum, value) => sum + value, 0) / values.length;
      const missing = all > values.length ? "; " + (all - values.length) + " of " + all + " nodes have none" : "";
      return name + Data.withUnit(values.reduce((a, b) => Math.min(a, b)), unit()) + " to " + Data.withUnit(values.reduce((a, b) => Math.max(a, b)), unit()) + ", mean " + Data.withUnit(mean, unit()) + missing;
    });
    readout.textContent = "This slice, " + label() + (groupName() ? " (" + groupName() + ")" : "") + ": " + parts.join(". ") + ".";
  }

  // Three dimensions, for a single result over a box.
  const isBox = cases.length === 1 && [0, 1, 2].every((axis) => coordinates[axis] && first.axes[axis].length > 1);
  let space = null;
  let isSpaceSeen = false;
  if (isBox) {
    space = Controls.chart(charts, "Workspace: this slice and the far walls", "space");
    if (Chart.hasWebGl()) {
      const turns = document.createElement("div");
      turns.className = "turns";
      space.box.append(turns);
      Controls.button(turns, "\u2190", "Turn the view left", () => turn(-0.35, 0));
      Controls.button(turns, "\u2192", "Turn the view right", () => turn(0.35, 0));
      Controls.button(turns, "\u2191", "Look from higher up", () => turn(0, 0.2));
      Controls.button(turns, "\u2193", "Look from lower down", () => turn(0, -0.2));
      Controls.button(turns, "Reset view", "Reset the view", () => setEye(HOME_EYE));
      new IntersectionObserver((entries, observer) => {
        if (!entries.some((entry) => entry.isIntersecting)) return;
        observer.disconnect();
        isSpaceSeen = true;
        drawSpace();
      }, { rootMargin: "200px" }).observe(space.plot);
    } else {
      space.plot.className = "missing";
      space.plot.removeAttribute("role");
      space.plot.textContent = "This browser offers no WebGL, so there is no view in three dimensions here. The slices show the same values.";
      space = null;
    }
  }
  const HOME_EYE = { x: 1.6, y: 1.6, z: 1.2 };
  let eye = HOME_EYE;
  function setEye(next) {
    eye = next;
    Plotly.relayout(space.plot, { "scene.camera.eye": eye });
  }
  function turn(around, up) {
    const seen = space.plot._fullLayout?.scene?.camera?.eye ?? eye;
    const reach = Math.hypot(seen.x, seen.y, seen.z);
    const azimuth = Math.atan2(seen.y, seen.x) + around;
    const elevation = Math.max(-1.5, Math.min(1.5, Math.asin(seen.z / reach) + up));
    setEye({ x: reach * Math.cos(elevation) * Math.cos(azimuth), y: reach * Math.cos(elevation) * Math.sin(azimuth), z: reach * Math.sin(elevation) });
  }
  function drawSpace() {
    if (!space || !isSpaceSeen) return;
    const at = placeOf(first);
    const [low, high] = range(false);
    const traces = [0, 1, 2].map((normal) => {
      const [columns, rows] = [0, 1, 2].filter((axis) => axis !== normal);
      const here = at.slice();
      if (normal !== state.normal) here[normal] = 0;
      const { z: colours, text } = plane(first, columns, rows, here);
      const grid = [0, 1, 2].map((axis) => colours.map((line, r) => line.map((value, c) => {
        if (value === null && axis === 2) return null;
        return first.axes[axis][axis === columns ? c : axis === rows ? r : here[normal]];
      })));
      return {
        type: "surface", x: grid[0], y: grid[1], z: grid[2], surfacecolor: colours, text, hoverinfo: "text", cmin: low, cmax: high,
        colorscale: "Viridis", showscale: normal === 2, colorbar: Chart.bar(Data.labelled(label(), unit())), opacity: normal === state.normal ? 1 : 0.75,
        lighting: { ambient: 1, diffuse: 0, specular: 0 }, contours: { x: { highlight: false }, y: { highlight: false }, z: { highlight: false } },
      };
    });
    const ink = Theme.colour("ink");
    traces.push({
      type: "scatter3d", mode: "markers+text", hoverinfo: "text", x: data.marks.map((m) => m.position[0]), y: data.marks.map((m) => m.position[1]),
      z: data.marks.map((m) => m.position[2]), text: data.marks.map((m) => Chart.text(m.label)), textfont: { color: ink }, marker: { size: 4, color: ink },
    });
    if (state.machine) {
      const lines = (polylines) => {
        const line = { x: [], y: [], z: [] };
        polylines.forEach((points) => {
          [...points, [null, null, null]].forEach((point) => ["x", "y", "z"].forEach((axis, i) => line[axis].push(point[i])));
        });
        return line;
      };
      traces.push({ type: "scatter3d", mode: "lines", hoverinfo: "skip", line: { color: Theme.colour("c1"), width: 5 }, ...lines(data.machine) });
      traces.push({ type: "scatter3d", mode: "lines", hoverinfo: "skip", line: { color: Theme.colour("c2"), width: 7 }, ...lines([data.tool]) });
      if (data.springs.length > 0) {
        traces.push({ type: "scatter3d", mode: "lines", hoverinfo: "skip", line: { color: Theme.colour("c1"), width: 5, dash: "dash" }, ...lines(data.springs) });
      }
      if (data.masses.length > 0) {
        // Discs as wide as the cube root of the mass.
        const most = Math.max(...data.masses.map((mass) => mass.kilograms));
        const [x, y, z] = [0, 1, 2].map((i) => data.masses.map((mass) => mass.position_mm[i]));
        traces.push({
          type: "scatter3d", mode: "markers", hoverinfo: "text", x, y, z, text: data.masses.map((mass) => Data.withUnit(mass.kilograms, "kg")),
          marker: { size: data.masses.map((mass) => Math.max(4, 16 * Math.cbrt(mass.kilograms / most))), color: Theme.colour("c2"), opacity: 0.8 },
        });
      }
    }
    const axis = (index) => Object.assign(Chart.axis(Data.labelled(coordinates[index].label, coordinates[index].unit), { showbackground: false, nticks: 5 }), { automargin: undefined, ticks: undefined, tickcolor: undefined });
    const layout = Chart.layout({
      margin: { l: 0, r: 0, t: 0, b: 80 },
      scene: { xaxis: axis(0), yaxis: axis(1), zaxis: axis(2), aspectmode: "data", camera: { eye }, uirevision: "view", dragmode: "orbit" },
      uirevision: "view",
    });
    Plotly.react(space.plot, traces, layout, Chart.config);
    space.plot.setAttribute("aria-label", "View of the workspace in three dimensions, coloured by " + label() + " " + groupName());
  }

  function draw() {
    panels.forEach(drawSlice);
    drawSpace();
    describe();
  }
  Controls.select(controls, "Quantity", data.labels.map((text, i) => Data.labelled(text, data.units[i])), (index) => {
    state.quantity = index;
    draw();
  });
  if (data.groups.length > 1) {
    Controls.select(controls, capital(data.group_label), data.groups, (index) => {
      state.group = index;
      draw();
    });
  }
  if (usable.length > 1) {
    Controls.select(controls, "Slice across", usable.map((axis) => coordinates[axis].label), (index) => {
      state.normal = usable[index];
      resetSlider();
      draw();
    });
  }
  let settled = 0;
  const slider = spatial.length === 0 ? null : Controls.slider(controls, "Slice", (index) => along(state.normal, first.axes[state.normal][index]), (index) => {
    state.place[state.normal] = first.axes[state.normal][index];
    // A slider moves faster than charts are drawn.
    cancelAnimationFrame(settled);
    settled = requestAnimationFrame(draw);
  });
  function resetSlider() {
    if (!slider) return;
    const axis = first.axes[state.normal];
    slider.reset("Slice at", axis.length, nearest(axis, state.place[state.normal]));
  }
  resetSlider();
  coordinates.forEach((coordinate, axis) => {
    if (axis < 3 || first.axes[axis].length < 2) return;
    const select = Controls.select(controls, capital(coordinate.label), first.axes[axis].map((value) => Data.withUnit(value, coordinate.unit)), (index) => {
      state.place[axis] = first.axes[axis][index];
      draw();
    });
    select.value = String(nearest(first.axes[axis], state.place[axis]));
  });
  if (isBox && space) {
    const box = document.createElement("input");
    box.type = "checkbox";
    box.addEventListener("change", () => {
      state.machine = box.checked;
      drawSpace();
    });
    const marks = [data.springs.length > 0 ? "springs dashed" : "", data.masses.length > 0 ? "masses as discs" : ""].filter(Boolean);
    Controls.labelled(controls, ["Machine at home", ...marks].join(", "), box).className = "check";
  }
  Theme.onChange(draw);
  draw();
}

const capital = (text) => text.charAt(0).toUpperCase() + text.slice(1);

// Blue to orange through grey, each side of even steps; P. Kovesi's and ColorBrewer's PuOr avoid red against green.
const DIVERGING = [
  [0, "#2d004b"], [0.1, "#542788"], [0.2, "#8073ac"], [0.3, "#b2abd2"], [0.4, "#d8daeb"], [0.5, "#f7f7f7"],
  [0.6, "#fee0b6"], [0.7, "#fdb863"], [0.8, "#e08214"], [0.9, "#b35806"], [1, "#7f3b08"],
];
