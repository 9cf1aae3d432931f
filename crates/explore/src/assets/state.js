// The whole state of the page, and its link.
//
// A link is a list of `key=value`: `law`, `axes` (what it has besides the usual axes), `x` and `y` (name, from, to, and "log"), `show`,
// `rows`, `source`, `fit` and `spread` (JSON: a table, what is known of it, and errors), `title`, `p.NAME` the value of a parameter or, with `motion`, of a quantity of a machine, `r.NAME` the ends of its slider, `u.NAME` the
// unit of both and its size in SI, if it is another, `pin=1` if a point is pinned. Unknown keys are ignored, and missing keys take their defaults,
// so that links can be written by hand.

import { short } from "./elements.js";

const TEXTS = ["phi", "table", "file", "rest", "quantity"];
const JSONS = ["rows", "source", "fit"];

export function write(state) {
  const link = new URLSearchParams();
  link.set("law", state.law.name);
  if (state.law.static) link.set("static", state.law.static);
  if (state.law.small) link.set("small", "1");
  for (const key of TEXTS) if (state.law[key]) link.set(key, state.law[key]);
  for (const key of JSONS) if (state.law[key]) link.set(key, JSON.stringify(state.law[key]));
  if (Object.keys(state.spread).length) link.set("spread", JSON.stringify(state.spread));
  if (state.title) link.set("title", state.title);
  if (state.law.axes?.length) link.set("axes", state.law.axes.join(","));
  for (const side of ["x", "y"]) {
    const { axis, from, to, log } = state[side];
    link.set(side, [axis, from, to, ...(log ? ["log"] : [])].join(","));
  }
  link.set("show", state.show);
  if (!state.curves) link.set("curves", "0");
  for (const axis of state.axes) {
    link.set(`p.${axis.name}`, state.at[axis.name]);
    const range = state.ranges[axis.name];
    if (range[0] !== axis.from || range[1] !== axis.to) link.set(`r.${axis.name}`, range.join(","));
    if (state.units[axis.name]) link.set(`u.${axis.name}`, state.units[axis.name].join(","));
  }
  if (state.motion) link.set("motion", state.motion);
  if (state.pinned) link.set("pin", "1");
  // Commas and slashes are legal in a fragment, and easier to read.
  return `#${link.toString().replaceAll("%2C", ",").replaceAll("%2F", "/")}`;
}

const number = (text) => (text !== null && text.trim() !== "" && Number.isFinite(Number(text)) ? Number(text) : null);

// Null for what is no JSON: the program then says what is missing.
function parsed(text) {
  try {
    return JSON.parse(text);
  } catch {
    return null;
  }
}

