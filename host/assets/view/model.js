// Folds the command's messages, which host/src/view/hub.rs defines, into one state.
import { charted } from "./format.js";

// Maximum and minimum time over which the pace is measured, seconds.
const PACE_S = [5, 3];

// Measures a board's pace: its own time per second of wall time.
export class Pace {
  marks = [];

  // Adds a pair of times. Returns the pace, or null until it is known.
  take(wall_s, now_s) {
    if (now_s < this.marks.at(-1)?.now_s) this.marks = [];
    this.marks.push({ wall_s, now_s });
    this.marks = this.marks.filter((mark) => wall_s - mark.wall_s <= PACE_S[0]);
    const [first] = this.marks;
    const span_s = wall_s - first.wall_s;
    return span_s >= PACE_S[1] ? (now_s - first.now_s) / span_s : null;
  }
}

export class Model {
  constructor() {
    this.state = null;
    this.missed = 0;
  }

  // Replaces the state by a whole new one.
  begin(message) {
    message.live.history = message.live.history.map(charted);
    this.state = message;
    this.missed = message.missed;
  }

  // Applies an update to the state.
  add(message) {
    const { state } = this;
    if (state === null) return;
    const { history, strips, log } = state.live;
    history.push(...message.points.map(charted));
    history.splice(0, history.length - state.points_most);
    strips.t_s.push(...message.strips.t_s);
    strips.number.push(...message.strips.number);
    strips.volts.forEach((values, taxel) => values.push(...message.strips.volts[taxel]));
    const excess = Math.max(0, strips.t_s.length - state.frames_most);
    [strips.t_s, strips.number, ...strips.volts].forEach((values) => values.splice(0, excess));
    state.live = { ...message.live, history, strips, log: message.log ?? log };
    for (const part of ["update", "status", "no_raw", "remarks", "spectrum", "curves", "settings_reply", "can_set", "recording_s"]) {
      if (part in message) state[part] = message[part];
    }
  }

  // Returns a copy that later messages do not change.
  frozen() {
    const copy = new Model();
    copy.missed = this.missed;
    copy.state = structuredClone(this.state);
    return copy;
  }
}
