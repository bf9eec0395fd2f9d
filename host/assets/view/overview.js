// All channels of a recording over its whole length, each to its own scale, with the touches. Dragging selects a part.
import { Plot, colour, line, robust } from "./plot.js";

// Number of steps to request per pixel; the command thins the rows to these steps.
const STEPS = 1;
// A turn of the wheel by this many pixels zooms by a factor of e.
const WHEEL = 400;
// Fraction of a row's height that its curve fills.
const FILL = 0.86;
// Points more than this many usual steps apart are separated by a gap.
const GAP = 4;
// Minimum distance between the labels of two touches, pixels.
const LABELS = 70;

export class Overview extends Plot {
  // `head`: the rows of the whole recording; `ask` returns the rows of a range; `select` takes the range of a drag.
  constructor(card, head, { ask, select }) {
    const names = head.names;
    const count = names.length;
    const series = names.map((name, at) => line(() => colour(`unit${at % 4}`), { width: 1, name }));
    const shown = Math.ceil(count / 16);
    super(card, () => {}, {
      x: head.is_dated ? "date" : "time, s", y: "", ySize: 72, series, isDated: head.is_dated,
      yRange: () => [0.5 - count, 0.5],
      yAxis: {
        splits: () => names.map((_, at) => -at).filter((at) => at % shown === 0).reverse(),
        values: (u, splits) => splits.map((split) => short(names[-Math.round(split)] ?? "")),
        grid: { show: false },
      },
      select, top: 20,
      // Dragging with Shift moves the shown range.
      bind: { mousedown: (u, target, handler) => (event) => (event.shiftKey ? this.grab(event) : handler(event)) },
      draw: [(u) => this.label(u)], below: [(u) => this.touches(u)],
    });
    Object.assign(this, { head, ask, wanted: null, isBusy: false });
    this.plot.over.addEventListener("wheel", (event) => this.wheel(event), { passive: false });
    this.put(head);
  }

  // Draws rows, each channel scaled to its shown values.
  put({ t_s, values, levels }) {
    const steps = t_s.slice(1).map((time_s, at) => time_s - t_s[at]);
    const usual = steps.toSorted((a, b) => a - b)[Math.floor(steps.length / 2)];
    const gaps = steps.flatMap((step, at) => (step > GAP * usual ? [at + 1] : [])).toReversed();
    this.scales = values.map((column) => {
      const [low, high] = robust(column, 0.001) ?? [0, 0];
      return { middle: 0.5 * (low + high), span: Math.max(high - low, Number.MIN_VALUE) / FILL };
    });
    this.levels = levels;
    const lanes = values.map((column, at) => {
      const { middle, span } = this.scales[at];
      return column.map((value) => (value === null ? null : (value - middle) / span - at));
    });
    const data = [t_s, ...lanes].map((column) => column.slice());
    for (const at of gaps) data.forEach((column, index) => column.splice(at, 0, index === 0 ? 0.5 * (t_s[at - 1] + t_s[at]) : null));
    const { min, max } = this.plot.scales.x;
    this.data = data;
    this.plot.setData(data, false);
    const isFirst = min === undefined || min === null;
    this.plot.setScale("x", isFirst ? { min: this.head.from_s, max: this.head.until_s } : { min, max });
  }

  // Returns a value in the unit of its channel, and the step of a pixel.
  measured(series, at) {
    const { middle, span } = this.scales[series - 1];
    const y = (this.data[series][at] + series - 1) * span + middle + this.levels[series - 1];
    const step = span * Math.abs(this.plot.posToVal(0, "y") - this.plot.posToVal(1, "y"));
    return { y, step, unit: this.head.units[series - 1] ?? "" };
  }

  // Shows a range, limited to the recording, and requests its rows.
  zoom(min, max) {
    const { from_s, until_s, rate_hz } = this.head;
    const span = Math.min(until_s - from_s, Math.max(max - min, 4 / rate_hz));
    const begin = Math.min(Math.max(from_s, 0.5 * (min + max) - 0.5 * span), until_s - span);
    this.plot.setScale("x", { min: begin, max: begin + span });
    this.fetch({ from_s: begin, until_s: begin + span });
  }

