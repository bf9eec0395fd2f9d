// Saves what is shown as pictures and tables.
import { colour } from "./plot.js";
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

// Saves a plot as a picture, with its title and a background.
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

const TABLES = {
  // The table that `ridgetone fit` and `ridgetone replay` read.
  strips({ live: { strips } }, plot) {
    const header = ["time_s", ...strips.volts.map((_, taxel) => `ain${taxel}`)];
    const frames = strips.t_s.map((t_s, frame) => [t_s, ...strips.volts.map((values) => values[frame])]);
    return table(header, frames.filter(([t_s]) => plot.shows(t_s)));
  },
  history({ live: { history } }, plot) {
    // Omit the fields that the page has added for drawing.
    const header = Object.keys(history[0] ?? { t_s: 0 }).filter((name) => !["frequency", "sigma", "channels"].includes(name));
    return table(header, history.filter((point) => plot.shows(point.t_s)).map((point) => header.map((name) => point[name])));
  },
  spectrum(_, plot) {
    const [x, db, rest] = plot.data ?? [[], [], []];
    const rows = x.map((value, bin) => [value, plot.real(value), db[bin], rest[bin]]).filter(([value]) => plot.shows(value));
    return table(["frequency_hz", "power_db", "rest_db"], rows.map(([, ...row]) => row));
  },
  fit(_, plot) {
    const [t_s, ...columns] = plot.data ?? [[]];
    const rows = t_s.map((value, at) => [value, ...columns.map((column) => column[at])]).filter(([value]) => plot.shows(value));
    return table(["t_s", "read_mv", "fitted_mv", "fundamental_mv", "residual_mv"], rows);
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
