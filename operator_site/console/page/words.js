// All texts of the page. The server sends those of alarms, refusals, findings and answers.
export const FINGERS = ["thumb", "index", "middle", "ring", "little"];
export const capital = name => name[0].toUpperCase() + name.slice(1);
export const FINGER_NAMES = FINGERS.map(capital);
export const FINGER_IDS = FINGERS.map((_, finger) => `D${finger + 1}`); // as anatomy counts them
export const DEVICE_LABELS = [...FINGERS.map((name, finger) => [name, FINGER_IDS[finger]]), ["exoskeleton", "exoskeleton"], ["remote hand", "remote hand"]];
export const MODES = ["free", "tapping", "resting", "stroking"];
export const KINDS = ["rough", "warm", "cold", "stiff", "soft", "other", "tender"];
export const BODY_SIDES = ["right", "left", "both", ""];
export const SIDES = ["", "head", "feet", "left", "right"];

export const STATES = {
  unknown: "NOT LIVE", disconnected: "DISCONNECTED", connected: "CONNECTED", engaging: "ENGAGING", engaged: "ENGAGED",
  paused: "PAUSED", lost: "LINK LOST", fault: "FAULT", stopped: "STOPPED", stopping: "STOPPING", playback: "PLAYBACK",
};

const RECORDED = { touch: "touch", pain: "pain answers", picture: "pictures", voice: "sound" };

// Texts of index.html.
export const FIXED = {
  console: "Console", stop: "STOP", help: "Help", alarms: "Alarms", acknowledge: "Acknowledge", scale: "Motion scale, hand to remote hand", stopAnswers: "What the devices answered to STOP", actions: "Actions",
  camera: "Camera:", voice: "Voice", talk: "Talk", unmute: "Open microphone",
  finding: "Finding", note: "Note", map: "Tactile map", quantities: "Quantity on the map", mapTable: "The map as a table",
  zoomIn: "Zoom in", zoomOut: "Zoom out", fit: "Fit", compare: "Compare", both: "Two", sure: "± sd",
  photo: "Picture", photoChoose: "Choose a file", photoCamera: "Camera", photoMarks: "Touch marks", photoAdjust: "Move and size", photoSmaller: "Picture smaller", photoLarger: "Picture larger", photoRemove: "Remove", fingers: "Fingers", drawing: "Hand; the table below says the same",
  chart: "Probability of each material since contact; a table follows", chartTable: "Probabilities as a table",
  lastSeconds: "Last 10 seconds", now: "now", strips: "Signals of the last 10 s; a table follows", stripTable: "Signals as a table",
  markFinding: "Mark a finding", kinds: "Kind of finding", save: "Save", discard: "Discard",
  markingHelp: "Arrows: 1 mm, with Shift 5",
  body: "Body", bodyMark: "Place on the body", bodyViews: "View", bodyRegions: "Region", bodySides: "Side of the examined person", landmark: "Landmark", landmarkMm: "mm from it",
  useBody: "Use this place", noBody: "No place", withdraw: "Withdraw", reason: "Reason", cancel: "Cancel",
  noteTo: "Note to", saveNote: "Save note", close: "Close", details: "Details", playback: "Playback", position: "Position in the recording", timeLine: "Time line: states, findings, alarms, faults; [ and ] jump", speed: "Speed",
  session: "Examination", startSession: "Begin an examination", studyNumber: "Study number", mapTop: "Map: top is", mapRight: "right is",
  begin: "Begin", sound: "Alarm sound", playAlarm: "Play alarm sound", heard: "I heard it", withoutSound: "Work without sound", takeControl: "Take control",
  openReport: "Open report", checkList: "Check list", keys: "Keys", link: "link",
  noEmergencyStop: "STOP on this page is not an emergency-stop device. The hardware switch is. A hidden page has no STOP key.",
};

