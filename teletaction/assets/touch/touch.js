// The page of `ridgetone touch`: pointer in, sound out.
import { withSigma } from "./format.js";
import { MM_PER_PX, draw } from "./surface.js";

const $ = (id) => document.getElementById(id);
const canvas = $("surface");
let state = null;
let isConnected = false;
// Sound: none before somebody wants it, as browsers demand.
let context = null;
let node = null;
let gain = null;
// The pointer that is down, where it was last, and its speed in millimetres per second.
let pointer = null;
let speed = 0;
let report = { late: 0, amplitude: 0 };
let lateBefore = 0;

// A hand that is moved by the arrow keys: its speeds, millimetres per second, the one that was chosen, and the time between
// two of its reports, milliseconds.
const KEY_SPEEDS = [5, 10, 20, 40, 80, 160];
const KEY_MS = 8;
let keySpeed = 3;

// Milliseconds between two readings of the page's clock for that of the sound.
const CLOCK_MS = 50;

const mmPerPx = () => MM_PER_PX * Number($("zoom").value);
const send = (what, ...values) => node?.port.postMessage({ what, values });
const sendPositions = (what, positions) => node?.port.postMessage({ what, at: positions[positions.length - 1][0], values: positions });

// One at a time: a click while the sound is being switched waits for nothing and does nothing.
async function toggle() {
  $("sound").disabled = true;
  try {
    await (context === null ? start() : stop());
  } finally {
    $("sound").disabled = false;
  }
}

async function start() {
  if (!isSecureContext || typeof AudioWorkletNode === "undefined") {
    $("message").textContent = "This browser plays sound from here only at an address of its own computer: open the page on localhost.";
    return;
  }
  context = new AudioContext({ latencyHint: "interactive" });
  const [wasm] = await Promise.all([
    fetch("/stimulus.wasm").then((answer) => answer.arrayBuffer()),
    context.audioWorklet.addModule("/worklet.js"),
  ]);
  const options = { numberOfInputs: 0, outputChannelCount: [1], processorOptions: { wasm, limits: state } };
  node = new AudioWorkletNode(context, "touch", options);
  node.port.onmessage = ({ data }) => {
    if (data.recorded) globalThis.ridgetone.recorded = data.recorded;
    else report = data;
  };
  gain = new GainNode(context, { gain: Number($("volume").value) });
  node.connect(gain).connect(context.destination);
  // For programs that look at the page.
  globalThis.ridgetone = { context, node, recorded: null };
  sendDelay();
  sendCarrier();
  sendTexture();
  await context.resume();
  $("sound").textContent = "Sound off";
}

async function stop() {
  send("lift");
  // As long as a vibration takes to fade.
  await new Promise((done) => setTimeout(done, 2e3 * state.fade_s));
  await context.close();
  [context, node, gain] = [null, null, null];
  $("sound").textContent = "Sound on";
}

function sendTexture() {
  if (!state?.texture) return;
  const overtones = state.texture.overtones.flatMap(({ amplitude, phase_cycles: phase }) => [amplitude, phase]);
  send("texture", state.texture.period_mm, Math.max(state.fraction, 1e-6), ...overtones);
}

function sendDelay() {
  const value = (id) => Number($(id).value) / 1e3;
  send("delay", value("mean_ms"), value("sigma_ms"), value("wait_ms"));
}

const sendCarrier = () => send("carrier", Number($("carrier_hz").value));

// Time in seconds and position in millimetres of a pointer's event, and of those that came with it.
function positions(event) {
  const all = event.getCoalescedEvents?.() ?? [];
  const left = canvas.getBoundingClientRect().left;
  return (all.length ? all : [event]).map((one) => [one.timeStamp / 1e3, (one.clientX - left) * mmPerPx()]);
}

