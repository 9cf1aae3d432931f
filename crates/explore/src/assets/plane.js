// The plane: its picture in steps from coarse to fine, the curves over it, and its mouse, touch and
// keyboard input.

import { short } from "./elements.js";
import { Glance } from "./glance.js";
import { legend } from "./legend.js";
import { draw, rectangle } from "./overlay.js";
import { paint } from "./paint.js";
import { Scale } from "./scale.js";
import { picture as ask, post } from "./program.js";
import { is_damping, label, plane, size } from "./state.js";

// Rows of pictures while something is dragged, and time limit of one such picture in seconds.
const QUICK = [12, 16, 24, 32, 48, 64, 96, 128, 192, 256];
const FRAME = 0.03;
// Time for a band of a finer picture, time below which no coarser one comes first, and time limit for all
// bands of a picture, in seconds. `MOST_CELLS` below bounds its cells.
const BAND = 4;
const SOON = 0.3;
const LONGEST = 900;
// Time limit of the program for an answer, in seconds.
const LATE = 20;
const MOST_CELLS = 1_500_000;
// Pixels within which a pointer grasps the pin, and movement in pixels beyond which a click is a drag.
const GRASP = 15;
const STILL = 4;

// A picture resampled to more cells, each with the value of the nearest old cell.
function enlarged(picture, width, height) {
  const cells = new picture.cells.constructor(width * height);
  for (let j = 0; j < height; j += 1) {
    const row = Math.floor(((j + 0.5) * picture.height) / height) * picture.width;
    for (let i = 0; i < width; i += 1) cells[j * width + i] = picture.cells[row + Math.floor(((i + 0.5) * picture.width) / width)];
  }
  return { ...picture, width, height, cells };
}

export class Plane {
  // `app` holds the state and receives changes: app.change("view" | "point" | "rest").
  constructor(app, catalogue) {
    const find = (id) => document.getElementById(id);
    Object.assign(this, { app, catalogue, stage: find("stage"), canvas: find("cells"), overlay: find("overlay") });
    Object.assign(this, { busy: find("busy"), legendBox: find("legend") });
    Object.assign(this, { picture: null, curves: [], curvesOf: "", changes: 0, running: null, hurry: false, cost: new Map(), pointers: new Map(), glance: new Glance(this) });
    addEventListener("resize", () => (this.legendBox.style.minHeight = ""));
    new ResizeObserver(() => this.resize()).observe(this.stage);
    this.listen();
  }

  get state() {
    return this.app.state;
  }

  get scales() {
    return { x: new Scale(this.state.x), y: new Scale(this.state.y) };
  }

  // Everything that determines the picture, except the ends of its axes.
  key() {
    const { law, motion, x, y, show, at, axes, units } = this.state;
    const held = axes.filter(({ name }) => name !== x.axis && name !== y.axis).map(({ name }) => [name, at[name]]);
    return JSON.stringify([law, motion, units, x.axis, x.log, y.axis, y.log, show, held]);
  }

  resize() {
    if (!this.state) return;
    this.rect = rectangle(this.stage);
    const { x, y, w, h } = this.rect;
    const ratio = devicePixelRatio;
    Object.assign(this.canvas.style, { left: `${x}px`, top: `${y}px`, width: `${w}px`, height: `${h}px` });
    const [width, height] = [Math.round(w * ratio), Math.round(h * ratio)];
    if (this.canvas.width !== width || this.canvas.height !== height) Object.assign(this.canvas, { width, height });
    this.update(false);
  }

  // Shows the state: at once from the last picture, then in finer ones. While something is dragged (`hurry`),
  // pictures have few cells and come many times a second.
  update(hurry) {
    if (!this.rect) return this.resize();
    this.changes += 1;
    this.hurry = hurry;
    delete this.canvas.dataset.settled;
    if (this.curvesOf !== this.key()) this.curves = [];
    this.show();
    // A quick picture in progress is followed by a new one; a slow one is superseded.
    if (!this.running?.quick) this.refine();
  }

  show() {
    const { picture, canvas } = this;
    const { x, y } = this.state;
    if (picture && picture.x.axis === x.axis && picture.y.axis === y.axis && picture.x.log === x.log && picture.y.log === y.log) {
      const [across, up] = [new Scale(picture.x), new Scale(picture.y)];
      paint(canvas, picture, this.catalogue, [across.unit(x.from), across.unit(x.to), up.unit(y.from), up.unit(y.to)]);
      canvas.dataset.cells = `${picture.width}x${picture.height}`;
      legend(this.legendBox, picture, this.curves, this.catalogue);
    }
    canvas.classList.toggle("of-other-inputs", picture !== null && picture.key !== this.key());
    const words = (side) => label(this.state, this.state[side].axis).words;
    this.overlay.setAttribute("aria-label", `Plane of ${words("x")} across and ${words("y")} up`);
    draw(this.overlay, this.rect, this.scales, this.state, this.state.curves ? this.curves : []);
  }

