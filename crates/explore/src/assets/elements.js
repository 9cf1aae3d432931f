// Making elements, and numbers as text.

// An element of HTML with attributes, listeners (functions under names such as "onclick") and children.
export function element(tag, attributes = {}, ...children) {
  return fill(document.createElement(tag), attributes, children);
}

// An element of SVG.
export function shape(tag, attributes = {}, ...children) {
  return fill(document.createElementNS("http://www.w3.org/2000/svg", tag), attributes, children);
}

function fill(made, attributes, children) {
  for (const [name, value] of Object.entries(attributes)) {
    if (typeof value === "function") made.addEventListener(name.slice(2), value);
    else if (value === true) made.setAttribute(name, "");
    else if (value !== false && value !== undefined && value !== null) made.setAttribute(name, value);
  }
  made.append(...children.filter((child) => child !== null && child !== undefined));
  return made;
}

// A number with `digits` significant digits, trailing zeros dropped.
export function short(x, digits = 6) {
  // JSON has no infinity: it is a text.
  if (typeof x === "string") return x;
  if (x === null || x === undefined || Number.isNaN(x)) return "–";
  if (!Number.isFinite(x)) return x > 0 ? "+inf" : "-inf";
  return String(Number(x.toPrecision(digits)));
}

// A number with its error, and no digits beyond the second of that: "0.0497 ± 0.00032".
export function with_error(value, error) {
  if (value === null) return `not known: its error, ${short(error, 2)}, is too large`;
  if (!(error > 0)) return String(value);
  const place = (x) => Math.floor(Math.log10(x));
  const last = place(error) - 1;
  const digits = Math.min(17, Math.max(1, (value === 0 ? last : place(Math.abs(value))) - last + 1));
  const known = Number(value.toPrecision(digits));
  const unit = 10 ** last;
  // Rounded up, so that it holds for the rounded number.
  return `${known} ± ${short(Math.ceil((error + Math.abs(known - value)) / unit) * unit, 2)}`;
}

// Why a typed number is refused; empty if it is not. `open` excludes the least value; null is no bound.
export function why_refused(text, { least, most, open }) {
  const value = Number(text);
  if (text.trim() === "") return "a number is missing";
  if (!Number.isFinite(value)) return /^[^,]*\d,\d[^,]*$/.test(text) ? `not a number; the decimal sign is a point: ${text.trim().replace(",", ".")}` : "not a number";
  const from = least ?? -Infinity;
  if (open && value <= from) return `must be greater than ${short(least)}`;
  if (value < from) return `must be ${short(least)} at least`;
  if (value > (most ?? Infinity)) return `must be ${short(most)} at most`;
  return "";
}

// A place for the reason why an input is refused, next to it.
export function refusals() {
  return element("p", { class: "problem", role: "alert", id: `refusal-${crypto.randomUUID()}` });
}

// Marks an input as refused for the reason `why`, shown in `place`; an empty reason removes the mark.
export function mark(input, place, words, why) {
  const was = input.getAttribute("aria-invalid") === "true";
  input.setAttribute("aria-invalid", String(why !== ""));
  if (why) {
    input.setAttribute("aria-describedby", place.id);
    place.textContent = `${words}: ${why}`;
  } else if (was) {
    input.removeAttribute("aria-describedby");
    place.textContent = "";
  }
}

// An SVG text of our own server as an element of this page.
export function drawing(svg) {
  return document.importNode(new DOMParser().parseFromString(svg, "image/svg+xml").documentElement, true);
}
