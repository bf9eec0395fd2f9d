// The recording being looked at: its overview, and the fit of the selected part, as `ridgetone fit` returns it.
import { Overview } from "./overview.js";
import { Track } from "./track.js";
import { tone, words } from "./format.js";
import * as runs from "./runs.js";

const $ = (id) => document.getElementById(id);
const ZOOM = 0.5;
const STEP = 0.5;

export class Recording {
  constructor() {
    Object.assign(this, { run: null, fit: null, plot: null, track: null, part: null, answer: 0 });
    const on = (id, act) => $(id).addEventListener("click", act);
    on("zoom-in", () => this.plot?.by(ZOOM));
    on("zoom-out", () => this.plot?.by(1 / ZOOM));
    on("move-left", () => this.plot?.move(-STEP));
    on("move-right", () => this.plot?.move(STEP));
    on("zoom-all", () => this.plot?.reset());
    on("zoom-part", () => this.part && this.plot?.zoom(...this.part));
    on("part-none", () => this.select(null));
    $("part").addEventListener("submit", (event) => {
      event.preventDefault();
      this.select([Number($("part-from").value), Number($("part-until").value)]);
    });
    $("picture").addEventListener("toggle", () => this.draw());
    $("track").addEventListener("toggle", () => $("track").open && this.follow());
    $("windows").addEventListener("submit", (event) => {
      event.preventDefault();
      this.follow();
    });
  }

  get(what, query = {}) {
    return runs.json(`/runs/${this.run.id}/${what}.json?${new URLSearchParams(query)}`);
  }

  // Shows a run, or hides the recording if `run` is null.
  async look(run) {
    this.run = run;
    $("recording").hidden = run === null;
    this.plot?.destroy();
    this.track?.destroy();
    [this.plot, this.track, this.part] = [null, null, null];
    $("track").open = false;
    if (run === null) return;
    $("recording-name").textContent = run.name;
    $("picture").open = false;
    this.show(run.fit, run.no_fit);
    const head = await this.get("rows", { steps: Math.max(300, $("overview").clientWidth) }).catch((error) => error);
    if (this.run !== run) return;
    const why = head instanceof Error ? `Nothing to draw: ${head.message}` : "";
    const empty = $("overview").querySelector(".empty");
    [empty.hidden, empty.textContent] = [why === "", why];
    $("part").inert = why !== "";
    $("recording-small").textContent = why ? "" : about(head);
    if (why) return;
    $("overview").querySelector(".plot").style.height = `${Math.min(640, 90 + Math.max(90, 24 * head.names.length))}px`;
    this.plot = new Overview($("overview"), head, {
      ask: (range) => this.get("rows", range).catch((error) => (this.say(error.message), null)),
      select: (from_s, until_s) => this.select([Math.max(from_s, head.from_s), Math.min(until_s, head.until_s)]),
    });
    this.mark(run.fit);
    this.head = head;
    [$("window").value, $("stride").value] = steps(head, run.fit);
  }

  // Fetches and draws the frequency of windows, on request.
  async follow() {
    const { run } = this;
    if (run === null || this.plot === null) return;
    const query = { window_s: $("window").value, stride_s: $("stride").value };
    for (const link of document.querySelectorAll("[data-track]")) {
      Object.assign(link, { href: `/runs/${run.id}/track.${link.dataset.track}?${new URLSearchParams(query)}`, download: `${run.name}.track.${link.dataset.track}` });
    }
    $("windows-message").textContent = "Fitting.";
    const found = await this.get("track", query).catch((error) => error);
    if (this.run !== run) return;
    const isWrong = found instanceof Error;
    const good = isWrong ? 0 : found.points.filter(({ status }) => status === "good").length;
    $("windows-message").textContent = isWrong ? found.message : `${found.points.length} windows, ${good} of them good.`;
    $("windows-message").classList.toggle("alarm", isWrong);
    this.track ??= new Track($("track-card"), this.head.is_dated);
    if (isWrong) this.track.explain("No track.");
    else {
      this.track.explain("");
      this.track.draw(found);
    }
  }

