// The runs: dropped files, recordings made on the page, and the run to compare with.
import { post } from "./settings.js";
import { charted, seconds, tone, withSigma, words } from "./format.js";

const $ = (id) => document.getElementById(id);
// Delay after an estimate's time stamp within which the estimate arrives, seconds.
const BEHIND_S = 0.005;

let runs = [];
let beside = null;

export function say(text, isWrong = false) {
  $("runs-message").textContent = text;
  $("runs-message").classList.toggle("alarm", isWrong);
}

// Runs `work`. If the server refuses it, shows the reason and returns null.
export async function trying(work) {
  try {
    return await work();
  } catch (error) {
    say(error.message, true);
    return null;
  }
}

export async function json(path) {
  const answer = await fetch(path);
  if (!answer.ok) throw new Error((await answer.text()).trim());
  return answer.json();
}

export async function state(id, query) {
  const found = await json(`/runs/${id}/state.json?${new URLSearchParams(query)}`);
  found.live.history = found.live.history.map(charted);
  return found;
}

// Returns the result of `fit`, or the board's if there are no frames to fit.
const value = ({ fit, no_fit: why, estimate }) => {
  if (fit) return fit.status === "good" ? tone(fit) : `${tone(fit)}, ${words(fit.status)}`;
  return estimate ? withSigma(estimate.frequency_hz, estimate.sigma_hz, "Hz") : why ?? "no tone";
};
const period = (point) => (point && point.spatial_period_mm !== null ? withSigma(point.spatial_period_mm, point.spatial_period_sigma_mm, "mm") : "");

// Inserts the note into the name of a file.
const named = ({ name, note }) => {
  const words = note.replace(/[^\p{L}\p{N}]+/gu, "-").replace(/^-|-$/g, "");
  return words === "" ? name : name.replace(/(\.[^.]*)?$/, (ending) => `-${words}${ending}`);
};

// Describes the difference between two runs.
export function difference(one, other) {
  const known = (run) => ((run?.fit?.frequency_hz ?? null) === null ? run?.estimate : run.fit);
  const [a, b] = [one, other].map(known);
  const shown = one?.is_table || other.is_table ? "" : `Dashed in violet: ${other.name}.`;
  if (!a || !b) return shown;
  const [own, others] = [charted(a), charted(b)];
  const [apart, sigma] = [own.frequency - others.frequency, Math.hypot(own.sigma, others.sigma)];
  return `${shown} ${one.name} − ${other.name}: ${withSigma(apart, sigma, "Hz")}, ${Math.abs(apart / sigma).toFixed(1)} σ apart.`;
}

export const of = (id) => runs.find((run) => run.id === id);
export const compared = () => beside;
export const first = () => runs[0] ?? null;

