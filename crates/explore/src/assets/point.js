// The pinned point: the motion there, figures, verdicts, and every number that is known.

import { drawing, element, mark, refusals, short, why_refused, with_error } from "./elements.js";
import { post } from "./program.js";
import { label, place, where } from "./state.js";

const FIGURES = [["orbit", "Motion"], ["friction", "Friction curve"], ["backbone", "Largest velocity against damping"]];

// Milliseconds for which a motion that is under way is waited for while the point moves on.
const PATIENCE = 400;

export class Point {
  constructor(app) {
    Object.assign(this, { app, box: document.getElementById("point"), line: document.getElementById("answer"), built: false, start: null, key: "", turn: 0 });
    Object.assign(this, { begun: -Infinity, behind: false });
  }

  get state() {
    return this.app.state;
  }

  // Shows the pinned point of the state: only the motion while the point moves, then everything.
  update(moving) {
    if (!this.state.pinned) {
      this.built = false;
      this.key = "";
      this.answer("");
      this.box.replaceChildren(element("h2", {}, "A point"), element("p", { class: "hint" }, "Click into the plane: the motion there, every method's verdict with its numbers, and what is proved."));
      return;
    }
    if (!this.built) this.build();
    const key = JSON.stringify(place(this.state));
    if (key !== this.key) {
      this.key = key;
      this.whole = false;
      this.start = null;
      this.tell_where();
      this.answer("…");
      this.age();
      this.turn += 1;
      this.follow();
    }
    if (!moving && !this.whole) {
      this.whole = true;
      this.tell();
      for (const [name] of FIGURES.slice(1)) this.draw(name);
    }
  }

  build() {
    this.built = true;
    this.where = element("div", { class: "where" });
    this.typed = new Map();
    this.regime = element("p", { class: "regime" });
    this.figures = new Map(FIGURES.map(([name]) => [name, element("div", { class: "figure" })]));
    this.verdicts = element("div");
    this.sensitivities = element("div");
    this.numbers = element("div");
    const unpin = element("button", { type: "button", onclick: () => this.app.unpin() }, "Unpin");
    const figures = FIGURES.map(([name, words]) => element("details", { open: true }, element("summary", {}, words), this.figures.get(name)));
    const hint = element("p", { class: "hint" }, "Click into the portrait to follow the orbit from there.");
    figures[0].append(hint);
    this.figures.get("orbit").addEventListener("click", (event) => this.start_from(event));
    this.box.replaceChildren(
      element("div", { class: "title" }, element("h2", {}, "The point"), unpin), this.where, this.regime,
      figures[0], this.verdicts, ...figures.slice(1),
      element("details", { open: true }, element("summary", {}, "What the critical damping depends on"), this.sensitivities),
      element("details", {}, element("summary", {}, "Every number"), this.numbers),
    );
  }

  // Marks what is shown as that of the previous state, until its own answer arrives.
  age() {
    delete this.box.dataset.regime;
    for (const part of [this.regime, this.verdicts, this.sensitivities, this.numbers, ...this.figures.values()]) {
      part.classList.toggle("previous", part.hasChildNodes());
    }
  }

  // Replaces the contents of a part by those of this state.
  show(part, ...contents) {
    part.classList.remove("previous");
    part.replaceChildren(...contents);
  }

  // The answer in a line below the plane, which is seen without scrolling.
  answer(words) {
    const { state, line } = this;
    line.hidden = !words;
    line.textContent = words ? `${where(state, state.at)}: ${words}` : "";
  }

  // Shows the coordinates of the point: those in the plane, which can be typed, and the others of the law.
  tell_where() {
    const { state } = this;
    const axes = [state.x.axis, state.y.axis];
    if (axes.some((name) => !this.typed.has(name)) || this.units !== state.units) {
      this.units = state.units;
      this.typed = new Map(axes.map((name) => [name, this.coordinate(name)]));
      this.others = element("p", { class: "hint" });
      const field = (name) => {
        const { words, unit } = label(state, name);
        return element("label", { class: "field" }, words, this.typed.get(name), unit);
      };
      this.problem = refusals();
      this.where.replaceChildren(...axes.map(field), this.problem, this.others);
    }
    for (const [name, input] of this.typed) {
      input.value = short(state.at[name]);
      mark(input, this.problem, "", "");
    }
    const others = state.motion ? [] : state.axes.filter(({ name }) => !axes.includes(name));
    this.others.textContent = others.map(({ name }) => `${label(state, name).words} = ${short(state.at[name])}`).join(", ");
  }

