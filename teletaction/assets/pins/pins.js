// The page of `ridgetone pins`: three grids of shades, as the latest update has them.
const $ = (id) => document.getElementById(id);
const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();

// What passes for rest, as in the terminal: a strain, and newtons.
const REST_STRAIN = 5e-4;
const REST_N = 0.01;
// Columns from which on cells have no numbers.
const WIDE = 8;

let state = null;
let isConnected = false;
let isDue = false;

// Without the sign of a zero.
const number = (value) => value.toFixed(2).replace(/^-(?=[0.]*$)/, "");

// Values row by row; `most` has the strongest shade, and what is below 0 the other colour.
function grid(id, values, columns, most, scale) {
  const canvas = $(id).querySelector("canvas");
  const rows = values.length / columns;
  const side = Math.max(1, Math.round(canvas.clientWidth * devicePixelRatio));
  if (canvas.width !== side) canvas.width = canvas.height = side;
  const context = canvas.getContext("2d");
  context.clearRect(0, 0, side, side);
  const cell = side / Math.max(rows, columns);
  const gap = Math.max(1, cell / 40);
  context.textAlign = "center";
  context.textBaseline = "middle";
  context.font = `600 ${Math.round(cell / 4.5)}px system-ui`;
  values.forEach((value, n) => {
    const [left, top] = [(n % columns) * cell, Math.floor(n / columns) * cell];
    const fill = (name, alpha) => {
      context.globalAlpha = alpha;
      context.fillStyle = colour(name);
      context.fillRect(left + gap, top + gap, cell - 2 * gap, cell - 2 * gap);
      context.globalAlpha = 1;
    };
    fill("cell", 1);
    fill(value < 0 ? "negative" : "positive", 0.85 * Math.min(1, Math.abs(value) / most));
    if (columns >= WIDE) return;
    context.fillStyle = colour("text");
    context.fillText(number(scale * value), left + cell / 2, top + cell / 2);
  });
  canvas.setAttribute("aria-label", `${rows} rows of ${columns}: ${values.map((value) => number(scale * value)).join(", ")}`);
}

function show() {
  isDue = false;
  const text = isConnected ? state.status : "The command cannot be reached: it has ended, or is being restarted. Trying again every second.";
  if ($("status").textContent !== text) $("status").textContent = text;
  $("status").classList.toggle("alarm", !isConnected);
  if (state === null) return;
  $("source").textContent = state.source;
  const { update, gain, force_most_n: force } = state;
  if (update === null) return;
  const gained = update.sensor_strain.map((strain) => gain * strain);
  const strain = Math.max(REST_STRAIN, ...gained, ...update.felt_strain);
  grid("sensor", gained, 4, strain, 100);
  grid("forces", update.forces_n, update.columns, Math.min(force, Math.max(5 * REST_N, ...update.forces_n)), 1);
  grid("felt", update.felt_strain, 4, strain, 100);
  $("summary").textContent = state.summary;
}

function schedule() {
  if (isDue) return;
  isDue = true;
  requestAnimationFrame(show);
}

const events = new EventSource("/events");
events.addEventListener("state", ({ data }) => {
  [state, isConnected] = [JSON.parse(data), true];
  schedule();
});
events.addEventListener("error", () => {
  isConnected = false;
  schedule();
});
addEventListener("resize", schedule);
