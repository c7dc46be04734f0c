// Comparisons on the map: each cell against its surroundings, against its mirror image, or against an earlier map.
// A difference is in K, or the natural logarithm of a ratio.
import { confidenceOf, kept, LOGARITHMIC, SIDE, UNEXPLORED, valueOf } from "./map_tiles.js";

export const COMPARISONS = ["none", "around", "mirror", "before"];
/** Differences at the ends of the colours: K, or the logarithm of a ratio. */
export const SPAN = { temperature: 3, roughness: Math.log(3), stiffness: Math.log(3) };
// Surroundings are a square ring, as wide as those of a finding; with fewer cells nothing is compared.
const INNER = 10, OUTER = 30, FEWEST = 60;
const before = new Map();

export const comparable = quantity => quantity !== "material";

// Keeps the present map of all quantities as the earlier one.
export function keepBefore(range) {
  for (const quantity of Object.keys(SPAN)) before.set(quantity, levels(quantity, range(quantity)));
}

export function forgetBefore() {
  before.clear();
}

export const hasBefore = quantity => before.has(quantity);

// Returns the levels of all cells, K or logarithms; NaN where they are not known well enough to be coloured.
function levels(quantity, range) {
  const { values, spreads } = kept[quantity], found = new Float32Array(SIDE * SIDE).fill(NaN);
  for (let cell = 0; cell < found.length; cell += 1) {
    if (values[cell] === UNEXPLORED || confidenceOf(quantity, spreads[cell]) === 0) continue;
    const value = valueOf(quantity, values[cell], range);
    found[cell] = LOGARITHMIC.includes(quantity) ? Math.log(value) : value;
  }
  return found;
}

// Returns each cell's difference from its reference; NaN without one. axis: column of the mirror, in cells.
export function differences(quantity, comparison, range, axis) {
  const mine = levels(quantity, range);
  const theirs = comparison === "around" ? surroundings(mine) : comparison === "mirror" ? mirrored(mine, axis) : before.get(quantity);
  return mine.map((level, cell) => level - (theirs?.[cell] ?? NaN));
}

function mirrored(levels, axis) {
  return levels.map((_, cell) => {
    const row = Math.floor(cell / SIDE), column = Math.round(2 * axis - (cell % SIDE) - 1);
    return column >= 0 && column < SIDE ? levels[row * SIDE + column] : NaN;
  });
}

// Mean of a ring around each cell, from sums over rectangles.
function surroundings(levels) {
  const wide = SIDE + 1, sums = new Float64Array(wide * wide), counts = new Float64Array(wide * wide);
  for (let row = 0; row < SIDE; row += 1) {
    for (let column = 0; column < SIDE; column += 1) {
      const level = levels[row * SIDE + column], known = Number.isNaN(level) ? 0 : 1, at = (row + 1) * wide + column + 1;
      sums[at] = sums[at - 1] + sums[at - wide] - sums[at - wide - 1] + (known ? level : 0);
      counts[at] = counts[at - 1] + counts[at - wide] - counts[at - wide - 1] + known;
    }
  }
  const within = (table, row, column, reach) => {
    const top = Math.min(SIDE, row + reach + 1), bottom = Math.max(0, row - reach), right = Math.min(SIDE, column + reach + 1), left = Math.max(0, column - reach);
    return table[top * wide + right] - table[bottom * wide + right] - table[top * wide + left] + table[bottom * wide + left];
  };
  return levels.map((level, cell) => {
    if (Number.isNaN(level)) return NaN;
    const row = Math.floor(cell / SIDE), column = cell % SIDE, ring = table => within(table, row, column, OUTER) - within(table, row, column, INNER);
    const count = ring(counts);
    return count < FEWEST ? NaN : ring(sums) / count;
  });
}
