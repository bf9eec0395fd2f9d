// Draws a state on the plots, or explains why there is nothing to draw.
import { words } from "./format.js";
import { Fit } from "./fit.js";
import * as panels from "./panels.js";

const $ = (id) => document.getElementById(id);

// `beside`: another run to compare with, as a state and its time shift in seconds; `why`: reason why a run has no estimate.
export function drawPlots(plots, state, { beside, why }) {
  const { live, spectrum, curves } = state;
  const hasRaw = live.strips.t_s.length > 1;
  const noRaw = state.no_raw ?? "No raw frames yet.";
  if (hasRaw) plots.strips.draw(state, Number($("strips-s").value));
  plots.strips.explain(hasRaw ? "" : noRaw);
  const others = beside === null ? [] : beside.state.live.history
    .filter((point) => (point.frequency ?? null) !== null && point.span === "window")
    .map((point) => ({ ...point, t_s: point.t_s + beside.shift_s }));
  const { hasTone, beyond } = plots.history.draw(state, Number($("history-s").value), others);
  plots.history.explain(hasTone ? "" : (live.history.length ? "No frequency in this time." : why ? `No frequency: ${why}.` : "No frequency yet: it takes a slide of a window's length."));
  for (const key of document.querySelectorAll("#history [data-drawn]")) {
    key.hidden = !plots.history.data?.[Number(key.dataset.drawn)].some((value) => (value ?? null) !== null);
  }
  $("history-small").textContent = beyond > 0 ? `${beyond} beyond the axis` : "";
  const isLog = $("spectrum-x").value === "log";
  if (spectrum) plots.spectrum.draw(state, isLog, beside?.state.spectrum ?? null);
  plots.spectrum.explain(spectrum ? "" : hasRaw ? "Too few frames yet." : noRaw);
  $("spectrum-small").textContent = spectrum ? aboutSpectrum(state) : "";
  drawFit(plots.fit, state, hasRaw ? "" : noRaw);
}

function aboutSpectrum({ spectrum: { of_estimate: ofEstimate, lines }, curves }) {
  const what = ofEstimate ? "Latest window" : "Latest frames";
  const dashed = lines.length ? " Dashed: f and its harmonics." : "";
  if (!lines.length || !curves?.residual_spectrum) return `${what}.${dashed}`;
  return `${what}: f is ${(lines[0].power_db - curves.residual_spectrum.noise_db).toFixed(0)} dB above the noise of its neighbourhood. Brown: residual.${dashed}`;
}

function drawFit(plot, state, noRaw) {
  const { live, curves } = state;
  const { estimate } = live.latest;
  const taxel = chosen(estimate);
  const canFit = Boolean(curves) && taxel !== null;
  $("fit-small").textContent = canFit ? `${Fit.words(state, taxel)} Dots: as read. Line: all harmonics. Green: f alone. Below: residual.` : "";
  if (canFit) plot.draw(state, taxel);
  plot.explain(canFit ? "" : noRaw || noFit(estimate));
}

const noFit = (estimate) => {
  if (!estimate) return "No estimate yet.";
  if ((estimate.frequency_hz ?? null) !== null) return "Its frames are no longer here.";
  return estimate.status === "no_tone" ? "The latest window has no tone." : `Nothing to draw: ${words(estimate.status)}.`;
};

// Returns the taxel to show: the chosen one, or the one with the strongest tone.
function chosen(estimate) {
  if ($("taxel").value !== "") return Number($("taxel").value);
  const channels = estimate?.channels ?? [];
  return channels.length ? channels.reduce((a, b) => (b.amplitude_v > a.amplitude_v ? b : a)).taxel : null;
}

export function drawMap(canvas, state) {
  const found = panels.image(state);
  const empty = $("map").querySelector(".empty");
  empty.hidden = found !== null;
  canvas.hidden = found === null;
  empty.textContent = found === null ? "No static image yet: it comes when a hold, before a slide or after one, is over." : "";
  $("map-small").textContent = found === null ? "" : `${words(found.image.hold)}, mV, x →`;
  if (found !== null) panels.map(canvas, found);
}
