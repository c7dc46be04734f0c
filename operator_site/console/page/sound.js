// Plays alarm sounds: bursts of pulses with a fundamental and six harmonics.
const FUNDAMENTAL_HZ = 440, HARMONICS = [0, 1, 0.7, 0.55, 0.4, 0.3, 0.2, 0.12], PULSE_S = { high: 0.15, medium: 0.2, low: 0.25 }, EDGE_S = 0.02;
export const AGAIN_S = { high: 4, medium: 20, low: Infinity };

// Returns the starts of a burst's pulses, s: high 3 + 2, a pause, and again; medium 3; low 1.
export function pulses(priority) {
  if (priority === "low") return [0];
  if (priority === "medium") return [0, 0.4, 0.8];
  const five = [0, 0.25, 0.5, 0.9, 1.15];
  return [...five, ...five.map(start => start + 1.9)];
}

let context = null, wave = null;

// A browser plays sound only after a person has used the page.
export function wakeSound() {
  if (context === null) {
    context = new AudioContext({ sampleRate: 48000 });
    wave = context.createPeriodicWave(new Float32Array(HARMONICS.length), new Float32Array(HARMONICS));
  }
  if (context.state === "suspended") context.resume();
}

export const audio = () => context;

export function soundPossible() {
  return context !== null && context.state === "running";
}

export function burst(priority) {
  if (!soundPossible()) return false;
  for (const start_s of pulses(priority)) {
    const oscillator = context.createOscillator(), gain = context.createGain();
    const from = context.currentTime + 0.02 + start_s, to = from + PULSE_S[priority];
    oscillator.setPeriodicWave(wave);
    oscillator.frequency.value = FUNDAMENTAL_HZ;
    gain.gain.setValueAtTime(0, from);
    gain.gain.linearRampToValueAtTime(0.5, from + EDGE_S);
    gain.gain.setValueAtTime(0.5, to - EDGE_S);
    gain.gain.linearRampToValueAtTime(0, to);
    oscillator.connect(gain).connect(context.destination);
    oscillator.start(from);
    oscillator.stop(to);
  }
  return true;
}
