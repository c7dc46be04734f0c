// Collects the microphone's samples into sounds of 20 ms, with the time of the first sample on the audio clock, s.
const SAMPLES = 960;

registerProcessor("microphone", class extends AudioWorkletProcessor {
  waiting = [];

  process([[samples]]) {
    this.waiting.push(...(samples ?? []));
    const begin_s = currentTime + ((samples?.length ?? 0) - this.waiting.length) / sampleRate;
    if (this.waiting.length >= SAMPLES) this.port.postMessage({ sound: new Float32Array(this.waiting.splice(0, SAMPLES)), begin_s });
    return true;
  }
});