export const WORDS = {
  spaceKey: "Space", escapeKey: "Esc", stopKeyOff: "press here",
  noAlarms: "No alarms", pausedBy: why => `PAUSED. ${why}.`, more: count => `+${count} (A)`, alarmList: "List (A)",
  engage: "Engage", confirmEngage: "Confirm engage", resume: "Resume", confirmResume: "Confirm resume", pause: "Pause",
  clear: "Clear fault", confirmClear: "Confirm clear", startSession: "Begin", hold: "hold 1 s",
  clutch: "Clutch", closeClutch: "Close clutch", coupling: (open, scale, edges) => [...(scale > 1 ? [`1:${scale}`] : []), ...(open ? ["clutch open"] : []), ...(edges.length ? [`edge: ${edges.join(", ")}`] : [])],
  pain: (pain, age_s) => (typeof pain === "number" ? `Pain ${pain.toFixed(1)} of 10, ${age_s.toFixed(1)} s old` : "Pain: no answer"), painNotLive: "Pain: not live", tenderCircle: "most tender, 95 %",
  stopping: "STOPPING. Waiting for the devices.", stopNotSent: "STOP NOT SENT. Use the hardware switch.",
  stopConfirmed: (count, seconds) => `STOPPED. All ${count} devices confirmed in ${seconds.toFixed(2)} s.`,
  stopNotConfirmed: names => `STOP NOT CONFIRMED: ${names}. Use the hardware switch.`,
  waiting: "waiting", stopped: "stopped", stoppedIn: seconds => `${seconds.toFixed(2)} s`,
  noData: seconds => `No data for ${seconds.toFixed(1)} s. Screen is not live.`,
  noConnection: "No connection to the console. Trying again.", refused: "This address needs its token. Open the link that the console printed.",
  noAnswer: "No answer from the console. Nothing is repeated: check the state, then press again.", notSent: "Not sent: no connection.",
  sessionOpen: (pseudonym, body) => `Examination ${pseudonym} is open${body ? `: ${body}` : ""}.`,
  noSession: "No examination is open.", end: "End examination",
  consents: names => `The patient agrees to have recorded: ${names.map(name => RECORDED[name]).join(", ")}.`,
  confirmEnd: (pseudonym, findings) => `End examination ${pseudonym}? ${count(findings, "finding")}.`,
  observer: control => `OBSERVER. Control is at ${control}.`, controlElsewhere: control => `Control is at ${control}.`,
  quiet: "Pause sound 60\u00a0s (Q)", quietFor: seconds => `Sound paused ${seconds}\u00a0s`,
  soundAsk: "Did you hear it?", soundHeard: "Alarm sound was heard.", soundRefused: "Alarms make no sound here.", soundNeeded: "Engaging needs this answer once.",
  soundBlocked: "No sound before you press something.", noSoundYet: "No alarm sound in this page. Click into it once.",
  recording: "● REC", notRecording: "not recording",
  against: ({ temperature, stiffness }) => [temperature, stiffness && `${stiffness} as stiff`].filter(Boolean).join(", "),
  held: (name, seconds) => `${name}, ${seconds.toFixed(1)} s ago`,
  oldFinger: (name, seconds) => `${name}, ${seconds.toFixed(1)} s old`,
  active: (name, seconds) => (typeof seconds !== "number" ? name : `${name}, ${seconds.toFixed(1)} s since contact`), auto: "auto",
  notCalibrated: "Accuracy of these answers: not known.", object: "object", uncertain: ", uncertain",
  stiffness: "stiffness", roughness: "roughness", groove: "groove period", rest: "rest", none: "none of these",
  legendUnit: { temperature: "°C", stiffness: "N/m", material: "" }, roughnessUnit: { um: "µm", level: "of 10" }, differenceUnit: "K", ratioUnit: "times",
  comparisons: { none: "Values", around: "Surroundings", mirror: "Mirror image", before: "Before" },
  axisHere: "Mirror line here", keepNow: "Keep as before", nothingBefore: "Press: Keep as before. Then touch again.",
  mirrored: (here, there) => `${here} · mirrored: ${there}`, notAPicture: "This file is no picture.",
  spreadUnit: { temperature: "± K", roughness: "± %", stiffness: "± %", material: "others %" },
  confidenceFoot: "sure →",
  nothingHere: "Nothing felt here.", pointAtMap: "Point at the map or tap it. Tab to it: arrows.",
  placeOf: (x, y) => `x ${x.toFixed(0)} y ${y.toFixed(0)} mm`, mapName: (quantity, comparison) => `Map of ${quantity}${comparison === "none" ? "" : ` against ${WORDS.comparisons[comparison].toLowerCase()}`}; a table follows`,
  findingAt: (finger, x, y, id) => `Finding${id ? ` ${id}` : ""} at ${finger}, ${x === null ? "no place" : `x ${x.toFixed(0)} y ${y.toFixed(0)} mm`}`,
  findingsTitle: standing => count(standing, "finding"), undo: "Undo", undoOf: id => `Undo the last change of finding ${id}`, edit: "Edit", editOf: id => `Edit finding ${id}`, noPlace: "no place",
  withdrawn: reason => `withdrawn: ${reason}`, withdrawAsk: id => `Withdraw finding ${id}? It stays in the record, struck out.`, reasonNeeded: "Give a reason.",
  proposed: kind => `Proposed ${kind}`, confident: step => `Confidence: ${step}.`, chooseBody: "Choose", bodyAsk: "Choose a region.", landmarkFar: mm => `The distance is a number from 0 to ${mm} mm.`, noSide: "no side", landmarkAt: (name, mm) => `${Number.isFinite(mm) ? `${mm} mm from` : "at"} ${name}`,
  noFindings: "No findings yet.", markFirst: "No findings yet. F marks one.", notSaved: "not yet on disk", noteSaving: "Saving…", limit: "LIMIT", softened: "∪ soft", limits: names => `limit: ${names.join(", ")}`, old: seconds => `${seconds.toFixed(1)} s`,
  camera: {
    live: age_s => `Picture ${age_s.toFixed(2)} s`, late: age_s => `Picture late by ${age_s.toFixed(1)} s`, frozen: age_s => `Picture frozen for ${age_s.toFixed(1)} s`,
    waiting: "No picture yet", no_camera: "No camera", refused: "Camera refuses the key", reduced: "Reduced for touch",
    still: secure => `Still pictures: ${secure ? "this browser decodes no video" : "this page has no HTTPS"}`,
  },
  voice: {
    far: { live: "Voice", muted: "Remote microphone muted", no_microphone: "No remote microphone", silent: "No voice", refused: "Voice refuses the key" },
    off: "you are muted", talks: "you are talking", unheard: "nobody hears you", other: who => `${who} talks`, recorded: "recorded",
    NotSupportedError: "no voice here: HTTPS or localhost is needed", NotAllowedError: "microphone refused", NotFoundError: "no microphone",
  },
  cameraNeeds: "No picture: HTTPS or localhost is needed, or the extra camera at the console.",
  markAsk: (number, of) => `Mark ${number} of ${of}: touch it, then tap it in the picture.`, markTouch: "No finger touches. Touch the mark first.",
  markError: error_mm => `Registered: error ${error_mm.toFixed(1)} mm.`, markLine: "Not registered: the marks are on one line.",
  rows: { force_n: "force N", plate_c: "plate °C", motor_hz: "vibration Hz", mode: "mode", remarks: "limit, age" },
  strips: [["force", "N"], ["contact", "N"], ["motor", "Hz"], ["plate", "°C"]],
  lastTable: "Smallest and largest of the last 10 s",
  stripTable: ["finger", "force N", "contact N", "motor Hz", "plate °C", "skin °C"],
  chartTable: ["s since contact", "material", "probability"], mapTable: ["x mm", "y mm", "explored", "lowest", "highest"],
  alarmAge: (active, since_s) => `${active ? "for " : ""}${since_s < 60 ? `${since_s.toFixed(0)} s` : `${Math.floor(since_s / 60)} min`}${active ? "" : " ago"}`,
  since: clock, lasted: seconds => `lasted ${seconds.toFixed(1)} s`, clearedBy: who => `acknowledged by ${who}`, present: "now", waits: "over, not acknowledged", past: "over",
  markKinds: { finding: "finding", clutch: "hand", alarm: "alarm", fault: "fault", mode: "state" }, marked: (at, kind, text) => `${clock(at)} ${kind}: ${text}`,
  partial: "Map and last 10 s follow.", play: "Play", pausePlay: "Pause", position: (at, length) => `${clock(at)} of ${clock(length)}`,
  letters: on => (on ? "Letter keys: on" : "Letter keys: with Alt"), theme: dark => (dark ? "Light (L)" : "Dark (L)"),
  ready: "ready", notLive: "not live", notLiveFor: seconds => (seconds > 0 && Number.isFinite(seconds) ? `not live, ${seconds.toFixed(1)} s` : "not live"),
};