  // Fits a part, or shows the fit of the part that `fit` chooses if `part` is null.
  async select(part) {
    const number = ++this.answer;
    this.part = part;
    if (part === null) {
      this.show(this.run.fit, this.run.no_fit);
      return;
    }
    this.paint(part);
    this.say("Fitting.");
    const [from_s, until_s] = part;
    const found = await this.get("fit", { from_s, until_s }).catch((error) => error);
    // Drop this answer if another part has been selected meanwhile.
    if (number !== this.answer) return;
    if (found instanceof Error) this.show(null, found.message);
    else this.show(found, null);
  }

  say(text, isWrong = false) {
    $("part-status").textContent = text;
    $("part-status").classList.toggle("alarm", isWrong);
  }

  show(fit, why) {
    $("part-frequency").textContent = tone(fit);
    $("part-frequency").classList.toggle("alarm", Boolean(fit) && fit.status !== "good" && tone(fit) !== "no tone");
    const lines = fit?.lines.filter(([name]) => !/^(frequency|sigma)_/.test(name)) ?? [];
    this.say(why ?? words(lines.find(([name]) => name === "status")?.[1] ?? ""), why !== null && why !== undefined);
    const shown = lines.filter(([name]) => name !== "status");
    $("part-lines").replaceChildren(...shown.map(([name, value]) => {
      const row = document.createElement("div");
      row.append(Object.assign(document.createElement("dt"), { textContent: words(name.replace(/_s$/, ", s").replace(/_(hz|mm)$/, (unit) => `, ${unit.slice(1).replace("hz", "Hz")}`)) }));
      row.append(Object.assign(document.createElement("dd"), { textContent: value.replace("; --whole fits everything", "") }));
      return row;
    }));
    $("part-remark").textContent = fit?.remark ? `How the file was read: ${fit.remark}.` : "";
    this.fit = fit ?? null;
    this.mark(fit);
    this.draw();
  }

  // Marks the part that was fitted.
  mark(fit) {
    const part = this.part ?? (fit ? [fit.from_s, fit.to_s] : null);
    if (part !== null) this.paint(part);
  }

  paint([from_s, until_s]) {
    $("part-from").value = Number(from_s.toFixed(6));
    $("part-until").value = Number(until_s.toFixed(6));
    if (this.plot === null) return;
    this.plot.mark = [from_s, until_s];
    this.plot.plot.redraw(false);
  }

  // Draws the picture of the fit if it is open.
  draw() {
    $("picture").hidden = this.fit === null;
    if (!$("picture").open || this.fit === null) return;
    const [from_s, until_s] = this.part ?? [];
    const query = this.part ? `?${new URLSearchParams({ from_s, until_s })}` : "";
    const source = `/runs/${this.run.id}/fit.svg${query}`;
    $("part-picture").src = source;
    $("part-picture").alt = `Channels, fit, residual and spectrum: ${tone(this.fit)}`;
    Object.assign($("part-save"), { href: source, download: `${this.run.name}.svg` });
  }
}

// Returns window and stride in seconds. A window has eight cycles, if the frequency is known, and
// at least a fortieth of the recording and 48 rows; the stride is half a window.
function steps({ from_s, until_s, rate_hz }, fit) {
  const cycles_s = fit?.frequency_hz ? 8 / fit.frequency_hz : 0;
  const length_s = Math.max(cycles_s, (until_s - from_s) / 40, 48 / rate_hz);
  return [length_s, 0.5 * length_s].map((s) => Number(s.toPrecision(2)));
}

function about({ rows, rate_hz, from_s, until_s, names, touches }) {
  const count = touches.contacts_s.length;
  const found = count > 0 ? `, ${count} ${count === 1 ? "touch" : "touches"}` : "";
  const channels = names.length === 1 ? "1 channel" : `${names.length} channels`;
  return `${channels}, ${rows} rows at ${Number(rate_hz.toPrecision(5))} Hz, ${Number((until_s - from_s).toPrecision(5))} s${found}`;
}
