// The program as WebAssembly, in a worker: requests in, answers out, in the same order.

let program;

onmessage = ({ data: { module, path, body } }) => {
  try {
    program ??= new WebAssembly.Instance(module).exports;
    const request = new TextEncoder().encode(`${path}\n${body}`);
    const at = program.room(request.length);
    new Uint8Array(program.memory.buffer, at, request.length).set(request);
    const status = program.ask();
    const where = program.answer();
    const start = Number(where & 0xffffffffn);
    const bytes = program.memory.buffer.slice(start, start + Number(where >> 32n));
    postMessage({ status, bytes }, [bytes]);
  } catch (why) {
    postMessage({ failed: String(why) });
  }
};
