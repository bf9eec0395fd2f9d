// Shows the board's state at any time of a telemetry recording: a slider, and playback.
import { Model } from "./model.js";
import { seconds } from "./format.js";
import * as runs from "./runs.js";

const $ = (id) => document.getElementById(id);
// Time that a key moves the slider, seconds.
const STEP_S = 0.05;

export class Scrub {
  // `changed` is called when the page must be redrawn.
  constructor(changed) {
    Object.assign(this, { changed, run: null, model: null, wanted: null, isBusy: false, playing: null });
    $("time").addEventListener("input", () => this.go(Number($("time").value)));
    $("play").addEventListener("click", () => this.play(this.playing === null));
  }

  get t_s() {
    return Number($("time").value);
  }

  // Shows a run, or goes back to the live board if `run` is null.
  async look(run) {
    this.play(false);
    [this.run, this.model] = [run, null];
    // A table has no board state.
    $("scrub").hidden = run === null || run.is_table;
    if ($("scrub").hidden) {
      this.changed();
      return;
    }
    const slider = $("time");
    [slider.min, slider.max] = [run.from_s, run.until_s];
    // Start just after the estimate has arrived.
    slider.value = run.estimate ? Math.min(run.until_s, run.estimate.t_s + STEP_S) : run.until_s;
    await this.go(this.t_s);
  }

  // Shows the state at a time. Of the requests made while one is pending, only the latest is sent.
  async go(t_s) {
    $("time").value = t_s;
    $("time-s").textContent = seconds(this.t_s);
    $("time").setAttribute("aria-valuetext", seconds(this.t_s));
    this.wanted = this.t_s;
    if (this.isBusy) return;
    this.isBusy = true;
    while (this.wanted !== null && this.run !== null) {
      const [then_s, run] = [this.wanted, this.run];
      this.wanted = null;
      const found = await runs.trying(() => runs.state(run.id, { t_s: then_s }));
      if (found !== null && this.run === run) {
        this.model ??= new Model();
        this.model.begin(found);
        this.changed();
      }
    }
    this.isBusy = false;
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

  // Handles a key; returns whether it did anything.
  key(key) {
    const act = {
      ",": () => this.go(this.t_s - STEP_S), ".": () => this.go(this.t_s + STEP_S),
      " ": () => this.play(this.playing === null),
    }[key];
    if ($("scrub").hidden || !act) return false;
    act();
    return true;
  }
}
