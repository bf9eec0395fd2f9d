// What a finger feels: bars of the receptors, scales of the scores, and the spectrum under the thresholds.
import { withSigma, words } from "./format.js";
import { Plot, Steady, colour, dots, line } from "./plot.js";
import { numbered } from "./spectrum.js";

// Ends of the scores' scale.
const SCALE = [1, 7];
// What the axis shows at least, decibels: the lowest threshold is -27 dB, the highest 59 dB. And at most: what is lower is
// far below every threshold.
const LEVELS_DB = [-40, 60];
const LEVEL_LEAST_DB = -80;
const STEP_DB = 20;
// Colours and dashes of the thresholds, so that the colour is not needed.
const LOOKS = [["unit0", []], ["unit1", [8, 4]], ["unit2", [2, 4]], ["unit3", [10, 4, 2, 4]]];

const shares = (low, high) => [low, high].map((share) => Math.min(1, Math.max(0, share)));
const percent = (share) => `${(100 * share).toFixed(1)}%`;

const measured = (value, sigma) => withSigma(value, sigma, "").trim();

export class FeelPanel extends Plot {
  constructor(card, onZoom) {
    const shown = { thresholds: [], range: LEVELS_DB };
    super(card, onZoom, {
      x: "frequency, Hz, logarithmic", y: "dB over 1 µm", units: ["Hz", "dB"], real: (x) => 10 ** x,
      series: [
        dots(() => colour("text"), 6, { name: "strongest line" }),
        ...LOOKS.map(([name, dash]) => line(() => colour(name), { dash, spanGaps: true, width: 2, name: "threshold" })),
      ],
      yRange: () => shown.range,
      xAxis: { splits: (u, axis, min, max) => numbered(u, min, max), values: (_, splits) => splits.map((split) => String(Number(this.real(split).toPrecision(6)))) },
      draw: [(u) => paintNames(u, shown.thresholds)],
    });
    [this.shown, this.steady] = [shown, new Steady()];
  }

  draw({ live: { latest: { feel } }, thresholds }) {
    const columns = 1 + thresholds.length;
    // A row for each band, and one for each end of a threshold's two lines.
    const row = (hz, column, db) => [Math.log10(hz), ...Array.from({ length: columns }, (_, at) => (at === column ? db : null))];
    const rows = [
      ...feel.spectrum.map(({ hz, level_db: db }) => row(hz, 0, db)),
      ...thresholds.flatMap(({ hz, level_db: db }, at) => hz.map((x, end) => row(x, 1 + at, db[end]))),
    ].sort((a, b) => a[0] - b[0]);
    const levels = feel.spectrum.map(({ level_db: db }) => db);
    const [least, most] = [Math.min(LEVELS_DB[0], ...levels), Math.max(LEVELS_DB[1], ...levels)];
    const rounded = [Math.max(LEVEL_LEAST_DB, STEP_DB * Math.floor(least / STEP_DB)), STEP_DB * Math.ceil(most / STEP_DB)];
    [this.shown.thresholds, this.shown.range] = [thresholds, this.steady.take(rounded)];
    this.show(Array.from({ length: 1 + columns }, (_, at) => rows.map((found) => found[at])), `from ${this.shown.range[0]} to ${this.shown.range[1]} dB`);
  }

  // The window in words.
  static words({ window_s: s, rate_hz: hz, taxels, m, m_sigma: sigma, faults }) {
    const count = taxels.toString(2).replaceAll("0", "").length;
    const parts = [`${s.toFixed(2)} s at ${hz.toFixed(0)} Hz`, `${count} taxels`, m === null ? "M not known" : `M ${measured(m, sigma)}`];
    if (faults.length) parts.push(`faults: ${faults.map(words).join(", ")}`);
    return parts.join(" · ");
  }

  // Bars and scales; what is absent has its reason and neither.
  static bars(list, { live: { latest: { feel } }, thresholds }) {
    const text = JSON.stringify(feel);
    if (list.dataset.text === text) return;
    list.dataset.text = text;
    if (!feel) return list.replaceChildren();
    const most = Math.max(0, ...feel.receptors.map(({ intensity_per_hz: value, intensity_per_hz_sigma: sigma }) => (value ?? 0) + (sigma ?? 0)));
    const receptors = feel.receptors.map(({ receptor, intensity_per_hz: value, intensity_per_hz_sigma: sigma, absent }) => {
      const at = (x) => (most > 0 ? x / most : 0);
      const { name } = thresholds.find((threshold) => threshold.receptor === receptor);
      return row(name, value, sigma, absent, () => track("bar", [["fill", 0, at(value)], ["spread", at(value - sigma), at(value + sigma)]]));
    });
    const at = (x) => (x - SCALE[0]) / (SCALE[1] - SCALE[0]);
    const scores = feel.scores.map(({ name, score, score_sigma: sigma, absent }) =>
      row(name, score, sigma, absent, () => track("scale", [["spread", at(score - sigma), at(score + sigma)], ["mark", at(score), null]])));
    list.replaceChildren(...receptors, ...scores);
  }
}

function row(name, value, sigma, absent, drawing) {
  const found = document.createElement("div");
  const [term, detail] = [document.createElement("dt"), document.createElement("dd")];
  term.textContent = name;
  const isThere = value !== null && value !== undefined;
  detail.textContent = isThere ? measured(value, sigma) : absent ?? "not known";
  found.append(term, detail);
  if (isThere) found.append(drawing());
  else found.className = "absent";
  return found;
}

// A drawing beside its number, which says all of it. Parts: a class, from, to; without `to` a mark.
function track(kind, parts) {
  const found = document.createElement("dd");
  found.className = `track ${kind}`;
  found.setAttribute("aria-hidden", "true");
  for (const [name, from, until] of parts) {
    const part = document.createElement("i");
    const [low, high] = shares(from, until ?? from);
    part.className = name;
    part.style.left = percent(low);
    if (until !== null) part.style.width = percent(high - low);
    found.append(part);
  }
  return found;
}

// Each threshold's name at its lowest place.
function paintNames(u, thresholds) {
  const scale = window.devicePixelRatio;
  u.ctx.save();
  u.ctx.font = `600 ${12 * scale}px system-ui`;
  u.ctx.textAlign = "center";
  thresholds.forEach(({ name, hz, level_db: db }, at) => {
    const lowest = db.indexOf(Math.min(...db));
    const [x, y] = [u.valToPos(Math.log10(hz[lowest]), "x", true), u.valToPos(db[lowest], "y", true)];
    const { left, top, width, height } = u.bbox;
    if (x < left || x > left + width || y < top || y > top + height) return;
    u.ctx.fillStyle = colour(LOOKS[at][0]);
    u.ctx.fillText(name, x, y + 14 * scale);
  });
  u.ctx.restore();
}
