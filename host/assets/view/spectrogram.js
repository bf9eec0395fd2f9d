// The spectrum over time: a tone that comes, follows the speed, and goes.
import { Plot, colour, dots, quantile } from "./plot.js";
import { label, places } from "./spectrum.js";

// Windows that fit into the frames that are kept, side by side; one begins this many times in the length of a window.
const WINDOWS = 4;
const OVERLAP = 16;
// From the strongest colour to none, decibels; the strongest few cells may be beyond.
const RANGE_DB = 40;
const STRONGEST = 0.99;
// Below these bins a window has its straight line and what that leaks.
const FIRST = 2;
// A line of numbers on the axis, pixels.
const LINE = 16;

// The discrete Fourier transform of a power of two numbers, in place (Cooley and Tukey). `turn`: cosines of a turn in as many steps.
function transform(re, im, turn) {
  const { length } = re;
  for (let at = 1, other = 0; at < length; at += 1) {
    let bit = length >> 1;
    for (; other & bit; bit >>= 1) other ^= bit;
    other ^= bit;
    if (at >= other) continue;
    [re[at], re[other]] = [re[other], re[at]];
    [im[at], im[other]] = [im[other], im[at]];
  }
  for (let half = 1; half < length; half *= 2) {
    for (let k = 0; k < half; k += 1) {
      const step = (0.5 * length * k) / half;
      const c = turn[step];
      const s = turn[(step + 0.25 * length) % length];
      for (let at = k; at < length; at += 2 * half) {
        const other = at + half;
        const x = re[other] * c - im[other] * s;
        const y = re[other] * s + im[other] * c;
        re[other] = re[at] - x;
        im[other] = im[at] - y;
        re[at] += x;
        im[at] += y;
      }
    }
  }
}

// Writes the part of a channel from `from` on, less its straight line, under a Hann window; nothing if a value is missing.
function take(values, from, into, hann) {
  const { length } = into;
  const middle = 0.5 * (length - 1);
  let [sum, slope] = [0, 0];
  for (let at = 0; at < length; at += 1) {
    const value = values[from + at];
    if (value === null) return into.fill(0);
    sum += value;
    slope += value * (at - middle);
  }
  slope /= (length * (length * length - 1)) / 12;
  for (let at = 0; at < length; at += 1) into[at] = hann[at] * (values[from + at] - sum / length - slope * (at - middle));
  return into;
}

// Mean square of all channels together in each bin, by window, decibels of a square millivolt; null where frames are missing.
// `most`: frames that are kept.
export function windows({ t_s, number, volts }, most) {
  const length = 2 ** Math.round(Math.log2(most / WINDOWS));
  const steps = number.slice(1).map((value, at) => value - number[at]).sort((a, b) => a - b);
  const [step, all] = [quantile(steps, 0.5), t_s.length];
  if (all < length) return null;
  const rate = (number.at(-1) - number[0]) / step / (t_s.at(-1) - t_s[0]);
  const stride = length / OVERLAP;
  const turn = Float64Array.from({ length }, (_, at) => Math.cos((2 * Math.PI * at) / length));
  const hann = turn.map((value) => 0.5 - 0.5 * value);
  const [re, im] = [new Float64Array(length), new Float64Array(length)];
  const none = Array(all).fill(0);
  const used = volts.filter((values) => values.some((value) => value !== null));
  const found = { t_s: [], db: [], bins: length / 2, bin_hz: rate / length, length_s: length / rate, stride_s: stride / rate };
  // Volts to millivolts, and the mean of the window.
  const scale = 1e6 * (2 / length) ** 2;
  // Whole strides of the board's numbers: columns stay as they are while frames come and go.
  const first = number.findIndex((value) => Math.floor(value / step) % stride === 0);
  for (let from = first; from >= 0 && from + length <= all; from += stride) {
    found.t_s.push(0.5 * (t_s[from] + t_s[from + length - 1]));
    const isWhole = number[from + length - 1] - number[from] === (length - 1) * step;
    if (!isWhole) {
      found.db.push(null);
      continue;
    }
    const power = new Float64Array(found.bins);
    // Two channels at once, as the parts of complex numbers: the powers at k and -k add up to those of both.
    for (let channel = 0; channel < used.length; channel += 2) {
      take(used[channel], from, re, hann);
      take(used[channel + 1] ?? none, from, im, hann);
      transform(re, im, turn);
      for (let k = 1; k < power.length; k += 1) power[k] += re[k] ** 2 + im[k] ** 2 + re[length - k] ** 2 + im[length - k] ** 2;
    }
    found.db.push(power.map((value) => 10 * Math.log10(scale * value + Number.MIN_VALUE)));
  }
  return found.t_s.length ? found : null;
}

