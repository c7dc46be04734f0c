// Units of the map: what a value is shown as, and things that people know beside it.
import { now } from "./now.js";
import { ANCHORS, WORDS } from "./words.js";

const SCALE_V = [0.002, 0.2];

// Ends of the console's scale are the levels 0 and 10.
const levels = () => now.state?.map?.legend?.roughness ?? SCALE_V;
const scaled = () => now.state?.map?.roughness_um ?? null;
const holds = (scale, value_v) => value_v >= scale.holds_v[0] && value_v <= scale.holds_v[1];
const inUm = (scale, value_v) => Math.exp(scale.ln_um + scale.exponent * Math.log(value_v));

// Returns the scale in um for a roughness in V; null where the sensor was not calibrated for it.
function scaleOf(value_v) {
  const scale = scaled();
  return scale && holds(scale, value_v) ? scale : null;
}

function level(value_v) {
  const [low, high] = levels();
  return 10 * Math.log(value_v / low) / Math.log(high / low);
}

// Converts a roughness in V and its spread to [value, spread, unit]: um, or a level of 0 to 10.
export function roughness(value_v, sd_v) {
  const scale = scaleOf(value_v), relative = typeof sd_v === "number" ? sd_v / value_v : null, [low, high] = levels();
  if (!scale) return [level(value_v), relative === null ? null : 10 * relative / Math.log(high / low), WORDS.roughnessUnit.level];
  const value_um = inUm(scale, value_v);
  return [value_um, relative === null ? null : value_um * Math.hypot(scale.exponent * relative, scale.ln_sd), WORDS.roughnessUnit.um];
}

export function unitOf(quantity) {
  return quantity === "roughness" ? WORDS.roughnessUnit[scaled() ? "um" : "level"] : WORDS.legendUnit[quantity];
}

// Writes a value in the map's unit; beyond the calibrated range in um, only that it is below or above the range.
export function numberText(quantity, value, digits) {
  if (quantity !== "roughness") return digits(value);
  const scale = scaled();
  if (!scale) return digits(level(value));
  const [low, high] = scale.holds_v;
  return value < low ? `< ${digits(inUm(scale, low))}` : value > high ? `> ${digits(inUm(scale, high))}` : digits(inUm(scale, value));
}

// Returns [value in the map's unit, name] of known things on a scale.
export function anchors(quantity) {
  if (quantity !== "roughness") return ANCHORS[quantity] ?? [];
  const scale = scaled();
  if (!scale) return [];
  return ANCHORS.roughness_um.map(([um, name]) => [Math.exp((Math.log(um) - scale.ln_um) / scale.exponent), name]).filter(([value_v]) => holds(scale, value_v));
}
