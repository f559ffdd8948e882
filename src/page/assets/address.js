// What is shown stands behind the # of the address: a link leads to the same quantity, source, slice and point, and so does "back".
const Address = (() => {
  const views = new Map();
  function parsed() {
    const text = location.hash.slice(1);
    return text.includes("=") ? new URLSearchParams(text) : null;
  }
  function own(all, name) {
    const found = {};
    all?.forEach((value, key) => {
      if (key.startsWith(name + ".")) found[key.slice(name.length + 1)] = value;
    });
    return found;
  }
  // Lets `view` (state() and apply(state), of texts by name) stand in the address as `name`.
  function join(name, view) {
    views.set(name, view);
    const here = own(parsed(), name);
    if (Object.keys(here).length > 0) view.apply(here);
  }
  // A step that "back" takes back; with `settling`, one more of the same.
  function write(settling) {
    const all = new URLSearchParams();
    // Views that are not drawn yet keep what the address says of them.
    parsed()?.forEach((value, key) => {
      if (!views.has(key.split(".")[0])) all.set(key, value);
    });
    views.forEach((view, name) => Object.entries(view.state()).forEach(([key, value]) => all.set(name + "." + key, value)));
    const hash = String(all) ? "#" + String(all).replaceAll("%2C", ",") : "";
    if (hash === location.hash) return;
    history[settling ? "replaceState" : "pushState"](null, "", hash || location.pathname + location.search);
  }
  window.addEventListener("popstate", () => {
    const all = parsed();
    // A link to a heading of this page says nothing of views.
    if (!all && location.hash.length > 1) return;
    views.forEach((view, name) => view.apply(own(all, name)));
  });
  return { join, write };
})();
