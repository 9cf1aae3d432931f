// The legend of the picture: kinds that it shows, or the colour scale, and the curves over it.

import { element, shape, short } from "./elements.js";
import { NO_NUMBER, bar, colours, swatch } from "./paint.js";

export function legend(box, picture, curves, catalogue) {
  const keys = [];
  const add = (kind) => {
    const canvas = element("canvas", { width: 26, height: 15, "aria-hidden": "true" });
    swatch(canvas, kind);
    keys.push(element("span", { class: "key" }, canvas, kind.words));
  };
  if (picture.kinds) {
    const shown = new Set(picture.cells);
    picture.kinds.filter(({ code }) => shown.has(code)).forEach(add);
  } else {
    const scale = colours(picture, catalogue);
    if (scale.least <= scale.most) {
      const canvas = element("canvas", { class: "bar", width: 260, height: 15, "aria-hidden": "true" });
      bar(canvas, scale);
      keys.push(element("span", { class: "key" }, `${picture.label}: ${short(scale.least)}`, canvas, short(scale.most)));
    }
    if (picture.cells.some(Number.isNaN)) add(NO_NUMBER);
  }
  const named = new Map(curves.map((curve) => [curve.words, curve]));
  for (const [words, { color, width, dash, mark }] of named) {
    const point = () => shape("circle", { cx: 13, cy: 7.5, r: 3.5, fill: "#ffffff", stroke: color });
    const line = mark ? point() : shape("path", { d: "M2 7.5H24", stroke: color, "stroke-width": 1.6 * width, "stroke-dasharray": dash.join(" ") || null });
    const errors = curves.filter((curve) => curve.words === words).flatMap((curve) => curve.errors);
    const title = `each point is known to ${short(Math.max(...errors), 2)} of the picture's sides`;
    keys.push(element("span", { class: "key", title }, shape("svg", { viewBox: "0 0 26 15", "aria-hidden": "true" }, line), words));
  }
  box.replaceChildren(...keys);
  // The legend never shrinks: a finer picture may have one more kind, which wraps. A stage that grew again
  // with the next coarse picture would restart for ever.
  box.style.minHeight = `${box.offsetHeight}px`;
}
