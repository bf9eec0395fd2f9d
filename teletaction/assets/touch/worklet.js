// The sound: the position of the pointer, as it is told, becomes samples by WebAssembly.

// Seconds over which the least delay of a message counts as that of the way here.
const WINDOW_S = 5;

class Touch extends AudioWorkletProcessor {
  constructor({ processorOptions: { wasm, limits } }) {
    super();
    this.core = new WebAssembly.Instance(new WebAssembly.Module(wasm)).exports;
    this.core.begin(limits.voltage_v, limits.cutoff_hz, limits.slew_v_s, limits.fade_s, sampleRate);
    // From the page's clock to that of the sound: the least of this window and of the one before.
    this.offsets = [Infinity, Infinity];
    this.windowEnds_s = 0;
    this.reported_s = 0;
    this.recording = null;
    this.port.onmessage = ({ data }) => this.take(data);
  }

  take({ at, what, values }) {
    if (what === "down" || what === "moved") {
      this.learn(currentTime - at);
      // A pointer reports several positions at once.
      for (const [at_s, x_mm] of values) this.core[what](at_s + this.offset(), x_mm);
    } else if (what === "clock") {
      this.learn(currentTime - at);
    } else if (what === "record") {
      this.recording = { from_s: null, left: Math.round(values[0] * sampleRate), samples: [], offsets_s: [Infinity, -Infinity] };
    } else this.core[what](...values);
  }

  learn(offset) {
    if (currentTime >= this.windowEnds_s) {
      this.offsets = [this.offsets[1], Infinity];
      this.windowEnds_s = currentTime + WINDOW_S;
    }
    this.offsets[1] = Math.min(this.offsets[1], offset);
  }

  offset() {
    return Math.min(...this.offsets);
  }

  process(_, [[out]]) {
    for (let n = 0; n < out.length; n += 1) out[n] = this.core.sample(currentTime + n / sampleRate);
    this.record(out);
    if (currentTime - this.reported_s > 0.1) {
      this.reported_s = currentTime;
      this.port.postMessage({ late: this.core.late(), amplitude: this.core.amplitude(), offset_s: this.offset() });
    }
    return true;
  }

  // Gives the next samples to whoever wants to look at them: the test of the page does.
  record(out) {
    if (this.recording === null) return;
    this.recording.from_s ??= currentTime;
    const [[min, max], offset] = [this.recording.offsets_s, this.offset()];
    this.recording.offsets_s = [Math.min(min, offset), Math.max(max, offset)];
    const part = out.slice(0, this.recording.left);
    this.recording.samples.push(...part);
    this.recording.left -= part.length;
    if (this.recording.left > 0) return;
    const { from_s, samples, offsets_s } = this.recording;
    this.port.postMessage({ recorded: { from_s, rate_hz: sampleRate, samples, offsets_s } });
    this.recording = null;
  }
}

registerProcessor("touch", Touch);
