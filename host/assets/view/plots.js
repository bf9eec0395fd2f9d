// The plots: uPlot behind a common look, and what each of them shows of the state.
/* global uPlot */
import { round125 } from "./format.js";

const TAXELS = 16;
// Lower end of the axis, decibels.
const FLOOR_DB = -70;
// Windows more than this many hops apart have a pause between them.
const GAP = 2.5;
// Least height of the history, as a share of the frequency: magnified further, a millionth would look like noise.
const LEAST_SHARE = 1e-4;

export const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
const unit = (taxel) => `unit${Math.floor(taxel / 4)}`;
const middle = (values) => {
  const known = values.filter((value) => value !== null);
  return known.length ? known.reduce((a, b) => a + b, 0) / known.length : 0;
};

// Base of all: `series` without x, `draw` makes the data of a state.
class Plot {
  constructor(card, onZoom, options) {
    this.box = card.querySelector(".plot");
    this.empty = card.querySelector(".empty");
    this.name = card.dataset.name;
    this.title = card.querySelector("h2").textContent;
    const axis = (label, size, more = {}) => ({
      label, size, stroke: () => colour("soft"), font: "12px system-ui", labelFont: "12px system-ui", labelSize: 16,
      grid: { stroke: () => colour("grid"), width: 1 }, ticks: { stroke: () => colour("grid"), width: 1 }, ...more,
    });
    this.plot = new uPlot({
      ...this.size(),
      padding: [10, 12, 0, 0],
      legend: { show: false },
      cursor: { drag: { x: true, y: true, uni: 30 }, points: { show: false } },
      scales: { x: { time: false }, y: { range: options.yRange } },
      axes: [axis(options.x, 38), axis(options.y, options.ySize ?? 62, options.yAxis)],
      series: [{}, ...options.series],
      hooks: { setSelect: [(u) => (u.select.width > 0 || u.select.height > 0) && onZoom()], draw: options.draw ?? [] },
    }, [[], ...options.series.map(() => [])], this.box);
    new ResizeObserver(() => this.plot.setSize(this.size())).observe(this.box);
  }

  size() {
    return { width: Math.max(200, this.box.clientWidth), height: Math.max(120, this.box.clientHeight) };
  }

  show(data) {
    this.data = data;
    this.plot.setData(data);
  }

  // Shows the reason instead of an empty plot; none for a plot with data.
  explain(why) {
    this.empty.hidden = why === "";
    this.empty.textContent = why;
    this.box.classList.toggle("dim", why !== "");
  }

  canvas() {
    return this.plot.ctx.canvas;
  }
}

const line = (stroke, more = {}) => ({ stroke, width: 1.5, points: { show: false }, ...more });
const dots = (stroke, size) => ({
  stroke, width: 0, paths: () => null, points: { show: true, size, stroke, fill: stroke, width: 1 },
});

export class Strips extends Plot {
  constructor(card, onZoom) {
    const apart = { mv: 1 };
    const series = Array.from({ length: TAXELS }, (_, taxel) => line(() => colour(unit(taxel)), { width: 1.25 }));
    const rows = () => Array.from({ length: TAXELS }, (_, row) => (row + 1 - TAXELS) * apart.mv);
    super(card, onZoom, {
      x: "device time, s", y: "taxel", ySize: 34, series,
      yRange: () => [(0.1 - TAXELS) * apart.mv, 1.1 * apart.mv],
      yAxis: { splits: rows, values: (_, splits) => splits.map((split) => String(Math.round(-split / apart.mv))) },
    });
    this.apart = apart;
  }

  draw({ live: { strips } }, length_s) {
    const end = strips.t_s.at(-1);
    const from = Math.max(0, strips.t_s.findIndex((t_s) => t_s > end - length_s));
    const t_s = strips.t_s.slice(from);
    const mv = strips.volts.map((values) => {
      const part = values.slice(from);
      const zero = middle(part);
      return part.map((value) => (value === null ? null : 1e3 * (value - zero)));
    });
    const swings = mv.map((values) => Math.max(...values) - Math.min(...values)).sort((a, b) => a - b);
    // The liveliest may reach into their neighbours' rows.
    this.apart.mv = round125(Math.max(0.02, 0.6 * swings[12]));
    this.plot.axes[1].label = `taxel, rows ${this.apart.mv} mV apart`;
    this.show([t_s, ...mv.map((values, taxel) => values.map((value) => (value === null ? null : value - taxel * this.apart.mv)))]);
  }
}

