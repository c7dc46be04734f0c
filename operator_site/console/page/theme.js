// Sets light or dark, by the system's setting until the user chooses; gives the canvases their colours.
import { byId, remember, remembered, write } from "./dom.js";
import { WORDS } from "./words.js";

const NAMES = ["ground", "panel", "text", "muted", "line", "faint", "mark"];
export const colour = {};
const watching = [];
let chosen = null; // the user's theme

export function onTheme(redraw) {
  watching.push(redraw);
}

function apply(theme) {
  document.documentElement.dataset.theme = theme;
  const style = getComputedStyle(document.documentElement);
  for (const name of NAMES) colour[name] = style.getPropertyValue(`--${name}`).trim();
  write(byId("theme-button"), WORDS.theme(theme === "dark"));
  for (const redraw of watching) redraw();
}

export function startTheme() {
  const kept = remembered("theme"), light = window.matchMedia("(prefers-color-scheme: light)");
  if (["light", "dark"].includes(kept)) chosen = kept;
  light.addEventListener("change", () => { if (!chosen) apply(light.matches ? "light" : "dark"); });
  apply(chosen ?? (light.matches ? "light" : "dark"));
}

export function otherTheme() {
  chosen = document.documentElement.dataset.theme === "dark" ? "light" : "dark";
  remember("theme", chosen);
  apply(chosen);
}
