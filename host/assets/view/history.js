// The frequency over time, with its uncertainty.
import { Plot, Steady, colour, dots, line, withoutWild } from "./plot.js";

// Estimates come no closer together than this, seconds, however short the stride.
const ESTIMATES_S = 0.05;
// Windows more than this many strides apart have a pause between them.
const GAP = 2.5;
// Least height, as a fraction of the frequency: magnified further, a millionth would look like noise.
const LEAST_SHARE = 1e-4;
// Fraction of the estimates at each end that may lie beyond the axis.
const WILD = 0.08;

// Half the height of the band around an estimate: what is hardly known must not flatten the others.
const band = (point) => Math.min(point.sigma, 0.1 * point.frequency);

// With an empty point in every pause that is longer: what is before it and behind it is not joined.
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

  // The axis shows all good estimates but wild ones, and the latest; gives how many of all are beyond it.
  scale(found) {
    const known = found.filter((point) => (point.frequency ?? null) !== null);
    if (!known.length) return 0;
    const good = known.filter((point) => point.status === "good");
    const wanted = good.length ? good : known;
    const [low, high] = withoutWild(wanted.map((point) => point.frequency), WILD);
    const latest = known.at(-1).frequency;
    const bands = good.filter(({ frequency }) => frequency >= low && frequency <= high);
    const ends = (sign) => bands.map((point) => point.frequency + sign * band(point));
    const [least, most] = [Math.min(low, latest, ...ends(-1)), Math.max(high, latest, ...ends(1))];
    const half = Math.max(0.65 * (most - least), 0.5 * LEAST_SHARE * most);
    const centre = 0.5 * (least + most);
    this.axis.range = this.steady.take([centre - half, centre + half]);
    const [from, to] = this.axis.range;
    return known.filter(({ frequency }) => frequency < from || frequency > to).length;
  }

  // `beside`: estimates of another run, shifted onto this one's time. Gives whether there is a frequency, and how many are
  // beyond the axis.
  draw({ live: { history, now_s, latest } }, length_s, beside = []) {
    const found = history.filter((point) => point.t_s > (now_s ?? 0) - length_s);
    found.sort((a, b) => a.t_s - b.t_s);
    const beyond = this.scale([...beside, ...found]);
    const own = apart(found, GAP * Math.max(latest.hello?.settings.stride_s ?? 0.25, ESTIMATES_S));
    const shown = [...own, ...beside.map((point) => ({ ...point, beside: point.frequency, frequency: undefined }))].sort((a, b) => a.t_s - b.t_s);
    // To the plot null is a gap, and undefined nothing at all.
    // Good windows are joined to good ones: what is between them is not known.
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
