// The spectrum in decibels, with the tone, its harmonics, and the noise next to it.
import { Plot, Steady, colour, line, quantile } from "./plot.js";

// Multiples of a power of ten that get a number on a logarithmic axis: the first set for which there is room.
const NUMBERED = [[1, 2, 5], [1, 3], [1]];
// Width of a digit, and the gap between two numbers, pixels.
const DIGIT = 7;
const GAP = 6;
// Decibels by which the axis extends below nearly all bins.
const MARGIN_DB = 6;

export const label = (hz) => String(Number(hz.toPrecision(6)));

// Returns the positions of numbers on a logarithmic axis (base ten). `room` returns the width of a number in the axis's scale.
export const places = ([min, max], room) => {
  const powers = Array.from({ length: Math.floor(max) - Math.floor(min) + 1 }, (_, at) => Math.floor(min) + at);
  const at = (multiples) => powers.flatMap((power) => multiples.map((multiple) => power + Math.log10(multiple))).filter((x) => x >= min && x <= max);
  // Numbers are centred on their positions.
  const fits = (found) => found.every((x, place) => place === 0 || x - found[place - 1] > room(label(10 ** x)));
  return NUMBERED.map(at).find(fits) ?? [];
};

// Returns the positions of numbers on a plot's x axis.
export const numbered = (u, min, max) => places([min, max], (text) => ((text.length * DIGIT + GAP) * (max - min) * window.devicePixelRatio) / u.bbox.width);

export class Spectrum extends Plot {
  constructor(card, onZoom) {
    const shown = { lines: [], residual: null, isLog: false, floor: -70 };
    const toX = (hz) => (shown.isLog ? Math.log10(hz) : hz);
    super(card, onZoom, {
      x: "frequency, Hz", y: "fraction of power, dB", units: ["Hz", "dB"], real: (x) => (shown.isLog ? 10 ** x : x),
      series: [
        line(() => colour("accent"), { name: "power" }), line(() => colour("unit1"), { width: 1, name: "residual" }),
        line(() => colour("other"), { dash: [5, 4], name: "other run" }),
      ],
      yRange: () => [shown.floor, 0],
      xAxis: {
        splits: (u, axis, min, max, increment) => {
          if (shown.isLog) return numbered(u, min, max);
          const first = Math.ceil(min / increment);
          return Array.from({ length: Math.max(0, Math.floor(max / increment) - first + 1) }, (_, at) => (first + at) * increment);
        },
        values: (_, splits) => splits.map((split) => label(this.real(split))),
      },
      below: [(u) => paintNeighbourhood(u, shown.residual, toX)],
      draw: [(u) => paintLines(u, shown.lines, toX)],
    });
    [this.shown, this.toX] = [shown, toX];
    this.steady = new Steady();
  }

  // `beside`: the spectrum of another run.
  draw({ spectrum, curves }, isLog, beside = null) {
    // The residual is of the estimate's window, and so is this spectrum if it has lines.
    const residual = spectrum.lines.length ? curves?.residual_spectrum ?? null : null;
    Object.assign(this.shown, { lines: spectrum.lines, residual, isLog });
    this.plot.axes[0].label = isLog ? "frequency, Hz, logarithmic" : "frequency, Hz";
    const db = spectrum.power_db.slice(1);
    const hz = db.map((_, bin) => (bin + 1) * spectrum.bin_hz);
    const low = quantile([...db, ...(residual?.power_db ?? [])].sort((a, b) => a - b), 0.03) - MARGIN_DB;
    this.shown.floor = this.steady.take([Math.max(-120, Math.min(-20, 10 * Math.floor(low / 10))), 0])[0];
    // The bins of the other spectrum may be at different frequencies.
    const other = (found) => hz.map((at) => (found ? found.power_db[Math.round(at / found.bin_hz)] ?? null : null));
    this.show([hz.map(this.toX), db, other(residual), other(beside)], `from ${this.shown.floor} to 0 dB`);
  }
}

function within(u, x) {
  return x >= u.scales.x.min && x <= u.scales.x.max;
}

function paintNeighbourhood(u, beside, toX) {
  if (!beside) return;
  const { left, top, width, height } = u.bbox;
  const at = (hz) => Math.min(left + width, Math.max(left, hz > 0 ? u.valToPos(toX(hz), "x", true) : left));
  const [from, until] = [at(beside.from_hz), at(beside.until_hz)];
  const level = u.valToPos(beside.noise_db, "y", true);
  u.ctx.save();
  u.ctx.fillStyle = colour("band");
  u.ctx.fillRect(from, top, until - from, height);
  u.ctx.strokeStyle = colour("soft");
  u.ctx.lineWidth = 2;
  u.ctx.beginPath();
  u.ctx.moveTo(from, level);
  u.ctx.lineTo(until, level);
  u.ctx.stroke();
  u.ctx.restore();
}

function paintLines(u, lines, toX) {
  u.ctx.save();
  const scale = window.devicePixelRatio;
  u.ctx.strokeStyle = u.ctx.fillStyle = colour("alarm");
  u.ctx.font = `${12 * scale}px system-ui`;
  [u.ctx.textAlign, u.ctx.textBaseline] = ["left", "alphabetic"];
  let labelled = -Infinity;
  lines.forEach(({ frequency_hz: hz }, at) => {
    if (!within(u, toX(hz))) return;
    const x = Math.round(u.valToPos(toX(hz), "x", true));
    u.ctx.setLineDash(at === 0 ? [6, 4] : [2, 4]);
    u.ctx.beginPath();
    u.ctx.moveTo(x, u.bbox.top);
    u.ctx.lineTo(x, u.bbox.top + u.bbox.height);
    u.ctx.stroke();
    const name = at === 0 ? "f" : `${at + 1}f`;
    const end = x + 3 * scale + u.ctx.measureText(name).width;
    if (x < labelled || end > u.bbox.left + u.bbox.width) return;
    labelled = end + 3 * scale;
    u.ctx.fillText(name, x + 3 * scale, u.bbox.top + 12 * scale);
  });
  u.ctx.restore();
}
