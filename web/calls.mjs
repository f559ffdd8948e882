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
// Where the tool may be, as a machine file and as the table of a study says.
for (const [machine, position] of [["orthoglide", [10, 20, 30]], ["kr270", [1700, 100, 900]]]) {
  const toml = read(`crates/engine/src/machine/catalogue/${machine}.toml`);
  const cloud = { call: "cloud", at: { position }, load: { wrench: [120, -40, -60, 0, 500, 0] } };
  open(machine);
  ask(cloud);
  const study = `schema = 3\nquestion = "Where?"\nmachine = "${machine}"\nprocess.force.path_frame = { radial_force_N = 215.0, tangential_force_N = -10.0, axial_force_N = -25.0 }
[uncertainty]\nmachine = "provenance"\nchain_error = [{ chain = "*", turn_about_drive_axis_deg = { uniform = [-0.1, 0.1] } }]\nprocess.force_relative_std = 0.15
[workspace_map]\nslices_z_mm = [${position[2]}]\n`;
  ask({ call: "open", machine, files: { [machine]: toml }, study });
  ask(cloud);
}
ask({ call: "open", machine: "orthoglide", files: { orthoglide: read("crates/engine/src/machine/catalogue/orthoglide.toml") }, study: read("studies/01_workspace_map/study.toml") });
for (const source of ["all", "cutting", "geometry"]) ask({ call: "effect", position: [100, -50, 20], source, phi_deg: source === "geometry" ? null : 40 });
