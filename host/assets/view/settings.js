// The settings in force on the board, and new ones for it. The server describes the inputs of the form.

const $ = (id) => document.getElementById(id);
// A plan that has no name.
const OWN = "";

// What somebody is changing stays as it is.
let isChanging = false;
// The run whose settings are shown; none: the board's.
let shownRun = null;
// Number of the board's answer that was said last. It comes with every update: what was said since stays.
let answered = null;
// An object for each input: the setting's entry, and its element.
let inputs = [];

const say = (text, isWrong = false) => {
  $("settings-message").textContent = text;
  $("settings-message").classList.toggle("alarm", isWrong);
};

// A setting by its name.
const value = (settings, name) => name.split(".").reduce((found, part) => found[part], settings);

// A value as its input has it, and back.
const WAYS = {
  number: [(found) => String(Number(found.toPrecision(6))), Number],
  whole: [String, Number],
  switch: [String, (text) => text === "true"],
  word: [String, String],
  plan: [(found) => (typeof found === "string" ? found : OWN), String],
};

function field(entry) {
  const isChosen = ["switch", "word", "plan"].includes(entry.kind);
  const input = document.createElement(isChosen ? "select" : "input");
  Object.assign(input, { id: entry.name, name: entry.name, title: entry.title });
  if (entry.kind === "switch") input.append(new Option("true"), new Option("false"));
  for (const { value: found, text } of entry.choices) input.add(new Option(text, found));
  if (entry.kind === "plan") input.add(new Option("custom", OWN));
  if (["number", "whole"].includes(entry.kind)) {
    Object.assign(input, { type: "number", step: entry.kind === "whole" ? "1" : "any", inputMode: "decimal" });
    if (entry.least !== null) Object.assign(input, { min: entry.least, max: entry.greatest });
  }
  const unit = entry.unit === "" ? "" : `, ${entry.unit}`;
  const label = document.createElement("label");
  label.append(`${entry.name.split(".").at(-1).replace(/_(s|hz|v|mm|rad|mm_s)$/, "").replaceAll("_", " ")}${unit} `, input);
  return { entry, input, label };
}

function build(entries) {
  inputs = entries.map(field);
  $("settings-inputs").replaceChildren(...inputs.map(({ label }) => label));
  // A new plan begins with its default window and stride: the latest ones may not be possible with it.
  $("plan").addEventListener("input", () => { $("window_s").value = $("stride_s").value = ""; });
}

// What somebody has changed.
function wanted() {
  const settings = {};
  for (const { entry, input } of inputs) {
    if (input.value === "" || input.value === input.dataset.shown) continue;
    const [name, table] = entry.name.split(".").toReversed();
    const place = table === undefined ? settings : (settings[table] ??= {});
    place[name] = WAYS[entry.kind][1](input.value);
  }
  return settings;
}

// Gives the server's answer in words; throws its refusal.
export async function post(path, body, type = "application/json") {
  const answer = await fetch(path, { method: "POST", headers: { "content-type": type }, body });
  const text = (await answer.text()).trim();
  if (!answer.ok) throw new Error(text);
  return text;
}

// Shows those in force; without a board that takes settings there is nothing to set.
export function show({ live, settings_form: entries, settings_reply: reply, can_set: canSet }, run) {
  $("settings").hidden = !canSet;
  if (!canSet) return;
  if (inputs.length === 0) build(entries);
  const isRun = run !== null;
  if (shownRun !== (run?.id ?? null)) {
    [shownRun, isChanging] = [run?.id ?? null, false];
    say("");
  }
  $("settings-title").textContent = isRun ? "Settings of this run" : "Settings of the board";
  $("settings-send").textContent = isRun ? "Run again" : "Send";
  $("plan").parentElement.hidden = isRun;
  if (!isChanging) {
    for (const { entry, input } of inputs) {
      input.value = input.dataset.shown = WAYS[entry.kind][0](value(live.latest.hello.settings, entry.name));
    }
  }
  if (isRun || (reply?.number ?? null) === answered) return;
  answered = reply?.number ?? null;
  if (reply) say(reply.text, reply.is_refused);
}

// `send` takes the wanted settings as JSON, and gives what became of them.
export function begin(send) {
  $("settings-form").addEventListener("input", () => { isChanging = true; });
  // The browser's own refusal of a value, which is nothing to send.
  const refuse = ({ target }) => say(`${target.name}: ${target.validationMessage}`, true);
  $("settings-form").addEventListener("invalid", refuse, true);
  $("settings-form").addEventListener("submit", async (event) => {
    event.preventDefault();
    say("Sending.");
    try {
      say(await send(JSON.stringify(wanted())));
      isChanging = false;
    } catch (error) {
      say(error.message, true);
    }
  });
  $("settings-reset").addEventListener("click", () => {
    isChanging = false;
    say("");
  });
}