  // Cells across and up of a picture with this many rows.
  cells(rows) {
    return [Math.max(2, Math.round((rows * this.rect.w) / this.rect.h)), rows];
  }

  is_damping(side) {
    return is_damping(this.state[side].axis);
  }

  // Relative cost of a picture: a column of all dampings costs little more than one of its cells.
  work([width, height]) {
    return this.is_damping("x") ? height : this.is_damping("y") ? width : width * height;
  }

  // Seconds that a picture with this many rows will take; unknown before the first of its kind.
  seconds(rows) {
    return this.work(this.cells(rows)) * (this.cost.get(this.kind()) ?? Infinity);
  }

  // Pictures that cost about the same for each cell.
  kind() {
    const { law, motion, x, y, show } = this.state;
    return [law.name, law.phi, motion, x.axis, y.axis, show].join(" ");
  }

  // Rows of the finest picture.
  full() {
    let rows = Math.min(this.canvas.height, 4096);
    while (this.cells(rows)[0] * rows > MOST_CELLS || this.cells(rows)[0] > 4096) rows = Math.floor(0.9 * rows);
    return rows;
  }

  // Rows of the picture after one with `rows` rows.
  finer(rows) {
    const full = this.full();
    if (this.seconds(full) < SOON) return full;
    return Math.min(this.seconds(4 * rows) < BAND ? 4 * rows : 2 * rows, full);
  }

  async refine() {
    const turn = this.changes;
    const rows = QUICK.findLast((rows) => this.seconds(rows) <= FRAME) ?? QUICK[0];
    const picture = await this.fetch(this.cells(rows), true, turn);
    if (!picture) return;
    this.picture = picture;
    this.show();
    if (turn !== this.changes) {
      this.refine();
      return;
    }
    if (this.hurry) return;
    this.follow_curves(turn);
    while (this.picture.height < this.full()) {
      const finer = this.finer(this.picture.height);
      const seconds = this.seconds(finer);
      // What follows comes in several bands.
      if (seconds >= BAND) this.canvas.dataset.settled = turn;
      if (seconds > LONGEST) {
        const text = `coarse: finer would take ${Math.round(seconds / 60)} min`;
        Object.assign(this.busy, { hidden: false, textContent: text });
        return;
      }
      if (!(await this.in_bands(this.cells(finer), turn))) return;
    }
    this.canvas.dataset.settled = turn;
  }

  // Computes a picture in one band, or in several of some seconds each, and shows each at once; `false` where
  // it was superseded or refused.
  async in_bands([width, height], turn) {
    // All dampings of a column are one piece of work.
    const [side, all] = this.is_damping("y") ? ["x", width] : ["y", height];
    const whole = enlarged(this.picture, width, height);
    for (let done = 0; done < all; ) {
      // A page in the background computes nothing.
      if (document.hidden) await new Promise((resolve) => document.addEventListener("visibilitychange", resolve, { once: true }));
      const left = this.seconds(height) * (1 - done / all);
      let count = Math.max(2, Math.min(all - done, Math.floor(((all - done) * BAND) / left)));
      // One line alone is no plane.
      if (all - done - count === 1) count += 1;
      const text = count === all ? undefined : `refining: ${Math.round((100 * done) / all)} %, ${Math.ceil(left)} s left`;
      const band = await this.fetch([width, height], false, turn, { side, part: [done, done + count], text });
      if (!band || turn !== this.changes || (band.late && count === 2)) return false;
      // The machine is busy; the next band is smaller.
      if (band.late) continue;
      const [column, row] = side === "x" ? [done, 0] : [0, done];
      for (let j = 0; j < band.height; j += 1) whole.cells.set(band.cells.subarray(j * band.width, (j + 1) * band.width), (row + j) * width + column);
      this.picture = whole;
      this.show();
      done += count;
    }
    return true;
  }

