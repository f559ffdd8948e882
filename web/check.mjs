// Holds engines against what the program itself answers.
//   node calls.mjs > calls; cargo run --example explore < calls > native; node check.mjs calls native ENGINE.wasm.br...
// Numbers must agree to 1e-9 of mm and degrees, and to as many digits where they are large; displacements with the reference
// states to 1e-8 mm.
import { readFileSync } from "node:fs";
import { brotliDecompressSync } from "node:zlib";

const [calls, native, ...engines] = process.argv.slice(2);
const lines = (file) => readFileSync(file, "utf8").trim().split("\n").map((line) => JSON.parse(line));
const asked = lines(calls);
const expected = lines(native);
if (asked.length !== expected.length) throw new Error(`${expected.length} answers to ${asked.length} questions`);

function start(file) {
  const bytes = readFileSync(file);
  const module = new WebAssembly.Module(file.endsWith(".br") ? brotliDecompressSync(bytes) : bytes);
  const { allocate, call, answer, memory, start } = new WebAssembly.Instance(module, {}).exports;
  start();
  return (question) => {
    const text = Buffer.from(JSON.stringify(question));
    const place = allocate(text.length);
    Buffer.from(memory.buffer, place, text.length).set(text);
    const length = call(place, text.length);
    return JSON.parse(Buffer.from(memory.buffer, answer(), length).toString());
  };
}

let worst = 0;
function compare(got, wanted, where) {
  if (typeof wanted === "number" && typeof got === "number") {
    const off = Math.abs(got - wanted) / Math.max(1, Math.abs(wanted));
    worst = Math.max(worst, off);
    if (!(off < 1e-9)) throw new Error(`${where}: ${got}, expected ${wanted}`);
  } else if (wanted && typeof wanted === "object") {
    const keys = new Set([...Object.keys(wanted), ...Object.keys(got ?? {})]);
    // Which of several chains that fail alike a message names is a matter of rounding.
    for (const key of keys) if (key !== "reason") compare(got?.[key], wanted[key], `${where}.${key}`);
  } else if (got !== wanted) throw new Error(`${where}: ${JSON.stringify(got)}, expected ${JSON.stringify(wanted)}`);
}

for (const engine of engines) {
  const ask = start(engine);
  worst = 0;
  let states = 0;
  asked.forEach((line, i) => {
    const got = ask(line.ask);
    compare(got, expected[i], `${engine}: question ${i + 1} (${line.ask.call})`);
    if (line.displacement) {
      const off = Math.max(...got.answer.displacement.map((v, axis) => Math.abs(v - line.displacement[axis])));
      if (!(off < 1e-8)) throw new Error(`${engine}: question ${i + 1} is ${off} mm off the reference state`);
      states += 1;
    }
  });
  console.log(`${engine}: ${asked.length} answers agree to ${worst.toExponential(1)}, ${states} reference states to 1e-8 mm`);
}
