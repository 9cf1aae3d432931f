// Requests to the program behind the page. A request about a topic ends the one before it, whose connection is closed: the program
// then stops computing.

const running = new Map();
let lost = false;

// An answer that is a refusal: the problem, the remedy, and the place in a formula.
export class Problem extends Error {
  constructor({ problem, remedy, place, overtaken = false }, status) {
    super(remedy ? `${problem}\n${remedy}` : problem);
    Object.assign(this, { problem, remedy, place, overtaken, late: status === 503 });
  }
}

// The program does not answer any more; it may come back.
export class Gone extends Error {}

async function send(path, read, options = {}) {
  let response, answer;
  try {
    response = await fetch(path, options);
    answer = await (response.ok ? read(response) : response.json());
  } catch {
    if (options.signal?.aborted) throw new Problem({ problem: "a newer request took the place of this one", overtaken: true });
    if (!lost) {
      lost = true;
      dispatchEvent(new Event("server-gone"));
      setTimeout(look, 500);
    }
    throw new Gone("the program does not answer");
  }
  if (!response.ok) throw new Problem(answer, response.status);
  return answer;
}

// Polls until the program answers again.
async function look() {
  try {
    await fetch("/api/catalogue");
    lost = false;
    dispatchEvent(new Event("server-back"));
  } catch {
    setTimeout(look, 500);
  }
}

function ask(path, read, body, topic) {
  const stop = new AbortController();
  if (topic) {
    running.get(topic)?.abort();
    running.set(topic, stop);
  }
  return send(path, read, { method: "POST", headers: { "content-type": "application/json" }, body: JSON.stringify(body), signal: stop.signal });
}

const json = (response) => response.json();
export const get = (path) => send(path, json);
export const post = (path, body, topic) => ask(path, json, body, topic);

// A picture: its description with the cells, codes or numbers, line by line from the lowest.
export async function picture(body, topic) {
  const bytes = await ask("/api/plane", (response) => response.arrayBuffer(), body, topic);
  const all = new Uint8Array(bytes);
  const end = all.indexOf(10);
  const head = JSON.parse(new TextDecoder().decode(all.subarray(0, end)));
  head.cells = head.kinds ? new Int8Array(bytes, end + 1) : new Float32Array(bytes, end + 1);
  return head;
}
