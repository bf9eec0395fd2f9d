// The page: takes the messages of the command, and shows them unless it is paused.
import { Model } from "./model.js";
import { words } from "./format.js";
import { Fit, History, Spectrum, Strips } from "./plots.js";
import * as panels from "./panels.js";
import * as save from "./save.js";

const $ = (id) => document.getElementById(id);
const model = new Model();
// The state when the page was paused.
let paused = null;
let isConnected = false;
let isDue = false;

const zoomed = () => pause(true);
const plots = {
  strips: new Strips($("strips"), zoomed),
  history: new History($("history"), zoomed),
  spectrum: new Spectrum($("spectrum"), zoomed),
  fit: new Fit($("fit"), zoomed),
};
const mapCanvas = $("map").querySelector("canvas");

function pause(wanted) {
  if (wanted === (paused !== null)) return;
  paused = wanted && model.state !== null ? model.frozen() : null;
  $("pause").textContent = paused === null ? "Pause" : "Resume";
  $("pause").setAttribute("aria-pressed", String(paused !== null));
  document.body.classList.toggle("paused", paused !== null);
  schedule();
}

// Draws at the browser's next picture, once.
function schedule() {
  if (isDue) return;
  isDue = true;
  requestAnimationFrame(() => {
    isDue = false;
    draw();
  });
}

function showStatus() {
  const { state } = model;
  $("status").textContent = isConnected ? state.status : "The command cannot be reached: it has ended, or is being restarted. Trying again every second.";
  $("status").classList.toggle("alarm", !isConnected || ["disconnected", "waiting"].includes(state.live.connection.state));
}

function draw() {
  showStatus();
  const shown = paused ?? model;
  if (shown.state === null) return;
  const { state } = shown;
  const { live } = state;
  document.title = `Ridgetone · ${live.source}`;
  $("source").textContent = live.now_s === null ? live.source : `${live.source}, ${live.now_s.toFixed(1)} s`;
  $("version").textContent = `Ridgetone ${state.version}.`;
  panels.tiles(state);
  panels.health(shown);
  panels.log(live);
  drawMap(state);
  // A zoomed plot stays as it is.
  if (paused === null) drawPlots(state);
}

function drawMap(state) {
  const found = panels.image(state);
  const empty = $("map").querySelector(".empty");
  empty.hidden = found !== null;
  mapCanvas.hidden = found === null;
  if (found === null) {
    empty.textContent = "No static image yet: it comes when a hold, before a slide or after one, is over.";
    $("map-small").textContent = "";
    return;
  }
  $("map-small").textContent = `${words(found.image.hold)}, mV, x →`;
  panels.map(mapCanvas, found);
}

function drawPlots(state) {
  const { live } = state;
  const hasRaw = live.strips.t_s.length > 1;
  const noRaw = state.no_raw ?? "No raw frames yet.";
  if (hasRaw) plots.strips.draw(state, Number($("strips-s").value));
  plots.strips.explain(hasRaw ? "" : noRaw);
  const hasTone = plots.history.draw(state, Number($("history-s").value));
  plots.history.explain(hasTone ? "" : (live.history.length ? "No frequency in this time." : "No frequency yet: it takes a slide of a window's length."));
  const { estimate } = live.latest;
  const tone_hz = estimate?.frequency_hz ?? null;
  const { spectrum, curves } = state;
  if (spectrum) plots.spectrum.draw(state, spectrum.of_estimate ? tone_hz : null);
  plots.spectrum.explain(spectrum ? "" : hasRaw ? "Too few frames yet." : noRaw);
  $("spectrum-small").textContent = spectrum ? (spectrum.of_estimate ? "of the latest window" : "of the latest frames") : "";
  const taxel = chosen(estimate);
  const canFit = Boolean(curves) && taxel !== null;
  const channel = estimate?.channels.find((found) => found.taxel === taxel);
  $("fit-small").textContent = channel && tone_hz !== null
    ? `Taxel ${taxel}: ${(1e3 * channel.amplitude_v).toFixed(2)} mV, residual ${(1e3 * channel.residual_v).toFixed(2)} mV. ` : "";
  if (canFit) plots.fit.draw(state, taxel);
  plots.fit.explain(canFit ? "" : hasRaw ? noFit(estimate) : noRaw);
}

const noFit = (estimate) => {
  if (!estimate) return "No estimate yet.";
  if (estimate.abscissa === "place") return "By place there is no curve in time.";
  return estimate.frequency_hz === null ? `No tone to draw: ${words(estimate.status)}.` : "Its frames are no longer here.";
};

// The taxel to show: the one that was chosen, or the one whose tone is the strongest.
function chosen(estimate) {
  if ($("taxel").value !== "") return Number($("taxel").value);
  const channels = estimate?.channels ?? [];
  return channels.length ? channels.reduce((a, b) => (b.amplitude_v > a.amplitude_v ? b : a)).taxel : null;
}

function connect() {
  const source = new EventSource("/events");
  const on = (take) => (event) => {
    isConnected = true;
    take(JSON.parse(event.data));
    schedule();
  };
  source.addEventListener("state", on((message) => model.begin(message)));
  source.addEventListener("update", on((message) => model.add(message)));
  source.addEventListener("error", () => {
    isConnected = false;
    schedule();
    // The browser recovers from most errors by itself.
    if (source.readyState === EventSource.CLOSED) setTimeout(connect, 1000);
  });
}

$("pause").addEventListener("click", () => pause(paused === null));
document.addEventListener("keydown", (event) => {
  if (event.key === " " && !["BUTTON", "SELECT"].includes(event.target.tagName)) {
    event.preventDefault();
    pause(paused === null);
  }
});
for (const select of document.querySelectorAll("select")) {
  select.addEventListener("change", () => {
    const { state } = paused ?? model;
    if (state !== null) drawPlots(state);
  });
}
for (let taxel = 0; taxel < 16; taxel += 1) $("taxel").add(new Option(String(taxel)));
for (const button of document.querySelectorAll("[data-save]")) {
  button.addEventListener("click", () => {
    const { state } = paused ?? model;
    if (state === null) return;
    const card = button.closest(".card");
    const what = card.dataset.name;
    if (button.dataset.save === "csv") save.csv(what, state, plots[what]);
    else save.png(what, card.querySelector("h2").textContent, plots[what]?.canvas() ?? mapCanvas, state.live);
  });
}
const redraw = () => {
  Object.values(plots).forEach((plot) => plot.plot.redraw(false, true));
  schedule();
};
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", redraw);
new ResizeObserver(schedule).observe($("map"));
connect();
