// The sixteen channels over time, one below another.
import { Plot, colour, line, robust } from "./plot.js";
import { round125 } from "./format.js";

const TAXELS = 16;
// Quantile of the channels' ranges that sets the distance of the rows: the three widest of sixteen may reach into their
// neighbours' rows.
const SWING = 0.75;
// Frames more than this many usual steps apart are separated by a gap.
const GAP = 1.5;
// The distance shrinks only if the rows would fit into this fraction of it.
const SLACK = 0.6;

// Returns the indices of the frames before which frames are missing.
function gaps(t_s) {
  const steps = t_s.slice(1).map((time_s, at) => time_s - t_s[at]);
  const usual = steps.toSorted((a, b) => a - b)[Math.floor(steps.length / 2)];
  return steps.flatMap((step, at) => (step > GAP * usual ? [at + 1] : []));
}

const unit = (taxel) => `unit${Math.floor(taxel / 4)}`;
const middle = (values) => {
  const known = values.filter((value) => value !== null);
  return known.length ? known.reduce((a, b) => a + b, 0) / known.length : 0;
};

export class Strips extends Plot {
  constructor(card, onZoom) {
    const apart = { mv: 1 };
    const series = Array.from({ length: TAXELS }, (_, taxel) => line(() => colour(unit(taxel)), { width: 1.25, name: `taxel ${taxel}` }));
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
    const parts = strips.volts.map((values) => values.slice(from).map((value) => (value === null ? null : 1e3 * value)));
    this.zeros = parts.map(middle);
    const mv = parts.map((values, row) => values.map((value) => (value === null ? null : value - this.zeros[row])));
    const swings = mv.map((values) => robust(values)).map((range) => (range ? range[1] - range[0] : 0)).sort((a, b) => a - b);
    const wanted = Math.max(0.02, 0.6 * swings[Math.floor(SWING * swings.length)]);
    if (wanted > this.apart.mv || wanted < SLACK * 0.5 * this.apart.mv) this.apart.mv = round125(wanted);
    const rows = `rows ${this.apart.mv} mV apart`;
    this.plot.axes[1].label = `taxel, ${rows}`;
    const lines = mv.map((values, taxel) => values.map((value) => (value === null ? null : value - taxel * this.apart.mv)));
    const missing = gaps(t_s).toReversed();
    const apart = [t_s, ...lines].map((values) => values.slice());
    // Insert an empty point into each gap, from the last gap on, so that the indices stay valid.
    for (const at of missing) apart.forEach((values, column) => values.splice(at, 0, column === 0 ? 0.5 * (t_s[at - 1] + t_s[at]) : null));
    this.show(apart, rows);
  }

  measured(series, at) {
    const row = series - 1;
    return { y: this.data[series][at] + row * this.apart.mv + this.zeros[row] };
  }
}
