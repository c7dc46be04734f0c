// The websocket to the console: pictures with credit, states, requests with answers, heartbeats.
import { decode, TILE } from "./picture.js";
import { WORDS } from "./words.js";

const HEARTBEAT_MS = 1000, SILENT_MS = 2500, ASLEEP_MS = 1500, ANSWER_MS = 1000, FIRST_WAIT_MS = 100, LONGEST_WAIT_MS = 2000, AGAIN_MS = 2000, NO_TOKEN = 4401, REPLACED = 4409;

const beside = new Set(); // ends each socket beside the session's, without waiting for its close

export function openBeside(path, handlers, closed) {
  const socket = Object.assign(openSocket(path), handlers);
  const end = () => {
    socket.onopen = socket.onmessage = socket.onclose = null;
    beside.delete(end);
    socket.close();
    handlers.onclose?.();
    closed();
  };
  beside.add(end);
  socket.addEventListener("close", event => {
    if (beside.delete(end) && event.code !== NO_TOKEN) setTimeout(closed, AGAIN_MS);
  });
  return socket;
}

function openSocket(path) {
  const address = new URL(path, document.baseURI);
  address.search = location.search; // such as ?role=observe
  address.protocol = location.protocol === "https:" ? "wss:" : "ws:";
  const socket = new WebSocket(address);
  socket.binaryType = "arraybuffer";
  return socket;
}

export class Connection {
  constructor(heard) {
    this.heard = heard; // handlers: {open(), closed(refused), picture(p), tile(t), state(s)}
    this.socket = null;
    this.waiting = new Map();
    this.asked = 0;
    this.wait_ms = FIRST_WAIT_MS;
    this.timer = null;
    this.last_ms = -Infinity;
    this.alive_ms = -Infinity;
    this.drawn = 0;
  }

  start() {
    this.open();
    setInterval(() => this.beat(), HEARTBEAT_MS);
    document.addEventListener("resume", () => this.open());
    window.addEventListener("pageshow", () => this.wake());
    document.addEventListener("visibilitychange", () => {
      this.alive();
      if (!document.hidden) this.wake();
    });
  }

  get ready() {
    return this.socket !== null && this.socket.readyState === WebSocket.OPEN;
  }

  // readyState is still open after a freeze; only a recent message proves a connection.
  wake() {
    if (this.socket === null || performance.now() - this.last_ms > ASLEEP_MS) this.open();
  }

  open() {
    clearTimeout(this.timer);
    if (this.socket) this.drop(this.socket);
    for (const end of beside) end(); // what is lost with the session's network is seen by nobody else
    const socket = openSocket("session");
    this.socket = socket;
    this.last_ms = performance.now();
    socket.onopen = () => {
      this.wait_ms = FIRST_WAIT_MS;
      this.heard.open();
      this.alive();
    };
    socket.onmessage = event => {
      this.last_ms = performance.now();
      if (typeof event.data === "string") this.text(event.data);
      else this.binary(event.data);
    };
    socket.onclose = event => this.lost(event.code === NO_TOKEN, event.code === REPLACED && document.hidden);
  }

  drop(socket) {
    socket.onopen = socket.onmessage = socket.onclose = null;
    socket.close();
    this.fail();
  }

  // A hidden page that was replaced reconnects when it becomes visible.
  lost(refused, waits = false) {
    this.socket = null;
    this.fail();
    this.heard.closed(refused);
    if (refused || waits) return;
    this.timer = setTimeout(() => this.open(), this.wait_ms * (0.75 + 0.5 * Math.random()));
    this.wait_ms = Math.min(2 * this.wait_ms, LONGEST_WAIT_MS);
  }

  fail() {
    for (const answer of this.waiting.values()) answer({ ok: false, text: WORDS.noAnswer, details: {} });
    this.waiting.clear();
  }

  binary(buffer) {
    let message;
    try { message = decode(buffer); } catch { return; } // such as of a newer version
    if (message.kind === TILE) this.heard.tile(message);
    else this.heard.picture(message);
  }

  text(data) {
    let message;
    try { message = JSON.parse(data); } catch { return; }
    if (message.kind === "state") {
      this.heard.state(message);
      // Timers of a page that is hidden for minutes run once a minute; its messages come all the time.
      if (performance.now() - this.alive_ms > HEARTBEAT_MS) this.alive();
    }
    else if (message.kind === "answer") {
      const answer = this.waiting.get(message.id);
      this.waiting.delete(message.id);
      if (answer) answer(message);
    }
  }

  send(message) {
    if (this.ready) this.socket.send(JSON.stringify(message));
    return this.ready;
  }

  // Returns credit for a drawn picture; a picture that only arrived returns none.
  drew(sequence) {
    this.drawn = sequence;
    this.send({ kind: "drawn", sequence });
  }

  alive() {
    this.alive_ms = performance.now();
    this.send({ kind: "alive", visible: !document.hidden, sequence: this.drawn });
  }

  // Also a connection that does not open: a browser waits minutes for it.
  beat() {
    if (this.socket !== null && performance.now() - this.last_ms > SILENT_MS) this.open();
    this.alive();
  }

  newId() {
    this.asked += 1;
    return this.asked;
  }

  // Sends a request once; resolves with the answer or with a failure.
  ask(verb, details = {}) {
    const id = this.newId();
    return new Promise(resolve => {
      if (!this.send({ kind: "ask", id, verb, details })) {
        resolve({ ok: false, text: WORDS.notSent, details: {} });
        return;
      }
      const late = setTimeout(() => {
        this.waiting.delete(id);
        resolve({ ok: false, text: WORDS.noAnswer, details: {} });
      }, ANSWER_MS);
      this.waiting.set(id, answer => { clearTimeout(late); resolve(answer); });
    });
  }

  // Sends STOP, also again under the same id; no other request is repeated.
  repeat(id, verb, answered) {
    this.waiting.set(id, answered);
    return this.send({ kind: "ask", id, verb, details: {} });
  }
}
