// The settings in force on the board, and new ones for it.

const $ = (id) => document.getElementById(id);
const NAMES = ["window_s", "hop_s", "harmonics"];

// What somebody is changing stays as it is.
let isChanging = false;
// Whose settings are shown.
let wasRun = false;

const say = (text, isWrong = false) => {
  $("settings-said").textContent = text;
  $("settings-said").classList.toggle("alarm", isWrong);
};

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
  $("settings-reset").textContent = isRun ? "As in the run" : "As on the board";
  const { settings } = live.latest.hello;
  if (!isChanging) NAMES.forEach((name) => { $(name).value = Number(settings[name].toPrecision(6)); });
  if (!isRun && reply !== null && reply !== undefined) say(reply.text, reply.is_refused);
}

// `send` takes the wanted settings as JSON, and gives what became of them.
export function begin(send) {
  $("settings-form").addEventListener("input", () => { isChanging = true; });
  $("settings-form").addEventListener("submit", async (event) => {
    event.preventDefault();
    const wanted = Object.fromEntries(NAMES.map((name) => [name, Number($(name).value)]));
    say("Sending.");
    try {
      say(await send(JSON.stringify(wanted)));
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
