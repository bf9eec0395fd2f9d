// Pictures and tables of what is shown.
import { colour } from "./plots.js";
import { image } from "./panels.js";

const PIXELS_TITLE = 28;

function download(name, blob) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}

const named = (what, live, ending) => `ridgetone-${what}-${(live.now_s ?? 0).toFixed(1)}s.${ending}`;

// A plot as a picture, with its title and a background.
export function png(what, title, canvas, live) {
  const scale = window.devicePixelRatio;
  const picture = document.createElement("canvas");
  const top = PIXELS_TITLE * scale;
  [picture.width, picture.height] = [canvas.width, canvas.height + top];
  const context = picture.getContext("2d");
  context.fillStyle = colour("card");
  context.fillRect(0, 0, picture.width, picture.height);
  context.fillStyle = colour("text");
  context.font = `600 ${14 * scale}px system-ui`;
  context.textBaseline = "middle";
  context.fillText(`${title} · ${live.source} · ${(live.now_s ?? 0).toFixed(2)} s`, 10 * scale, top / 2, picture.width - 20 * scale);
  context.drawImage(canvas, 0, top);
  picture.toBlob((blob) => download(named(what, live, "png"), blob));
}

const cell = (value) => {
  if (value === null || value === undefined) return "";
  const text = String(value);
  return /[",\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
};
const table = (header, rows) => `${[header, ...rows].map((row) => row.map(cell).join(",")).join("\n")}\n`;

// Rows of a plot that its zoom shows; all of them without one.
const inSight = (plot, x) => {
  const { min, max } = plot.plot.scales.x;
  return !(x < min || x > max);
};

const TABLES = {
  // As `ridgetone fit` and `ridgetone replay` read it.
  strips({ live: { strips } }, plot) {
    const header = ["time_s", ...strips.volts.map((_, taxel) => `ain${taxel}`)];
    const frames = strips.t_s.map((t_s, frame) => [t_s, ...strips.volts.map((values) => values[frame])]);
    return table(header, frames.filter(([t_s]) => inSight(plot, t_s)));
  },
  history({ live: { history } }, plot) {
    const header = Object.keys(history[0] ?? { t_s: 0 });
    return table(header, history.filter((point) => inSight(plot, point.t_s)).map((point) => header.map((name) => point[name])));
  },
  spectrum(_, plot) {
    const [hz, db] = plot.data ?? [[], []];
    return table(["frequency_hz", "power_db"], hz.map((value, bin) => [value, db[bin]]).filter(([value]) => inSight(plot, value)));
  },
  fit(_, plot) {
    const [t_s, read, fitted] = plot.data ?? [[], [], []];
    return table(["t_s", "read_mv", "fitted_mv"], t_s.map((value, at) => [value, read[at], fitted[at]]).filter(([value]) => inSight(plot, value)));
  },
  map(state) {
    const found = image(state);
    const rows = found === null ? [] : found.rows.flatMap((row, y) => row.map(({ taxel, level_v, sigma_v }, x) => [y, x, taxel, level_v, sigma_v]));
    return table(["row", "column", "taxel", "level_v", "sigma_v"], rows);
  },
};

export function csv(what, state, plot) {
  download(named(what, state.live, "csv"), new Blob([TABLES[what](state, plot)], { type: "text/csv" }));
}
