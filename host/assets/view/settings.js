// The settings in force on the board, and a form to change them. The server describes the inputs of the form.

const $ = (id) => document.getElementById(id);
// Value of a plan without a name.
const OWN = "";

// True while the user edits the form; the inputs are then not updated.
let isChanging = false;
// Run whose settings are shown; null for the board's.
let shownRun = null;
// Number of the board's latest answer that was shown. Every update repeats the answer, which must not replace later messages.
let answered = null;
// For each input: the setting's entry and the element.
let inputs = [];

const say = (text, isWrong = false) => {
  $("settings-message").textContent = text;
  $("settings-message").classList.toggle("alarm", isWrong);
};

// Returns a setting by its name.
const value = (settings, name) => name.split(".").reduce((found, part) => found[part], settings);

// For each kind of setting, conversions from a value to the text of its input and back.
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
    if (entry.min !== null) Object.assign(input, { min: entry.min, max: entry.max });
  }
  const unit = entry.unit === "" ? "" : `, ${entry.unit}`;
  const label = document.createElement("label");
  label.append(`${entry.name.split(".").at(-1).replace(/_(s|hz|v|mm|rad|mm_s)$/, "").replaceAll("_", " ")}${unit} `, input);
  return { entry, input, label };
}

function build(entries) {
  inputs = entries.map(field);
  $("settings-inputs").replaceChildren(...inputs.map(({ label }) => label));
  // A new plan starts with its default window and stride, because the previous ones may be impossible with it.
  $("plan").addEventListener("input", () => { $("window_s").value = $("stride_s").value = ""; });
}

// Returns the settings that the user has changed.
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

// Returns the server's answer as text; throws if the server refuses.
export async function post(path, body, type = "application/json") {
  const answer = await fetch(path, { method: "POST", headers: { "content-type": type }, body });
  const text = (await answer.text()).trim();
  if (!answer.ok) throw new Error(text);
  return text;
}

// Shows the settings in force. Hides the form if no connected board accepts settings.
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

// `send` takes the changed settings as JSON, and returns the outcome.
export function begin(send) {
  $("settings-form").addEventListener("input", () => { isChanging = true; });
  // Show the browser's own message for an invalid value; such a value is not sent.
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
