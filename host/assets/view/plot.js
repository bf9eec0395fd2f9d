// Base of all plots: uPlot with a common look, axes that a few wild values do not stretch, and keys for zooming.
/* global uPlot */
import { Cursor } from "./cursor.js";

export const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();

// Fraction of the axis that new data may leave unused before it shrinks, so that a live axis does not tremble.
const SLACK = 0.4;
// Maximum distance from the cursor to the point that it reads, pixels.
const NEAR = 30;
// Minimum distance between two numbers on the x axis, pixels: seven digits and a gap.
const APART = 64;
// Distance from the median beyond which a value is wild, in median deviations.
const FAR = 8;
// Steps of moving and zooming, as fractions of the shown range.
const STEP = 0.2;
const ZOOM = 0.6;

// Returns the value below which this fraction of the values lies.
export function quantile(sorted, fraction) {
  return sorted[Math.min(sorted.length - 1, Math.max(0, Math.round(fraction * (sorted.length - 1))))];
}

// Returns the range of the values without the outermost `fraction` at each end; null without values.
export function robust(values, fraction = 0.01) {
  const sorted = values.filter((value) => value !== null && value !== undefined && Number.isFinite(value)).sort((a, b) => a - b);
  return sorted.length ? [quantile(sorted, fraction), quantile(sorted, 1 - fraction)] : null;
}

// Returns the range of the values without outliers. Leaves out only values far from the median, and at most this fraction at each
// end, so that a second level that lasts stays in.
export function withoutWild(values, fraction) {
  const sorted = [...values].sort((a, b) => a - b);
  const middle = quantile(sorted, 0.5);
  const spread = quantile(sorted.map((value) => Math.abs(value - middle)).sort((a, b) => a - b), 0.5);
  const isWild = (value) => Math.abs(value - middle) > FAR * spread;
  const max = sorted.length > 2 ? Math.ceil(fraction * sorted.length) : 0;
  const cut = (ordered) => ordered.slice(0, max).filter(isWild).length;
  return [sorted[cut(sorted)], sorted.at(-1 - cut(sorted.toReversed()))];
}

// A range that grows at once, but shrinks only when much of it is unused.
export class Steady {
  take(range) {
    const [min, max] = range;
    const fits = this.range && min >= this.range[0] && max <= this.range[1];
    if (!fits || max - min < (1 - SLACK) * (this.range[1] - this.range[0])) this.range = range;
    return this.range;
  }
}

export const line = (stroke, more = {}) => ({ stroke, width: 1.5, points: { show: false }, ...more });
export const dots = (stroke, size, more = {}) => ({
  stroke, width: 0, paths: () => null, points: { show: true, size, stroke, fill: stroke, width: 1 }, ...more,
});

// `series`: all series except x; those whose points the cursor can read have a `name`. Each kind of
// plot has a `draw` that makes the data from a state.
export class Plot {
  constructor(card, onZoom, options) {
    this.box = card.querySelector(".plot");
    this.empty = card.querySelector(".empty");
    this.name = card.dataset.name;
    this.title = card.querySelector("h2").textContent;
    this.onZoom = onZoom;
    this.isZoomed = { x: false, y: false };
    this.units = options.units ?? ["s", "mV"];
    this.names = ["", ...options.series.map(({ name }) => name)];
    // Converts a position on the x axis to its unit.
    this.real = options.real ?? ((x) => x);
    // Start and end of a marked part of the time; either may be null.
    this.mark = [null, null];
    const axis = (label, size, more = {}) => ({
      label, size, stroke: () => colour("soft"), font: "12px system-ui", labelFont: "12px system-ui", labelSize: 16,
      grid: { stroke: () => colour("grid"), width: 1 }, ticks: { stroke: () => colour("grid"), width: 1 }, ...more,
    });
    const { right } = options;
    // A plot with `select` passes the range of a drag to it; other plots zoom to that range.
    this.select = options.select;
    const drag = this.select ? { x: true, y: false, setScale: false } : { x: true, y: true, uni: 30 };
    this.plot = new uPlot({
      ...this.size(),
      padding: [options.top ?? 10, right ? 4 : 12, 0, 0],
      legend: { show: false },
      cursor: { drag, bind: options.bind, points: { show: false }, hover: { skip: [null, undefined], prox: NEAR } },
      scales: { x: { time: options.isDated ?? false }, y: { range: options.yRange }, ...(right ? { right: { range: right.range } } : {}) },
      axes: [
        axis(options.x, 38, { space: APART, ...options.xAxis }), axis(options.y, options.ySize ?? 62, options.yAxis),
        ...(right ? [axis(right.label, 54, { scale: "right", side: 1, grid: { show: false }, splits: right.splits })] : []),
      ],
      series: [{}, ...options.series],
      hooks: {
        setSelect: [(u) => this.zoomed(u)], setCursor: [() => this.cursor?.show()],
        drawClear: [(u) => this.paintMark(u), ...(options.below ?? [])], draw: options.draw ?? [],
      },
    }, [[], ...options.series.map(() => [])], this.box);
    this.plot.over.addEventListener("dblclick", () => this.reset());
    this.cursor = new Cursor(this);
    this.observer = new ResizeObserver(() => this.plot.setSize(this.size()));
    this.observer.observe(this.box);
    this.box.tabIndex = 0;
    this.box.setAttribute("role", "group");
    this.box.setAttribute("aria-label", `${this.title}, plot. Plus and minus zoom, the arrows move, 0 shows all. With shift the arrows move a cursor, enter marks a point.`);
    this.keys = (event) => this.key(event);
    this.box.addEventListener("keydown", this.keys);
  }

