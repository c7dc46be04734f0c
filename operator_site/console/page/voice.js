// The voice: Opus over a websocket of its own, coded by the browser, played by Web Audio. The page in control talks.
import { siteTime_s } from "./camera.js";
import { openBeside } from "./connection.js";
import { byId, write } from "./dom.js";
import { acts, controls, now, playback } from "./now.js";
import { audio } from "./sound.js";
import { WORDS } from "./words.js";

const MAGIC = 0x17ea9, HEADER = 28, PAGE_HEADER = 16, FRAME_S = 0.02, ALIVE_MS = 250;
const OLD_S = 0.5, FIRST_S = 0.06, MOST_S = 0.16, FASTER = 1.02;
const again = () => {}; // the next sound opens a new codec
const CONFIG = { codec: "opus", sampleRate: 48000, numberOfChannels: 1 };
let socket = null, decoder = null, encoder = null, microphone = null, problem = "", held = false, open = false;
let echo = {}, next_s = 0, sequence = 0, encoding = []; // times of sounds in the encoder

const words = WORDS.voice, codes = typeof AudioDecoder !== "undefined"; // on HTTPS and localhost
const clock_s = () => performance.now() / 1000, heard = () => audio()?.state === "running", connected = () => socket?.readyState === WebSocket.OPEN;
const may = () => controls() && Boolean(now.state.voice), talks = () => (held || open) && microphone && may();

function connect() {
  echo = { sent_s: 0, heard_s: 0 };
  socket = openBeside("voice", { onopen: alive, onmessage: event => take(event.data) }, () => { socket = null; });
}

// Reports this page's state and clock.
function alive() {
  if (connected()) socket.send(JSON.stringify({ page: now.state.you.name, microphone: Boolean(microphone), plays: heard(), ...echo, answered_s: clock_s() }));
}

function take(data) {
  const view = new DataView(data);
  if (data.byteLength < HEADER || view.getUint32(0, true) !== MAGIC) return;
  const captured_s = view.getFloat64(8, true);
  echo = { sent_s: view.getFloat64(16, true), heard_s: clock_s() };
  if (data.byteLength === HEADER || !heard() || (!playback() && siteTime_s() - captured_s > OLD_S)) return;
  if (decoder?.state !== "configured") {
    decoder = new AudioDecoder({ output: play, error: again });
    decoder.configure(CONFIG);
  }
  decoder.decode(new EncodedAudioChunk({ type: "key", timestamp: 1e6 * captured_s, data: new Uint8Array(data, HEADER) }));
}

// Plays a sound after the one before, faster while many wait.
function play(data) {
  const context = audio(), node = context.createBufferSource(), at_s = context.currentTime;
  if (next_s < at_s) next_s = at_s + FIRST_S;
  if (next_s - at_s <= MOST_S) {
    node.buffer = context.createBuffer(1, data.numberOfFrames, data.sampleRate);
    data.copyTo(node.buffer.getChannelData(0), { planeIndex: 0, format: "f32-planar" });
    node.playbackRate.value = next_s - at_s > FIRST_S + FRAME_S ? FASTER : 1;
    node.connect(context.destination);
    node.start(next_s);
    next_s += FRAME_S / node.playbackRate.value;
  }
  data.close();
}

async function openMicrophone() {
  if (microphone !== null) return;
  microphone = false; // it opens
  problem = "";
  try {
    if (!codes || !navigator.mediaDevices) throw new DOMException("", "NotSupportedError");
    const stream = await navigator.mediaDevices.getUserMedia({ audio: { channelCount: 1 } });
    await audio().audioWorklet.addModule("page/voice_worklet.js");
    const node = new AudioWorkletNode(audio(), "microphone", { numberOfOutputs: 0, channelCount: 1, channelCountMode: "explicit" });
    node.port.onmessage = event => encode(event.data);
    microphone = audio().createMediaStreamSource(stream);
    microphone.connect(node);
    stream.getAudioTracks()[0].onended = () => { microphone = null; problem = words.NotFoundError; };
  } catch (error) {
    microphone = null;
    problem = words[error.name] ?? words.NotFoundError;
    held = open = false;
  }
  alive();
}

function encode({ sound, begin_s }) {
  if (!talks()) return;
  if (encoder?.state !== "configured") {
    encoding = [];
    encoder = new AudioEncoder({ output: send, error: again });
    encoder.configure({ ...CONFIG, bitrate: 24000, bitrateMode: "constant" });
  }
  encoding.push(clock_s() - audio().currentTime + begin_s);
  const data = new AudioData({ ...CONFIG, format: "f32-planar", numberOfFrames: sound.length, timestamp: 1e6 * FRAME_S * (sequence + encoding.length), data: sound });
  encoder.encode(data);
  data.close();
}

function send(chunk) {
  const packed = new Uint8Array(PAGE_HEADER + chunk.byteLength), view = new DataView(packed.buffer);
  view.setUint32(0, MAGIC, true);
  view.setUint32(4, sequence += 1, true);
  view.setFloat64(8, encoding.shift(), true);
  chunk.copyTo(packed.subarray(PAGE_HEADER));
  if (talks() && connected()) socket.send(packed);
}

export function holdTalk() {
  if (!may()) return;
  held = true;
  openMicrophone();
}

export const releaseTalk = () => { held = false; };

export function toggleTalk() {
  open = !open && may();
  if (open) openMicrophone();
}

export function startVoice() {
  byId("talk").addEventListener("pointerdown", holdTalk);
  byId("talk").addEventListener("click", event => { if (event.detail === 0) toggleTalk(); }); // a keyboard or assistive software cannot hold it
  for (const kind of ["pointerup", "pointercancel", "blur"]) window.addEventListener(kind, releaseTalk);
  byId("talk-open").addEventListener("click", toggleTalk);
  setInterval(alive, ALIVE_MS);
}

function own(voice) {
  if (!may()) return voice.talker && words.other(voice.talker);
  if (problem || !talks()) return problem || words.off;
  return connected() && voice.hears ? words.talks : words.unheard;
}

// Runs ten times a second.
export function showVoice() {
  const voice = now.state?.voice;
  byId("voice").hidden = !voice;
  if (!voice) return;
  if (!socket && now.connected && codes) connect();
  if (!may()) open = held = false;
  for (const [id, on] of [["talk", Boolean(talks())], ["talk-open", open]]) {
    byId(id).hidden = !acts();
    byId(id).disabled = !may();
    byId(id).setAttribute("aria-pressed", on);
  }
  const far = codes ? words.far[connected() ? voice.heard : "silent"] : words.NotSupportedError;
  write(byId("voice-said"), [far, own(voice), voice.recorded && words.recorded].filter(Boolean).join(" · "));
}
