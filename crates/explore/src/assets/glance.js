// The answer at the pointer: at once from the picture, and, where the pointer rests, from every method.

import { element } from "./elements.js";
import { post } from "./program.js";
import { place, where } from "./state.js";

const REST = 120;

export class Glance {
  constructor(plane) {
    Object.assign(this, { plane, box: document.getElementById("glance"), turn: 0 });
  }

  hide() {
    this.turn += 1;
    this.box.hidden = true;
  }

  show(event) {
    const { plane } = this;
    const [u, v] = plane.unit(event);
    if (u < 0 || u > 1 || v < 0 || v > 1) {
      this.hide();
      return;
    }
    this.turn += 1;
    const turn = this.turn;
    plane.overlay.style.cursor = plane.near_pin(event) ? "grab" : "crosshair";
    const { state, scales } = plane;
    const at = { ...state.at, [state.x.axis]: scales.x.rounded(u), [state.y.axis]: scales.y.rounded(v) };
    const lines = [element("div", {}, where(state, at)), element("b", {}, plane.cell(u, v))];
    this.box.replaceChildren(...lines);
    this.box.hidden = false;
    this.move_to(event);
    setTimeout(async () => {
      if (turn !== this.turn) return;
      try {
        const found = await post("glance", place({ ...state, at }), "glance");
        if (turn !== this.turn) return;
        const rows = found.methods.map(([name, verdict]) =>
          element("tr", {}, element("td", {}, name.replaceAll("_", " ")), element("td", {}, element("span", { class: `say ${verdict}` }, verdict))));
        this.box.replaceChildren(lines[0], element("b", {}, found.words), element("table", {}, ...rows));
        this.move_to(event);
      } catch {
        // The next movement sends a new request.
      }
    }, REST);
  }

  move_to(event) {
    const stage = this.plane.stage.getBoundingClientRect();
    const [x, y] = [event.clientX - stage.left, event.clientY - stage.top];
    const { offsetWidth, offsetHeight } = this.box;
    const left = x + 18 + offsetWidth < stage.width ? x + 18 : Math.max(4, x - 18 - offsetWidth);
    const top = Math.max(4, Math.min(y + 14, stage.height - offsetHeight - 6));
    Object.assign(this.box.style, { left: `${left}px`, top: `${top}px` });
  }
}
