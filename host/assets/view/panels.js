// Everything except the plots: the tiles, the static image, the board's health, and the log.
import { PHASES, seconds, withSigma, words } from "./format.js";
import { colour } from "./plot.js";

const $ = (id) => document.getElementById(id);
const put = (id, text) => {
  const element = $(id);
  if (element.textContent !== text) element.textContent = text;
};
const sum = (values) => values.reduce((a, b) => a + b, 0);

// Returns the frequency of an estimate with its uncertainty; null without a tone.
const tone = (estimate) => {
  if (estimate.frequency_hz !== undefined && estimate.frequency_hz !== null) {
    return withSigma(estimate.frequency_hz, estimate.sigma_hz, "Hz");
  }
  return null;
};

// `why`: reason why there is no estimate.
export function tiles({ live, remarks }, why = "no estimate yet") {
  const { estimate, whole_slide: whole, health } = live.latest;
  put("frequency", (estimate && tone(estimate)) ?? "none");
  const parts = [];
  // Show an estimate until the next one arrives, even during a new touch.
  const isPast = Boolean(estimate) && live.contact_s !== null && estimate.t_s < live.contact_s;
  for (const id of ["frequency", "period", "speed"]) $(id).classList.toggle("past", isPast);
  if (estimate) {
    if (isPast) parts.push("of the touch before");
    parts.push(words(estimate.status), ...remarks, `${estimate.span} of ${seconds(estimate.window_s)}, ending at ${seconds(estimate.t_s)}`);
    if (estimate.faults.length) parts.push(`faults: ${estimate.faults.map(words).join(", ")}`);
    if (whole && estimate.span !== "slide" && tone(whole)) parts.push(`slide before: ${tone(whole)}`);
  } else parts.push(why);
  put("frequency-small", parts.join(" · "));
  $("frequency").classList.toggle("alarm", Boolean(estimate && tone(estimate)) && estimate.status !== "good");
  const known = estimate && estimate.spatial_period_mm !== null;
  const travel = estimate ? (estimate.travel === "nothing" ? "not known" : words(estimate.travel)) : "not known";
  put("period", known ? withSigma(estimate.spatial_period_mm, estimate.spatial_period_sigma_mm, "mm") : "none");
  put("period-small", isPast ? `of the touch before · ${travel}` : travel);
  put("speed", known ? withSigma(estimate.speed_mm_s, estimate.speed_sigma_mm_s, "mm/s") : "none");
  put("speed-small", isPast ? "of the touch before" : estimate?.direction ? `${estimate.direction} ${estimate.direction === "forward" ? "→" : "←"}` : travel);
  put("phase", PHASES[live.phase] ?? words(live.phase));
  const since = live.phase_since_s === null ? "" : `since ${seconds(live.phase_since_s)} · `;
  put("phase-small", `${since}${live.touches} ${live.touches === 1 ? "touch" : "touches"}`);
  const { missing, damaged } = live.counts;
  const board = health ? health.conversions_lost + health.overruns : 0; // Losses on the board also count.
  const lost = missing + board; // A damaged packet also counts as missing.
  put("lost", lost === 0 ? "nothing" : String(lost));
  put("lost-small", live.counts.received === 0 ? "" : lost + damaged === 0 ? `of ${live.counts.received} packets` : `${missing} packets, ${board} on the board; ${damaged} arrived damaged`);
  $("lost").classList.toggle("alarm", lost + damaged > 0);
}

