"use strict";
// The deflected machine at a point of a map. The engine is started at the first point that is picked.
(() => {
  let engine = null;
  async function started() {
    const own = await Engine.start();
    const { answer } = await own.ask({ call: "open", ...JSON.parse(document.getElementById("scene-to-try").textContent) });
    return { ask: own.ask, view: answer };
  }
  const linesOf = (skeleton) => [...skeleton.chains.flatMap((chain) => chain.links), [skeleton.platform_mm, skeleton.tool_tip_mm]];
  // A round number by which displacements are drawn larger: the tool's as a twelfth of the machine.
  function amplified({ before, displacement }) {
    const points = linesOf(before).flat();
    const extent = Math.max(...[0, 1, 2].map((i) => Math.max(...points.map((p) => p[i])) - Math.min(...points.map((p) => p[i]))));
    return Data.larger(extent / 12 / Math.hypot(...displacement));
  }
  // `place` and `phi_deg` of a node, `source` as tables name it.
  Bending.connect(async (position, source, phi_deg) => {
    engine = engine ?? started();
    const { answer } = await (await engine).ask({ call: "effect", position, source, phi_deg: Number.isFinite(phi_deg) ? phi_deg : null });
    return drawnLarger(answer);
  }, async (index, arc, wantedAt) => {
    const { ask, view } = await (engine = engine ?? started());
    const { features: [path], candidates } = view.workpiece;
    const isAt = (own) => Math.abs(own - arc) < 1e-5 * Math.max(1, path.arc_length.at(-1));
    const point = isAt(path.arc_length[index]) ? index : path.arc_length.findIndex(isAt);
    // The place at which the path is where the table has it.
    const isThere = (own) => Math.hypot(...Space.add(own.wanted, wantedAt(path.arc_length[own.index]), -1)) < 0.01;
    for (const place of point < 0 ? [] : [...candidates.map(([, own]) => own), [0, 0, 0, 0, 0, 0]]) {
      const { answer } = await ask({ call: "place", place, most: 1, shown: [0, point] });
      if (!answer.features[0]?.length || !answer.features[0].every(isThere)) continue;
      const { machine, failure } = answer;
      return drawnLarger(machine ? { ...machine, before: machine.commanded, phi_deg: null } : { loaded: null, reason: failure?.reason ?? "it has no equilibrium" });
    }
    return { words: "The engine in this page has this path at other points than the table, so that the machine cannot be drawn here." };
  });
  function drawnLarger(answer) {
    if (!answer.loaded) return { answer };
    const factor = amplified(answer);
    const drawn = bent(answer.before, answer.loaded, factor);
    return { answer, factor, drawn, lines: { before: linesOf(answer.before), bent: linesOf(drawn) } };
  }
  Bending.draw = (canvas, right, up, { answer, drawn }) => {
    const points = [...linesOf(answer.before), ...linesOf(drawn)].flat();
    const box = [Math.min, Math.max].map((end) => [0, 1, 2].map((i) => end(...points.map((p) => p[i]))));
    const view = Space.view(canvas, right, up, box);
    const paint = () => {
      if (!canvas.isConnected) return;
      view.clear();
      lines(view, answer.before, Theme.colour("muted"), 2);
      lines(view, drawn, Theme.colour("c4"), 2.5);
      view.dot(drawn.tool_tip_mm, 5, Theme.colour("c4"));
    };
    new ResizeObserver(paint).observe(canvas);
    return paint;
  };
})();
