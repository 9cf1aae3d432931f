// Everything that changes the state but the plane itself: law, what is shown, axes, sliders.

import { element, mark, refusals, short, why_refused } from "./elements.js";
import { post } from "./program.js";
import { label, place, size } from "./state.js";

const EXAMPLE = "mu + (1 - mu)*exp(-u/vs)";
const EXAMPLE_OF_MACHINE = "muk + (mus - muk)*exp(-u/vs)";
// Values for the names of that example.
const COEFFICIENTS = { muk: 0.25, mus: 0.4, vs: 0.05 };
const OWN = [["expression", "your formula"], ["table", "your measurement"]];

// The text of a file: in UTF-16 that says so, in UTF-8, or in the encoding of old spreadsheets.
function text_of(bytes) {
  const mark = new Uint8Array(bytes.slice(0, 2)).join();
  try {
    return new TextDecoder({ "255,254": "utf-16le", "254,255": "utf-16be" }[mark] ?? "utf-8", { fatal: true }).decode(bytes);
  } catch {
    return new TextDecoder("windows-1252").decode(bytes);
  }
}

export class Controls {
  constructor(app, catalogue) {
    const find = (id) => document.getElementById(id);
    Object.assign(this, { app, catalogue, law: find("law"), show: find("show"), editor: find("law-editor") });
    Object.assign(this, { axesBox: find("axes"), sliderBox: find("parameters"), built: "", inputs: new Map(), refused: null, refused_inputs: new Set() });
    const option = ([value, words]) => element("option", { value }, words);
    this.law.append(...catalogue.laws.map(({ name }) => option([name, name])), ...OWN.map(option));
    this.law.addEventListener("change", () => this.choose_law(this.law.value));
    const words = (name) => name.replaceAll("_", " ");
    const group = (label, options) => element("optgroup", { label }, ...options.map(option));
    this.show.append(
      group("Behaviour", [["regime", "what the mass does"], ["decider", "which method decides"]]),
      group("Verdict of", catalogue.methods.map((name) => [`verdict_${name}`, words(name)])),
      group("Where it is wrong", catalogue.methods.filter((name) => name !== "simulation").map((name) => [`difference:${name}:simulation`, `${words(name)} against simulation`])),
      group("Two tests compared", [["difference:perturbation:bendixson", "perturbation, bendixson"], ["difference:bendixson:symmetric", "bendixson, symmetric"], ["difference:harmonic_balance:perturbation", "harmonic balance, perturbation"]]),
      group("Numbers", [["critical_c_simulation", "critical damping"], ["margin_simulation", "margin"], ...catalogue.quantities.map(({ name, words }) => [name, words])]),
    );
    this.show.addEventListener("change", () => {
      this.app.state.show = this.show.value;
      this.app.change("rest");
    });
    this.listen_for_files();
  }

  get state() {
    return this.app.state;
  }

  // Shows the state in all inputs; for another law or other axes the inputs are rebuilt.
  sync() {
    const { state } = this;
    const key = JSON.stringify([state.law.name, state.axes.map(({ name }) => name), state.x.axis, state.y.axis, state.motion, state.units]);
    if (this.built !== key) {
      this.built = key;
      this.inputs.clear();
      this.refused_inputs.clear();
      this.grey();
      this.build_editor();
      this.build_axes();
      this.build_sliders();
    }
    this.law.value = state.law.name;
    if (this.show.value !== state.show) {
      this.show.value = state.show;
      if (this.show.selectedIndex < 0) {
        // A link may show what the list does not offer.
        this.show.append(element("option", { value: state.show }, state.show));
        this.show.value = state.show;
      }
    }
    for (const [input, value] of this.inputs) {
      const wanted = value();
      if (input.type === "checkbox") input.checked = wanted;
      else if (document.activeElement !== input || input.type === "range") {
        const text = typeof wanted === "number" ? short(wanted) : wanted;
        if (input.type === "range") {
          input.value = wanted;
          input.setAttribute("aria-valuetext", short(wanted));
        } else if (input.value !== text) input.value = text;
      }
    }
  }

