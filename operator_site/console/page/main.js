// Connects the parts: draws once a frame, updates numbers four times a second.
import { showActions, startActions } from "./actions.js";
import { showAlarms, showList, soundAlarms, startAlarms } from "./alarms.js";
import { showBar, stepMark } from "./bar.js";
import { followClock, showCamera, startCamera } from "./camera.js";
import { showClutch, startClutch } from "./clutch.js";
import { drawChart, followChart, startChart } from "./chart.js";
import { Connection } from "./connection.js";
import { startDetails } from "./details.js";
import { byId, write } from "./dom.js";
import { startBody } from "./body.js";
import { openWithdraw, showFindings, startFindings } from "./findings.js";
import { followFingers, showFingers, startFingers } from "./fingers.js";
import { drawHand } from "./hand.js";
import { showIdentification } from "./identification.js";
import { startKeys } from "./keys.js";
import { drawMap, followMap, readOut, subscribe, showMapTable, startMap, takeTile } from "./map.js";
import { cameraDrew } from "./map_photo.js";
import { marked, moveTo, showMarking, startMarking } from "./marking.js";
import { showNotes, startNotes } from "./notes.js";
import { followContact, live, now, shownState } from "./now.js";
import { showPatient } from "./patient.js";
import { showPlayback, startPlayback } from "./playback.js";
import { showSession, startSession } from "./session.js";
import { startSheets } from "./sheets.js";
import { wakeSound } from "./sound.js";
import { sendKept, showStop, startStop } from "./stop.js";
import { drawStrips, showStripTable, startStrips } from "./strips.js";
import { startTheme } from "./theme.js";
import { showVoice, startVoice } from "./voice.js";
import { speakIn, STATES } from "./words.js";

const NUMBERS_MS = 250, STATE_MS = 100, SAID_MS = 6000;
const pending = [];
let framed = false, said = { text: "", until_ms: 0, under: null, names: null };

const connection = new Connection({
  open() {
    now.connected = true;
    now.refused = false;
    pending.length = 0;
    sendKept();
    subscribe();
  },
  closed(refused) {
    now.connected = false;
    now.refused = refused;
    showNow();
  },
  picture(picture) {
    picture.came_ms = performance.now(); // a later state may be drawn first
    followClock(picture);
    pending.push(picture);
    if (!framed) { framed = true; requestAnimationFrame(draw); }
  },
  tile: takeTile,
  state(state) {
    now.state = state;
    now.stateAt_ms = performance.now();
    followChart(state);
    followMap(state);
    drawChart();
    showNow();
  },
});

// Returns credit once the pictures are on the canvases.
function draw() {
  framed = false;
  const pictures = pending.splice(0);
  for (const picture of pictures) {
    now.picture = picture;
    now.pictureAt_ms = performance.now();
    followContact(picture);
    followFingers(picture);
    drawStrips(picture);
    stepMark();
  }
  if (!now.picture) return;
  drawHand(now.picture);
  drawMap(marked());
  for (const picture of pictures) connection.drew(picture.sequence);
}

// Runs ten times a second, so that a standstill shows soon.
function showState() {
  showAlarms(); // first: time passes between both, and no state that acts may stand over an alarm of an old screen
  showBar();
  showCamera();
  showVoice();
  dropSaid();
}

function showNow() {
  showState();
  soundAlarms(); // with each state, too: timers of a page that is hidden for minutes run once a minute
  showStop();
  showActions();
  showClutch();
  showPatient();
  showSession();
  showFindings();
  showPlayback();
}

function showNumbers() {
  // A standstill must grey out, too.
  if (now.picture && !live()) { drawHand(now.picture); drawMap(marked()); }
  showNow();
  showFingers();
  showIdentification();
  showMarking();
  showNotes();
  showStripTable();
  showMapTable();
  readOut(performance.now() < said.until_ms ? said.text : "");
}

// Shows an answer below the map for 6 s and announces it.
function say(text) {
  const names = Object.values(STATES).find(word => text.startsWith(word)) ?? null;
  said = { text, until_ms: performance.now() + SAID_MS, under: STATES[shownState()], names };
  byId("polite").textContent = text;
  readOut(text);
}

// An answer that names a state is shown only in that state and in the one in which it came.
function dropSaid() {
  const shown = STATES[shownState()];
  if (said.names === null || shown === said.under) return;
  if (shown === said.names) said.under = shown;
  else {
    if (byId("polite").textContent === said.text) write(byId("polite"), "");
    said = { text: "", until_ms: 0, under: null, names: null };
    readOut("");
  }
}

function choose(finger) {
  now.chosen = finger;
  if (finger !== null) now.active = finger;
  drawChart();
  showNumbers();
}

speakIn(document);
startStrips();
startChart();
startFingers(choose);
startMap(connection, moveTo);
startTheme();
startAlarms();
startStop(connection, showNow);
startActions(connection, say);
startClutch();
startCamera(cameraDrew);
startVoice();
startMarking(openWithdraw);
startFindings();
startBody();
startNotes();
startPlayback();
startSession();
startSheets(showList);
const details = startDetails(() => { if (now.picture) drawHand(now.picture); drawChart(); });
startKeys({ choose, details, listed: showList });
window.addEventListener("pointerdown", wakeSound, { capture: true });
window.addEventListener("keydown", wakeSound, { capture: true });
document.addEventListener("focusin", showStop);
document.addEventListener("focusout", () => setTimeout(showStop));
setInterval(showNumbers, NUMBERS_MS);
setInterval(showState, STATE_MS);
showNow();
wakeSound(); // a browser that is set so allows it at once
connection.start();