  // The input of a coordinate; the plane is extended to a point outside of it.
  coordinate(name) {
    const { words } = label(this.state, name);
    const input = element("input", { class: "number", inputmode: "decimal", autocomplete: "off", "aria-label": `${words} of the point` });
    input.addEventListener("change", () => {
      const { state, app } = this;
      const why = why_refused(input.value, state.axes.find((axis) => axis.name === name));
      mark(input, this.problem, words, why);
      if (why) return;
      const value = Number(input.value);
      const side = state.x.axis === name ? "x" : "y";
      const { from, to } = state[side];
      state[side] = { ...state[side], from: Math.min(from, value), to: Math.max(to, value) };
      app.move({ [name]: value });
      app.change("rest");
    });
    return input;
  }

  // The motion of a point that moves, as often as there is time.
  async follow() {
    this.behind = true;
    if (performance.now() - this.begun < PATIENCE) return;
    this.behind = false;
    const begun = performance.now();
    this.begun = begun;
    await this.draw("orbit", true);
    if (begun !== this.begun) return;
    this.begun = -Infinity;
    if (this.behind) this.follow();
  }

  // A figure of the point; while it `moves` also that of where it was.
  async draw(figure, moves = false) {
    const turn = this.turn;
    const box = this.figures.get(figure);
    try {
      const drawn = await post("figure", { ...place(this.state), figure, start: figure === "orbit" ? this.start : null }, figure);
      if (turn !== this.turn && !moves) return;
      this.show(box, drawing(drawn.svg));
      box.classList.toggle("previous", turn !== this.turn);
      if (drawn.panel) this.panel = drawn.panel;
    } catch (problem) {
      if (turn === this.turn && problem.problem && !problem.overtaken) this.show(box, element("p", { class: "problem" }, problem.message));
    }
  }

  // The orbit from the place in the portrait that was clicked.
  start_from(event) {
    const svg = this.figures.get("orbit").firstElementChild;
    if (!svg?.viewBox || !this.panel) return;
    const box = svg.getBoundingClientRect();
    const scale = svg.viewBox.baseVal.width / box.width;
    const { x, y, w, h, x1, x2 } = this.panel;
    const [u, v] = [((event.clientX - box.left) * scale - x) / w, 1 - ((event.clientY - box.top) * scale - y) / h];
    if (u < 0 || u > 1 || v < 0 || v > 1) return;
    this.start = [x1[0] + u * (x1[1] - x1[0]), x2[0] + v * (x2[1] - x2[0])];
    this.draw("orbit");
  }

  async tell() {
    const turn = this.turn;
    try {
      const probe = await post("point", place(this.state), "point");
      if (turn !== this.turn) return;
      this.probe = probe;
      this.show(this.regime, element("b", {}, probe.regime.replaceAll("_", " ")));
      this.box.dataset.regime = probe.regime;
      this.answer(in_a_line(probe, this.state.units));
      this.show(this.verdicts, verdict_table(probe, this.state.units));
      this.show(this.sensitivities, ...sensitivity_table(probe));
      this.show(this.numbers, ...numbers(probe));
    } catch (problem) {
      if (turn === this.turn && problem.problem && !problem.overtaken) {
        this.show(this.regime, element("span", { class: "problem" }, problem.message));
        this.answer(problem.message);
        for (const part of [this.verdicts, this.sensitivities, this.numbers]) this.show(part);
      }
    }
  }
}

// Unit of the dampings or velocities that are shown, and its size in those of the answer.
function unit_of({ machine }, units, quantity) {
  if (!machine) return ["", 1];
  const { force, velocity } = machine.units;
  const turns = machine.motion === "rotation";
  const [si, size] = quantity === "damping" ? [turns ? "N m s/rad" : "N s/m", force / velocity] : [turns ? "rad/s" : "m/s", velocity];
  const [unit, of_unit] = units[quantity] ?? [si, 1];
  return [` ${unit}`, size / of_unit];
}