  reset() {
    this.zoom(this.head.from_s, this.head.until_s);
  }

  // Zooms by a factor about a position on the axis.
  by(factor, at = 0.5 * (this.plot.scales.x.min + this.plot.scales.x.max)) {
    const { min, max } = this.plot.scales.x;
    this.zoom(at - factor * (at - min), at + factor * (max - at));
  }

  move(fraction) {
    const { min, max } = this.plot.scales.x;
    this.zoom(min + fraction * (max - min), max + fraction * (max - min));
  }

  isWhole() {
    const { min, max } = this.plot.scales.x;
    return min <= this.head.from_s && max >= this.head.until_s;
  }

  wheel(event) {
    const sideways = Math.abs(event.deltaX) > Math.abs(event.deltaY);
    // If there is nothing more to show, let the page scroll.
    if (this.isWhole() && (sideways || event.deltaY > 0)) return;
    event.preventDefault();
    const { left, width } = this.plot.over.getBoundingClientRect();
    if (sideways) this.move(event.deltaX / width);
    else this.by(Math.exp(event.deltaY / WHEEL), this.plot.posToVal(event.clientX - left, "x"));
  }

  grab(event) {
    let before = event.clientX;
    const { width } = this.plot.over.getBoundingClientRect();
    const move = ({ clientX }) => {
      this.move((before - clientX) / width);
      before = clientX;
    };
    document.addEventListener("pointermove", move);
    document.addEventListener("pointerup", () => document.removeEventListener("pointermove", move), { once: true });
  }

  // Fetches and draws the rows of a range; if another range is requested meanwhile, only that one.
  async fetch(range) {
    this.wanted = range;
    if (this.isBusy) return;
    this.isBusy = true;
    while (this.wanted !== null) {
      const next = this.wanted;
      this.wanted = null;
      const found = await this.ask({ ...next, steps: this.steps() });
      if (found !== null && this.wanted === null) this.put(found);
    }
    this.isBusy = false;
  }

  steps() {
    return Math.round(STEPS * Math.max(300, this.box.clientWidth));
  }

  // Draws slides as bands, and contacts and releases as lines.
  touches(u) {
    const { left, top, width, height } = u.bbox;
    const x = (t_s) => Math.min(left + width, Math.max(left, u.valToPos(t_s, "x", true)));
    const { slides, contacts_s, releases_s } = this.head.touches;
    u.ctx.save();
    u.ctx.fillStyle = colour("slide");
    for (const { start_s, end_s } of slides) u.ctx.fillRect(x(start_s), top, x(end_s) - x(start_s), height);
    u.ctx.fillStyle = colour("soft");
    const scale = window.devicePixelRatio;
    for (const t_s of [...contacts_s, ...releases_s]) if (this.shows(t_s)) u.ctx.fillRect(x(t_s) - 0.5 * scale, top, scale, height);
    u.ctx.restore();
  }

  // Draws the names of the marks for which there is room.
  label(u) {
    const scale = window.devicePixelRatio;
    const { slides, contacts_s, releases_s } = this.head.touches;
    const labels = [
      ...contacts_s.map((t_s) => [t_s, "contact"]), ...releases_s.map((t_s) => [t_s, "release"]),
      ...slides.map(({ start_s }) => [start_s, "slide"]),
    ].filter(([t_s]) => this.shows(t_s)).sort((a, b) => a[0] - b[0]);
    u.ctx.save();
    u.ctx.fillStyle = colour("soft");
    u.ctx.font = `${11 * scale}px system-ui`;
    [u.ctx.textBaseline, u.ctx.textAlign] = ["bottom", "left"];
    let free = -Infinity;
    for (const [t_s, name] of labels) {
      const x = u.valToPos(t_s, "x", true);
      if (x < free) continue;
      // At the right edge, put the name to the left of its mark.
      const isLast = x > u.bbox.left + u.bbox.width - 50 * scale;
      if (isLast) u.ctx.textAlign = "right";
      u.ctx.fillText(name, x + (isLast ? -2 : 2) * scale, u.bbox.top - 2 * scale);
      free = x + LABELS * scale;
    }
    u.ctx.restore();
  }
}

const short = (name) => (name.length > 9 ? `${name.slice(0, 8)}…` : name);