// Parses a link, except what depends on the law's axes.
export function read(fragment) {
  const link = new URLSearchParams(fragment.replace(/^#/, ""));
  if (!link.has("law")) return null;
  const law = { name: link.get("law") };
  for (const key of TEXTS) if (link.has(key)) law[key] = link.get(key);
  for (const key of JSONS) if (link.has(key)) law[key] = parsed(link.get(key));
  if (number(link.get("static")) !== null) law.static = number(link.get("static"));
  if (link.get("small") === "1") law.small = true;
  if (link.has("axes")) law.axes = link.get("axes").split(",");
  const side = (key) => {
    const [axis, from, to, log] = (link.get(key) ?? "").split(",");
    const ends = [number(from ?? null), number(to ?? null)];
    return axis && ends[0] !== null && ends[1] !== null && ends[0] < ends[1] ? { axis, from: ends[0], to: ends[1], log: log === "log" } : null;
  };
  const at = {};
  const ranges = {};
  const units = {};
  for (const [key, value] of link) {
    const name = key.slice(2);
    if (key.startsWith("p.") && number(value) !== null) at[name] = number(value);
    if (key.startsWith("r.")) {
      const ends = value.split(",").map(number);
      if (ends.length === 2 && ends[0] !== null && ends[1] !== null && ends[0] < ends[1]) ranges[name] = ends;
    }
    if (key.startsWith("u.")) {
      const [unit, size] = value.split(",");
      if (unit && Number(size) > 0) units[name] = [unit, Number(size)];
    }
  }
  return { law, x: side("x"), y: side("y"), show: link.get("show"), curves: link.get("curves") !== "0", at, ranges, units, spread: parsed(link.get("spread")) ?? {}, title: link.get("title"), motion: link.get("motion"), pinned: link.get("pin") === "1" };
}

// Whether an axis is that of the damping.
export const is_damping = (name) => ["c", "damping", "damping_ratio"].includes(name);

// An axis in SI units in the unit that is wanted of it.
function in_unit(axis, [unit, size] = []) {
  if (!unit) return axis;
  const shown = ["least", "most", "from", "to", "value"].map((key) => [key, axis[key] === null ? null : axis[key] / size]);
  return { ...axis, unit, ...Object.fromEntries(shown) };
}

// The state of a law with these axes, in SI units: the values in `wanted`, in its units, and defaults for the rest.
export function complete(wanted, in_si) {
  const units = wanted.motion ? (wanted.units ?? {}) : {};
  const axes = in_si.map((axis) => in_unit(axis, units[axis.name]));
  const names = axes.map((axis) => axis.name);
  const at = {};
  const ranges = {};
  for (const axis of axes) {
    at[axis.name] = wanted.at?.[axis.name] ?? axis.value;
    // Quantities of a machine have no default range.
    const usual = axis.unit !== undefined && at[axis.name] > 0 ? [0, 2 * at[axis.name]] : [axis.from, axis.to];
    ranges[axis.name] = wanted.ranges?.[axis.name] ?? usual;
  }
  const side = (wanted, usual) => {
    if (wanted && names.includes(wanted.axis)) return { ...wanted };
    const [from, to] = ranges[usual];
    return { axis: usual, from, to, log: false };
  };
  const y = side(wanted.y, names.find(is_damping));
  const free = names.filter((name) => name !== y.axis && name !== "epsilon");
  const usual = ["gamma", "V", "belt_speed"].find((name) => free.includes(name)) ?? free[0];
  let x = side(wanted.x, usual);
  if (x.axis === y.axis) x = side(null, usual);
  return { law: wanted.law, axes, at, ranges, units, x, y, spread: wanted.spread ?? {}, title: wanted.title ?? null, motion: wanted.motion ?? null, show: wanted.show || "regime", curves: wanted.curves ?? true, pinned: wanted.pinned ?? false };
}

// Size in SI of the unit in which a quantity is shown.
export const size = ({ units }, name) => units[name]?.[1] ?? 1;

// The part of the state that the program needs for a point: values in SI units, and the units of its figures.
export function place(state) {
  const { law, at, units, motion, spread, title } = state;
  return { law, at: Object.fromEntries(Object.entries(at).map(([name, value]) => [name, value * size(state, name)])), units, motion, spread, title };
}

// What it needs for a plane, of these numbers of cells: the sides in SI units.
export function plane(state, width, height) {
  const side = (of, points) => ({ ...of, points, from: of.from * size(state, of.axis), to: of.to * size(state, of.axis) });
  return { ...place(state), x: side(state.x, width), y: side(state.y, height) };
}

// The name of an axis; for a machine, with its unit.
export function label(state, name) {
  const { symbol, unit } = state.axes.find((axis) => axis.name === name);
  return { words: symbol, text: unit ? `${symbol}, ${unit}` : symbol, unit: unit ? ` ${unit}` : "" };
}

// The coordinates of a point in the plane, in words.
export function where(state, at) {
  return [state.x.axis, state.y.axis].map((name) => {
    const { words, unit } = label(state, name);
    return `${words} = ${short(at[name])}${unit}`;
  }).join(", ");
}
