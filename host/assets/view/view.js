// The page: receives the command's messages and shows them, or a run, unless it is paused.
import { Model, Pace } from "./model.js";
import { drawMap, drawPlots } from "./draw.js";
import { Fit } from "./fit.js";
import { History } from "./history.js";
import { Spectrum } from "./spectrum.js";
import { Strips } from "./strips.js";
import { Recording } from "./recording.js";
import { Scrub } from "./scrub.js";
import * as panels from "./panels.js";
import * as ports from "./ports.js";
import * as runs from "./runs.js";
import * as save from "./save.js";
import * as settings from "./settings.js";

const $ = (id) => document.getElementById(id);
// Elements that handle keys themselves.
const OWN_KEYS = ["BUTTON", "SELECT", "INPUT", "A"];
// Pace below which an emulated board is reported as slow.
const SLOW = 0.95;
const EMULATED = "emulated board";
const model = new Model();
// The state when the page was paused.
let paused = null;
let isConnected = false;
let isDue = false;
let source = null;
let pace = new Pace();
// True once the file of a command without a board was shown.
let hasLooked = false;

const zoomed = () => scrub.run === null && pause(true);
const plots = {
  strips: new Strips($("strips"), zoomed),
  history: new History($("history"), zoomed),
  spectrum: new Spectrum($("spectrum"), zoomed),
  fit: new Fit($("fit"), zoomed),
};
const mapCanvas = $("map").querySelector("canvas");
const recording = new Recording();
const scrub = new Scrub(() => {
  list.list();
  drawAll();
});
// Shows a run, or goes back to the live board if `run` is null.
function look(run) {
  Object.values(plots).forEach((plot) => plot.clear());
  return Promise.all([recording.look(run), scrub.look(run)]);
}
const list = runs.begin({ look, changed: () => drawAll(), shown: () => scrub.run });

const shown = () => (scrub.run === null ? paused ?? model : scrub.model ?? model);

function pause(wanted) {
  if (wanted === (paused !== null)) return;
  paused = wanted && model.state !== null ? model.frozen() : null;
  $("pause").textContent = paused === null ? "Pause" : "Resume";
  $("pause").setAttribute("aria-pressed", String(paused !== null));
  document.body.classList.toggle("paused", paused !== null);
  schedule();
}

// Draws once, at the browser's next frame.
function schedule() {
  if (isDue) return;
  isDue = true;
  requestAnimationFrame(() => {
    isDue = false;
    // Do not redraw the plots while a run is shown, or while the page is paused, as after zooming.
    draw(paused === null && scrub.run === null);
  });
}

const drawAll = () => draw(true);

// Shows the file if the command has no board.
function lookAtFile({ live }) {
  const isAlone = live.connection.state === "over" && live.counts.received === 0;
  document.body.classList.toggle("alone", isAlone);
  $("live").hidden = isAlone || scrub.run === null;
  if (!isAlone || hasLooked || runs.first() === null) return;
  hasLooked = true;
  runs.say(runs.first().remark ?? "");
  look(runs.first());
}

function showStatus({ state }) {
  // Without the command, nothing can be requested from it, and what is shown is old.
  document.body.classList.toggle("gone", !isConnected);
  for (const id of ["clear", "record", "latest"]) $(id).disabled = !isConnected;
  for (const id of ["runs", "settings"]) $(id).inert = !isConnected;
  const status = scrub.run === null ? state.status : `This is ${scrub.run.name}.`;
  $("status").textContent = isConnected ? status : "The command cannot be reached: it has ended, or is being restarted. Trying again every second.";
  // An emulated board takes a while to start.
  const waits = ["disconnected", "waiting"].includes(state.live.connection.state) && state.live.source !== EMULATED;
  $("status").classList.toggle("alarm", !isConnected || waits);
}