  // An input for a number: `read` returns it, `set` takes a new one or returns the refusal, shown in `place`.
  number(label, read, set, place, bounds = () => ({})) {
    const input = element("input", { class: "number", inputmode: "decimal", "aria-label": label, autocomplete: "off" });
    const tell = (why) => {
      mark(input, place, label, why);
      this.refused_inputs[why ? "add" : "delete"](input);
      this.grey();
    };
    input.addEventListener("input", () => tell(why_refused(input.value, bounds()) || set(Number(input.value)) || ""));
    input.addEventListener("blur", () => {
      tell("");
      this.sync();
    });
    this.inputs.set(input, read);
    return input;
  }

  // The picture is grey while it does not match the inputs, because a law or a number was refused.
  grey() {
    document.body.classList.toggle("of-other-inputs", this.refused !== null || this.refused_inputs.size > 0);
  }

  build_axes() {
    const { state, app } = this;
    const row = (side, words) => {
      const other = side === "x" ? "y" : "x";
      const choices = state.axes.map(({ name }) => name);
      const choice = element("select", { "aria-label": `Axis ${words}` }, ...choices.map((name) => element("option", { value: name }, label(state, name).words)));
      choice.addEventListener("change", () => {
        if (choice.value === state[other].axis) [state.x, state.y] = [state.y, state.x];
        else {
          const [from, to] = state.ranges[choice.value];
          state[side] = { axis: choice.value, from, to, log: false };
        }
        app.change("rest");
      });
      this.inputs.set(choice, () => this.state[side].axis);
      const bounds = () => ({ ...this.state.axes.find(({ name }) => name === this.state[side].axis), open: false });
      const problem = refusals();
      const end = (key, words, why) =>
        this.number(words, () => this.state[side][key], (value) => {
          const refused = why(value);
          if (refused) return refused;
          this.state[side] = { ...this.state[side], [key]: value };
          app.change("rest");
        }, problem, bounds);
      const from = end("from", `${words}: from`, (value) => {
        const { to, log } = this.state[side];
        if (log && value <= 0) return "must be greater than 0 on a logarithmic axis";
        return value < to ? "" : `must be less than the other end, ${short(to)}`;
      });
      const to = end("to", `${words}: to`, (value) => {
        const { from } = this.state[side];
        return value > from ? "" : `must be greater than the other end, ${short(from)}`;
      });
      const log = element("input", { type: "checkbox" });
      log.addEventListener("change", () => {
        const old = this.state[side];
        this.state[side] = { ...old, log: log.checked, from: log.checked && old.from <= 0 ? old.to / 100 : old.from };
        app.change("rest");
      });
      this.inputs.set(log, () => Boolean(this.state[side].log));
      return element("div", { class: "axis-row" }, element("span", {}, words), choice, from, to, element("label", { class: "log" }, log, "log"), problem);
    };
    const curves = element("input", { type: "checkbox" });
    curves.addEventListener("change", () => {
      this.state.curves = curves.checked;
      app.change("rest");
    });
    this.inputs.set(curves, () => this.state.curves);
    const swap = element("button", { type: "button", onclick: () => {
      [this.state.x, this.state.y] = [this.state.y, this.state.x];
      app.change("rest");
    } }, "Swap");
    const home = element("button", { type: "button", onclick: () => app.plane.home() }, "Show all");
    this.axesBox.replaceChildren(
      element("div", { class: "title" }, element("h2", {}, "Axes"), element("span", {}, swap, " ", home)),
      row("x", "across"), row("y", "up"),
      element("div", {}, element("label", { class: "field" }, curves, "exact boundary curves")),
    );
  }

  build_sliders() {
    const { state } = this;
    const held = state.axes.filter(({ name }) => name !== state.x.axis && name !== state.y.axis);
    const rows = held.map((axis) => this.slider(axis));
    this.sliderBox.replaceChildren(...(rows.length ? [element("h2", {}, "Held"), ...rows] : []));
  }