  destroy() {
    this.observer.disconnect();
    this.box.removeEventListener("keydown", this.keys);
    this.plot.destroy();
  }

  // Handles the end of a drag.
  zoomed({ select: { left, width, height }, over, posToVal }) {
    if (!(width > 0 || height > 0)) return;
    if (this.select) {
      this.plot.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
      this.select(posToVal(left, "x"), posToVal(left + width, "x"));
      return;
    }
    this.isZoomed = { x: this.isZoomed.x || (width > 0 && width < over.clientWidth), y: this.isZoomed.y || (height > 0 && height < over.clientHeight) };
    this.onZoom();
  }

  // Resets the zoom, so that the next data is shown in full.
  reset() {
    this.isZoomed = { x: false, y: false };
  }

  paintMark(u) {
    const [from, until] = (this.mark ?? [null, null]).map((x) => (x === null ? null : u.valToPos(x, "x", true)));
    const { left, top, width, height } = u.bbox;
    const inside = (x) => Math.min(left + width, Math.max(left, x));
    u.ctx.save();
    u.ctx.fillStyle = colour("band");
    if (from !== null && until !== null) u.ctx.fillRect(inside(from), top, inside(until) - inside(from), height);
    u.ctx.fillStyle = colour("accent");
    const points = this.cursor.points.map(({ x }) => u.valToPos(x, "x", true));
    for (const x of [from, until, ...points]) if (x !== null && x === inside(x)) u.ctx.fillRect(x - 1, top, 2, height);
    u.ctx.restore();
  }

  key(event) {
    const { min, max } = this.plot.scales.x;
    const span = max - min;
    const middle = 0.5 * (min + max);
    const to = {
      "+": [middle - 0.5 * ZOOM * span, middle + 0.5 * ZOOM * span],
      "-": [middle - 0.5 * span / ZOOM, middle + 0.5 * span / ZOOM],
      ArrowLeft: [min - STEP * span, max - STEP * span],
      ArrowRight: [min + STEP * span, max + STEP * span],
    }[event.key === "=" ? "+" : event.key];
    if (event.ctrlKey || event.metaKey || event.altKey || !(span > 0)) return;
    if ((event.shiftKey && event.key.startsWith("Arrow")) || ["Enter", "Escape"].includes(event.key)) this.cursor.key(event.key);
    else if (to) this.zoom(...to);
    else if (event.key === "0") {
      this.reset();
      this.plot.setData(this.plot.data);
    } else return;
    event.preventDefault();
  }

  // Shows this range of the x axis.
  zoom(min, max) {
    this.onZoom();
    this.isZoomed.x = true;
    this.plot.setScale("x", { min, max });
  }

  size() {
    return { width: Math.max(200, this.box.clientWidth), height: Math.max(120, this.box.clientHeight) };
  }

  // `shown` describes the axes for screen readers. A zoomed range is kept, and moves with the time.
  show(data, shown = "") {
    const { x, y } = Object.fromEntries(["x", "y"].map((name) => [name, { min: this.plot.scales[name].min, max: this.plot.scales[name].max }]));
    const by = this.units[0] === "s" ? data[0].at(-1) - this.data?.[0].at(-1) || 0 : 0;
    this.data = data;
    this.plot.batch(() => {
      this.plot.setData(data);
      if (this.isZoomed.x) this.plot.setScale("x", { min: x.min + by, max: x.max + by });
      if (this.isZoomed.y) this.plot.setScale("y", y);
    });
    this.box.setAttribute("aria-description", shown);
  }

  // Returns a point of a series in its units; plots whose height is not the value override this.
  measured(series, at) {
    return { y: this.data[series][at] };
  }

  // Shows a reason instead of the plot, and clears the old data; an empty reason shows the plot.
  explain(why) {
    this.empty.hidden = why === "";
    this.empty.textContent = why;
    this.box.classList.toggle("bare", why !== "");
    if (why !== "") this.clear();
  }

  // Forgets the data, the marks and the zoom.
  clear() {
    this.reset();
    this.data = undefined;
    this.cursor.mark(null);
    this.plot.setData(this.plot.series.map(() => []));
    this.box.removeAttribute("aria-description");
  }

  // True if this position is within the shown range of the x axis.
  shows(x) {
    const { min, max } = this.plot.scales.x;
    return !(x < min || x > max);
  }

  canvas() {
    return this.plot.ctx.canvas;
  }
}