// With an empty point in every pause that is longer: what is before it and behind it is not joined.
const apart = (points, pause_s) => points.flatMap((point, at) => {
  const before = points[at - 1];
  return before && point.t_s - before.t_s > pause_s ? [{ t_s: 0.5 * (before.t_s + point.t_s) }, point] : [point];
});

export class History extends Plot {
  constructor(card, onZoom) {
    const edge = { stroke: "transparent", width: 0, points: { show: false } };
    super(card, onZoom, {
      x: "device time, s", y: "frequency, Hz", ySize: 76,
      series: [edge, edge, line(() => colour("accent")), dots(() => colour("accent"), 6), dots(() => colour("alarm"), 8), dots(() => colour("text"), 10)],
      yAxis: { values: (_, splits) => splits.map((split) => String(Number(split.toPrecision(8)))) },
      yRange: (_, least, most) => {
        const centre = 0.5 * (least + most);
        const half = Math.max(0.55 * (most - least), 0.5 * LEAST_SHARE * most);
        return Number.isFinite(half) && half > 0 ? [centre - half, centre + half] : [0, 1];
      },
    });
    this.plot.addBand({ series: [2, 1], fill: () => colour("band") });
  }

  draw({ live: { history, now_s, latest } }, length_s) {
    const abscissa = history.at(-1)?.abscissa;
    const found = history.filter((point) => point.t_s > (now_s ?? 0) - length_s && point.abscissa === abscissa);
    found.sort((a, b) => a.t_s - b.t_s);
    const shown = apart(found, GAP * (latest.hello?.settings.hop_s ?? 0.25));
    // To the plot null is a gap, and undefined nothing at all.
    const windows = (value) => shown.map((point) => {
      if (point.span === "slide") return undefined;
      return (point.frequency ?? null) === null ? null : value(point);
    });
    const only = (want) => shown.map((point) => ((point.frequency ?? null) !== null && want(point) ? point.frequency : undefined));
    // What is hardly known must not flatten the rest.
    const sigma = (point) => Math.min(point.sigma, 0.1 * point.frequency);
    this.plot.axes[1].label = abscissa === "place" ? "cycles per mm" : "frequency, Hz";
    this.show([
      shown.map((point) => point.t_s),
      windows((point) => point.frequency - sigma(point)),
      windows((point) => point.frequency + sigma(point)),
      windows((point) => point.frequency),
      only((point) => point.span === "window" && point.status === "good"),
      only((point) => point.span === "window" && point.status !== "good"),
      only((point) => point.span === "slide"),
    ]);
    return found.some((point) => point.frequency !== null);
  }
}

export class Spectrum extends Plot {
  constructor(card, onZoom) {
    const mark = { hz: null };
    super(card, onZoom, {
      x: "frequency, Hz", y: "share of power, dB", series: [line(() => colour("accent"))],
      yRange: () => [FLOOR_DB, 0],
      draw: [(u) => {
        if (mark.hz === null || mark.hz > u.scales.x.max || mark.hz < u.scales.x.min) return;
        const x = Math.round(u.valToPos(mark.hz, "x", true));
        u.ctx.save();
        u.ctx.strokeStyle = colour("alarm");
        u.ctx.setLineDash([6, 4]);
        u.ctx.beginPath();
        u.ctx.moveTo(x, u.bbox.top);
        u.ctx.lineTo(x, u.bbox.top + u.bbox.height);
        u.ctx.stroke();
        u.ctx.restore();
      }],
    });
    this.mark = mark;
  }

  // The board's tone is marked.
  draw({ spectrum }, tone_hz) {
    this.mark.hz = tone_hz;
    const bins = spectrum.power_db.slice(1);
    this.show([bins.map((_, bin) => (bin + 1) * spectrum.bin_hz), bins]);
  }
}

export class Fit extends Plot {
  constructor(card, onZoom) {
    super(card, onZoom, {
      x: "device time, s", y: "mV", series: [dots(() => colour("soft"), 4), line(() => colour("accent"), { width: 2 })],
    });
  }

  // What was read of a taxel, and the fundamental over it.
  draw({ curves }, taxel) {
    const mv = (values) => values?.map((value) => (value === null ? null : 1e3 * value)) ?? curves.t_s.map(() => null);
    this.show([curves.t_s, mv(curves.read_v[taxel]), mv(curves.tone_v[taxel])]);
  }
}
