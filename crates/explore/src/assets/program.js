// Requests to the program: to a server, or to workers of the browser, in which it runs as WebAssembly. A request about a topic
// ends the one before it: its connection is closed, or its worker ended.

const read = (id) => document.getElementById(id).textContent;

// What the page begins with: the catalogue, the file of the command, and the path of the server, if there is one.
export const begin = JSON.parse(read("begin"));

// An answer that is a refusal: the problem, the remedy, and the place in a formula.
export class Problem extends Error {
  constructor({ problem, remedy, place, overtaken = false }, status) {
    super(remedy ? `${problem}\n${remedy}` : problem);
    Object.assign(this, { problem, remedy, place, overtaken, late: status === 503 });
  }
}

// The server does not answer any more.
export class Gone extends Error {}

const overtaken = () => new Problem({ problem: "a newer request took the place of this one", overtaken: true });

class Server {
  constructor(path) {
    Object.assign(this, { path, running: new Map() });
  }

  async ask(path, body, topic) {
    const stop = new AbortController();
    if (topic) {
      this.running.get(topic)?.abort();
      this.running.set(topic, stop);
    }
    try {
      const response = await fetch(`${this.path}${path}`, { method: "POST", body: JSON.stringify(body), signal: stop.signal });
      return { status: response.status, bytes: await response.arrayBuffer() };
    } catch {
      if (stop.signal.aborted) throw overtaken();
      dispatchEvent(new Event("program-gone"));
      throw new Gone("the program does not answer");
    }
  }
}

// A worker, with the requests that it has not answered yet.
class Lane {
  constructor(workers) {
    Object.assign(this, { workers, waiting: [], worker: null });
  }

  async ask(path, body) {
    const module = await this.workers.module;
    return new Promise((resolve, reject) => {
      this.waiting.push({ resolve, reject });
      if (!this.worker) this.start(module);
      this.worker.postMessage({ path, body: JSON.stringify(body) });
    });
  }

  start(module) {
    this.worker = new Worker(this.workers.script);
    this.worker.postMessage({ module });
    this.worker.onmessage = ({ data }) => {
      if (data.failed) this.end(new Problem({ problem: `the computation failed: ${data.failed}`, remedy: "please report it" }, 500));
      else this.waiting.shift().resolve(data);
    };
    this.worker.onerror = () => this.end(new Problem({ problem: "the computation failed", remedy: "please report it" }, 500));
  }

  // Ends the worker if it computes; all that wait are told why.
  end(why) {
    if (!this.waiting.length) return;
    this.worker.terminate();
    this.worker = null;
    for (const { reject } of this.waiting.splice(0)) reject(why);
  }
}

// Strips of a picture for each worker: some take longer than others.
const STRIPS = 4;
// Rows or columns of the narrowest strip.
const NARROW = 4;

class Workers {
  constructor(packed) {
    this.module = this.compile(packed);
    this.script = URL.createObjectURL(new Blob([read("worker")], { type: "text/javascript" }));
    Object.assign(this, { lanes: new Map(), turns: new Map(), count: Math.max(1, Math.min(16, navigator.hardwareConcurrency || 1)) });
  }

  async compile(packed) {
    const bytes = Uint8Array.from(atob(packed), (letter) => letter.charCodeAt(0));
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
    return WebAssembly.compile(await new Response(stream).arrayBuffer());
  }

  // The worker of a topic; pictures of planes have several.
  lane(topic, number = 0) {
    const name = `${topic} ${number}`;
    if (!this.lanes.has(name)) this.lanes.set(name, new Lane(this));
    return this.lanes.get(name);
  }

  end(topic) {
    for (let number = 0; number < this.count; number += 1) this.lane(topic, number).end(overtaken());
  }

  ask(path, body, topic) {
    if (topic) this.end(topic);
    return this.lane(topic).ask(path, body);
  }

  // A picture in strips across a side, which are computed at the same time: their answers in order.
  async strips(body, topic, side) {
    this.end(topic);
    const turn = (this.turns.get(topic) ?? 0) + 1;
    this.turns.set(topic, turn);
    const [from, to] = body[side].part ?? [0, body[side].points];
    const count = Math.max(1, Math.min(STRIPS * this.count, Math.floor((to - from) / NARROW)));
    const edge = (i) => from + Math.floor(((to - from) * i) / count);
    const answers = [];
    let next = 0;
    const work = async (number) => {
      while (next < count) {
        const i = next;
        next += 1;
        answers[i] = await this.lane(topic, number).ask("plane", { ...body, [side]: { ...body[side], part: [edge(i), edge(i + 1)] } });
        if (turn !== this.turns.get(topic)) throw overtaken();
        if (answers[i].status !== 200) next = count;
      }
    };
    try {
      await Promise.all(Array.from({ length: Math.min(this.count, count) }, (_, number) => work(number)));
    } catch (why) {
      // The others would go on.
      if (turn === this.turns.get(topic)) this.end(topic);
      throw why;
    }
    return answers.filter((answer) => answer);
  }
}

const program = begin.server ? new Server(begin.server) : new Workers(read("wasm"));

const json = (bytes) => JSON.parse(new TextDecoder().decode(bytes));

function checked({ status, bytes }) {
  if (status !== 200) throw new Problem(json(bytes), status);
  return bytes;
}

export const post = async (path, body, topic) => json(checked(await program.ask(path, body, topic)));

// A picture: its description with the cells, codes or numbers, line by line from the lowest; and how many seconds it took. Its
// strips across `side` may be computed at the same time.
export async function picture(body, topic, side = "x") {
  const started = performance.now();
  const answers = program.strips ? await program.strips(body, topic, side) : [await program.ask("plane", body, topic)];
  const strips = answers.map((answer) => one(checked(answer)));
  const seconds = (performance.now() - started) / 1000;
  return { ...(strips.length > 1 ? joined(strips, side) : strips[0]), seconds };
}

function one(bytes) {
  const all = new Uint8Array(bytes);
  const end = all.indexOf(10);
  const head = json(all.subarray(0, end));
  head.cells = head.kinds ? new Int8Array(bytes, end + 1) : new Float32Array(bytes, end + 1);
  return head;
}

function joined(strips, side) {
  const sum = (size) => strips.reduce((all, strip) => all + strip[size], 0);
  const [width, height] = side === "x" ? [sum("width"), strips[0].height] : [strips[0].width, sum("height")];
  const cells = new strips[0].cells.constructor(width * height);
  let [column, row] = [0, 0];
  for (const strip of strips) {
    for (let j = 0; j < strip.height; j += 1) cells.set(strip.cells.subarray(j * strip.width, (j + 1) * strip.width), (row + j) * width + column);
    if (side === "x") column += strip.width;
    else row += strip.height;
  }
  return { ...strips[0], width, height, cells };
}
