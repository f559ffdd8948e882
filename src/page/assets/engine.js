"use strict";
// The engine in workers, each with its own copy, or in the page where a browser makes no workers of a page from disk.
function engineWorker() {
  let engine = null;
  const encoder = new TextEncoder();
  const decoder = new TextDecoder();
  function ask(question) {
    const bytes = encoder.encode(JSON.stringify(question));
    const { allocate, call, answer, fault, memory } = engine;
    const read = (length) => decoder.decode(new Uint8Array(memory.buffer, answer(), length));
    const began = performance.now();
    let length = 0;
    try {
      const place = allocate(bytes.length);
      new Uint8Array(memory.buffer, place, bytes.length).set(bytes);
      length = call(place, bytes.length);
    } catch (trap) {
      const words = read(fault());
      engine = null;
      return { error: "a fault of the program: " + (words || trap.message), ended: true };
    }
    const answered = JSON.parse(read(length));
    answered.ms = performance.now() - began;
    return answered;
  }
  async function open(bytes) {
    const { instance } = await WebAssembly.instantiate(bytes, {});
    engine = instance.exports;
    engine.start();
  }
  return {
    open,
    ask: (question) => (engine ? ask(question) : { error: "the engine has ended", ended: true }),
  };
}

const Engine = (() => {
  const SOURCE = `const engine = (${engineWorker})();
    let opened = null;
    onmessage = async ({ data: { id, bytes, question } }) => {
      if (bytes) { opened = engine.open(bytes); await opened.catch((fault) => postMessage({ id, answer: { error: String(fault) } })); return; }
      try { await opened; postMessage({ id, answer: engine.ask(question) }); } catch (fault) { postMessage({ id, answer: { error: String(fault) } }); }
    };`;
  async function unpacked(text) {
    const packed = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
    const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
    return new Response(stream).arrayBuffer();
  }
  let bytes = null;
  // The engine's bytes, once for all workers.
  const load = () => (bytes ??= unpacked(document.getElementById("engine").textContent));

  // One instance that answers question after question. `ask` gives a promise.
  async function start() {
    const own = await load();
    let worker = null;
    try {
      worker = new Worker(URL.createObjectURL(new Blob([SOURCE], { type: "text/javascript" })));
    } catch {
      const engine = engineWorker();
      await engine.open(own);
      return { inPage: true, ask: async (question) => checked(engine.ask(question)) };
    }
    const waiting = new Map();
    let last = 0;
    worker.onmessage = ({ data: { id, answer } }) => {
      const settle = waiting.get(id);
      waiting.delete(id);
      if (settle) settle(answer);
      else if (answer?.error) waiting.forEach((other) => other(answer));
    };
    worker.onerror = (event) => waiting.forEach((settle) => settle({ error: event.message || "the worker ended" }));
    worker.postMessage({ bytes: own });
    return {
      inPage: false,
      ask: (question) => new Promise((settle) => {
        waiting.set(++last, settle);
        worker.postMessage({ id: last, question });
      }).then(checked),
      end: () => worker.terminate(),
    };
  }
  function checked(answer) {
    if (answer.error) throw new Error(answer.error);
    return answer;
  }
  return { start };
})();