function moved(event) {
  if (event.pointerId !== pointer?.id) return;
  const found = positions(event);
  const [t_s, x_mm] = found[found.length - 1];
  const passed_s = t_s - pointer.t_s;
  if (passed_s > 0) speed += Math.min(1, passed_s / 0.05) * (Math.abs(x_mm - pointer.x_mm) / passed_s - speed);
  const { left, top } = canvas.getBoundingClientRect();
  Object.assign(pointer, { t_s, x_mm, x: event.clientX - left, y: event.clientY - top });
  sendPositions("moved", found);
}

canvas.addEventListener("pointerdown", (event) => {
  if (pointer !== null || event.button !== 0) return;
  canvas.setPointerCapture(event.pointerId);
  const [[t_s, x_mm]] = positions(event);
  pointer = { id: event.pointerId, t_s, x_mm, x: event.offsetX, y: event.offsetY };
  if (state?.is_silent || !isConnected) return;
  sendPositions("down", [[t_s, x_mm]]);
});
// As soon as it is known, and not once a picture, where the browser can.
canvas.addEventListener("onpointerrawupdate" in canvas ? "pointerrawupdate" : "pointermove", moved);
for (const end of ["pointerup", "pointercancel", "lostpointercapture"]) {
  canvas.addEventListener(end, (event) => {
    if (event.pointerId !== pointer?.id) return;
    [pointer, speed] = [null, 0];
    send("lift");
  });
}

// The arrow keys move a hand along the surface as long as they are held down.
const keys = { way: 0, timer: null };

function moveByKeys() {
  const t_s = performance.now() / 1e3;
  const way = keys.way * KEY_SPEEDS[keySpeed];
  pointer.x_mm += way * (t_s - pointer.t_s);
  const width = canvas.clientWidth;
  // The surface goes on beyond its edges: there the ring enters it again on the other side.
  Object.assign(pointer, { t_s, x: (((pointer.x_mm / mmPerPx()) % width) + width) % width });
  speed = Math.abs(way);
  sendPositions("moved", [[t_s, pointer.x_mm]]);
}

function liftKeys() {
  clearInterval(keys.timer);
  Object.assign(keys, { way: 0, timer: null });
  if (pointer?.id !== "keys") return;
  [pointer, speed] = [null, 0];
  send("lift");
}

canvas.addEventListener("keydown", (event) => {
  const way = { ArrowLeft: -1, ArrowRight: 1 }[event.key] ?? 0;
  const faster = { ArrowDown: -1, ArrowUp: 1 }[event.key] ?? 0;
  if ((way === 0 && faster === 0) || event.ctrlKey || event.metaKey || event.altKey) return;
  event.preventDefault();
  keySpeed = Math.min(KEY_SPEEDS.length - 1, Math.max(0, keySpeed + faster));
  if (way === 0 || (pointer !== null && pointer.id !== "keys")) return;
  keys.way = way;
  if (pointer !== null) return;
  const [t_s, x] = [performance.now() / 1e3, 0.5 * canvas.clientWidth];
  pointer = { id: "keys", t_s, x_mm: x * mmPerPx(), x, y: 0.5 * canvas.clientHeight };
  if (!state?.is_silent && isConnected) sendPositions("down", [[t_s, pointer.x_mm]]);
  keys.timer = setInterval(moveByKeys, KEY_MS);
});
canvas.addEventListener("keyup", (event) => {
  if ({ ArrowLeft: -1, ArrowRight: 1 }[event.key] === keys.way) liftKeys();
});
canvas.addEventListener("blur", liftKeys);

$("sound").addEventListener("click", () => state !== null && toggle());
$("volume").addEventListener("input", () => gain?.gain.setTargetAtTime(Number($("volume").value), context.currentTime, 0.02));
$("condition").addEventListener("change", () => {
  if ($("condition").value !== "own") [$("mean_ms").value, $("sigma_ms").value] = $("condition").value.split(",");
  sendDelay();
});
$("carrier_hz").addEventListener("change", sendCarrier);
for (const id of ["mean_ms", "sigma_ms", "wait_ms"]) {
  $(id).addEventListener("change", () => {
    chooseCondition();
    sendDelay();
  });
}
$("own").addEventListener("submit", async (event) => {
  event.preventDefault();
  const answer = await fetch("/texture", { method: "POST", body: JSON.stringify({ period_mm: Number($("period_mm").value) }) });
  $("message").textContent = await answer.text();
});