// The regime, the critical damping and the kick.
function in_a_line(probe, units) {
  const parts = [probe.regime.replaceAll("_", " ")];
  const told = (words, value, quantity) => {
    const [unit, size] = unit_of(probe, units, quantity);
    parts.push(`${words} ${short(value * size, 4)}${unit}`);
  };
  if (probe.critical_c.value !== null) told("critical damping", probe.critical_c.value, "damping");
  const kick = probe.basin_boundary?.kick;
  if (kick) told("kick of velocity", kick.forward, "belt_speed");
  return parts.join("; ");
}

function verdict_table({ methods, critical_c, machine }, units) {
  // Of a machine, dampings are shown in its units.
  const [of_damping, damping] = unit_of({ machine }, units, "damping");
  const unit = of_damping.trim();
  const heads = machine ? [`margin, ${unit}`, `critical damping, ${unit}`] : ["margin", "critical c"];
  const number = (value, factor) => short(typeof value === "number" ? value * factor : value, 4);
  const head = element("tr", {}, ...["method", "verdict", ...heads].map((words) => element("th", { scope: "col" }, words)));
  // Below each method, over the whole width: the reason why it does not decide, or its guarantee.
  const rows = Object.entries(methods).flatMap(([name, method]) => [
    element("tr", { "data-method": name, title: method.equation },
      element("th", { scope: "row" }, name.replaceAll("_", " ")),
      element("td", {}, element("span", { class: `say ${method.verdict}` }, method.verdict)),
      element("td", { class: "number" }, number(method.margin, damping)),
      element("td", { class: "number" }, number(method.critical_c, damping))),
    element("tr", { class: "why" }, element("td", { class: "hint", colspan: "4" }, method.reason ?? `guarantee: ${method.guarantee.replaceAll("_", " ")}`)),
  ]);
  const exact = critical_c.value === null ? `not told (${critical_c.reason})` : `${with_error(critical_c.value * damping, critical_c.error * damping)} ${unit}`.trim();
  const margin = machine ? `${unit} of damping` : "c";
  return element("div", { class: "wide", tabindex: "0", role: "group", "aria-label": "verdicts" },
    element("table", { class: "verdicts" }, element("caption", {}, "Does a stick-slip limit cycle exist?"), element("thead", {}, head), element("tbody", {}, ...rows)),
    element("p", { class: "hint" }, `Critical damping${machine ? "" : " c*"} = ${exact}. A margin is in ${margin} to the edge of presence.`));
}

// Derivatives of the critical damping; for a machine in per cent for one per cent of each quantity.
function sensitivity_table({ sensitivity, machine }) {
  const of_machine = machine?.sensitivities;
  if (!of_machine && sensitivity.reason) return [element("p", { class: "hint" }, `None: ${sensitivity.reason}.`)];
  const words = (name) => name.replaceAll("_", " ").replace("stribeck", "Stribeck");
  const rows = of_machine
    ? of_machine.map(({ quantity, critical_damping, critical_damping_error }) => [words(quantity), `${with_error(critical_damping, critical_damping_error)} %`])
    : Object.entries(sensitivity.derivatives).map(([name, { value, error }]) => [name, with_error(value, error)]);
  if (sensitivity.standard_error && !of_machine) rows.push(["standard error, by the data", short(sensitivity.standard_error.value)]);
  const head = of_machine ? "quantity 1 % larger" : "parameter";
  const heads = [head, of_machine ? "critical damping" : "derivative of c*"].map((text) => element("th", { scope: "col" }, text));
  const body = rows.map(([name, value]) => element("tr", {}, element("th", { scope: "row" }, name), element("td", { class: "number" }, value)));
  return [element("table", { class: "sensitivities" }, element("thead", {}, element("tr", {}, ...heads)), element("tbody", {}, ...body))];
}

// Every line of the answer, as nested lists.
function numbers(value) {
  const list = element("dl", { class: "numbers" });
  const parts = [list];
  for (const [key, entry] of Object.entries(value)) {
    const name = key.replaceAll("_", " ");
    if (entry !== null && typeof entry === "object") {
      const inner = Object.keys(entry).length ? numbers(entry) : ["none"];
      parts.push(element("details", {}, element("summary", {}, name), ...inner));
    } else list.append(element("dt", {}, name), element("dd", {}, entry === null ? "–" : String(entry)));
  }
  return parts;
}
