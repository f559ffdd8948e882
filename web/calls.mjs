// Questions to the engine, a line each: the reference states of tests/reference, workpieces of studies, a map.
import { readFileSync } from "node:fs";
import { fileURLToPath } from "node:url";

const root = fileURLToPath(new URL("..", import.meta.url));
const read = (path) => readFileSync(root + path, "utf8");
const ask = (call, answer) => console.log(JSON.stringify({ ask: call, ...answer }));
const open = (machine) => ask({ call: "open", machine, files: { [machine]: read(`crates/engine/src/machine/catalogue/${machine}.toml`) } });
for (const machine of ["orthoglide", "tripteron"]) {
  open(machine);
  for (const state of JSON.parse(read(`tests/reference/${machine}.json`))) {
    const call = { call: "tool", at: { position: state.position_mm }, load: { wrench: state.wrench_N_Nmm } };
    if (state.assembly_deg) call.assembly_deg = state.assembly_deg;
    ask(call, { displacement: state.tool_displacement_mm });
  }
}
for (const machine of ["kr270", "hexapod", "hybrid_3ups"]) {
  open(machine);
  ask({ call: "slice", axis: 2, level: 800, counts: [3, 3], nodes: [0, 9], load: { wrench: [300, -100, -200, 0, 0, 0] } });
}
for (const [folder, files, places] of [
  ["04_placement_pocket", ["process.toml", "pocket.nc"], [[0, 0, 110, 0, 0, 0], [25.5, 31, 110, -37, 0, 0], [320, 0, 110, 0, 0, 0]]],
  ["03_placement_circle", ["process.toml"], [[26, 26, 26, 0, 0, 0]]],
]) {
  const named = Object.fromEntries(files.map((name) => [name, read(`studies/${folder}/${name}`)]));
  named.orthoglide = read("crates/engine/src/machine/catalogue/orthoglide.toml");
  ask({ call: "open", machine: "orthoglide", files: named, study: read(`studies/${folder}/study.toml`) });
  for (const place of places) {
    ask({ call: "place", place, most: 40 });
    ask({ call: "place", place });
  }
}
ask({ call: "open", machine: "orthoglide", files: { orthoglide: read("crates/engine/src/machine/catalogue/orthoglide.toml") }, study: read("studies/01_workspace_map/study.toml") });
for (const source of ["all", "cutting", "errors"]) ask({ call: "effect", position: [100, -50, 20], source, phi_deg: source === "errors" ? null : 40 });
