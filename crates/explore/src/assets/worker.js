// The program as WebAssembly, in a worker: its module first, then requests in, and answers out in their order.

let program;

function answer({ path, body }) {
  const request = new TextEncoder().encode(`${path}\n${body}`);
  const at = program.room(request.length);
  new Uint8Array(program.memory.buffer, at, request.length).set(request);
  const status = program.ask();
  const where = program.answer();
  const start = Number(where & 0xffffffffn);
  return { status, bytes: program.memory.buffer.slice(start, start + Number(where >> 32n)) };
}

onmessage = ({ data }) => {
  try {
    if (data.module) program = new WebAssembly.Instance(data.module).exports;
    else {
      const found = answer(data);
      postMessage(found, [found.bytes]);
    }
  } catch (why) {
    postMessage({ failed: String(why) });
  }
};