// Values of things that people know: °C, N/m, µm. docs/how-it-works/tactile-map.md has their sources.
export const ANCHORS = {
  temperature: [[20, "room"], [33, "skin"], [36, "lukewarm"], [41, "hot bath"]],
  stiffness: [[350, "fat"], [830, "muscle"], [13000, "rubber"]],
  roughness_um: [[3.6, "fine sandpaper"], [42, "sandpaper"]],
};

export const KEYS = [
  ["Space, Esc", "STOP while engaging, engaged, paused; in a text field only Esc"], ["E", "hold 1 s: engage, resume; or twice, 0.5 s apart"], ["P", "pause"], ["G, F9 or pedal", "hold: clutch open, the remote hand stays"],
  ["C", "hold 1 s: clear a fault of a site"], ["K", "acknowledge alarms that are over"], ["F, N", "finding, note"], ["1–5, 0", "finger D1 thumb to D5 little, or the one that touched last"], ["T R S M", "quantity on the map"],
  ["U", "how sure the map is"], ["V", "two maps"], ["B", "compare"], ["+ − X", "zoom, fit"], [", .", "narrower, wider colours"], ["A, Q", "alarms, pause the sound for 60 s"], ["D", "details"], ["W", "camera: small, large, off"], ["H, O", "hold: talk; open microphone"],
  ["N, ° below a finger", "force at your finger; temperature of its plate, not of the object, °C"], ["LIMIT", "an output is at its limit: move slower, or lift"], ["∪ soft", "the surface is stiffer than the force displays; nothing to do"],
  ["L", "light or dark"], ["?", "keys"], ["Playback", "Space plays, arrows 1 s, Shift 10 s, [ ] events, Home, End"],
];

