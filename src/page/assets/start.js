// Each view gets its numbers when it comes into sight. A page of one result is a comparison with one case.
(() => {
  const articles = [...document.querySelectorAll(".explorer")];
  const begun = new Set();
  const read = articles.map((article) => {
    const data = JSON.parse(document.getElementById(article.dataset.json).textContent);
    if (!data.cases) {
      data.labels = data.quantities.map((quantity) => quantity.label);
      data.units = data.quantities.map((quantity) => quantity.unit);
      const series = data.quantities.map((quantity) => quantity.series);
      data.cases = [{ name: data.title, is_difference: false, axes: data.axes, names: data.names, notes: data.notes, flags: data.flags, series }];
    }
    return data;
  });
  // Below a ten-millionth of the largest number of its unit on the page, a number is rounding and sets no axis.
  const largest = new Map();
  read.forEach((data) => data.cases.forEach((one) => one.series.forEach((groups, quantity) => groups.filter(Boolean).forEach((packed) => {
    const unit = data.units[quantity];
    largest.set(unit, Math.max(largest.get(unit) ?? 0, Math.abs(packed.low), Math.abs(packed.high)));
  }))));
  read.forEach((data) => {
    data.floors = data.floors ?? data.units.map((unit) => 1e-7 * (largest.get(unit) ?? 0));
  });
  function begin(index) {
    const folds = [];
    for (let fold = articles[index].closest("details"); fold; fold = fold.parentElement.closest("details")) folds.push(fold);
    if (begun.has(index)) return;
    if (folds.every((fold) => fold.open)) {
      begun.add(index);
      ({ grid: gridView, part: partView }[read[index].shape] ?? lineView)(articles[index], read[index], String(index));
    } else {
      // A chart in a fold has no size until the fold is opened.
      folds.filter((fold) => !fold.open).forEach((fold) => fold.addEventListener("toggle", () => begin(index), { once: true }));
    }
  }
  articles.forEach((_, index) => begin(index));
  // What the first screen shows can be pointed at. Paper shows the figure.
  const hero = document.querySelector(".hero[data-json]");
  const pointed = hero ? articles.findIndex((article) => article.dataset.json === hero.dataset.json) : -1;
  if (pointed >= 0) {
    const data = read[pointed];
    const article = document.createElement("article");
    article.className = "pointed";
    article.setAttribute("aria-label", "The answer, to point at");
    for (const [part, tag] of [["controls", "div"], ["charts", "div"], ["readout", "p"]]) article.append(Object.assign(document.createElement(tag), { className: part }));
    article.lastChild.setAttribute("role", "status");
    hero.prepend(article);
    hero.classList.add("live");
    const seen = { quantity: Math.max(0, data.labels.indexOf(hero.dataset.quantity)), group: Number(hero.dataset.group), tolerance: Number(hero.dataset.tolerance) };
    (data.shape === "grid" ? gridView : planView)(article, data, "first", seen);
  }
  // Paper shows all views; their folds were opened for it just now. Those that begin only now hear of it, too.
  window.addEventListener("beforeprint", () => {
    articles.forEach((_, index) => begin(index));
    window.dispatchEvent(new Event("paper"));
  });
  // A link to what lies in a fold opens it.
  const open = () => {
    const id = decodeURIComponent(location.hash.slice(1));
    for (let fold = id && !id.includes("=") ? document.getElementById(id)?.closest("details") : null; fold; fold = fold.parentElement.closest("details")) fold.open = true;
  };
  window.addEventListener("hashchange", open);
  document.querySelectorAll('a[href^="#"]').forEach((link) => link.addEventListener("click", () => setTimeout(open)));
  open();
  document.documentElement.dataset.ready = "true";
})();