function draw(withPlots) {
  if (model.state === null) return;
  runs.showRecording(model.state);
  lookAtFile(model.state);
  const found = shown();
  showStatus(scrub.run === null ? model : found);
  const { state } = found;
  const { live } = state;
  const { run } = scrub;
  document.title = `Ridgetone · ${live.source}`;
  $("source").textContent = [live.source + slowness(), ...(live.now_s === null ? [] : [`${live.now_s.toFixed(1)} s`])].join(", ");
  $("version").textContent = `Ridgetone ${state.version}.`;
  $("pause").hidden = run !== null;
  document.body.classList.toggle("looking", run !== null);
  document.body.classList.toggle("table", run?.is_table ?? false);
  const why = run?.why_none ?? undefined;
  panels.tiles(state, why);
  panels.health(found);
  panels.log(live);
  settings.show(run === null ? state : { ...state, can_set: run.frames > 0 && Boolean(live.latest.hello) }, run);
  drawMap(mapCanvas, state);
  if (!withPlots || run?.is_table) return;
  drawPlots(plots, state, { beside: compared(run, live), why });
}

// Reports the pace of a slow emulated board; otherwise a slow computer would look like a slow
// finger.
function slowness() {
  const { source: name, now_s } = model.state.live;
  const found = scrub.run === null && name === EMULATED && now_s !== null ? pace.take(1e-3 * performance.now(), now_s) : null;
  return found !== null && found < SLOW ? ` (${found.toFixed(2)} of real time)` : "";
}

// Returns the run to compare with, shifted so that the first contacts of both runs coincide. Next
// to a live board, its end is shifted to the present.
function compared(run, live) {
  const beside = runs.compared();
  $("difference").textContent = beside === null ? "" : runs.difference(run, beside.run);
  if (beside === null || beside.run.id === run?.id) return null;
  const [a, b] = [run?.contact_s ?? null, beside.run.contact_s];
  const shift_s = run !== null && a !== null && b !== null ? a - b : (live.now_s ?? 0) - beside.run.until_s;
  return { state: beside.state, shift_s };
}

function connect() {
  source?.close();
  pace = new Pace();
  source = new EventSource("/events");
  const on = (take) => (event) => {
    isConnected = true;
    take(JSON.parse(event.data));
    schedule();
  };
  source.addEventListener("state", on((message) => model.begin(message)));
  source.addEventListener("update", on((message) => model.add(message)));
  source.addEventListener("error", (event) => {
    isConnected = false;
    schedule();
    // The browser recovers from most errors by itself.
    if (event.target.readyState === EventSource.CLOSED && event.target === source) setTimeout(connect, 1000);
  });
}

$("pause").addEventListener("click", () => pause(paused === null));
document.addEventListener("keydown", (event) => {
  // A slider does not use the space bar.
  const { tagName, type } = event.target;
  const hasOwn = OWN_KEYS.includes(tagName) && ((event.key === " " && type !== "range") || ["number", "text"].includes(type));
  if (hasOwn || event.ctrlKey || event.metaKey || event.altKey || event.defaultPrevented) return;
  if (!scrub.key(event.key)) {
    if (event.key !== " ") return;
    pause(paused === null);
  }
  event.preventDefault();
});
for (const select of document.querySelectorAll("select")) {
  select.addEventListener("change", () => {
    plots[select.closest(".card")?.dataset.name]?.reset();
    drawAll();
  });
}
for (let taxel = 0; taxel < 16; taxel += 1) $("taxel").add(new Option(String(taxel)));
for (const button of document.querySelectorAll("[data-save]")) {
  button.addEventListener("click", () => {
    const { state } = shown();
    if (state === null) return;
    const card = button.closest(".card");
    const what = card.dataset.name;
    if (button.dataset.save === "csv") save.csv(what, state, plots[what]);
    else save.png(what, card.querySelector("h2").textContent, plots[what]?.canvas() ?? mapCanvas, state.live);
  });
}
$("live").addEventListener("click", () => look(null));
ports.begin(() => look(null));
const redraw = () => {
  Object.values(plots).forEach((plot) => plot.plot.redraw(false, true));
  recording.plot?.plot.redraw(false, true);
  schedule();
};
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", redraw);
new ResizeObserver(schedule).observe($("map"));
// A hidden page closes its connection, so that an emulated board can pause.
document.addEventListener("visibilitychange", () => (document.hidden ? source?.close() : connect()));
settings.begin(async (wanted) => {
  if (scrub.run === null) return settings.post("/settings", wanted);
  const found = JSON.parse(await settings.post(`/runs/${scrub.run.id}/settings`, wanted));
  Object.assign(scrub.run, found);
  list.update(found);
  await scrub.go(scrub.t_s);
  return found.why_none === null ? "These are this run's estimates with the new settings." : `No window has an estimate: ${found.why_none}.`;
});
connect();