function chooseCondition() {
  const own = `${Number($("mean_ms").value)},${Number($("sigma_ms").value)}`;
  const known = [...$("condition").options].some(({ value }) => value === own);
  $("condition").value = known ? own : "own";
}

setInterval(() => node?.port.postMessage({ what: "clock", at: performance.now() / 1e3 }), CLOCK_MS);

const events = new EventSource("/events");
events.addEventListener("state", ({ data }) => {
  const before = state;
  const wasAway = !isConnected;
  state = JSON.parse(data);
  isConnected = true;
  const isChanged = (names) => names.some((name) => JSON.stringify(state[name]) !== JSON.stringify(before?.[name]));
  // The command was started again with other limits: the sound keeps those it was switched on with.
  if (node !== null && before !== null && isChanged(["voltage_v", "cutoff_hz", "slew_v_s", "fade_s"])) toggle();
  if (before === null) {
    [$("mean_ms").value, $("sigma_ms").value] = state.delay_ms;
    chooseCondition();
    const carrier = String(state.carrier_hz ?? 0);
    if (![...$("carrier_hz").options].some(({ value }) => value === carrier)) $("carrier_hz").add(new Option(`${carrier} Hz`, carrier));
    $("carrier_hz").value = carrier;
  }
  if (state.texture && isChanged(["number", "texture", "fraction"])) {
    $("period_mm").value = Number(state.texture.period_mm.toPrecision(5));
    sendTexture();
  }
  if (state.is_silent) send("lift");
  else if ((before?.is_silent || wasAway) && pointer !== null) sendPositions("down", [[pointer.t_s, pointer.x_mm]]);
});
events.addEventListener("error", () => {
  isConnected = false;
  send("lift");
});

const put = (id, text) => {
  if ($(id).textContent !== text) $(id).textContent = text;
};

function show() {
  requestAnimationFrame(show);
  if (pointer !== null && performance.now() / 1e3 - pointer.t_s > 0.1) speed = 0;
  put("status", isConnected ? state.status : "The command cannot be reached: it has ended, or is being restarted. Trying again every second.");
  $("status").classList.toggle("alarm", !isConnected || state.is_silent);
  draw(canvas, state?.texture ?? null, mmPerPx(), pointer);
  put("scale", `${(canvas.clientWidth * mmPerPx()).toFixed(0)} mm wide`);
  put("hint", context === null ? "The sound is off: press Sound on." : `← and → move the hand at ${KEY_SPEEDS[keySpeed]} mm/s, ↑ and ↓ change the speed.`);
  if (state === null) return;
  put("source", state.source);
  const { texture } = state;
  // A sigma of 0 means: not known.
  put("period", texture ? withSigma(texture.period_mm, texture.period_sigma_mm, "mm") : "none");
  put("period-small", texture ? `${(100 * state.fraction).toFixed(0)} % of the amplitude` : "");
  put("speed", `${speed.toFixed(0)} mm/s`);
  put("frequency", texture ? `${(speed / texture.period_mm).toFixed(0)} Hz` : "-");
  // From the position to the sound: the wait, the added delay, and what the browser says of its output.
  const output_ms = context === null ? null : 1e3 * (context.baseLatency + (context.outputLatency || 0));
  const chosen_ms = Number($("wait_ms").value) + Number($("mean_ms").value);
  put("latency", output_ms === null ? "-" : `${(chosen_ms + output_ms).toFixed(0)} ms`);
  const isLate = pointer !== null && speed > 0 && report.late !== lateBefore;
  lateBefore = report.late;
  put("latency-small", output_ms === null ? "" : `${output_ms.toFixed(0)} ms of it the output's${isLate ? " · the pointer is late: a longer wait helps" : ""}`);
}
show();
