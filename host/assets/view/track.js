// The frequency of windows over a recording, drawn over its spectrogram.
import { Plot, colour, dots, line } from "./plot.js";

// Half-width of a 95 % interval, standard deviations.
const INTERVAL = 1.96;
// A shade, 0 to 7, divided by this is its opacity, so even the darkest shade is translucent.
const SHADES = 9;

export class Track extends Plot {
  constructor(card, isDated) {
    const edge = { stroke: "transparent", width: 0, points: { show: false } };
    const axis = { max_hz: 1 };
    super(card, () => {}, {
      x: isDated ? "date" : "time, s", y: "frequency, Hz", ySize: 72, isDated, yRange: () => [0, axis.max_hz],
      series: [edge, edge, line(() => colour("accent"), { name: "" }), dots(() => colour("accent"), 6, { name: "window" }), dots(() => colour("alarm"), 7, { name: "not good" })],
      below: [(u) => this.shade(u)],
    });
    Object.assign(this, { axis, image: null, units: ["s", "Hz"] });
    this.plot.addBand({ series: [2, 1], fill: () => colour("band") });
  }

  draw({ points, spectrogram }) {
    this.spectrogram = spectrogram;
    this.axis.max_hz = spectrogram.max_hz;
    this.image = picture(spectrogram.levels);
    this.points = points;
    const good = ({ status, frequency_hz: hz }) => status === "good" && hz !== null;
    const only = (want, value) => points.map((point) => (want(point) ? value(point) : null));
    const hz = (point) => point.frequency_hz;
    this.show([
      points.map(({ from_s, to_s }) => 0.5 * (from_s + to_s)),
      only(good, (point) => hz(point) - INTERVAL * point.sigma_hz), only(good, (point) => hz(point) + INTERVAL * point.sigma_hz),
      only(good, hz), only(good, hz), only((point) => !good(point) && hz(point) !== null, hz),
    ]);
    this.plot.setScale("x", { min: spectrogram.from_s, max: spectrogram.until_s });
  }

  measured(_, at) {
    return { y: this.points[at].frequency_hz, sigma: this.points[at].sigma_hz };
  }

  shade(u) {
    if (!this.image) return;
    const { left, top, width, height } = u.bbox;
    const { from_s, until_s, max_hz } = this.spectrogram;
    const [x, right] = [from_s, until_s].map((t_s) => u.valToPos(t_s, "x", true));
    const [bottom, upper] = [0, max_hz].map((hz) => u.valToPos(hz, "y", true));
    u.ctx.save();
    u.ctx.beginPath();
    u.ctx.rect(left, top, width, height);
    u.ctx.clip();
    u.ctx.imageSmoothingEnabled = false;
    u.ctx.drawImage(this.image, x, upper, right - x, bottom - upper);
    u.ctx.restore();
  }
}

// Draws the shades as a picture of one pixel each, with the lowest frequency at the bottom.
function picture(levels) {
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [levels.length, levels[0].length];
  const context = canvas.getContext("2d");
  context.fillStyle = colour("soft");
  levels.forEach((column, x) => column.forEach((level, y) => {
    context.globalAlpha = level / SHADES;
    context.fillRect(x, canvas.height - 1 - y, 1, 1);
  }));
  return canvas;
}
