// The workspace in three dimensions, for a single result over a box: the slice and the far walls.
function spaceView(charts, view, plane) {
  const { data, cases, state } = view;
  const coordinates = data.coordinates;
  const first = cases[0];
  const isBox = cases.length === 1 && [0, 1, 2].every((axis) => coordinates[axis] && first.axes[axis].length > 1);
  const TITLE = "Workspace: this slice and the far walls";
  let space = null;
  let isSpaceSeen = false;
  if (isBox) {
    space = Controls.chart(charts, TITLE, "space");
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
      Chart.scrollUnderWheel(space.plot);
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
  let isClickable = false;
  function listen() {
    isClickable = true;
    const find = (points) => points.find((other) => other.data.type === "surface") ?? null;
    Chart.onPick(space.plot, find, (under) => view.choose(state.place.map((value, axis) => [under.x, under.y, under.z][axis] ?? value)));
  }
  function drawSpace() {
    if (!space || !isSpaceSeen) return;
    const at = view.placeOf(first);
    const scale = view.scale(false);
    const traces = [0, 1, 2].map((normal) => {
      const [columns, rows] = [0, 1, 2].filter((axis) => axis !== normal);
      const here = at.slice();
      if (normal !== state.normal) here[normal] = 0;
      const { z: colours, text } = plane(first, columns, rows, here, true);
      const grid = [0, 1, 2].map((axis) => colours.map((line, r) => Array.from(line, (value, c) => {
        if (!Number.isFinite(value) && axis === 2) return null;
        return first.axes[axis][axis === columns ? c : axis === rows ? r : here[normal]];
      })));
      return {
        type: "surface", x: grid[0], y: grid[1], z: grid[2], surfacecolor: colours.map((line) => Array.from(line, (value) => (Number.isFinite(value) ? value : null))), text, hoverinfo: "text", cmin: scale.low, cmax: scale.high,
        colorscale: scale.colorscale, showscale: normal === 2, colorbar: Chart.bar(Data.labelled(view.label(), view.unit())), opacity: normal === state.normal ? 1 : 0.75,
        lighting: { ambient: 1, diffuse: 0, specular: 0 }, contours: { x: { highlight: false }, y: { highlight: false }, z: { highlight: false } },
      };
    });
    const ink = Theme.colour("ink");
    traces.push({
      type: "scatter3d", mode: "markers+text", hoverinfo: "text", x: data.marks.map((m) => m.position[0]), y: data.marks.map((m) => m.position[1]),
      z: data.marks.map((m) => m.position[2]), text: data.marks.map((m) => Chart.text(m.label)), textfont: { color: ink }, marker: { size: 4, color: ink },
    });
    if (state.chosen) {
      const [x, y, z] = state.chosen.map((value) => [value]);
      traces.push({ type: "scatter3d", mode: "markers", hoverinfo: "skip", x, y, z, marker: { size: 7, color: "#d0006f", symbol: "circle" } });
    }
    const lines = (polylines) => {
      const line = { x: [], y: [], z: [] };
      polylines.forEach((points) => {
        [...points, [null, null, null]].forEach((point) => ["x", "y", "z"].forEach((axis, i) => line[axis].push(point[i])));
      });
      return line;
    };
    if (state.bent) {
      const { before, bent } = state.bent.lines;
      traces.push({ type: "scatter3d", mode: "lines", hoverinfo: "skip", line: { color: Theme.colour("muted"), width: 3 }, ...lines(before) });
      traces.push({ type: "scatter3d", mode: "lines", hoverinfo: "skip", line: { color: "#d0006f", width: 5 }, ...lines(bent) });
    }
    space.heading.textContent = TITLE + (state.bent ? `; the machine at the picked point, deflected ${Data.number(state.bent.factor)} times as much` : "");
    if (state.machine) {
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
      scene: { xaxis: axis(0), yaxis: axis(1), zaxis: axis(2), aspectmode: "data", camera: { eye }, uirevision: "view", dragmode: "turntable" },
      uirevision: "view",
    });
    Plotly.react(space.plot, traces, layout, Object.assign({}, Chart.config, { scrollZoom: true }));
    if (!isClickable) listen();
    space.plot.setAttribute("aria-label", "View of the workspace in three dimensions, coloured by " + view.label() + " " + view.groupName());
  }
  if (space) {
    Chart.onPaper(space.plot, () => {
      isSpaceSeen = true;
      drawSpace();
    });
  }
  let waiting = 0;
  // While slices follow each other quickly, the view waits for the last.
  function drawSoon() {
    clearTimeout(waiting);
    waiting = setTimeout(drawSpace, 150);
  }
  return { draw: drawSpace, drawSoon, isShown: () => space !== null };
}
