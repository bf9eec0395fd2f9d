// The settings in force on the board, and new ones for it.

const $ = (id) => document.getElementById(id);
// The usual scan plans, and what they give.
const PLANS = { paper: "16 × 241 Hz", hand: "16 × 1.46 kHz", texture: "4 × 5.8 kHz", vibration: "2 × 11.7 kHz", single: "1 × 23.3 kHz" };
// A plan that has no name.
const OWN = "";
// Inputs; each has the setting as its name, and that of a table has a dot.
const IDS = ["window_s", "hop_s", "harmonics", "volts_per_um", "sigma_share", "force_ratio"];

// What somebody is changing stays as it is.
let isChanging = false;
// Whose settings are shown.
let wasRun = false;

const say = (text, isWrong = false) => {
  $("settings-message").textContent = text;
  $("settings-message").classList.toggle("alarm", isWrong);
};

// A setting by its name.
const value = (settings, name) => name.split(".").reduce((found, part) => found[part], settings);

function wanted() {
  const settings = $("plan-label").hidden || $("plan").value === OWN ? {} : { plan: $("plan").value };
  for (const id of IDS) {
    if ($(id).value === "") continue;
    const [name, table] = $(id).name.split(".").toReversed();
    const place = table === undefined ? settings : (settings[table] ??= {});
    place[name] = Number($(id).value);
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
export function show({ live, settings_reply: reply, can_set: canSet }, isRun) {
  $("settings").hidden = !canSet;
  if (!canSet) return;
  if (wasRun !== isRun) {
    [wasRun, isChanging] = [isRun, false];
    say("");
  }
  $("settings-title").textContent = isRun ? "Settings of this run" : "Settings of the board";
  $("settings-send").textContent = isRun ? "Run again" : "Send";
  $("plan-label").hidden = isRun;
  const { settings } = live.latest.hello;
  if (!isChanging) $("plan").value = typeof settings.plan === "string" ? settings.plan : OWN;
  if (!isChanging) IDS.forEach((id) => { $(id).value = Number(value(settings, $(id).name).toPrecision(6)); });
  if (!isRun && reply !== null && reply !== undefined) say(reply.text, reply.is_refused);
}

// `send` takes the wanted settings as JSON, and gives what became of them.
export function begin(send) {
  const options = [...Object.entries(PLANS).map(([name, what]) => [name, `${name}: ${what}`]), [OWN, "its own"]];
  $("plan").replaceChildren(...options.map(([name, text]) => new Option(text, name)));
  // A new plan begins with its default window and hop: the latest ones may not be possible with it.
  $("plan").addEventListener("input", () => { $("window_s").value = $("hop_s").value = ""; });
  $("settings-form").addEventListener("input", () => { isChanging = true; });
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