  // A picture of the present state with `width` by `height` cells, or a band of it: those of `part` along one side. Null
  // where it was superseded or refused; `late` where it took too long.
  async fetch([width, height], quick, turn, { side, part, text = "computing" } = {}) {
    const { x, y, show } = this.state;
    const count = part ? part[1] - part[0] : 0;
    const cells = side === "x" ? [count, height] : side === "y" ? [width, count] : [width, height];
    const [key, kind, work] = [this.key(), this.kind(), this.work(cells)];
    const running = { quick };
    this.running = running;
    // Between two bands the message stays.
    const late = setTimeout(() => Object.assign(this.busy, { hidden: false, textContent: text }), part?.[0] > 0 ? 0 : 300);
    try {
      const body = { ...plane(this.state, width, height), show };
      if (side) body[side].part = part;
      const picture = await ask(body, "plane", this.is_damping("y") ? "x" : "y");
      this.app.complain(null);
      this.cost.set(kind, picture.seconds / work);
      return Object.assign(picture, { x: { ...x }, y: { ...y }, show, key });
    } catch (problem) {
      if (problem.late && !quick) {
        this.cost.set(kind, LATE / work);
        return { late: true };
      }
      if (!problem.overtaken) this.app.complain(problem);
      // The state may have become legal in the meantime.
      if (quick && turn !== this.changes) setTimeout(() => this.refine());
      return null;
    } finally {
      clearTimeout(late);
      if (this.running === running) {
        this.running = null;
        this.busy.hidden = true;
      }
    }
  }

  async follow_curves(turn) {
    const { x, y, curves } = this.state;
    if (!curves) return;
    const key = this.key();
    const body = plane(this.state, 2, 2);
    const sizes = [x, y].map(({ axis }) => size(this.state, axis));
    let all = [];
    // Folds take longer, and come last.
    for (const folds of [false, true]) {
      try {
        const found = await post("curves", { ...body, folds }, "curves");
        if (turn !== this.changes) return;
        all = [...all, ...found.curves.map((curve) => ({ ...curve, points: curve.points.map((point) => point.map((value, i) => value / sizes[i])) }))];
      } catch (problem) {
        // The picture is shown without curves.
        if (problem.overtaken || turn !== this.changes) return;
      }
      this.curves = all;
      this.curvesOf = key;
      this.show();
    }
  }

  // Where in the plane an event is, in the unit square.
  unit(event) {
    const box = this.stage.getBoundingClientRect();
    const { x, y, w, h } = this.rect;
    return [(event.clientX - box.left - this.stage.clientLeft - x) / w, 1 - (event.clientY - box.top - this.stage.clientTop - y) / h];
  }

  pin(u, v) {
    const { scales, state } = this;
    const clamp = (share) => Math.max(0, Math.min(1, share));
    this.app.move({ [state.x.axis]: scales.x.rounded(clamp(u)), [state.y.axis]: scales.y.rounded(clamp(v)) });
  }

  near_pin(event) {
    const { state, scales } = this;
    if (!state.pinned) return false;
    const [u, v] = this.unit(event);
    const across = (u - scales.x.unit(state.at[state.x.axis])) * this.rect.w;
    const up = (v - scales.y.unit(state.at[state.y.axis])) * this.rect.h;
    return Math.hypot(across, up) < GRASP;
  }

  // Shows other ends of both axes, [left, right] and [low, high] in units of the present axes, kept legal.
  window([left, right], [low, high]) {
    const side = (name, [a, b]) => {
      const { axis } = this.state[name];
      const { least, most } = this.state.axes.find(({ name }) => name === axis);
      const scale = this.scales[name];
      let [from, to] = [scale.value(a), scale.value(b)];
      const span = to - from;
      if (least !== null && from < least) [from, to] = [least, scale.log ? to : least + span];
      if (most !== null && to > most) [from, to] = [scale.log ? from : Math.max(most - span, least ?? -Infinity), most];
      if (!(to - from > 1e-9 * Math.max(Math.abs(from), Math.abs(to)))) return this.state[name];
      const digits = (value) => Number(value.toPrecision(9));
      return { ...this.state[name], from: digits(from), to: digits(to) };
    };
    const [x, y] = [side("x", [left, right]), side("y", [low, high])];
    Object.assign(this.state, { x, y });
    this.app.change("view");
  }

  zoom(factor, [u, v] = [0.5, 0.5]) {
    const ends = (centre) => [centre - centre * factor, centre + (1 - centre) * factor];
    this.window(ends(u), ends(v));
  }

  pan(across, up) {
    this.window([-across, 1 - across], [-up, 1 - up]);
  }

