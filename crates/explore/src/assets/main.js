// The page: one state, shown by the plane, the controls and the point, and written into the link.

import { Controls } from "./controls.js";
import { element } from "./elements.js";
import { CASES } from "./gallery.js";
import { Leave } from "./leave.js";
import { paint } from "./paint.js";
import { Plane } from "./plane.js";
import { Point } from "./point.js";
import { Gone, begin, picture, post } from "./program.js";
import { complete, is_damping, label, plane, read, write } from "./state.js";

// Milliseconds without movement after which a change counts as finished.
const REST = 160;

class App {
  constructor(catalogue) {
    Object.assign(this, { catalogue, state: null, timer: 0, lasting: null, notice: document.getElementById("notice") });
    this.plane = new Plane(this, catalogue);
    this.controls = new Controls(this, catalogue);
    this.point = new Point(this);
    this.leave = new Leave(this);
  }

  // Shows another state of a law with these axes.
  open(wanted, axes) {
    this.controls.refuse(null);
    this.state = complete(wanted, axes);
    this.change("rest");
  }

  // Shows a law or a machine, whose axes are requested from the program.
  async take(wanted) {
    const { axes } = await post("law", { ...wanted.law, motion: wanted.motion });
    this.open(wanted, axes);
  }

  // Opens a link; without one, or where it is refused, `false`.
  async open_link(fragment) {
    this.lasting = null;
    if (fragment.length < 2) return false;
    const wanted = read(fragment);
    const why = wanted ? await this.try_to_take(wanted) : new Error("the link names no law: it is not one of this page");
    this.lasting = why;
    this.complain(null);
    return !why;
  }

  // Shows a law or a machine; returns the refusal.
  async try_to_take(wanted) {
    try {
      await this.take(wanted);
    } catch (problem) {
      return problem;
    }
    return null;
  }

  // Reports a change: "slider", "view" or "point" while it moves, "rest" when it has come to rest.
  change(what) {
    clearTimeout(this.timer);
    if (what !== "rest") this.timer = setTimeout(() => this.change("rest"), REST);
    this.controls.sync();
    if (what === "point") this.plane.show();
    else this.plane.update(what !== "rest");
    if (what !== "view") this.point.update(what !== "rest");
    if (what === "rest") {
      const link = write(this.state);
      if (link !== location.hash) history.replaceState(null, "", link);
      const words = (side) => label(this.state, this.state[side].axis).words;
      document.title = `${words("x")}, ${words("y")} – slipmap explore`;
    }
  }

  // Pins the point with these values.
  move(values) {
    Object.assign(this.state.at, values);
    this.state.pinned = true;
    this.change("point");
  }

  unpin() {
    this.state.pinned = false;
    this.change("rest");
  }

  // Shows a problem; without one, that of the link or the file that was opened.
  complain(problem) {
    if (problem instanceof Gone) return;
    const told = problem ?? this.lasting;
    this.notice.hidden = !told;
    this.notice.textContent = told ? told.message : "";
  }
}

function listen_for_the_program(app) {
  addEventListener("program-gone", () => {
    app.lasting = new Error("The program behind this page has ended. Start `slipmap explore` again, and open the address that it prints, with all of this one from its # on.");
    app.complain(null);
  });
}

// A small picture of an example.
async function thumbnail(app, canvas, wanted) {
  const { axes } = await post("law", { ...wanted.law, motion: wanted.motion });
  const state = complete(wanted, axes);
  // Formulas take longer.
  const fine = wanted.law.name === "expression" || state.show.includes("stick_band") ? 1 : 2;
  const found = await picture({ ...plane(state, 36 * fine, 22 * fine), show: state.show }, "thumbnail");
  Object.assign(canvas, { width: 288, height: 180 });
  paint(canvas, { ...found, show: state.show }, app.catalogue);
}

async function build_gallery(app) {
  const dialog = document.getElementById("gallery");
  const cards = document.getElementById("cards");
  const pictures = [];
  for (const { title, words, link } of CASES) {
    const canvas = element("canvas", { "aria-hidden": "true" });
    const open = () => {
      dialog.close();
      app.open_link(link);
    };
    cards.append(element("button", { type: "button", class: "card", onclick: open }, canvas, element("b", {}, title), element("span", {}, words)));
    pictures.push({ canvas, wanted: read(link) });
  }
  let drawn = false;
  const show = async () => {
    dialog.showModal();
    if (drawn) return;
    drawn = true;
    for (const { canvas, wanted } of pictures) {
      try {
        await thumbnail(app, canvas, wanted);
      } catch {
        // A card without a picture still opens its example.
      }
    }
  };
  document.getElementById("open-gallery").addEventListener("click", show);
  return show;
}

function choose_theme() {
  const root = document.documentElement;
  const dark = matchMedia("(prefers-color-scheme: dark)");
  const follow = () => (root.dataset.theme = dark.matches ? "dark" : "light");
  follow();
  dark.addEventListener("change", follow);
  document.getElementById("theme").addEventListener("click", () => {
    root.dataset.theme = root.dataset.theme === "dark" ? "light" : "dark";
  });
}

// The state for the file that was given to the command.
function state_of(start) {
  // The two axes with most nodes; among equal numbers in the order of `usual`. The damping is vertical.
  const usual = ["c", "damping", "damping_ratio", "V", "belt_speed", "gamma"];
  const rank = ({ name }) => (usual.includes(name) ? usual.indexOf(name) : usual.length);
  const several = start.axes.filter(({ nodes }) => nodes > 1).sort((a, b) => b.nodes - a.nodes || rank(a) - rank(b));
  const shown = several.slice(0, 2).map(({ name }) => name);
  const side = (name) => {
    const axis = start.axes.find((it) => it.name === name);
    return axis ? { axis: name, from: axis.from, to: axis.to, log: axis.log } : null;
  };
  const y = shown.find(is_damping) ?? shown.at(-1);
  const x = shown.find((name) => name !== y);
  const at = { ...start.at, ...Object.fromEntries(start.axes.map(({ name, value }) => [name, value])) };
  const ranges = Object.fromEntries(start.axes.filter(({ nodes }) => nodes > 1).map(({ name, from, to }) => [name, [from, to]]));
  // The critical damping must be seen, too.
  const damping = start.axes.find(({ name }) => is_damping(name)).name;
  if (start.most_damping) ranges[damping] ??= [0, start.most_damping];
  return { law: start.law, x: side(x), y: side(y), at, ranges, units: start.units, spread: start.spread, title: start.title, motion: start.motion, pinned: start.pinned };
}

async function main() {
  choose_theme();
  document.getElementById("icon").src = document.querySelector("link[rel=icon]").href;
  const { catalogue, start } = begin;
  const app = new App(catalogue);
  listen_for_the_program(app);
  const show_gallery = await build_gallery(app);
  addEventListener("hashchange", () => {
    document.getElementById("gallery").close();
    app.open_link(location.hash);
  });
  if (await app.open_link(location.hash)) return;
  const of_link = app.lasting;
  const of_start = start ? await app.try_to_take(state_of(start)) : null;
  const is_shown = start && !of_start;
  if (!is_shown) await app.open_link(CASES[2].link.replace("&pin=1", ""));
  app.lasting = of_link ?? of_start;
  app.complain(null);
  if (!is_shown && !app.lasting) show_gallery();
}

// For the console, and for tests.
globalThis.slipmap = { begin, paint, picture, post };
main();