export function clock(seconds) {
  const whole = Math.max(0, Math.floor(seconds));
  return [whole / 3600, (whole / 60) % 60, whole % 60].map(part => String(Math.floor(part)).padStart(2, "0")).join(":");
}

export function count(number, thing) {
  return `${number} ${thing}${number === 1 ? "" : "s"}`;
}

// Rounds the sd to one significant digit, and the value to the same place.
export function withSd(value, sd, digits = 1) {
  if (typeof value !== "number") return "--";
  if (!(sd >= 0) || sd === null) return `${value.toFixed(digits)} ± ?`;
  let place = sd > 0 ? -Math.floor(Math.log10(sd)) : digits;
  if (sd > 0 && Math.round(sd * 10 ** place) >= 10) place -= 1; // 0.96 is 1, not 1.0
  const step = 10 ** -place;
  const shown = Math.max(0, Math.min(6, place));
  return `${(Math.round(value / step) * step).toFixed(shown)} ± ${(Math.round(sd / step) * step).toFixed(shown)}`;
}

export function percent(probability) {
  return probability >= 0.995 ? "> 99 %" : `${Math.round(probability * 100)} %`;
}

// Returns the first letter of each material, or two where another begins alike.
export function marks(names) {
  const first = names.map(name => name.slice(0, 1));
  return names.map((name, at) => capital(first.indexOf(first[at]) === first.lastIndexOf(first[at]) ? first[at] : name.slice(0, 2)));
}

export function delay(link) {
  if (typeof link?.delay_ms !== "number") return "--";
  const sd = link.delay_sd_ms;
  if (typeof sd === "number" && link.delay_ms < sd) return `< ${Math.ceil(sd)} ms`;
  return `${withSd(link.delay_ms, sd, 0)} ms`;
}

export function linkMore(link) {
  const age = typeof link?.age_ms === "number" ? `${link.age_ms.toFixed(0)} ms` : "--";
  const loss = typeof link?.loss === "number" ? `${(link.loss * 100).toFixed(link.loss < 0.1 ? 1 : 0)} %` : "--";
  return `age ${age} · loss ${loss}`;
}

export function speakIn(root) {
  for (const element of root.querySelectorAll("[data-word]")) element.textContent = FIXED[element.dataset.word];
  for (const element of root.querySelectorAll("[data-name]")) element.setAttribute("aria-label", FIXED[element.dataset.name]);
}
