// Curves over one coordinate, or values by name.
function lineView(article, data, viewName) {
  const charts = article.querySelector(".charts");
  charts.classList.add("single");
  const readout = article.querySelector(".readout");
  const controls = article.querySelector(".controls");
  const cases = data.cases.filter((one) => !one.is_difference);
  const differences = data.cases.filter((one) => one.is_difference);
  const coordinate = data.coordinates[0];
  const isNamed = data.shape === "names";
  const single = cases.length === 1;
  // All groups of a single result at once, or one group of several results.
  // What the curves can be seen over besides their coordinate: the quantity of the second one.
  const second = isNamed || !single ? -1 : data.labels.indexOf(data.coordinates[1]?.label);
  const has = (series) => series.some((packed) => packed && Data.unpack(packed).some(Number.isFinite));
  // What is seen first has values.
  const seen = Math.max(0, cases[0]?.series.findIndex(has) ?? 0);
  const state = { quantity: seen, group: single && data.groups.length > 1 ? -1 : 0, over: 0 };
  const DASHES = ["solid", "dash", "dot", "dashdot", "longdash", "longdashdot"];
  const SYMBOLS = ["circle", "square", "diamond", "triangle-up", "x", "cross"];
  const label = () => data.labels[state.quantity];
  const unit = () => data.units[state.quantity];
  const places = (one) => (isNamed ? one.names : one.axes[0]);
  const groupIndices = () => (state.group < 0 ? data.groups.map((_, index) => index) : [state.group]);

  // Where each value stands: over the coordinate, or over the second one, in its order.
  function standing(one, group) {
    const over = state.over === 1 ? Data.unpack(one.series[second][group]) : null;
    if (!over) return { x: places(one), order: null };
    const order = Array.from(over, (_, index) => index).filter((index) => Number.isFinite(over[index])).sort((a, b) => over[a] - over[b] || a - b);
    return { x: over, order };
  }
  function curves(list) {
    const found = [];
    list.forEach((one, index) => groupIndices().forEach((group) => {
      const values = Data.unpack(one.series[state.quantity][group]);
      // A curve without a value is not there.
      if (values?.some(Number.isFinite)) found.push({ one, group, values, style: single ? group : index, name: single ? (data.groups[group] ?? "") : one.name, ...standing(one, group) });
    }));
    return found;
  }
  function trace(curve) {
    const x = curve.x;
    const picked = (list) => (curve.order ? curve.order.map((index) => list[index]) : list);
    // Places that share an angle, such as those of a straight line, make no curve.
    const isCurve = !curve.order || curve.order.every((index, k) => k === 0 || x[index] > x[curve.order[k - 1]]);
    const notes = new Map(curve.one.flags[curve.group] ?? []);
    const colour = Theme.colour("c" + (curve.style % 6));
    const own = places(curve.one);
    const place = (index) => (isNamed ? Chart.text(x[index]) : coordinate.label + " " + Data.withUnit(own[index], coordinate.unit)
      + (curve.order ? ", " + data.labels[second] + " " + Data.withUnit(x[index], data.units[second]) : ""));
    const values = Array.from(curve.values, (value) => (Number.isFinite(value) ? value : null));
    return {
      type: "scatter", name: Chart.text(curve.name), mode: isNamed || x.length < 3 || !isCurve ? "markers" : "lines",
      x: isNamed ? values : picked(x), y: isNamed ? x.map((name) => allNames.indexOf(name)) : picked(values),
      line: { color: colour, width: 2.5, dash: DASHES[curve.style % 6] }, marker: { color: colour, size: isCurve ? 12 : 5, symbol: SYMBOLS[curve.style % 6] },
      text: picked(Array.from(curve.values, (value, index) => {
        const note = notes.get(index);
        return place(index) + "<br>" + (curve.name ? Chart.text(curve.name) + ": " : "") + "<b>" + Data.withUnit(value, unit()) + "</b>" + (note === undefined ? "" : "<br>" + Chart.text(curve.one.notes[note]));
      })),
      hovertemplate: "%{text}<extra></extra>",
    };
  }
  // All names of all results, those of the first first.
  const allNames = isNamed ? [...new Set(data.cases.flatMap((one) => one.names))] : [];
  function namedAxis() {
    const short = (name) => Chart.text(name.length > 22 ? name.slice(0, 21) + "\u2026" : name);
    return {
      tickvals: allNames.map((_, index) => index), ticktext: allNames.map(short), range: [allNames.length - 0.4, -0.6], zeroline: false,
    };
  }
  function drawChart({ plot, heading }, list, title, mayBeLog) {
    const found = curves(list);
    const values = found.flatMap((curve) => Array.from(curve.values).filter(Number.isFinite));
    const low = values.reduce((a, b) => Math.min(a, b), Infinity);
    const high = values.reduce((a, b) => Math.max(a, b), -Infinity);
    const floor = data.floors[state.quantity];
    const isLog = mayBeLog && low > 0 && high / low > 2000 && high > floor;
    heading.textContent = title + (isLog ? " (logarithmic scale)" : "");
    // Names stand beside the chart, one below the other, where there is room for them.
    const place = isNamed ? namedAxis() : {};
    const nticks = isNamed ? 4 : 8;
    // Whole powers of ten: what stands between them does not fit a narrow page.
    const powers = Math.log10(high / Math.max(low, 0.5 * floor)) / nticks;
    const size = isLog ? { type: "log", exponentformat: "power", dtick: Math.max(1, Math.ceil(powers)) } : { rangemode: "tozero", nticks };
    // What is rounding sets no axis.
    if (isLog && low < floor) size.range = [Math.log10(0.5 * floor), Math.log10(2 * high)];
    const isNothing = found.length > 0 && Math.max(Math.abs(low), Math.abs(high)) <= floor;
    if (isNothing) Object.assign(size, { range: low < 0 ? [-10 * floor, 10 * floor] : [0, 10 * floor] });
    if (isNothing) heading.textContent = title + ": nothing but rounding";
    if (isNamed) plot.style.height = 8 + 2 * Math.max(2, place.tickvals.length) + "rem";
    const [along, alongUnit] = state.over === 1 ? [data.labels[second], data.units[second]] : [coordinate.label, coordinate.unit];
    const placeAxis = Chart.axis(isNamed ? "" : Data.labelled(along, alongUnit), place);
    const sizeAxis = Chart.axis(Data.labelled(label(), unit()), size);
    const layout = Chart.layout({
      hovermode: isNamed ? "closest" : "x", showlegend: found.length > 1, legend: { orientation: "h", y: 1.02, yanchor: "bottom", x: 0 },
      margin: { l: 66, r: 20, t: found.length > 1 ? 44 : 12, b: 56 },
      xaxis: isNamed ? sizeAxis : placeAxis,
      yaxis: isNamed ? placeAxis : sizeAxis,
    });
    Plotly.react(plot, found.map(trace), layout, Chart.config);
    plot.setAttribute("aria-label", title);
    return found;
  }
  const main = Controls.chart(charts, "");
  main.plot.classList.add("wide");
  const difference = differences.length ? Controls.chart(charts, "") : null;
  if (difference) difference.plot.classList.add("wide");
  function draw() {
    const found = drawChart(main, cases, label(), true);
    if (difference) drawChart(difference, differences, "Difference of " + label(), false);
    const parts = found.map((curve) => {
      const best = Array.from(curve.values).reduce((best, value, index, all) => (Number.isFinite(value) && !(value <= all[best]) ? index : best), 0);
      const x = places(curve.one)[best];
      const turned = curve.order ? ", " + data.labels[second] + " " + Data.withUnit(curve.x[best], data.units[second]) : "";
      const where = isNamed ? " for " + x : " at " + Data.withUnit(x, coordinate.unit) + turned;
      return Data.withUnit(curve.values[best], unit()) + where + (curve.name ? " (" + curve.name + ")" : "");
    });
    readout.textContent = capital(label()) + ", highest: " + (parts.length ? parts.join("; ") : "no numbers") + ".";
  }
  let groupSelect = null;
  const quantitySelect = Controls.select(controls, "Quantity", data.labels.map((text, i) => Data.labelled(text, data.units[i])), (index) => {
    state.quantity = index;
    changed();
  });
  if (data.groups.length > 1) {
    const options = single ? ["all", ...data.groups] : data.groups;
    groupSelect = Controls.select(controls, capital(data.group_label), options, (index) => {
      state.group = single ? index - 1 : index;
      changed();
    });
  }
  const overSelect = second < 0 ? null : Controls.select(controls, "Over", [coordinate.label, data.labels[second]], (index) => {
    state.over = index;
    changed();
  });
  function changed() {
    showControls();
    Address.write();
    draw();
  }
  function showControls() {
    quantitySelect.value = String(state.quantity);
    if (overSelect) overSelect.value = String(state.over);
    const offset = single ? 1 : 0;
    const has = (group) => data.cases.some((one) => one.series[state.quantity]?.[group]);
    if (state.group >= 0 && !has(state.group)) state.group = single ? -1 : Math.max(0, data.groups.findIndex((_, group) => has(group)));
    if (!groupSelect) return;
    groupSelect.value = String(state.group + offset);
    data.groups.forEach((_, group) => Controls.offer(groupSelect, group + offset, has(group)));
  }
  showControls();
  Theme.onChange(draw);
  draw();
  const BEGIN = { quantity: state.quantity, group: state.group, over: 0 };
  Address.join(viewName, {
    state() {
      const said = {};
      if (state.quantity !== BEGIN.quantity) said.quantity = data.labels[state.quantity];
      if (state.over !== BEGIN.over) said.over = data.labels[second];
      if (state.group !== BEGIN.group) said[data.group_label || "group"] = data.groups[state.group] ?? "all";
      return said;
    },
    apply(said) {
      const quantity = data.labels.indexOf(said.quantity);
      const group = data.groups.indexOf(said[data.group_label || "group"]);
      Object.assign(state, BEGIN);
      if (quantity >= 0) state.quantity = quantity;
      if (group >= 0) state.group = group;
      if (second >= 0 && said.over === data.labels[second]) state.over = 1;
      showControls();
      draw();
    },
  });
}
