// The whole state of the page, and how it is written into the link.
//
// A link is a list of `key=value`: `v` the version, `law`, `x` and `y` (name, from, to, and "log"), `show`,
// `p.NAME` the value of a parameter, `m.NAME` a quantity of a machine in SI units, `r.NAME` the ends of its
// slider, `pin=1` if a point is pinned. Keys that this page does not know are passed over, and keys that are
// missing take their defaults: links of older and of newer versions open.

export const VERSION = 1;

export function write(state) {
  const link = new URLSearchParams();
  link.set("v", VERSION);
  link.set("law", state.law.name);
  for (const key of ["phi", "table", "file"]) if (state.law[key]) link.set(key, state.law[key]);
  if (state.law.static && state.law.static !== 1) link.set("static", state.law.static);
  if (state.law.small) link.set("small", "1");
  for (const side of ["x", "y"]) {
    const { axis, from, to, log } = state[side];
    link.set(side, [axis, from, to, ...(log ? ["log"] : [])].join(","));
  }
  link.set("show", state.show);
  if (!state.curves) link.set("curves", "0");
  if (state.stored) link.set("stored", "1");
  for (const axis of state.axes) {
    link.set(`p.${axis.name}`, state.at[axis.name]);
    const range = state.ranges[axis.name];
    if (range[0] !== axis.from || range[1] !== axis.to) link.set(`r.${axis.name}`, range.join(","));
  }
  if (state.machine) for (const [name, value] of Object.entries(state.machine)) link.set(`m.${name}`, value);
  if (state.pinned) link.set("pin", "1");
  // Commas and slashes are legal in a fragment, and easier to read.
  return `#${link.toString().replaceAll("%2C", ",").replaceAll("%2F", "/")}`;
}

const number = (text) => (text !== null && text.trim() !== "" && Number.isFinite(Number(text)) ? Number(text) : null);

// What a link says, without what depends on the law's axes.
export function read(fragment) {
  const link = new URLSearchParams(fragment.replace(/^#/, ""));
  if (!link.has("law")) return null;
  const law = { name: link.get("law") };
  for (const key of ["phi", "table", "file"]) if (link.has(key)) law[key] = link.get(key);
  if (number(link.get("static")) !== null) law.static = number(link.get("static"));
  if (link.get("small") === "1") law.small = true;
  const side = (key) => {
    const [axis, from, to, log] = (link.get(key) ?? "").split(",");
    const ends = [number(from ?? null), number(to ?? null)];
    return axis && ends[0] !== null && ends[1] !== null && ends[0] < ends[1] ? { axis, from: ends[0], to: ends[1], log: log === "log" } : null;
  };
  const at = {};
  const ranges = {};
  let machine = null;
  for (const [key, value] of link) {
    const name = key.slice(2);
    if (key.startsWith("m.")) machine = { ...machine, [name]: number(value) ?? value };
    if (key.startsWith("p.") && number(value) !== null) at[name] = number(value);
    if (key.startsWith("r.")) {
      const ends = value.split(",").map(number);
      if (ends.length === 2 && ends[0] !== null && ends[1] !== null && ends[0] < ends[1]) ranges[name] = ends;
    }
  }
  return { law, x: side("x"), y: side("y"), show: link.get("show"), curves: link.get("curves") !== "0", stored: link.get("stored") === "1", at, ranges, machine, pinned: link.get("pin") === "1" };
}

// A state of a law with these axes: what is said, and defaults for the rest.
export function complete(said, axes) {
  const names = axes.map((axis) => axis.name);
  const at = {};
  const ranges = {};
  for (const axis of axes) {
    at[axis.name] = said.at?.[axis.name] ?? axis.value;
    ranges[axis.name] = said.ranges?.[axis.name] ?? [axis.from, axis.to];
  }
  const side = (wanted, usual) => {
    if (wanted && names.includes(wanted.axis)) return { ...wanted };
    const [from, to] = ranges[usual];
    return { axis: usual, from, to, log: false };
  };
  const y = side(said.y, "c");
  const free = names.filter((name) => name !== y.axis && name !== "epsilon");
  const usual = ["gamma", "V"].find((name) => free.includes(name)) ?? free[0];
  let x = side(said.x, usual);
  if (x.axis === y.axis) x = side(null, usual);
  return { law: said.law, axes, at, ranges, x, y, machine: said.machine ?? null, si: said.si ?? null, show: said.show || "regime", curves: said.curves ?? true, stored: said.stored ?? false, pinned: said.pinned ?? false };
}

// What the program has to know of a place.
export const place = ({ law, at, machine }) => ({ law, at, machine });

// How an axis is called and counted: in the SI units of a machine, if the state is one's.
export function label(state, name) {
  const si = state.si?.axes[name];
  if (si) return { words: si.words, text: `${si.words}, ${si.unit}`, unit: ` ${si.unit}`, factor: si.factor };
  const { symbol } = state.axes.find((axis) => axis.name === name);
  return { words: symbol, text: symbol, unit: "", factor: 1 };
}