// The strongest line, between its bins by the parabola of the decibels.
function strongest(db) {
  const at = db.reduce((best, value, k) => (k >= FIRST && value > db[best] ? k : best), FIRST);
  const [before, top, after] = [db[at - 1], db[at], db[at + 1] ?? db[at - 1]];
  const bend = before - 2 * top + after;
  return at + (at > FIRST && bend < 0 ? (0.5 * (before - after)) / bend : 0);
}

export class Spectrogram extends Plot {
  constructor(card, onZoom) {
    const shown = { found: null, top: 0, isLog: true, range: [0, 1] };
    const toY = (hz) => (shown.isLog ? Math.log10(hz) : hz);
    super(card, onZoom, {
      x: "device time, s", y: "frequency, Hz", units: ["s", "Hz"],
      series: [dots(() => colour("text"), 3, { name: "strongest" })],
      yRange: () => shown.range,
      yAxis: {
        splits: (u, axis, min, max, increment) => {
          if (shown.isLog) return places([min, max], () => (LINE * (max - min) * window.devicePixelRatio) / u.bbox.height);
          return Array.from({ length: Math.floor(max / increment) + 1 }, (_, at) => at * increment).filter((hz) => hz >= min);
        },
        values: (_, splits) => splits.map((split) => label(shown.isLog ? 10 ** split : split)),
      },
      below: [(u) => paint(u, shown, toY)],
    });
    [this.shown, this.toY] = [shown, toY];
  }

  // Gives whether there are frames enough.
  draw({ live: { strips }, frames_most: most }, isLog) {
    const found = windows(strips, most);
    if (found === null) return false;
    const { bins, bin_hz, db } = found;
    const cells = db.flatMap((column) => (column === null ? [] : [...column.slice(FIRST)])).sort((a, b) => a - b);
    Object.assign(this.shown, { found, isLog, top: cells.length ? quantile(cells, STRONGEST) : 0 });
    const end_hz = bins * bin_hz;
    this.shown.range = [isLog ? this.toY((FIRST - 0.5) * bin_hz) : 0, this.toY(end_hz)];
    this.hz = db.map((column) => (column === null ? null : bin_hz * strongest(column)));
    this.show([found.t_s, this.hz.map((hz) => (hz === null ? null : this.toY(hz)))], `up to ${label(Number(end_hz.toPrecision(4)))} Hz`);
    return true;
  }

  measured(series, at) {
    return { y: this.hz[at] };
  }

  // What is drawn, in words.
  words() {
    return `Windows of ${Number(this.shown.found.length_s.toPrecision(2))} s; colour fades ${RANGE_DB} dB below the strongest.`;
  }
}

function paint(u, { found, top }, toY) {
  if (found === null) return;
  const { left, top: above, width, height } = u.bbox;
  const { t_s, db, bins, bin_hz, stride_s } = found;
  u.ctx.save();
  u.ctx.beginPath();
  u.ctx.rect(left, above, width, height);
  u.ctx.clip();
  u.ctx.fillStyle = colour("accent");
  const edges = Array.from({ length: bins + 1 }, (_, k) => Math.round(u.valToPos(toY(Math.max(k - 0.5, 0.01) * bin_hz), "y", true)));
  db.forEach((column, at) => {
    if (column === null) return;
    // Neighbours share their edge.
    const ends = [0.5 * ((t_s[at - 1] ?? t_s[at] - stride_s) + t_s[at]), 0.5 * (t_s[at] + (t_s[at + 1] ?? t_s[at] + stride_s))];
    const [from, until] = ends.map((x) => Math.round(u.valToPos(x, "x", true)));
    for (let k = FIRST; k < bins; k += 1) {
      const share = 1 + (column[k] - top) / RANGE_DB;
      if (share <= 0) continue;
      u.ctx.globalAlpha = Math.min(1, share);
      u.ctx.fillRect(from, edges[k + 1], until - from, edges[k] - edges[k + 1]);
    }
  });
  u.ctx.restore();
}
