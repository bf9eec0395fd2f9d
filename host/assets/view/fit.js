// Readings of one taxel, the fit with all its harmonics, and the residual.
import { Plot, colour, dots, line, robust } from "./plot.js";
import { round125 } from "./format.js";

// Fraction of the plot's height for the residual, at the bottom.
const RESIDUAL = 0.28;

export class Fit extends Plot {
  constructor(card, onZoom) {
    const axis = { read: [-1, 1], residual_mv: 1 };
    super(card, onZoom, {
      x: "device time, s", y: "mV",
      series: [
        dots(() => colour("soft"), 4, { name: "as read" }), line(() => colour("accent"), { width: 2, name: "fit" }),
        line(() => colour("unit2"), { width: 1.5, dash: [4, 4], name: "f alone" }), dots(() => colour("unit1"), 3, { scale: "right", name: "residual" }),
      ],
      yRange: () => axis.read,
      right: {
        label: "residual, mV",
        range: () => [-1.2 * axis.residual_mv, 1.2 * axis.residual_mv * (2 / RESIDUAL - 1)],
        splits: () => [-axis.residual_mv, 0, axis.residual_mv],
      },
    });
    this.axis = axis;
  }

  draw({ curves }, taxel) {
    const mv = (values) => values?.map((value) => (value === null ? null : 1e3 * value)) ?? curves.t_s.map(() => null);
    const [read, fit, tone] = [curves.read_v, curves.fit_v, curves.tone_v].map((all) => mv(all[taxel]));
    const rest = read.map((value, at) => (value === null || fit[at] === null ? null : value - fit[at]));
    const [min, max] = robust([...(robust(read) ?? [0]), ...fit, ...tone], 0) ?? [-1, 1];
    const span = Math.max(1e-6, max - min);
    this.axis.read = [max + 0.05 * span - 1.1 * span / (1 - RESIDUAL), max + 0.05 * span];
    const [low, high] = robust(rest) ?? [-1, 1];
    this.axis.residual_mv = round125(Math.max(1e-6, -low, high));
    this.show([curves.t_s, read, fit, tone, rest], `taxel ${taxel}, residual within ${this.axis.residual_mv} mV`);
  }

  // Formats the amplitudes as text; empty if this taxel was not fitted.
  static words({ curves }, taxel) {
    const harmonics = curves?.harmonics[taxel];
    if (!harmonics) return "";
    const name = (at) => (at === 0 ? "f" : `${at + 1}f`);
    const parts = harmonics.map(({ amplitude_v: v }, at) => `${name(at)} ${(1e3 * v).toPrecision(3)}`);
    return `Taxel ${taxel}: ${parts.join(", ")} mV; residual ${(1e3 * curves.residual_v[taxel]).toPrecision(2)} mV rms.`;
  }
}
