// The frequency over time, with its uncertainty.
import { Plot, Steady, colour, dots, line, withoutWild } from "./plot.js";

// Minimum time between estimates, seconds, however short the stride.
const ESTIMATES_S = 0.05;
// Windows more than this many strides apart are separated by a pause.
const GAP = 2.5;
// Minimum height of the axis, as a fraction of the frequency: at a higher magnification, changes of
// a millionth would look like noise.
const MIN_FRACTION = 1e-4;
// Fraction of the estimates at each end that may lie beyond the axis.
const WILD = 0.08;

// Returns half the height of an estimate's band, limited so that a very uncertain estimate does not flatten the others.
const band = (point) => Math.min(point.sigma, 0.1 * point.frequency);

// Adds an empty point in every pause longer than `pause_s`, so that the points on either side are not joined.
const apart = (points, pause_s) => points.flatMap((point, at) => {
  const before = points[at - 1];
  return before && point.t_s - before.t_s > pause_s ? [{ t_s: 0.5 * (before.t_s + point.t_s) }, point] : [point];
});

export class History extends Plot {
  constructor(card, onZoom) {
    const edge = { stroke: "transparent", width: 0, points: { show: false } };
    const axis = { range: [0, 1] };
    super(card, onZoom, {
      x: "device time, s", y: "frequency, Hz", ySize: 76,
      series: [
        edge, edge, line(() => colour("accent")), dots(() => colour("accent"), 6, { name: "window" }), dots(() => colour("alarm"), 8, { name: "not good" }),
        dots(() => colour("text"), 10, { name: "whole slide" }), line(() => colour("other"), { name: "other run", dash: [5, 4], width: 2, points: { show: true, size: 5, fill: () => colour("other") } }),
      ],
      yAxis: { values: (_, splits) => splits.map((split) => String(Number(split.toPrecision(8)))) },
      yRange: () => axis.range,
    });
    this.axis = axis;
    this.steady = new Steady();
    this.plot.addBand({ series: [2, 1], fill: () => colour("band") });
  }

  // Scales the axis to all good estimates except wild ones, and to the latest one. Returns how many estimates are beyond it.
  scale(found) {
    const known = found.filter((point) => (point.frequency ?? null) !== null);
    if (!known.length) return 0;
    const good = known.filter((point) => point.status === "good");
    const wanted = good.length ? good : known;
    const [low, high] = withoutWild(wanted.map((point) => point.frequency), WILD);
    const latest = known.at(-1).frequency;
    const bands = good.filter(({ frequency }) => frequency >= low && frequency <= high);
    const ends = (sign) => bands.map((point) => point.frequency + sign * band(point));
    const [min, max] = [Math.min(low, latest, ...ends(-1)), Math.max(high, latest, ...ends(1))];
    const half = Math.max(0.65 * (max - min), 0.5 * MIN_FRACTION * max);
    const centre = 0.5 * (min + max);
    this.axis.range = this.steady.take([centre - half, centre + half]);
    const [from, to] = this.axis.range;
    return known.filter(({ frequency }) => frequency < from || frequency > to).length;
  }

  // `beside`: estimates of another run, shifted onto this one's time. Returns whether there is a frequency, and how many
  // estimates are beyond the axis.
  draw({ live: { history, now_s, latest } }, length_s, beside = []) {
    const found = history.filter((point) => point.t_s > (now_s ?? 0) - length_s);
    found.sort((a, b) => a.t_s - b.t_s);
    const beyond = this.scale([...beside, ...found]);
    const own = apart(found, GAP * Math.max(latest.hello?.settings.stride_s ?? 0.25, ESTIMATES_S));
    const shown = [...own, ...beside.map((point) => ({ ...point, beside: point.frequency, frequency: undefined }))].sort((a, b) => a.t_s - b.t_s);
    // In uPlot, null makes a gap and undefined no point at all. Windows that are not good make a gap, because their frequency
    // is uncertain.
    const windows = (value) => shown.map((point) => {
      if (point.span === "slide" || point.beside !== undefined) return undefined;
      return (point.frequency ?? null) === null || point.status !== "good" ? null : value(point);
    });
    const only = (want) => shown.map((point) => ((point.frequency ?? null) !== null && want(point) ? point.frequency : undefined));
    [this.shown, this.units] = [shown, ["s", "Hz"]];
    this.show([
      shown.map((point) => point.t_s),
      windows((point) => point.frequency - band(point)),
      windows((point) => point.frequency + band(point)),
      windows((point) => point.frequency),
      only((point) => point.span === "window" && point.status === "good"),
      only((point) => point.span === "window" && point.status !== "good"),
      only((point) => point.span === "slide"),
      shown.map((point) => point.beside),
    ], `from ${this.axis.range.map((end) => end.toPrecision(6)).join(" to ")}`);
    return { hasTone: found.some((point) => point.frequency !== null), beyond };
  }

  measured(series, at) {
    const { frequency, beside, sigma } = this.shown[at];
    return { y: frequency ?? beside, sigma };
  }
}
