// An axis of the plane: from parameters to the unit interval and back, and round numbers along it.

export class Scale {
  constructor({ from, to, log }) {
    Object.assign(this, { from, to, log: Boolean(log) });
  }

  unit(value) {
    const { from, to, log } = this;
    return log ? Math.log(value / from) / Math.log(to / from) : (value - from) / (to - from);
  }

  value(unit) {
    const { from, to, log } = this;
    return log ? from * (to / from) ** unit : from + (to - from) * unit;
  }

  // The value at a place, with as many digits as distinguish the cells of a fine picture.
  rounded(unit) {
    const value = this.value(unit);
    const step = Math.abs(this.value(unit + 1e-4) - value) || 1;
    const digits = Math.max(0, Math.min(15, -Math.floor(Math.log10(step))));
    return Number(value.toFixed(digits));
  }

  // About `count` round numbers.
  ticks(count) {
    const { from, to, log } = this;
    if (log && to / from > 8) {
      const ticks = [];
      for (let decade = Math.floor(Math.log10(from)); decade <= Math.ceil(Math.log10(to)); decade += 1) {
        for (const digit of to / from > 1000 ? [1] : [1, 2, 5]) {
          const tick = Number((digit * 10 ** decade).toPrecision(3));
          if (tick >= from && tick <= to) ticks.push(tick);
        }
      }
      return ticks;
    }
    const raw = (to - from) / count;
    const power = 10 ** Math.floor(Math.log10(raw));
    const step = [1, 2, 2.5, 5, 10].map((digit) => digit * power).find((size) => size >= raw);
    const ticks = [];
    for (let i = Math.ceil(from / step - 1e-9); i * step <= to + 1e-9 * step; i += 1) ticks.push(Number((i * step).toPrecision(12)));
    return ticks;
  }
}
