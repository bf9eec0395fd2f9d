// The page: takes the messages of the command, and shows them unless it is paused.
import { Model } from "./model.js";
import { drawMap, drawPlots } from "./draw.js";
import { Fit } from "./fit.js";
import { History } from "./history.js";
import { Spectrum } from "./spectrum.js";
import { Strips } from "./strips.js";
import * as panels from "./panels.js";
import * as save from "./save.js";
import * as settings from "./settings.js";

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
  settings.show(state);
  drawMap(mapCanvas, state);
  // A zoomed plot stays as it is.
  if (paused === null) drawPlots(plots, state);
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
  if (event.key === " " && !["BUTTON", "SELECT", "INPUT"].includes(event.target.tagName)) {
    event.preventDefault();
    pause(paused === null);
  }
});
for (const select of document.querySelectorAll("select")) {
  select.addEventListener("change", () => {
    const { state } = paused ?? model;
    if (state !== null) drawPlots(plots, state);
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
settings.begin(() => "/settings");
connect();
