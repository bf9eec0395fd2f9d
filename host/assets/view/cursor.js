// Shows the value under a plot's cursor, and the difference between two marked points.
import { withSigma } from "./format.js";

// Distance that the up and down keys move the cursor, as a fraction of the height.
const STEP = 0.05;

const signed = (text) => text.replace("-", "−");

export class Cursor {
  constructor(plot) {
    Object.assign(this, { plot, points: [], readout: document.createElement("p") });
    this.readout.className = "readout small";
    const { over } = plot.plot;
    over.append(this.readout);
    over.addEventListener("click", () => this.mark(this.nearest()));
    over.addEventListener("dblclick", () => this.mark(null));
    over.addEventListener("pointermove", () => { this.readout.ariaLive = "off"; });
    this.show();
  }

  // Returns the measured point nearest to the cursor; null if there is none.
  nearest() {
    const { plot: u, names } = this.plot;
    const { top, idxs } = u.cursor;
    const found = u.series.flatMap(({ scale }, series) => {
      const at = idxs?.[series] ?? null;
      const height = at === null ? null : u.data[series][at] ?? null;
      if (!names[series] || height === null) return [];
      return [{ name: names[series], scale, x: u.data[0][at], far: Math.abs(u.valToPos(height, scale) - top), ...this.plot.measured(series, at) }];
    });
    return u.cursor.left < 0 ? null : found.toSorted((a, b) => a.far - b.far)[0] ?? null;
  }

  // Marks a first point, then a second one; the next call, or null, removes the marks.
  mark(point) {
    this.points = point === null || this.points.length === 2 ? [] : [...this.points, point];
    this.show();
    this.plot.plot.redraw(false);
  }

  key(key) {
    const { plot: u } = this.plot;
    const { left, top, idx } = u.cursor;
    const by = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -STEP], ArrowDown: [0, STEP] }[key];
    this.readout.ariaLive = "polite";
    if (key === "Enter") this.mark(this.nearest());
    else if (key === "Escape") this.mark(null);
    else if (left < 0) u.setCursor({ left: 0.5 * u.over.clientWidth, top: 0.5 * u.over.clientHeight });
    else u.setCursor({ left: by[0] === 0 ? left : u.valToPos(u.data[0][idx + by[0]] ?? u.data[0][idx], "x"), top: top + by[1] * u.over.clientHeight });
  }

  // Returns a position on the x axis, the width of a pixel there, and the unit.
  place(x) {
    const { plot: u, real, units } = this.plot;
    const at = u.valToPos(x, "x");
    return [real(x), real(u.posToVal(at + 1, "x")) - real(x), units[0]];
  }

  height({ y, sigma, scale, unit = this.plot.units[1], step }) {
    const { plot: u } = this.plot;
    if (sigma > 0) return signed(withSigma(y, sigma, unit));
    return number(y, step ?? u.posToVal(0, scale) - u.posToVal(1, scale), unit);
  }

  difference([one, other]) {
    const { units } = this.plot;
    const [[from, step], [until]] = [this.place(one.x), this.place(other.x)];
    const rate = units[0] === "s" && until !== from ? ` (${Number((1 / Math.abs(until - from)).toPrecision(4))} Hz)` : "";
    const apart = { ...other, y: other.y - one.y, sigma: Math.hypot(one.sigma ?? 0, other.sigma ?? 0) };
    return `Δ ${number(until - from, step, units[0])}${rate}, ${this.height(apart)}`;
  }

  show() {
    const now = this.nearest();
    const ends = this.points.length === 1 && now !== null ? [this.points[0], now] : this.points;
    const lines = [
      ...(now === null ? [] : [`${number(...this.place(now.x))}, ${now.name}: ${this.height(now)}`]),
      ...(ends.length === 2 ? [this.difference(ends)] : []),
    ];
    this.readout.textContent = lines.join("\n");
    this.readout.hidden = lines.length === 0;
  }
}

const number = (value, step, unit) => `${signed(value.toFixed(Math.min(9, Math.max(0, Math.ceil(-Math.log10(Math.abs(step)))))))} ${unit}`.trim();
