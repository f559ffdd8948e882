// A grid of values: slices as colour maps, the workspace in three dimensions, and any of its points. With `seen` ({ quantity, group, tolerance }) it begins with
// those, where they are least, in slices alone, on which least and most are marked.
function gridView(article, data, name, seen) {
  const charts = article.querySelector(".charts");
  const readout = article.querySelector(".readout");
  const controls = article.querySelector(".controls");
  const cases = data.cases;
  const first = cases[0];
  const coordinates = data.coordinates;
  const spatial = [2, 1, 0].filter((axis) => axis < coordinates.length && coordinates.length > 2);
  const usable = spatial.filter((axis) => [0, 1, 2].filter((other) => other !== axis).every((other) => first.axes[other].length > 1));
  const middle = (axis) => first.axes[axis][Math.floor(first.axes[axis].length / 2)];
  const beginning = () => ({
    quantity: seen?.quantity ?? 0, group: seen?.group ?? 0, normal: usable.includes(2) ? 2 : usable[0] ?? 2, place: (seen && extremes(seen)[0]?.position.slice()) ?? coordinates.map((_, axis) => middle(axis)), chosen: null,
  });
  // The nodes of the least and the most of a quantity, as marks.
  const found = new Map();
  function extremes({ quantity, group }) {
    const key = quantity + " " + group;
    if (!found.has(key)) found.set(key, ends(quantity, group));
    return found.get(key);
  }
  function ends(quantity, group) {
    const values = Data.unpack(first.series[quantity]?.[group]) ?? [];
    const known = [...values.keys()].filter((node) => Number.isFinite(values[node]));
    const nodes = [(a, b) => a < b, (a, b) => a > b].map((isFurther) => known.reduce((best, node) => (best === null || isFurther(values[node], values[best]) ? node : best), null));
    const at = (node) => first.axes.reduce(({ rest, position }, axis) => ({ rest: Math.floor(rest / axis.length), position: [...position, axis[rest % axis.length]] }), { rest: node, position: [] }).position;
    return known.length ? nodes.map((node, end) => ({ label: ["least", "most"][end], position: at(node) })) : [];
  }
  const results = cases.filter((one) => !one.is_difference);
  const state = Object.assign(beginning(), { machine: false, bent: null });

  // Position on an axis nearest to a coordinate.
  function nearest(axis, value) {
    let best = 0;
    axis.forEach((other, index) => {
      if (Math.abs(other - value) < Math.abs(axis[best] - value)) best = index;
    });
    return best;
  }
  const has = (quantity, group) => cases.some((one) => one.series[quantity]?.[group]);
  const groupCount = Math.max(1, data.groups.length);
  const groups = (quantity) => [...Array(groupCount).keys()].filter((group) => has(quantity, group));

  const view = {
    data, cases, state,
    node(one, at) {
      let index = 0;
      for (let axis = at.length - 1; axis >= 0; axis--) index = index * one.axes[axis].length + at[axis];
      return index;
    },
    series: (one) => Data.unpack(one.series[state.quantity][state.group]),
    label: () => data.labels[state.quantity],
    unit: () => data.units[state.quantity],
    groupName: () => data.groups[state.group] ?? "",
    along: (axis, value) => coordinates[axis].label + " = " + Data.withUnit(value, coordinates[axis].unit),
    placeAt: (one, place) => place.map((value, axis) => nearest(one.axes[axis], value)),
    placeOf: (one) => view.placeAt(one, state.place),
    notesOf(one) {
      one.noteMaps = one.noteMaps ?? [];
      one.noteMaps[state.group] = one.noteMaps[state.group] ?? new Map(one.flags[state.group] ?? []);
      return one.noteMaps[state.group];
    },
    // One colour scale for all results; differences have their own around zero.
    scale(isDifference) {
      const packed = cases.filter((one) => one.is_difference === isDifference).map((one) => one.series[state.quantity][state.group]).filter(Boolean);
      const low = packed.length ? Math.min(...packed.map((p) => p.low)) : 0;
      const high = packed.length ? Math.max(...packed.map((p) => p.high)) : 1;
      return Scales.of({
        colours: data.colours, label: view.label(), unit: view.unit(), low, high, floor: data.floors[state.quantity], isDifference, better: data.better?.[state.quantity],
      });
    },
    tolerance: () => (seen && state.quantity === seen.quantity ? seen.tolerance : NaN),
    marks: () => (seen ? extremes(state) : data.marks),
    // A key that is held down writes no history, and the machine is bent where it rests.
    choose(place, isStep = false) {
      state.chosen = place;
      if (place && state.place[state.normal] !== place[state.normal]) {
        state.place[state.normal] = place[state.normal];
        showControls();
      }
      Address.write(isStep);
      chosen.show(place);
      slices.step();
      describe();
      clearTimeout(bendDelay);
      if (isStep) {
        // Not that of the point before.
        state.bent = null;
        chosen.showBent(null);
        space.drawSoon();
        bendDelay = setTimeout(bend, 200);
        return;
      }
      space.draw();
      bend();
    },
  };
  let bendDelay = 0;
  const slices = sliceView(charts, view);
  const nothing = () => {};
  const space = seen ? { draw: nothing, drawSoon: nothing, isShown: () => false } : spaceView(charts, view, slices.plane);
  const chosen = chosenPoint(article, view);

  async function bend() {
    const [place, group] = [state.chosen, state.group];
    const had = state.bent;
    state.bent = null;
    if (had) space.draw();
    const question = place && Bending.at ? chosen.question(place) : null;
    chosen.showBent(question && { words: "The deflected machine is being computed." });
    if (!question) return;
    const found = await Bending.at(...question).catch((fault) => ({ words: `The deflected machine cannot be computed: ${fault.message}` }));
    if (state.chosen !== place || state.group !== group) return;
    state.bent = found.lines ? found : null;
    chosen.showBent(found);
    space.draw();
  }
  Bending.waiting.push(bend);
  function describe() {
    const [columns, rows] = [0, 1, 2].filter((axis) => axis !== state.normal);
    const parts = cases.filter((one) => !one.is_difference).map((one) => {
      let [low, high, sum, count] = [Infinity, -Infinity, 0, 0];
      slices.plane(one, columns, rows, view.placeOf(one), false).z.forEach((line) => line.forEach((value) => {
        if (!Number.isFinite(value)) return;
        low = Math.min(low, value);
        high = Math.max(high, value);
        sum += value;
        count++;
      }));
      const all = one.axes[columns].length * one.axes[rows].length;
      const name = cases.length > 1 ? one.name + ": " : "";
      if (count === 0) return name + "no numbers on this slice";
      const missing = all > count ? "; " + (all - count) + " of " + all + " nodes have none" : "";
      return name + Data.withUnit(low, view.unit()) + " to " + Data.withUnit(high, view.unit()) + ", mean " + Data.withUnit(sum / count, view.unit()) + missing;
    });
    const picked = state.chosen && results.length === 1 ? "Picked: " + Data.withUnit(view.series(first)?.[view.node(first, view.placeAt(first, state.chosen))] ?? NaN, view.unit()) + ". " : "";
    readout.textContent = picked + "This slice, " + view.label() + (view.groupName() ? " (" + view.groupName() + ")" : "") + ": " + parts.join(". ") + ".";
  }
  function draw() {
    slices.draw();
    space.draw();
    describe();
  }
  function changed() {
    if (!has(state.quantity, state.group)) state.group = groups(state.quantity)[0] ?? 0;
    showControls();
    Address.write();
    draw();
    chosen.show(state.chosen);
    bend();
  }

  const quantitySelect = Controls.select(controls, "Quantity", data.labels.map((text, i) => Data.labelled(text, data.units[i])), (index) => {
    state.quantity = index;
    changed();
  });
  data.labels.forEach((_, quantity) => Controls.offer(quantitySelect, quantity, groups(quantity).length > 0));
  const groupSelect = data.groups.length < 2 ? null : Controls.select(controls, capital(data.group_label), data.groups, (index) => {
    state.group = index;
    changed();
  });
  const normalSelect = usable.length < 2 ? null : Controls.select(controls, "Slice across", usable.map((axis) => coordinates[axis].label), (index) => {
    state.normal = usable[index];
    changed();
  });
  let settled = 0;
  let restDelay = 0;
  const slider = spatial.length === 0 ? null : Controls.slider(slices.beside ?? controls, "Slice", (index) => view.along(state.normal, first.axes[state.normal][index]), (index) => {
    state.place[state.normal] = first.axes[state.normal][index];
    // A slider moves faster than charts are drawn.
    cancelAnimationFrame(settled);
    settled = requestAnimationFrame(() => {
      const begin = performance.now();
      slices.step();
      describe();
      space.drawSoon();
      article.dataset.stepMs = (performance.now() - begin).toFixed(1);
    });
    clearTimeout(restDelay);
    restDelay = setTimeout(() => Address.write(true), 250);
  });
  const others = coordinates.map((coordinate, axis) => {
    if (axis < 3 || first.axes[axis].length < 2) return null;
    return Controls.select(controls, capital(coordinate.label), first.axes[axis].map((value) => Data.withUnit(value, coordinate.unit)), (index) => {
      state.place[axis] = first.axes[axis][index];
      changed();
    });
  });
  function showControls() {
    quantitySelect.value = String(state.quantity);
    if (groupSelect) {
      groupSelect.value = String(state.group);
      data.groups.forEach((_, group) => Controls.offer(groupSelect, group, has(state.quantity, group)));
    }
    if (normalSelect) normalSelect.value = String(usable.indexOf(state.normal));
    const axis = first.axes[state.normal];
    if (slider && axis) slider.reset("Slice at", axis.length, nearest(axis, state.place[state.normal]));
    others.forEach((select, axis) => {
      if (select) select.value = String(nearest(first.axes[axis], state.place[axis]));
    });
  }
  if (space.isShown()) {
    const box = document.createElement("input");
    box.type = "checkbox";
    box.addEventListener("change", () => {
      state.machine = box.checked;
      space.draw();
    });
    const marks = [data.springs?.length > 0 ? "springs dashed" : "", data.masses?.length > 0 ? "masses as discs" : ""].filter(Boolean);
    Controls.labelled(controls, ["Machine at home", ...marks].join(", "), box).className = "check";
  }

  const numbers = (list) => list.map((value) => String(Number(value.toPrecision(9)))).join(",");
  showControls();
  Theme.onChange(draw);
  draw();
  Address.join(name, {
    state() {
      const [now, then] = [state, beginning()];
      const said = {};
      if (now.quantity !== then.quantity) said.quantity = data.labels[now.quantity];
      if (now.group !== then.group) said[data.group_label || "group"] = data.groups[now.group];
      if (now.normal !== then.normal) said.across = coordinates[now.normal].label;
      if (numbers(now.place) !== numbers(then.place)) said.at = numbers(now.place);
      if (now.chosen) said.point = numbers(now.chosen);
      return said;
    },
    apply(said) {
      const place = (text) => {
        const list = text?.split(",").map(Number) ?? [];
        return list.length === coordinates.length && list.every(Number.isFinite) ? list : null;
      };
      Object.assign(state, beginning());
      const quantity = data.labels.indexOf(said.quantity);
      const group = data.groups.indexOf(said[data.group_label || "group"]);
      const normal = usable.find((axis) => coordinates[axis].label === said.across);
      if (quantity >= 0) state.quantity = quantity;
      if (group >= 0 && has(state.quantity, group)) state.group = group;
      if (normal !== undefined) state.normal = normal;
      state.place = place(said.at) ?? state.place;
      state.chosen = place(said.point);
      showControls();
      draw();
      chosen.show(state.chosen);
      bend();
    },
  });
}
