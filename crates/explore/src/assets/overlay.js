// The drawing over the cells: axes, curves, and the pinned point.

import { shape, short } from "./elements.js";
import { label } from "./state.js";

const MARGIN = { left: 62, right: 16, top: 14, bottom: 48 };

// The rectangle of the cells inside the stage.
export function rectangle(stage) {
  const { clientWidth, clientHeight } = stage;
  const { left, right, top, bottom } = MARGIN;
  return { x: left, y: top, w: Math.max(20, clientWidth - left - right), h: Math.max(20, clientHeight - top - bottom) };
}

export function draw(svg, rect, scales, state, curves) {
  const place = (x, y) => [rect.x + rect.w * scales.x.unit(x), rect.y + rect.h * (1 - scales.y.unit(y))];
  const shown = (side) => label(state, state[side].axis);
  const parts = [
    shape("defs", {}, shape("clipPath", { id: "frame" }, shape("rect", { x: rect.x, y: rect.y, width: rect.w, height: rect.h }))),
    shape("rect", { class: "frame", x: rect.x, y: rect.y, width: rect.w, height: rect.h }),
  ];
  for (const tick of scales.x.ticks(Math.max(2, rect.w / 90))) {
    const [x] = place(tick, scales.y.from);
    parts.push(shape("path", { class: "tick", d: `M${x} ${rect.y + rect.h}v5` }));
    parts.push(shape("text", { x, y: rect.y + rect.h + 19, "text-anchor": "middle" }, short(tick)));
  }
  for (const tick of scales.y.ticks(Math.max(2, rect.h / 60))) {
    const [, y] = place(scales.x.from, tick);
    parts.push(shape("path", { class: "tick", d: `M${rect.x} ${y}h-5` }));
    parts.push(shape("text", { x: rect.x - 9, y: y + 4, "text-anchor": "end" }, short(tick)));
  }
  parts.push(shape("text", { class: "name", x: rect.x + rect.w / 2, y: rect.y + rect.h + 40, "text-anchor": "middle" }, shown("x").text));
  const across = `translate(16 ${rect.y + rect.h / 2}) rotate(-90)`;
  parts.push(shape("text", { class: "name", transform: across, "text-anchor": "middle" }, shown("y").text));
  const lines = shape("g", { "clip-path": "url(#frame)" });
  const paths = curves.map((curve) => [curve, path(curve.points.map(([x, y]) => place(x, y)))]);
  // The white halos of all curves come first, so that no halo covers a curve.
  for (const [curve, d] of paths) lines.append(shape("path", { class: "halo", d, "stroke-width": 1.6 * curve.width + 2.4 }));
  for (const [curve, d] of paths) {
    if (curve.mark) {
      const [x, y] = place(...curve.points[0]);
      lines.append(shape("circle", { cx: x, cy: y, r: 3.5, fill: "#ffffff", stroke: curve.color }));
      continue;
    }
    const dash = curve.dash.map((length) => 1.5 * length).join(" ");
    lines.append(shape("path", { class: "curve", d, stroke: curve.color, "stroke-width": 1.6 * curve.width, "stroke-dasharray": dash || null }));
  }
  parts.push(lines);
  if (state.pinned) {
    const [x, y] = place(state.at[state.x.axis], state.at[state.y.axis]);
    if (x >= rect.x - 1 && x <= rect.x + rect.w + 1 && y >= rect.y - 1 && y <= rect.y + rect.h + 1) {
      parts.push(shape("path", { class: "cross", d: `M${rect.x} ${y}H${rect.x + rect.w}M${x} ${rect.y}V${rect.y + rect.h}` }));
      parts.push(shape("circle", { class: "pin", cx: x, cy: y, r: 8 }));
      parts.push(shape("circle", { class: "pin-dot", cx: x, cy: y, r: 3.5 }));
    }
  }
  svg.replaceChildren(...parts);
}

function path(places) {
  let d = "";
  let down = false;
  for (const [x, y] of places) {
    if (Number.isFinite(x) && Number.isFinite(y)) {
      d += `${down ? "L" : "M"}${x.toFixed(1)} ${y.toFixed(1)}`;
      down = true;
    } else down = false;
  }
  return d;
}