export function health(model) {
  const { live } = model.state;
  const { health: latest, hello } = live.latest;
  const rows = [["faults now", live.faults.length ? live.faults.map(words).join(", ") : "none", live.faults.length > 0]];
  if (latest) {
    const counts = Object.entries(latest.faults).filter(([, count]) => count > 0).map(([kind, count]) => `${words(kind)} ${count}`);
    rows.push(
      ["faults seen", counts.length ? counts.join(", ") : "none", counts.length > 0],
      ["conversions lost", latest.conversions_lost, latest.conversions_lost > 0],
      ["conversions doubtful", latest.conversions_doubtful, latest.conversions_doubtful > 0],
      ["windows not fitted", latest.overruns, latest.overruns > 0],
      ["messages dropped", latest.messages_dropped, latest.messages_dropped > 0],
      ["raw frames not sent", latest.frames_thinned],
      ["chip restarts", latest.chip_restarts, latest.chip_restarts > 0],
      ["requests damaged", latest.requests_damaged, latest.requests_damaged > 0],
      ["frame rate", `${latest.frame_rate_hz.toFixed(3)} Hz`],
      ["processor load", latest.load > 0 ? `${(100 * latest.load).toFixed(1)} %` : "not measured"],
      ["supply, reference", `${latest.supply_v.toFixed(3)} V, ${latest.reference_v.toFixed(3)} V`],
      ["temperature", `${latest.temperature_c.toFixed(1)} °C`],
      ["offset, gain", `${(1e6 * latest.offset_v).toFixed(1)} µV, ${latest.gain.toFixed(5)}`],
      ["stack", latest.stack_bytes > 0 ? `${latest.stack_used_bytes} of ${latest.stack_bytes} bytes` : "not measured"],
    );
  } else rows.push(["the board's", "none yet"]);
  const { received, missing, damaged } = live.counts;
  rows.push(["packets received", received], ["packets missing", missing, missing > 0], ["packets damaged", damaged, damaged > 0]);
  rows.push(["restarts", live.restarts, live.restarts > 0], ["updates this page missed", model.missed, model.missed > 0]);
  if (hello) rows.push(["firmware", `${hello.version}, settings ${hello.settings_source}, last reset: ${words(hello.reset_cause)}`]);
  const text = JSON.stringify(rows);
  const list = $("readings");
  if (list.dataset.text === text) return;
  list.dataset.text = text;
  list.replaceChildren(...rows.map(([name, value, wrong]) => {
    const row = document.createElement("div");
    const term = document.createElement("dt");
    const detail = document.createElement("dd");
    [term.textContent, detail.textContent] = [name, String(value)];
    detail.classList.toggle("alarm", Boolean(wrong));
    row.append(term, detail);
    return row;
  }));
}

export function log({ log: lines }) {
  const list = $("lines");
  const text = lines.join("\n");
  if (list.dataset.text === text) return;
  list.dataset.text = text;
  list.replaceChildren(...lines.toReversed().map((line) => {
    const item = document.createElement("li");
    item.textContent = line;
    return item;
  }));
}

// Returns the latest static image and its rows of taxels; null without one.
export function image({ live, places }) {
  const latest = live.latest.image_after ?? live.latest.image_before;
  if (!latest) return null;
  const level = new Map(latest.taxels.map((taxel) => [taxel.taxel, taxel]));
  return { image: latest, rows: places.map((row) => row.map((taxel) => ({ taxel, ...(level.get(taxel) ?? { level_v: null, sigma_v: null }) }))) };
}

// Draws the static image. The sign is also written, so that colour is not needed.
export function map(canvas, found) {
  const box = canvas.parentElement;
  const scale = window.devicePixelRatio;
  const side = Math.max(160, Math.min(box.clientWidth, box.clientHeight));
  if (canvas.width !== Math.round(side * scale)) {
    canvas.width = canvas.height = Math.round(side * scale);
    canvas.style.width = canvas.style.height = `${side}px`;
  }
  const context = canvas.getContext("2d");
  context.setTransform(scale, 0, 0, scale, 0, 0);
  context.clearRect(0, 0, side, side);
  const max = Math.max(1e-6, ...found.rows.flat().map(({ level_v: level }) => Math.abs(level ?? 0)));
  const [cell, gap] = [side / 4, 2];
  const text = colour("text");
  context.textAlign = "center";
  context.textBaseline = "middle";
  found.rows.forEach((row, y) => row.forEach(({ taxel, level_v: level }, x) => {
    const [left, top] = [x * cell + gap, y * cell + gap];
    context.globalAlpha = 1;
    context.fillStyle = colour("cell");
    context.fillRect(left, top, cell - 2 * gap, cell - 2 * gap);
    context.globalAlpha = level === null ? 0 : 0.75 * Math.abs(level) / max;
    context.fillStyle = colour(level < 0 ? "negative" : "positive");
    context.fillRect(left, top, cell - 2 * gap, cell - 2 * gap);
    context.globalAlpha = 1;
    context.fillStyle = text;
    context.font = `600 ${Math.round(cell / 5.5)}px system-ui`;
    context.fillText(level === null ? "dead" : `${level < 0 ? "−" : "+"}${Math.abs(1e3 * level).toFixed(2)}`, left + cell / 2 - gap, top + cell / 2);
    context.font = `${Math.round(cell / 7.5)}px system-ui`;
    context.fillText(`${taxel}`, left + cell / 2 - gap, top + cell * 0.8);
  }));
  const spoken = found.rows.map((row) => row.map(({ level_v: level }) => (level === null ? "dead" : (1e3 * level).toFixed(2))).join(", "));
  canvas.setAttribute("aria-label", `4 x 4 map, millivolts, row by row: ${spoken.join("; ")}`);
}
