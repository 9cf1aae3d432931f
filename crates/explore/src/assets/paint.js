// Pictures as pixels: codes by colour and hatching, numbers by a colour scale.

function rgb(hex) {
  const value = Number.parseInt(hex.slice(1), 16);
  return [value >> 16, (value >> 8) & 255, value & 255];
}

// As a pixel in memory, on machines of either byte order.
const pixel = ([r, g, b]) => new Uint32Array(new Uint8ClampedArray([r, g, b, 255]).buffer)[0];

// Whether a hatching covers a place (x, y) in its square tile of `size` pixels.
const hatchings = {
  rising: (x, y, size) => (x + y) % size < size / 8,
  falling: (x, y, size) => (x - y + size) % size < size / 8,
  crossed: (x, y, size) => (x + y) % size < size / 8 || (x - y + size) % size < size / 8,
  dots: (x, y, size) => (2 * x) % size < size / 4 && (2 * y) % size < size / 4 && (x < size / 2) === (y < size / 2),
};

// The tiles of all kinds, by code.
function tiles(kinds, size) {
  const all = new Map();
  for (const { code, ground, hatch, ink } of kinds) {
    const tile = new Uint32Array(size * size).fill(pixel(rgb(ground)));
    if (hatch) {
      const inked = pixel(rgb(ink));
      for (let i = 0; i < tile.length; i += 1) {
        if (hatchings[hatch](i % size, Math.floor(i / size), size)) tile[i] = inked;
      }
    }
    all.set(code, tile);
  }
  return all;
}

// Steps of the colour scale of numbers.
const STEPS = 256;
export const NO_NUMBER = { code: 0, words: "no number", ground: "#ffffff", hatch: "rising", ink: "#b4b4b4" };

// Colours of numbers: between two ends, or around zero where both signs occur and the sign matters.
export function colours(picture, catalogue) {
  let [least, most] = [Infinity, -Infinity];
  for (const value of picture.cells) {
    if (Number.isFinite(value)) {
      least = Math.min(least, value);
      most = Math.max(most, value);
    }
  }
  const signed = picture.show.startsWith("margin_") && least < 0 && most > 0;
  if (signed) [least, most] = [-Math.max(most, -least), Math.max(most, -least)];
  const anchors = (signed ? catalogue.diverging : catalogue.sequential).map(rgb);
  const lookup = new Uint32Array(STEPS);
  for (let i = 0; i < STEPS; i += 1) {
    const at = (i / (STEPS - 1)) * (anchors.length - 1);
    const low = Math.min(Math.floor(at), anchors.length - 2);
    lookup[i] = pixel(anchors[low].map((channel, k) => Math.round(channel + (at - low) * (anchors[low + 1][k] - channel))));
  }
  return { least, most, lookup, signed };
}

// Fills a canvas with the part of a picture that lies in the view; `fit` maps places in the view to places
// in the picture, both in the unit square from the lower left corner: [left, right, low, high].
export function paint(canvas, picture, catalogue, fit = [0, 1, 0, 1]) {
  const { width, height } = canvas;
  const context = canvas.getContext("2d");
  const image = context.createImageData(width, height);
  const out = new Uint32Array(image.data.buffer);
  const size = devicePixelRatio < 1.5 ? 8 : 16;
  const [left, right, low, high] = fit;
  const column = Int32Array.from({ length: width }, (_, i) => Math.floor((left + ((i + 0.5) / width) * (right - left)) * picture.width));
  const { cells } = picture;
  const of = picture.kinds ? tiles(picture.kinds, size) : tiles([NO_NUMBER], size);
  const scale = picture.kinds ? null : colours(picture, catalogue);
  // Most cells are of the kind of the one before.
  let [last, tile] = [NaN, null];
  for (let y = 0; y < height; y += 1) {
    const row = Math.floor((low + ((height - y - 0.5) / height) * (high - low)) * picture.height);
    if (row < 0 || row >= picture.height) continue;
    const [first, line, stripe] = [row * picture.width, y * width, (y % size) * size];
    for (let x = 0; x < width; x += 1) {
      const at = column[x];
      if (at < 0 || at >= picture.width) continue;
      const cell = cells[first + at];
      if (scale && !Number.isNaN(cell)) {
        const span = scale.most - scale.least;
        const unit = span > 0 ? Math.max(0, Math.min(1, (cell - scale.least) / span)) : 0.5;
        out[line + x] = scale.lookup[Math.round(unit * (STEPS - 1))];
        continue;
      }
      if (cell !== last) [last, tile] = [cell, of.get(scale ? 0 : cell)];
      out[line + x] = tile[stripe + (x % size)];
    }
  }
  context.putImageData(image, 0, 0);
}

// A swatch of one kind, or the whole colour scale.
export function swatch(canvas, kind) {
  paint(canvas, { width: 1, height: 1, cells: [kind.code], kinds: [kind], show: "" });
}

export function bar(canvas, { lookup }) {
  const context = canvas.getContext("2d");
  const image = context.createImageData(canvas.width, canvas.height);
  const out = new Uint32Array(image.data.buffer);
  for (let i = 0; i < out.length; i += 1) out[i] = lookup[Math.round(((i % canvas.width) / (canvas.width - 1)) * (STEPS - 1))];
  context.putImageData(image, 0, 0);
}