// `look` shows a run, `changed` redraws the page, and `shown` returns the run that is shown.
export function begin({ look, changed, shown }) {
  const update = (found) => {
    runs = runs.some(({ id }) => id === found.id) ? runs.map((run) => (run.id === found.id ? found : run)) : [...runs, found];
    list();
  };
  const open = async (name, bytes, query = {}) => {
    say(`Reading ${name}.`);
    const found = JSON.parse(await post(`/runs?${new URLSearchParams({ name, ...query })}`, bytes, "application/octet-stream"));
    say(found.remark ?? "");
    update(found);
    return found;
  };
  // Show a single file; several files get a row each. A file without times may be opened again with its rate.
  let untimed = [];
  const openAll = async (files, query) => {
    const [opened, refused] = [[], []];
    untimed = [];
    for (const file of files) {
      const found = await open(file.name, file, query).catch((error) => error);
      if (!(found instanceof Error)) opened.push(found);
      else {
        refused.push(found.message);
        if (found.message.includes("--rate")) untimed.push(file);
      }
    }
    if (refused.length) say(refused.join(" "), true);
    $("rate-label").hidden = untimed.length === 0;
    if (opened.length === 1 && files.length === 1) await look(opened[0]);
    else $("runs").scrollIntoView();
  };
  $("rate-open").addEventListener("click", () => openAll(untimed, { rate_hz: $("rate").value }));
  const compare = (run) => trying(async () => {
    if (beside?.run.id === run.id) beside = null;
    else {
      const whole = await state(run.id, { t_s: run.until_s });
      const last = whole.live.history.findLast((point) => point.span === "window" && point.status === "good");
      const then = last ? await state(run.id, { t_s: last.t_s + BEHIND_S }) : whole;
      beside = { run, state: { ...whole, spectrum: then.spectrum } };
    }
    list();
    changed();
  });
  const isMeant = (run) => !run.is_unsaved || window.confirm(`${run.name} is not saved, and goes when it is closed.`);
  const close = (run) => trying(async () => {
    if (!isMeant(run)) return;
    await post(`/runs/${run.id}/close`, "");
    runs = runs.filter(({ id }) => id !== run.id);
    if (beside?.run.id === run.id) beside = null;
    if (shown()?.id === run.id) await look(null);
    list();
    changed();
  });

  const reload = (run) => trying(async () => {
    const found = JSON.parse(await post(`/runs/${run.id}/reload`, ""));
    say(found.remark ?? "");
    update(found);
    if (beside?.run.id === run.id) beside = null;
    if (shown()?.id === run.id) await look(found);
    changed();
  });
  const noteOf = (run) => {
    const input = Object.assign(document.createElement("input"), { type: "text", value: run.note, maxLength: 200, placeholder: "note" });
    input.setAttribute("aria-label", `note on ${run.name}`);
    input.addEventListener("change", () => trying(async () => {
      await post(`/runs/${run.id}/note`, input.value, "text/plain");
      update({ ...run, note: input.value });
    }));
    return input;
  };

  function list() {
    $("run-list").hidden = runs.length === 0;
    $("run-rows").replaceChildren(...runs.map((run) => {
      const row = document.createElement("tr");
      const cells = [run.is_unsaved ? `${run.name}, not saved` : run.name, seconds(run.until_s - run.from_s), `${run.touches}`, value(run), period(run.estimate)];
      row.append(...cells.map((text) => Object.assign(document.createElement("td"), { textContent: text })));
      const actions = document.createElement("td");
      const button = (text, act, isPressed) => {
        const made = Object.assign(document.createElement("button"), { type: "button", textContent: text });
        made.setAttribute("aria-label", `${text} ${run.name}`);
        if (isPressed !== undefined) made.setAttribute("aria-pressed", String(isPressed));
        made.addEventListener("click", act);
        return made;
      };
      const save = Object.assign(document.createElement("a"), { href: `/runs/${run.id}/file`, download: named(run), textContent: "Save" });
      save.className = "button";
      // Update only after the browser has taken the link.
      save.addEventListener("click", () => setTimeout(() => update({ ...of(run.id), is_unsaved: false })));
      save.setAttribute("aria-label", `Save ${run.name}`);
      actions.append(
        button("Look", () => trying(() => look(run)), shown()?.id === run.id),
        button("Compare", () => compare(run), beside?.run.id === run.id), save,
        ...(run.can_reload ? [button("Reload", () => reload(run))] : []), button("Close", () => close(run)),
      );
      row.firstChild.append(document.createElement("br"), noteOf(run));
      row.append(actions);
      return row;
    }));
  }

  $("file").addEventListener("change", async () => {
    await openAll([...$("file").files]);
    $("file").value = "";
  });
  document.addEventListener("dragover", (event) => {
    event.preventDefault();
    document.body.classList.add("dropping");
  });
  document.addEventListener("dragleave", (event) => event.relatedTarget === null && document.body.classList.remove("dropping"));
  document.addEventListener("drop", async (event) => {
    event.preventDefault();
    document.body.classList.remove("dropping");
    await openAll([...event.dataTransfer.files]);
  });
  // Ask before leaving the page, because unsaved runs would be lost.
  window.addEventListener("beforeunload", (event) => runs.some((run) => run.is_unsaved) && event.preventDefault());
  $("clear").addEventListener("click", () => trying(() => post("/clear", "")));
  $("record").addEventListener("click", () => trying(async () => {
    const ended = await post("/record", "");
    if (ended === "") return;
    const found = JSON.parse(ended);
    update(found);
    say("Recorded, in memory only: press Save to keep it.");
  }));
  $("latest").addEventListener("click", () => trying(async () => {
    const found = JSON.parse(await post("/record/latest", ""));
    update(found);
    say("The last minute, in memory only: press Save to keep it.");
    await look(found);
  }));
  // Add the runs that the command already has.
  trying(async () => {
    (await (await fetch("/runs")).json()).forEach(update);
    changed();
  });
  return { update, list };
}

export function showRecording({ recording_s: length_s, live }) {
  const isOn = (length_s ?? null) !== null;
  $("record").hidden = live.connection.state === "over" && !isOn;
  $("latest").hidden = $("clear").hidden = live.counts.received === 0;
  $("record").setAttribute("aria-pressed", String(isOn));
  $("record").textContent = isOn ? `Stop, ${length_s.toFixed(0)} s` : "Record";
}
