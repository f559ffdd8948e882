"use strict";
// Dark and light: as the system says, until the reader chooses.
const Theme = (() => {
  const root = document.documentElement;
  const button = document.getElementById("theme");
  const system = window.matchMedia("(prefers-color-scheme: dark)");
  const listeners = [];
  let chosen = null;
  function isDark() {
    return chosen === null ? system.matches : chosen;
  }
  function apply(dark) {
    root.dataset.theme = dark ? "dark" : "light";
    button.textContent = dark ? "Light" : "Dark";
    listeners.forEach((listener) => listener());
  }
  button.addEventListener("click", () => {
    chosen = !isDark();
    apply(chosen);
  });
  system.addEventListener("change", () => apply(isDark()));
  // Paper is white.
  window.addEventListener("beforeprint", () => apply(false));
  window.addEventListener("afterprint", () => apply(isDark()));
  apply(isDark());
  return {
    colour: (name) => getComputedStyle(root).getPropertyValue("--" + name).trim(),
    onChange: (listener) => listeners.push(listener),
  };
})();