  home() {
    for (const name of ["x", "y"]) {
      const axis = this.state.axes.find((axis) => axis.name === this.state[name].axis);
      // The only range of a machine's quantity is that of its slider.
      const [least, to] = axis.unit === undefined ? [axis.from, axis.to] : this.state.ranges[axis.name];
      const from = this.state[name].log ? Math.max(least, to / 1000) : least;
      this.state[name] = { ...this.state[name], from, to };
    }
    this.app.change("view");
  }

  listen() {
    const { overlay, pointers } = this;
    const on = (name, listener, options) => overlay.addEventListener(name, listener, options);
    on("pointerdown", (event) => {
      if (event.button !== 0) return;
      overlay.setPointerCapture(event.pointerId);
      const start = this.unit(event);
      pointers.set(event.pointerId, { start, last: start, moved: 0, pin: pointers.size === 0 && this.near_pin(event) });
      this.glance.hide();
    });
    on("pointermove", (event) => {
      const pointer = pointers.get(event.pointerId);
      if (!pointer) {
        if (event.pointerType !== "touch") this.glance.show(event);
        return;
      }
      const [u, v] = this.unit(event);
      const [across, up] = [u - pointer.last[0], v - pointer.last[1]];
      pointer.moved += Math.hypot(across * this.rect.w, up * this.rect.h);
      if (pointers.size === 2) this.pinch(pointer, [u, v]);
      else if (pointer.pin) this.pin(u, v);
      else if (pointer.moved > STILL) this.pan(across, up);
      // The plane has moved with the pointer.
      pointer.last = pointer.pin || pointers.size === 2 || pointer.moved > STILL ? this.unit(event) : pointer.last;
    });
    const end = (event) => {
      const pointer = pointers.get(event.pointerId);
      pointers.delete(event.pointerId);
      if (!pointer) return;
      const [u, v] = this.unit(event);
      const inside = u >= 0 && u <= 1 && v >= 0 && v <= 1;
      if (event.type === "pointerup" && pointer.moved <= STILL && inside && pointers.size === 0) this.pin(u, v);
      this.app.change("rest");
    };
    on("pointerup", end);
    on("pointercancel", end);
    on("pointerleave", () => this.glance.hide());
    on("wheel", (event) => {
      event.preventDefault();
      this.glance.hide();
      this.zoom(Math.exp(Math.max(-0.5, Math.min(0.5, event.deltaY / 400))), this.unit(event));
    }, { passive: false });
    on("keydown", (event) => this.press(event));
  }

  pinch(pointer, [u, v]) {
    const other = [...this.pointers.values()].find((it) => it !== pointer);
    const size = (a, b) => Math.max(20, Math.hypot((a[0] - b[0]) * this.rect.w, (a[1] - b[1]) * this.rect.h));
    const before = size(pointer.last, other.last);
    const centre = [(u + other.last[0]) / 2, (v + other.last[1]) / 2];
    this.zoom(before / size([u, v], other.last), centre);
  }

  press(event) {
    const arrows = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowDown: [0, -1], ArrowUp: [0, 1] };
    const arrow = arrows[event.key];
    const { state, scales } = this;
    const here = state.pinned ? [scales.x.unit(state.at[state.x.axis]), scales.y.unit(state.at[state.y.axis])] : [0.5, 0.5];
    if (arrow && event.altKey) this.pan(-0.1 * arrow[0], -0.1 * arrow[1]);
    else if (arrow) {
      const step = event.shiftKey ? 0.1 : 0.01;
      this.pin(here[0] + step * arrow[0], here[1] + step * arrow[1]);
    } else if (event.key === "+" || event.key === "=") this.zoom(0.8, here);
    else if (event.key === "-") this.zoom(1.25, here);
    else if (event.key === "Home" || event.key === "0") this.home();
    else if (event.key === "Enter" || event.key === " ") this.pin(...here);
    else if (event.key === "Escape" && state.pinned) this.app.unpin();
    else return;
    event.preventDefault();
  }

  // The value of the picture at a place.
  cell(u, v) {
    const { picture } = this;
    if (!picture || picture.key !== this.key()) return "";
    const { x, y } = this.scales;
    const column = Math.floor(new Scale(picture.x).unit(x.value(u)) * picture.width);
    const row = Math.floor(new Scale(picture.y).unit(y.value(v)) * picture.height);
    if (column < 0 || row < 0 || column >= picture.width || row >= picture.height) return "";
    const value = picture.cells[row * picture.width + column];
    if (!picture.kinds) return `${picture.label}: ${short(value)}`;
    return picture.kinds.find(({ code }) => code === value)?.words ?? "";
  }
}
