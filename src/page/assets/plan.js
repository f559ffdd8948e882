// A path where the tool really goes, from the side on which it is widest, unless this hides more than half of how far off the tool is (as in the figure): coloured by a
// quantity, any of its points to be picked.
function planView(article, data, name, { quantity, group }) {
  const [controls, charts, readout] = [".controls", ".charts", ".readout"].map((part) => article.querySelector(part));
  const one = data.cases[0];
  const along = one.axes[0];
  const state = { quantity, group, chosen: null };
  const wanted = data.plan.map(([packed]) => (packed ? Data.unpack(packed) : new Float64Array(along.length)));
  const extent = (values) => values.reduce((most, value) => Math.max(most, value), -Infinity) - values.reduce((least, value) => Math.min(least, value), Infinity);
  const moved = () => data.plan.map(([, label]) => Data.unpack(one.series[data.labels.indexOf(label)]?.[state.group]) ?? new Float64Array(along.length));
  const squares = moved().map((way) => way.reduce((sum, own) => sum + (own * own || 0), 0));
  const [first, second, across] = [0, 1, 2].sort((a, b) => extent(wanted[b]) - extent(wanted[a]) || a - b);
  const isHidden = 2 * squares[across] > squares[0] + squares[1] + squares[2];
  const hidden = isHidden ? (squares[first] < squares[second] ? first : second) : across;
  const axes = [0, 1, 2].filter((axis) => axis !== hidden);
  const values = () => Data.unpack(one.series[state.quantity][state.group]);
  const label = () => data.labels[state.quantity];
  const unit = () => data.units[state.quantity];
  const nearest = (arc) => along.reduce((best, other, index) => (Math.abs(other - arc) < Math.abs(along[best] - arc) ? index : best), 0);
  const { plot, heading } = Controls.chart(charts, "");
  const worst = () => values().reduce((best, value, index, all) => (Number.isFinite(value) && !(value <= all[best]) ? index : best), 0);
  const place = (index) => data.coordinates[0].label + " = " + Data.withUnit(along[index], data.coordinates[0].unit);
  const view = {
    data, cases: data.cases, state,
    node: (_, [index]) => index,
    placeAt: (_, [arc]) => [nearest(arc)],
    along: (axis, value) => data.coordinates[axis].label + " = " + Data.withUnit(value, data.coordinates[axis].unit),
    choose(picked, isStep = false) {
      state.chosen = picked;
      Address.write(isStep);
      show();
    },
  };
  const chosen = chosenPoint(article, view);
  let delay = 0;
  async function bend() {
    const picked = state.chosen;
    // The page's engine has all sources at once.
    const isAll = data.sources.length < 2 || data.sources[state.group] === "all";
    if (!picked || !Bending.along || !isAll) return chosen.showBent(null);
    chosen.showBent({ words: "The deflected machine is being computed." });
    const found = await Bending.along(nearest(picked[0]), along[nearest(picked[0])], (arc) => wanted.map((own) => own[nearest(arc)])).catch((fault) => ({ words: `The deflected machine cannot be computed: ${fault.message}` }));
    if (state.chosen !== picked) return;
    // A picture that belies the table is none.
    const [own, told] = [found.answer?.displacement ?? [], moved().map((way) => way[nearest(picked[0])])].map((way) => Math.hypot(...way));
    const isOther = found.answer?.displacement && Math.abs(own - told) > 2e-4 * told;
    chosen.showBent(isOther ? { words: `The machine cannot be drawn here: the engine in this page moves the tool by ${Data.withUnit(own, "mm")}, the table by ${Data.withUnit(told, "mm")}.` } : found);
  }
  Bending.waiting.push(() => bend());
  function show() {
    chosen.show(state.chosen);
    chosen.showBent(null);
    mark();
    clearTimeout(delay);
    delay = setTimeout(bend, 200);
  }
  // How many times as large the way off the path is drawn: a round number, so that the largest is a fifteenth of the path.
  function factor(ways) {
    const most = Math.max(...along.map((_, index) => Math.hypot(...ways.map((way) => way[index] || 0))));
    return Data.larger(Math.max(...axes.map((axis) => extent(wanted[axis]))) / 15 / most);
  }
  let drawn = [[], []];
  function marks() {
    const points = [[worst(), "most"], ...(state.chosen ? [[nearest(state.chosen[0]), ""]] : [])];
    return { x: [points.map(([index]) => drawn[0][index])], y: [points.map(([index]) => drawn[1][index])], text: [points.map(([, words]) => words)] };
  }
  function mark() {
    const { x, y, text } = marks();
    Plotly.restyle(plot, { x, y, text }, [2]);
    tell();
  }
  function tell() {
    const own = values();
    const index = worst();
    const words = `${capital(label())}${data.groups[state.group] ? ` (${data.groups[state.group]})` : ""}, most: ${Data.withUnit(own[index], unit())} at ${place(index)}.`;
    const picked = state.chosen ? nearest(state.chosen[0]) : null;
    readout.textContent = picked === null ? words : `Picked: ${Data.withUnit(own[picked], unit())} at ${place(picked)}. ${words}`;
  }
  function draw() {
    const [own, ways] = [values(), moved()];
    const times = factor(ways);
    drawn = axes.map((axis) => Array.from(along, (_, index) => wanted[axis][index] + times * ways[axis][index]));
    const scale = Scales.of({ colours: data.colours, label: label(), unit: unit(), low: one.series[state.quantity][state.group].low, high: one.series[state.quantity][state.group].high, floor: data.floors[state.quantity], isDifference: false });
    const ink = Theme.colour("ink");
    const at = marks();
    const traces = [
      { type: "scatter", mode: "lines", hoverinfo: "skip", x: Array.from(wanted[axes[0]]), y: Array.from(wanted[axes[1]]), line: { color: Theme.colour("muted"), width: 1.2 } },
      {
        type: "scatter", mode: "lines+markers", x: drawn[0], y: drawn[1], line: { color: Theme.colour("zero"), width: 1 },
        marker: { color: Array.from(own), colorscale: scale.colorscale, cmin: scale.low, cmax: scale.high, size: along.length > 400 ? 5 : 8, showscale: true, colorbar: Chart.bar(Data.labelled(label(), unit())) },
        text: Array.from(along, (_, index) => place(index) + "<br><b>" + Chart.text(label()) + " " + Data.withUnit(own[index], unit()) + "</b>"), hovertemplate: "%{text}<extra></extra>",
      },
      {
        type: "scatter", mode: "markers+text", hoverinfo: "skip", cliponaxis: false, x: at.x[0], y: at.y[0], text: at.text[0], textposition: "top center", textfont: { color: ink },
        marker: { size: 13, color: "rgba(255, 255, 255, 0.6)", line: { width: 3, color: ["#000", "#d0006f"] } },
      },
    ];
    const axis = (which, more) => Chart.axis(Data.labelled("xyz"[which], "mm"), Object.assign({ zeroline: false }, more));
    const layout = Chart.layout({
      margin: { l: 62, r: 22, t: 14, b: 112 }, hovermode: "closest", xaxis: axis(axes[0], { constrain: "domain" }), yaxis: axis(axes[1], { scaleanchor: "x", constrain: "domain" }),
    });
    Plotly.react(plot, traces, layout, Chart.config);
    const larger = times > 1 ? `, drawn ${Data.number(times)} times as far off` : ", true scale";
    heading.textContent = `Where the tool goes${data.groups[state.group] ? ` (${data.groups[state.group]})` : ""}${larger}, ${"xyz"[hidden]} not shown; thin: wanted`;
    plot.setAttribute("aria-label", `${heading.textContent}; coloured by ${label()}; arrow keys move the picked point`);
    tell();
  }
  const quantities = Controls.select(controls, "Quantity", data.labels.map((text, i) => Data.labelled(text, data.units[i])), (index) => {
    state.quantity = index;
    changed();
  });
  const groups = data.groups.length < 2 ? null : Controls.select(controls, capital(data.group_label), data.groups, (index) => {
    state.group = index;
    changed();
  });
  function changed() {
    if (!one.series[state.quantity][state.group]) state.group = one.series[state.quantity].findIndex(Boolean);
    quantities.value = String(state.quantity);
    data.labels.forEach((_, index) => Controls.offer(quantities, index, one.series[index].some(Boolean)));
    if (groups) groups.value = String(state.group);
    data.groups.forEach((_, index) => groups && Controls.offer(groups, index, Boolean(one.series[state.quantity][index])));
    draw();
    if (state.chosen) show();
  }
  plot.tabIndex = 0;
  plot.setAttribute("role", "application");
  plot.addEventListener("keydown", (event) => {
    const step = { ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1, PageUp: 10, PageDown: -10 }[event.key];
    const isOut = event.key === "Escape" && state.chosen;
    if ((!step && !isOut) || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    if (isOut) return view.choose(null);
    const index = state.chosen ? Math.min(Math.max(nearest(state.chosen[0]) + step, 0), along.length - 1) : worst();
    view.choose([along[index]], true);
  });
  changed();
  plot.on("plotly_click", (event) => {
    const point = event.points.find((other) => other.curveNumber === 1);
    if (point) view.choose([along[point.pointNumber]]);
  });
  Theme.onChange(draw);
  Address.join(name, {
    state: () => (state.chosen ? { point: String(Number(state.chosen[0].toPrecision(9))) } : {}),
    apply(said) {
      state.chosen = said.point && Number.isFinite(Number(said.point)) ? [along[nearest(Number(said.point))]] : null;
      show();
    },
  });
}
