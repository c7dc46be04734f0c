// Clutch and motion scale. A key or pedal holds the clutch open, the button opens and closes it.
import { ask } from "./actions.js";
import { byId, make, onChoice, remake, write } from "./dom.js";
import { controls, known, lastState, now } from "./now.js";
import { WORDS } from "./words.js";

const SCALES = [1, 2, 5];
let held = false;

export function startClutch() {
  const scale = byId("scale");
  scale.append(...SCALES.map(n => make("option", { value: n, text: `1:${n}` })));
  byId("clutch-button").addEventListener("click", () => ask("clutch", { open: !now.state.coupling.open }));
  onChoice(scale, async value => { await ask("scale", { scale: Number(value) }); showClutch(); });
  // Without the focus the release of a key is not seen: the clutch then stays open until the button closes it.
  window.addEventListener("blur", () => { held = false; });
}

const may = () => controls() && known();

export function holdClutch() {
  if (held || !may() || now.state.session.state !== "engaged") return;
  held = true;
  ask("clutch", { open: true });
}

export function releaseClutch() {
  if (!held) return;
  held = false;
  ask("clutch", { open: false });
}

export function showClutch() {
  const { open, scale, edges } = now.state?.coupling ?? { open: false, scale: 1, edges: [] }, state = lastState();
  const button = byId("clutch-button"), list = byId("scale");
  remake(button, [open], () => [make("span", { text: open ? WORDS.closeClutch : WORDS.clutch }), " ", make("kbd", { text: "G" })]);
  button.disabled = !may() || (state !== "engaged" && !open);
  button.setAttribute("aria-pressed", String(open));
  list.disabled = !may();
  if (document.activeElement !== list) list.value = String(scale);
  const shown = known() && ["engaged", "engaging", "paused"].includes(state);
  write(byId("coupling"), shown ? WORDS.coupling(open, scale, edges).join("\n") : "");
}
