// From values to colours on maps: what the figures of the folder have, a cyclic scale for angles, a diverging one where zero matters.
const Scales = (() => {
  const NAMED = { viridis: "Viridis", cividis: "Cividis", grey: [[0, "#262626"], [1, "#f0f0f0"]] };
  // Purple to orange through white: ColorBrewer's PuOr avoids red against green.
  const DIVERGING = [
    [0, "#2d004b"], [0.1, "#542788"], [0.2, "#8073ac"], [0.3, "#b2abd2"], [0.4, "#d8daeb"], [0.5, "#f7f7f7"],
    [0.6, "#fee0b6"], [0.7, "#fdb863"], [0.8, "#e08214"], [0.9, "#b35806"], [1, "#7f3b08"],
  ];
  const DIVERGING_GREY = [[0, "#262626"], [0.5, "#f0f0f0"], [1, "#262626"]];
  // N. Thyng and others' twilight (matplotlib, CC0): both ends are the same colour.
  const CYCLIC = [
    [0, "#e2d9e2"], [0.125, "#9ebbc9"], [0.25, "#6276ba"], [0.375, "#5e3c99"], [0.5, "#2f1436"], [0.625, "#8e2c50"],
    [0.75, "#b2604f"], [0.875, "#cfa98e"], [1, "#e2d9e2"],
  ];
  const reversed = (scale) => scale.map(([at]) => [at, scale[scale.length - 1 - scale.findIndex(([other]) => other === at)][1]]);
  const isAngle = (label, unit) => unit === "\u00b0" && /angle/.test(label);
  // Scale and range of numbers from `low` to `high`; sizes up to `floor` are rounding and set no axis.
  function of({ colours, label, unit, low, high, floor, isDifference, better }) {
    const least = Math.max(floor ?? 0, Number.MIN_VALUE);
    if (isDifference || (low < -least && high > least)) {
      const size = Math.max(Math.abs(low), Math.abs(high));
      const most = size > least ? size : Math.max(10 * least, 1e-12);
      const scale = colours === "grey" && !isDifference ? DIVERGING_GREY : DIVERGING;
      return { colorscale: isDifference && better === "smaller" ? reversed(scale) : scale, low: -most, high: most };
    }
    if (isAngle(label, unit)) {
      return { colorscale: CYCLIC, low: low < 0 ? -180 : 0, high: low < 0 ? 180 : 360 };
    }
    const colorscale = NAMED[colours] ?? NAMED.viridis;
    // As the figures: from 0 where sizes differ much.
    if (high - low > least) return { colorscale, low: low > 0 && low < 0.5 * high ? 0 : low, high };
    const half = 0.5 * Math.max(Math.abs(high), 10 * least, 1e-12);
    return { colorscale, low: low - half, high: high + half };
  }
  return { of };
})();

const capital = (text) => text.charAt(0).toUpperCase() + text.slice(1);
