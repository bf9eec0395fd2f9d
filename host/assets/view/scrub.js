// A run at any of its times: a slider, marks, and the fit of what is marked.
import { Model } from "./model.js";
import { seconds } from "./format.js";
import * as runs from "./runs.js";
import { post } from "./settings.js";

const $ = (id) => document.getElementById(id);
// A step of the keys, seconds.
const STEP_S = 0.05;

export class Scrub {
  // `changed` draws anew, and `read` takes a run that was read anew.
  constructor(changed, read) {
    Object.assign(this, { changed, read, run: null, model: null, mark: [null, null], wanted: null, isBusy: false, playing: null });
    $("time").addEventListener("input", () => this.go(Number($("time").value)));
    $("play").addEventListener("click", () => this.play(this.playing === null));
    $("live").addEventListener("click", () => this.look(null));
    $("mark-from").addEventListener("click", () => this.setMark(0, this.t_s));
    $("mark-until").addEventListener("click", () => this.setMark(1, this.t_s));
    $("mark-none").addEventListener("click", () => this.setMark(null));
    $("mark-all").addEventListener("click", () => {
      this.mark = [this.run.from_s, this.run.until_s];
      this.go(this.t_s);
    });
  }

  get t_s() {
    return Number($("time").value);
  }

  // Shows a run; null: the board again.
  async look(run) {
    this.play(false);
    [this.run, this.mark] = [run, [null, null]];
    $("scrub").hidden = run === null;
    if (run === null) {
      this.model = null;
      this.changed();
      return;
    }
    $("run-name").textContent = run.name;
    const slider = $("time");
    [slider.min, slider.max] = [run.from_s, run.until_s];
    // Where its estimate has just come.
    slider.value = run.estimate ? Math.min(run.until_s, run.estimate.t_s + STEP_S) : run.until_s;
    await this.go(this.t_s);
    slider.focus();
  }

  // The state at a time; of several wishes the latest counts.
  async go(t_s) {
    $("time").value = t_s;
    $("time-s").textContent = seconds(this.t_s);
    $("time").setAttribute("aria-valuetext", seconds(this.t_s));
    this.wanted = this.t_s;
    if (this.isBusy) return;
    this.isBusy = true;
    while (this.wanted !== null && this.run !== null) {
      const [then_s, [from_s, until_s]] = [this.wanted, this.mark];
      this.wanted = null;
      const query = from_s !== null && until_s !== null ? { from_s, until_s } : { t_s: then_s };
      const found = await runs.trying(() => runs.state(this.run.id, query));
      if (found !== null && this.run !== null) {
        this.model ??= new Model();
        this.model.begin(found);
        this.changed();
      }
    }
    this.isBusy = false;
    this.saySome();
  }

  saySome() {
    const [from_s, until_s] = this.mark;
    const marked = from_s !== null && until_s !== null;
    $("scrub-message").textContent = marked ? `Marked ${seconds(from_s)} to ${seconds(until_s)}: the estimate is of this part.`
      : from_s !== null ? `Marked from ${seconds(from_s)}: go on, and mark its end.`
      : until_s !== null ? `Marked until ${seconds(until_s)}: go back, and mark its beginning.`
      : "Comma and full stop step 0.05 s; [ and ] mark the part to fit; space plays.";
  }

  setMark(end, t_s) {
    if (end === null) this.mark = [null, null];
    else this.mark[end] = t_s;
    const [from_s, until_s] = this.mark;
    // The later wish counts.
    if (from_s !== null && until_s !== null && from_s >= until_s) this.mark[1 - end] = null;
    this.go(this.t_s);
  }

  play(wanted) {
    if (wanted === (this.playing !== null)) return;
    $("play").textContent = wanted ? "Stop" : "Play";
    if (!wanted) {
      cancelAnimationFrame(this.playing);
      this.playing = null;
      return;
    }
    let before = performance.now();
    const from_s = this.t_s >= this.run.until_s ? this.run.from_s : this.t_s;
    this.mark = [null, null];
    let t_s = from_s;
    const step = (now) => {
      t_s += 1e-3 * (now - before);
      before = now;
      this.go(t_s);
      if (t_s < this.run.until_s) this.playing = requestAnimationFrame(step);
      else this.play(false);
    };
    this.playing = requestAnimationFrame(step);
  }

  // Whether a key was for it.
  key(key) {
    const act = {
      ",": () => this.go(this.t_s - STEP_S), ".": () => this.go(this.t_s + STEP_S),
      "[": () => this.setMark(0, this.t_s), "]": () => this.setMark(1, this.t_s), " ": () => this.play(this.playing === null),
    }[key];
    if (this.run === null || !act) return false;
    act();
    return true;
  }
}
