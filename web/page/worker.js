"use strict";
// The scanner in a worker, so that a long scan does not block the page. Requests are processed in order.
let bytes = null;
let scanner = null;
let turn = Promise.resolve();

/** Answers one request: a JSON head, and the bytes of a file or a port. */
function ask(head, body) {
  const text = new TextEncoder().encode(JSON.stringify(head));
  const length = 4 + text.length + body.length;
  const at = scanner.reserve(length);
  // The memory may have grown, which replaces its buffer.
  new DataView(scanner.memory.buffer).setUint32(at, text.length, true);
  const room = new Uint8Array(scanner.memory.buffer, at, length);
  room.set(text, 4);
  room.set(body, 4 + text.length);
  const answer = scanner.ask();
  return JSON.parse(new TextDecoder().decode(new Uint8Array(scanner.memory.buffer, answer, scanner.length())));
}

async function work({ id, wasm, head, body }) {
  let answer = {};
  try {
    if (wasm) bytes = wasm;
    scanner ??= (await WebAssembly.instantiate(bytes, {})).instance.exports;
    if (head) answer = ask(head, body ?? new Uint8Array());
  } catch (error) {
    // The next request creates a new scanner.
    scanner = null;
    answer = { error: `the scanner stopped: ${error.message}` };
  }
  self.postMessage({ id, answer });
}

self.onmessage = ({ data }) => {
  turn = turn.then(() => work(data));
};
