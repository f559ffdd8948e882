// A slice of a grid as a colour map, one panel for each result and difference.
function sliceView(charts, view) {
  const { data, cases, state } = view;
  const coordinates = data.coordinates;
  const panels = cases.map((one) => ({ one, ...Controls.chart(charts, one.name) }));
  // The slider of a single map stands beside it.
  const beside = panels.length === 1 ? document.createElement("div") : null;
  if (beside) {
    beside.className = "controls";
    panels[0].plot.before(beside);
  }
  // Arrow keys move the picked point, Page Up and Page Down through the slices.
  panels.forEach(({ one, plot }) => {
    plot.tabIndex = 0;
    plot.setAttribute("role", "application");
    plot.addEventListener("keydown", (event) => {
      const [columns, rows] = inPlane();
      const way = { ArrowLeft: [columns, -1], ArrowRight: [columns, 1], ArrowDown: [rows, -1], ArrowUp: [rows, 1], PageDown: [state.normal, -1], PageUp: [state.normal, 1] }[event.key];
      const isOut = event.key === "Escape" && state.chosen;
      if ((!way && !isOut) || event.ctrlKey || event.metaKey || event.altKey) return;
      event.preventDefault();
      if (isOut) return view.choose(null);
      const at = state.chosen ? view.placeAt(one, state.chosen) : view.placeOf(one);
      // The first key picks the middle of the slice, or the point that is marked.
      if (state.chosen) at[way[0]] = Math.min(Math.max(at[way[0]] + way[1], 0), one.axes[way[0]].length - 1);
      view.choose(at.map((index, axis) => one.axes[axis][index]), true);
    });
  });

  function hover(one, at, value) {
    const note = view.notesOf(one).get(view.node(one, at));
    const lines = at.map((index, axis) => [axis, index]).filter(([axis]) => one.axes[axis].length > 1).map(([axis, index]) => view.along(axis, one.axes[axis][index]));
    lines.push("<b>" + Chart.text(view.label()) + " " + (Number.isFinite(value) ? Data.withUnit(value, view.unit()) : "no number") + "</b>");
    if (note !== undefined) {
      const words = one.notes[note];
      lines.push(Chart.text(words.length > 90 ? words.slice(0, 88) + "\u2026" : words));
    }
    return lines.join("<br>");
  }
  // The values of a plane: `rows` and `columns` are axes, `at` the position on the others. Words only where they are needed.
  function plane(one, columns, rows, at, withWords) {
    const values = view.series(one);
    const [width, height] = [one.axes[columns].length, one.axes[rows].length];
    const origin = at.slice();
    origin[columns] = origin[rows] = 0;
    const begin = view.node(one, origin);
    const step = (axis) => one.axes.slice(0, axis).reduce((size, other) => size * other.length, 1);
    const [across, up] = [step(columns), step(rows)];
    const z = [];
    let hasAll = true;
    for (let r = 0; r < height; r++) {
      const line = new Float64Array(width);
      for (let c = 0; c < width; c++) {
        line[c] = values ? values[begin + r * up + c * across] : NaN;
        hasAll = hasAll && Number.isFinite(line[c]);
      }
      z.push(line);
    }
    if (!withWords && hasAll && view.notesOf(one).size === 0) return { z, text: null };
    const text = z.map((line, r) => Array.from(line, (value, c) => {
      const here = at.slice();
      [here[columns], here[rows]] = [c, r];
      return hover(one, here, value);
    }));
    return { z, text };
  }
  // The line where the tolerance ends, and hatching beyond it.
  function border(one, columns, rows, z) {
    const [line, hatched] = [{ x: [], y: [] }, { x: [], y: [] }];
    const limit = view.tolerance();
    if (!Number.isFinite(limit)) return [line, hatched];
    const edges = (axis) => axis.concat(axis.at(-1)).map((value, i) => (i === 0 ? axis[0] - 0.5 * ((axis[1] ?? 1) - axis[0]) : i === axis.length ? value + 0.5 * (value - (axis[i - 2] ?? 0)) : 0.5 * (value + axis[i - 1])));
    const [x, y] = [edges(one.axes[columns]), edges(one.axes[rows])];
    const differ = (a, b) => Number.isFinite(a + b) && (a <= limit) !== (b <= limit);
    const add = (from, to, own = line) => [from, to, [null, null]].forEach((point) => { own.x.push(point[0]); own.y.push(point[1]); });
    z.forEach((own, r) => own.forEach((value, c) => {
      if (value > limit) add([x[c], y[r]], [x[c + 1], y[r + 1]], hatched);
      if (c > 0 && differ(value, own[c - 1])) add([x[c], y[r]], [x[c], y[r + 1]]);
      if (r > 0 && differ(value, z[r - 1][c])) add([x[c], y[r]], [x[c + 1], y[r]]);
    }));
    return [line, hatched];
  }
  const inPlane = () => [0, 1, 2].filter((axis) => axis !== state.normal);
  function template(one, columns, rows, text) {
    if (text) return "%{text}<extra></extra>";
    const along = (axis, name) => coordinates[axis].label + " = %{" + name + ":.4~g} " + coordinates[axis].unit;
    return along(columns, "x") + "<br>" + along(rows, "y") + "<br><b>" + Chart.text(view.label()) + " %{z:.4~g} " + view.unit() + "</b><extra></extra>";
  }
  // Named places, and the one picked, of this slice: off the plane by at most half a step.
  function marks(one, at) {
    const [columns, rows] = inPlane();
    const isNear = (position) => at.every((index, axis) => {
      const level = one.axes[axis];
      if (axis === columns || axis === rows || level.length < 2) return true;
      return Math.abs(position[axis] - level[index]) <= 0.5 * Math.abs(level[1] - level[0]) + 1e-9;
    });
    const named = view.marks().filter((mark) => isNear(mark.position));
    const [x, y] = [one.axes[columns], one.axes[rows]];
    const all = { x: [named.map((mark) => mark.position[columns])], y: [named.map((mark) => mark.position[rows])],
      text: [named.map((mark) => "<b>" + Chart.text(mark.label) + "</b>")], textposition: [named.map((mark) => textPosition(mark, columns, rows, x, y))] };
    const chosen = state.chosen && isNear(state.chosen) ? [state.chosen] : [];
    return { all, chosen: { x: [chosen.map((place) => place[columns])], y: [chosen.map((place) => place[rows])] } };
  }
  // Labels stay on the map.
  function textPosition(mark, columns, rows, x, y) {
    const side = (value, axis) => (value - axis[0]) / (axis[axis.length - 1] - axis[0] || 1);
    const across = side(mark.position[columns], x);
    const up = side(mark.position[rows], y);
    return (up > 0.85 ? "bottom" : "top") + " " + (across > 0.85 ? "left" : across < 0.15 ? "right" : "center");
  }
  function head({ one, heading }, at) {
    const [columns, rows] = inPlane();
    const cut = at.map((index, axis) => [axis, index]).filter(([axis]) => axis !== columns && axis !== rows && (one.axes[axis].length > 1 || axis === state.normal));
    const words = cut.map(([axis, index]) => view.along(axis, one.axes[axis][index])).join(", ");
    const better = data.better?.[state.quantity];
    const sense = one.is_difference ? " (orange: " + one.name.charAt(0) + (better && better !== "neither" ? " is better)" : " is larger)") : "";
    heading.textContent = (cases.length > 1 ? one.name + ", " : "Slice at ") + words + (Number.isFinite(view.tolerance()) ? "; hatched: out of tolerance, " + Data.withUnit(view.tolerance(), view.unit()) : "") + sense;
    return words;
  }
  function draw(panel) {
    const { one, plot } = panel;
    const [columns, rows] = inPlane();
    const at = view.placeOf(one);
    const { z, text } = plane(one, columns, rows, at, false);
    const scale = view.scale(one.is_difference);
    const words = head(panel, at);
    const [x, y] = [one.axes[columns], one.axes[rows]];
    const { all, chosen } = marks(one, at);
    const traces = [
      {
        type: "heatmap", x, y, z, text: text ?? undefined, hovertemplate: template(one, columns, rows, text), zmin: scale.low, zmax: scale.high,
        colorscale: scale.colorscale, colorbar: Chart.bar(Data.labelled(one.is_difference ? "difference of " + view.label() : view.label(), view.unit())), xgap: 0, ygap: 0,
      },
      {
        type: "scatter", mode: "markers+text", hoverinfo: "skip", cliponaxis: false, x: all.x[0], y: all.y[0], text: all.text[0], textposition: all.textposition[0],
        textfont: { color: "#000", shadow: "0 0 3px #fff, 0 0 3px #fff, 0 0 3px #fff" },
        marker: { size: 9, color: "#fff", line: { width: 2.5, color: "#000" } },
      },
      {
        type: "scatter", mode: "markers", hoverinfo: "skip", cliponaxis: false, x: chosen.x[0], y: chosen.y[0],
        marker: { size: 12, color: "rgba(255, 255, 255, 0.75)", line: { width: 3.5, color: "#d0006f" } },
      },
      ...border(one, columns, rows, z).map((own, k) => ({ type: "scatter", mode: "lines", hoverinfo: "skip", ...own, opacity: k ? 0.7 : 1, line: { color: "#fff", width: k ? 1 : 2.5 } })),
    ];
    const axis = (index, more) => Chart.axis(Data.labelled(coordinates[index].label, coordinates[index].unit), Object.assign({ zeroline: false, showgrid: false }, more));
    const alike = coordinates[columns].unit === coordinates[rows].unit && x.length > 1 && y.length > 1;
    const layout = Chart.layout({
      margin: { l: 62, r: 22, t: 14, b: 112 }, xaxis: axis(columns, { constrain: "domain" }), yaxis: axis(rows, alike ? { scaleanchor: "x", constrain: "domain" } : {}), dragmode: "zoom",
    });
    // Axes of equal scale keep the ranges of the slice before.
    const isNew = plot.dataset.normal !== String(state.normal);
    plot.dataset.normal = state.normal;
    (isNew ? Plotly.newPlot : Plotly.react)(plot, traces, layout, Chart.config);
    panel.hasWords = Boolean(text);
    plot.setAttribute("aria-label", "Colour map of " + view.label() + " " + view.groupName() + ", " + words + "; arrow keys move the picked point, Page Up and Page Down the slice");
    if (!isNew) return;
    plot.removeAllListeners?.("plotly_click");
    plot.on("plotly_click", (event) => {
      const point = event.points.find((other) => other.curveNumber === 0);
      if (!point) return;
      const place = view.placeOf(one).map((index, other) => one.axes[other][index]);
      [place[columns], place[rows]] = [point.x, point.y];
      view.choose(place);
    });
  }
  // Another slice of the same: nothing but numbers changes.
  function step(panel) {
    const { one, plot } = panel;
    const [columns, rows] = inPlane();
    const at = view.placeOf(one);
    const { z, text } = plane(one, columns, rows, at, false);
    if (Boolean(text) !== panel.hasWords) return draw(panel);
    const words = head(panel, at);
    const { all, chosen } = marks(one, at);
    Plotly.restyle(plot, text ? { z: [z], text: [text] } : { z: [z] }, [0]);
    const shown = plot.data;
    border(one, columns, rows, z).forEach(({ x, y }, k) => {
      if (x.length || shown[3 + k].x.length) Plotly.restyle(plot, { x: [x], y: [y] }, [3 + k]);
    });
    if (shown[1].x.length || all.x[0].length) Plotly.restyle(plot, all, [1]);
    if (shown[2].x.length || chosen.x[0].length) Plotly.restyle(plot, chosen, [2]);
    plot.setAttribute("aria-label", "Colour map of " + view.label() + " " + view.groupName() + ", " + words + "; arrow keys move the picked point, Page Up and Page Down the slice");
  }
  return { plane, beside, draw: () => panels.forEach(draw), step: () => panels.forEach(step) };
}
