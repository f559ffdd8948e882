// Each view gets its numbers. A page of one result is a comparison with one case.
document.querySelectorAll(".explorer").forEach((article) => {
  const data = JSON.parse(document.getElementById(article.dataset.json).textContent);
  if (!data.cases) {
    data.labels = data.quantities.map((quantity) => quantity.label);
    data.units = data.quantities.map((quantity) => quantity.unit);
    const series = data.quantities.map((quantity) => quantity.series);
    data.cases = [{ name: data.title, is_difference: false, axes: data.axes, names: data.names, notes: data.notes, flags: data.flags, series }];
  }
  Folds.whenShown(article, () => (data.shape === "grid" ? gridView : lineView)(article, data));
});
document.documentElement.dataset.ready = "true";
