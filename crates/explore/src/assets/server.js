// Requests to the program behind the page. Each contains its tab and its number, so that the program can drop
// superseded requests.

const tab = crypto.randomUUID();
let number = 0;
let lost = false;

// An answer that is a refusal: the problem, the remedy, and the place in a formula.
export class Problem extends Error {
  constructor({ problem, remedy, place }, status) {
    super(remedy ? `${problem}\n${remedy}` : problem);
    Object.assign(this, { problem, remedy, place, overtaken: status === 204, late: status === 503 });
  }
}

// The program does not answer any more; it may come back.
export class Gone extends Error {}

async function send(path, options) {
  let response;
  try {
    response = await fetch(path, options);
  } catch {
    if (!lost) {
      lost = true;
      dispatchEvent(new Event("server-gone"));
      setTimeout(look, 500);
    }
    throw new Gone("the program does not answer");
  }
  if (response.status === 204) throw new Problem({ problem: "a newer request took the place of this one" }, 204);
  if (response.ok) return response;
  const refusal = await response.json().catch(() => ({ problem: `the program answered ${response.status}`, remedy: "" }));
  throw new Problem(refusal, response.status);
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

function ask(path, body, name = tab) {
  number += 1;
  const text = JSON.stringify({ ...body, turn: { tab: name, number } });
  return send(path, { method: "POST", headers: { "content-type": "application/json" }, body: text });
}

export const get = (path) => send(path).then((response) => response.json());
export const post = (path, body) => ask(path, body).then((response) => response.json());

// A picture: its description with the cells, codes or numbers, line by line from the lowest.
export async function picture(body, name) {
  const bytes = await (await ask("/api/plane", body, name)).arrayBuffer();
  const all = new Uint8Array(bytes);
  const end = all.indexOf(10);
  const head = JSON.parse(new TextDecoder().decode(all.subarray(0, end)));
  head.cells = head.kinds ? new Int8Array(bytes, end + 1) : new Float32Array(bytes, end + 1);
  return head;
}
