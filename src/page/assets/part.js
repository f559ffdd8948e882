// The machined part in three dimensions, coloured by how far its surface is from the programmed one, or by the cut that made it; a click tells what that was.
function partView(article, data) {
  const [controls, charts, readout] = [".controls", ".charts", ".readout"].map((name) => article.querySelector(name));
  const chart = Controls.chart(charts, data.title, "space");
  if (!Chart.hasWebGl()) {
    chart.plot.className = "missing";
    chart.plot.removeAttribute("role");
    chart.plot.textContent = "This browser offers no WebGL, so there is no view in three dimensions here. The figure above shows the same.";
    return;
  }
  let course = 0;
  const corners = data.corners.map(Data.unpack);
  const made = Data.unpack(data.made);
  const count = made.length;
  const faces = { skin: [], cut: [] };
  // What was not to be cut, and is.
  const isGouged = (face) => data.deviations.some((packed) => Data.unpack(packed)?.[face] < -1e-3);
  for (let face = 0; face < count; face++) faces[Number.isFinite(made[face]) || isGouged(face) ? "cut" : "skin"].push(face);
  // Two triangles of each face, whose corners are its own.
  function mesh(own) {
    const at = corners.map((values) => own.flatMap((face) => [0, 1, 2, 3].map((corner) => values[4 * face + corner])));
    const triangles = [[0, 1, 2], [0, 2, 3]];
    const [i, j, k] = [0, 1, 2].map((corner) => own.flatMap((_, face) => triangles.map((triangle) => 4 * face + triangle[corner])));
    return { type: "mesh3d", x: at[0], y: at[1], z: at[2], i, j, k, flatshading: true, lighting: { ambient: 0.9, diffuse: 0.35, specular: 0, roughness: 1 }, lightposition: { x: -1e4, y: -2e4, z: 3e4 } };
  }
  // Lengths along the axes as shares of the longest, so that all of the part is in view.
  function aspect() {
    const extents = corners.map((values) => values.reduce((most, value) => Math.max(most, value), -Infinity) - values.reduce((least, value) => Math.min(least, value), Infinity));
    const [x, y, z] = extents.map((extent) => Math.max(extent / Math.max(...extents), 1e-3));
    return { x, y, z };
  }
  // What it can be coloured by: the deviations, then what is known of the cuts.
  const cuts = data.columns.map((column) => ({ label: column.label, unit: column.unit, values: Data.unpack(column.values) })).filter((cut) => cut.values);
  const names = [...data.courses.map((name) => `material left, ${name}`), ...cuts.map((cut) => cut.label)];
  const cut = () => cuts[course - data.courses.length];
  function layer() {
    if (!cut()) return Data.unpack(data.deviations[course]);
    const { values } = cut();
    return made.map((place) => Number.isFinite(place) ? values[place] : NaN);
  }
  // The middle of the scale is white, as in the figure.
  const SCALE = [[0, "#053061"], [0.25, "#4393c3"], [0.5, "#f7f7f7"], [0.75, "#d6604d"], [1, "#67001f"]];
  function colours() {
    const values = layer();
    const most = cut() ? cut().values.reduce((largest, value) => value > largest ? value : largest, 0) || 1 : data.end;
    const least = cut() ? 0 : -most;
    // Labels that rounding puts beyond the ends would be left out.
    const ticks = [0.0001, 0.5, 0.9999].map((share) => least + share * (most - least));
    const title = cut() ? Data.labelled(cut().label, cut().unit) : Data.labelled("material left", "mm");
    return {
      intensity: faces.cut.flatMap((face) => [values[face], values[face]]), cmin: least, cmax: most, colorscale: cut() ? "Viridis" : SCALE,
      colorbar: { ...Chart.bar(title), tickmode: "array", tickvals: ticks, ticktext: [least, (least + most) / 2, most].map(Data.number) },
    };
  }
  const heading = () => {
    chart.heading.textContent = `${data.title}: ${names[course]}`;
    chart.plot.setAttribute("aria-label", `${data.title}: ${names[course]}; ${data.note}`);
  };
  function draw() {
    heading();
    const hidden = { visible: false };
    const traces = [
      { ...mesh(faces.skin), color: "#a8acb3", hoverinfo: "skip" },
      { ...mesh(faces.cut), ...colours(), intensitymode: "cell", hoverinfo: "none" },
    ];
    Plotly.newPlot(chart.plot, traces, Chart.layout({
      margin: { l: 0, r: 0, t: 0, b: 70 },
      scene: { aspectmode: "manual", aspectratio: aspect(), xaxis: hidden, yaxis: hidden, zaxis: hidden, camera: { eye: { x: 0.65, y: -1.15, z: 1.15 } } },
    }), Chart.config);
    const find = (points) => {
      const point = points.find((other) => other.curveNumber === 1);
      return point ? faces.cut[Math.floor(point.pointNumber / 4)] : null;
    };
    Chart.onPick(chart.plot, find, tell);
    Chart.scrollUnderWheel(chart.plot);
  }
  function tell(face) {
    const at = made[face];
    const words = data.courses.map((name, own) => `${name} ${Data.withUnit(Data.unpack(data.deviations[own])[face], "mm")}`);
    const values = data.columns.map((column) => `${column.label} ${Data.withUnit(Data.unpack(column.values)?.[at], column.unit)}`);
    if (!Number.isFinite(at)) {
      readout.textContent = `No move of the program is to cut here: material left ${words.join(", ")}.`;
      return;
    }
    readout.textContent = `${data.places[at]}: material left ${words.join(", ")}; ${values.join(", ")}.`;
  }
  const select = Controls.select(controls, "coloured by", names, (index) => {
    course = index;
    heading();
    const { intensity, cmin, cmax, colorscale, colorbar } = colours();
    Plotly.restyle(chart.plot, { intensity: [intensity], cmin, cmax, colorscale: [colorscale], colorbar: [colorbar] }, [1]);
  });
  readout.textContent = "Click the part to see which line made it there, and with which force.";
  const observer = new IntersectionObserver((entries) => {
    if (!entries.some((entry) => entry.isIntersecting)) return;
    observer.disconnect();
    draw();
  }, { rootMargin: "200px" });
  observer.observe(chart.plot);
  Chart.onPaper(chart.plot, () => {
    observer.disconnect();
    if (!chart.plot.data) draw();
  });
  Theme.onChange(() => chart.plot.data && Plotly.relayout(chart.plot, { "font.color": Theme.colour("ink") }));
}