  // A slider of a parameter of the law, or of a quantity of a machine with its unit; value and ends can
  // be typed.
  slider({ name, symbol, words, unit, least, most, open }) {
    const rest = () => (this.state.at.static_friction * size(this.state, "static_friction")) / size(this.state, name);
    const bounds = () => ({ least, most: name === "kinetic_friction" ? rest() : most, open });
    const read = () => this.state.at[name];
    const set = (value, what) => {
      this.state.at[name] = value;
      this.app.change(what);
    };
    const range_of = () => this.state.ranges[name];
    const [left, below, label] = unit === undefined ? [symbol, words, `${words || symbol} (${symbol})`] : [words, unit, words];
    const range = element("input", { type: "range", "aria-label": label });
    // The position is a share of the range, so that every range has fine steps.
    Object.assign(range, { min: 0, max: 1, step: "any" });
    const ends = () => {
      const [from, to] = range_of();
      return [open && from === least ? from + (to - from) / 1000 : from, to];
    };
    range.addEventListener("input", () => {
      const [from, to] = ends();
      const digits = Math.min(15, Math.max(0, 3 - Math.floor(Math.log10(to - from))));
      set(Math.min(to, Math.max(from, Number((from + range.value * (to - from)).toFixed(digits)))), "slider");
    });
    range.addEventListener("change", () => this.app.change("rest"));
    range.addEventListener("keydown", (event) => {
      const step = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1, PageUp: 10, PageDown: -10 }[event.key];
      if (!step) return;
      event.preventDefault();
      const [from, to] = ends();
      set(Number(Math.min(to, Math.max(from, read() + (step * (to - from)) / 100)).toPrecision(6)), "slider");
    });
    this.inputs.set(range, () => {
      const [from, to] = ends();
      return (read() - from) / (to - from);
    });
    const problem = refusals();
    const value = this.number(`${label}: value`, read, (value) => {
      const ends = range_of();
      [ends[0], ends[1]] = [Math.min(ends[0], value), Math.max(ends[1], value)];
      set(value, "rest");
    }, problem, bounds);
    const end = (i, which) =>
      this.number(`${label}: ${which} end of the slider`, () => range_of()[i], (value) => {
        const ends = range_of();
        if (i === 0 && value >= ends[1]) return `must be less than the other end, ${short(ends[1])}`;
        if (i === 1 && value <= ends[0]) return `must be greater than the other end, ${short(ends[0])}`;
        ends[i] = value;
        set(Math.min(ends[1], Math.max(ends[0], read())), "rest");
      }, problem, () => ({ ...bounds(), open: false }));
    return element("div", { class: "slider" },
      element("span", { class: "symbol" }, left), range, value,
      element("div", { class: "ends" }, end(0, "lower"), element("span", { class: "words" }, below), end(1, "upper")), problem);
  }

  build_editor() {
    const { state } = this;
    const known = this.catalogue.laws.find(({ name }) => name === state.law.name);
    const units = element("p", {}, state.motion ? "A machine. " : "Dimensionless. ",
      element("button", { type: "button", onclick: () => this.change_units() }, state.motion ? "Without units" : "As a machine in SI units"));
    if (known) {
      const formula = state.motion ? [] : [element("p", {}, known.formula)];
      this.editor.replaceChildren(element("h2", {}, "Friction law"), ...formula, units);
      return;
    }
    this.problem = element("div", { class: "problem", role: "alert" });
    const level = element("input", { class: "number", inputmode: "decimal", "aria-label": "friction at rest", placeholder: state.motion ? "" : 1, value: state.law.static ?? "" });
    const parts = [];
    let text;
    if (state.law.name === "expression") {
      text = element("textarea", { "aria-label": "Friction over slip speed u, as a formula", spellcheck: "false" });
      text.value = (this.refused ?? state.law).phi;
      const words = state.motion
        ? "The coefficient of friction; u is the slip speed in SI units, every other name becomes a slider."
        : "φ(u) in units of the static friction; u is the slip speed, eps the small parameter, every other name becomes a slider.";
      parts.push(element("p", { class: "hint" }, words), text);
    } else {
      const file = element("input", { type: "file", accept: ".csv,.txt,text/csv", "aria-label": "Table of slip speed and friction" });
      file.addEventListener("change", () => file.files[0] && this.drop(file.files[0]));
      text = element("textarea", { "aria-label": "Slip speed and friction, row by row", spellcheck: "false", rows: 6 });
      const { table, rows } = this.refused ?? state.law;
      text.value = table ?? rows.map((row) => `${row.join(",")}\n`).join("");
      const words = state.motion ? "Slip speed in SI units, coefficient of friction" : "Slip speed, friction";
      parts.push(element("p", { class: "hint" }, `${words}, and perhaps its standard error, row by row; drop a CSV file anywhere on the page.`), file, text);
    }
    const written = text.value;
    let timer;
    const changed = () => {
      clearTimeout(timer);
      timer = setTimeout(() => {
        const law = { ...this.state.law, static: level.value.trim() === "" ? undefined : Number(level.value) };
        // Rows are taken as they are, and what was typed is read.
        const own = text.value === written ? {} : { table: text.value, file: law.file ?? law.source?.file, rows: undefined, source: undefined };
        this.try_law(law.name === "expression" ? { ...law, phi: text.value } : { ...law, ...own });
      }, 250);
    };
    text.addEventListener("input", changed);
    level.addEventListener("input", changed);
    parts.push(element("label", { class: "field" }, "static friction", level));
    parts.push(this.problem, units);
    this.editor.replaceChildren(element("h2", {}, "Friction law"), ...parts);
  }

  choose_law(name) {
    const law = { name };
    const { motion } = this.state;
    if (name === "expression") law.phi = motion ? EXAMPLE_OF_MACHINE : EXAMPLE;
    const table = motion ? "0,0.4\n0.02,0.35\n0.05,0.31\n0.1,0.27\n0.2,0.25\n1,0.25\n" : "0,1\n0.25,0.8\n0.5,0.68\n1,0.56\n2,0.5\n4,0.5\n";
    if (name === "table") Object.assign(law, { table, file: "friction.csv" });
    this.try_law(law, true);
  }

  // Changes units under the same law: from a machine to dimensionless numbers, or to a default machine.
  async change_units() {
    const { state, app } = this;
    const { show, curves, pinned } = state;
    const { refused } = this;
    try {
      if (!state.motion) {
        const law = { ...state.law, rest: undefined, small: undefined };
        await app.take({ law, motion: "translation", show, curves, pinned, at: COEFFICIENTS });
      } else {
        const { law, at } = await post("dimensionless", place(state));
        const { axes } = await post("law", law);
        app.open({ law, at, show, curves, pinned }, axes);
      }
      // A law that was refused in the old units may be legal in the new ones.
      if (refused?.name === this.state.law.name) {
        this.refuse(refused);
        this.build_editor();
        await this.try_law(refused);
      }
    } catch (problem) {
      app.complain(problem);
    }
  }

  // Keeps the text of a refused law; the picture of the law before it is grey until another law is accepted.
  refuse(law) {
    this.refused = law;
    this.grey();
  }

  // Takes a law that was chosen, typed or dropped, or shows why and where it is refused.
  async try_law(law, anew = false) {
    try {
      const { motion, show, curves, at, ranges, units, spread, title, x, y, pinned } = this.state;
      const { axes } = await post("law", { ...law, motion });
      this.problem?.replaceChildren();
      // A machine keeps its motion and its quantities under the new law.
      const kept = { law, motion, show, curves, at: { ...(motion ? COEFFICIENTS : {}), ...at }, ranges, units, spread, title, x, y, pinned };
      this.app.open(anew && !motion ? { law, show, curves } : kept, axes);
    } catch (problem) {
      if (!problem.problem) return;
      this.refuse(law);
      const marks = problem.place ? [element("pre", {}, `${law.phi}\n${" ".repeat(problem.place[0])}${"^".repeat(Math.max(1, problem.place[1] - problem.place[0]))}`)] : [];
      if (this.problem) this.problem.replaceChildren(problem.problem, ...marks, element("div", {}, problem.remedy ?? ""));
      else this.app.complain(problem);
    }
  }

  async drop(file) {
    if (file.size > 900_000) {
      this.app.complain(new Error(`${file.name} is longer than 900 kB, and no measured friction`));
      return;
    }
    const table = text_of(await file.arrayBuffer());
    // The editor has another text afterwards.
    this.built = "";
    // Rows at one slip speed are averaged when the table is read, but for two rows at rest: the larger one holds.
    const rows = table.split("\n").map((line) => line.split(",")).filter(([u]) => u?.trim() !== "" && Number.isFinite(Number(u)));
    const at_rest = rows.filter(([u]) => Number(u) === 0);
    const two = at_rest.length === 2 && new Set(rows.map(([u]) => Number(u))).size === rows.length - 1;
    const level = at_rest.reduce((sum, row) => sum + Number(row[1]), 0) / at_rest.length;
    await this.try_law({ name: "table", table, file: file.name, static: !this.state.motion && !two && Number.isFinite(level) && level > 0 ? level : undefined }, true);
  }

  listen_for_files() {
    addEventListener("dragover", (event) => event.preventDefault());
    addEventListener("drop", (event) => {
      event.preventDefault();
      if (event.dataTransfer.files[0]) this.drop(event.dataTransfer.files[0]);
    });
  }
}
