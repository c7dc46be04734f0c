// Region D: tiles of each quantity, painted through the colour tables with confidence as opacity.
import { BACKGROUND, MATERIALS, OPACITY, TABLES } from "./colours.js";

export const QUANTITIES = ["temperature", "roughness", "stiffness", "material"], SIDE = 256, TILE = 32, UNEXPLORED = 65535;
export const LOGARITHMIC = ["roughness", "stiffness"];
const CODES = 65534;
// Flag of a spread; largest spread of each confidence; ends of the scale that key U shows, K and %.
const STEEP = 128, CONFIDENT = [72, 64, 56], CONFIDENT_MATERIAL = [50, 10, 2];
export const SPREADS = { temperature: [0.125, 2], roughness: [3.75, 60], stiffness: [5, 80], material: [0, 50] };
// Of each quantity: codes and spreads of all cells, row by row from the near edge.
export const kept = Object.fromEntries(QUANTITIES.map(name => [name, { values: new Uint16Array(SIDE * SIDE).fill(UNEXPLORED), spreads: new Uint8Array(SIDE * SIDE) }]));

export function forgetTiles() {
  for (const { values } of Object.values(kept)) values.fill(UNEXPLORED);
}

export function keepTile(tile) {
  const { values, spreads } = kept[QUANTITIES[tile.quantity]];
  for (let row = 0; row < TILE; row += 1) {
    const to = (tile.row * TILE + row) * SIDE + tile.column * TILE, from = row * TILE;
    values.set(tile.values.subarray(from, from + TILE), to);
    spreads.set(tile.spreads.subarray(from, from + TILE), to);
  }
}

// Converts a cell's code to a value, with the range of the state.
export function valueOf(quantity, code, range) {
  if (quantity === "material") return code;
  const share = code / CODES, [low, high] = range;
  return LOGARITHMIC.includes(quantity) ? low * (high / low) ** share : low + share * (high - low);
}

// Returns the place of a value on the legend's scale, 0..1 between its ends.
export function placeOf(quantity, value, [low, high]) {
  return LOGARITHMIC.includes(quantity) ? Math.log(value / low) / Math.log(high / low) : (value - low) / (high - low);
}

export function inkOf(quantity, place) {
  const table = quantity === "material" ? MATERIALS : TABLES[quantity];
  const entry = quantity === "material" ? Math.min(4, place) : Math.round(255 * Math.min(1, Math.max(0, place)));
  return [table[3 * entry], table[3 * entry + 1], table[3 * entry + 2]];
}

export function over(ink, confidence) {
  const share = OPACITY[confidence];
  return ink.map((part, at) => Math.round(share * part + (1 - share) * BACKGROUND[at]));
}

export function confidenceOf(quantity, spread) {
  return (quantity === "material" ? CONFIDENT_MATERIAL : CONFIDENT).filter(most => (spread & ~STEEP) <= most).length;
}

// Returns the colour of a spread on the scale of key U: white is well known, dark is uncertain.
function unsureInk(quantity, spread) {
  return inkOf("stiffness", quantity === "material" ? (spread & ~STEEP) / 50 : ((spread & ~STEEP) - 48) / 32);
}

// Paints tiles into 256 x 256 pixels, far edge on top: colours, and masks of stippled, dotted and steep.
// how: range and legend of the quantity; sure, to show the spread; or differences of all cells, with the span of the colours.
export class Painting {
  constructor() {
    this.layers = ["colours", "stippled", "dotted", "steep"].map(name => {
      this[name] = Object.assign(document.createElement("canvas"), { width: SIDE, height: SIDE });
      return [this[name].getContext("2d"), new ImageData(TILE, TILE)];
    });
    this.beyond = [false, false];
  }

  tile(quantity, column, row, { range, legend, sure, differences, span }) {
    const { values, spreads } = kept[quantity], [image, stippled, dotted, steep] = this.layers.map(([, part]) => part.data.fill(0));
    for (let y = 0; y < TILE; y += 1) {
      for (let x = 0; x < TILE; x += 1) {
        const cell = (row * TILE + y) * SIDE + column * TILE + x, code = values[cell];
        if (code === UNEXPLORED) continue;
        const pixel = 4 * ((TILE - 1 - y) * TILE + x), step = confidenceOf(quantity, spreads[cell]);
        if (spreads[cell] & STEEP) steep[pixel + 3] = 255;
        if (sure) { image.set([...unsureInk(quantity, spreads[cell]), 255], pixel); continue; }
        if (step === 0) { dotted[pixel + 3] = 255; continue; }
        if (differences && Number.isNaN(differences[cell])) continue;
        const place = differences ? 0.5 + differences[cell] / span / 2 : quantity === "material" ? code : placeOf(quantity, valueOf(quantity, code, range), legend);
        if (quantity !== "material") { if (place < 0) this.beyond[0] = true; if (place > 1) this.beyond[1] = true; }
        image.set([...over(inkOf(differences ? "temperature" : quantity, place), step), 255], pixel);
        if (step === 1) stippled[pixel + 3] = 255;
      }
    }
    for (const [pen, part] of this.layers) pen.putImageData(part, column * TILE, SIDE - (row + 1) * TILE);
  }

  all(quantity, how) {
    this.beyond = [false, false];
    for (let row = 0; row < SIDE / TILE; row += 1) for (let column = 0; column < SIDE / TILE; column += 1) this.tile(quantity, column, row, how);
  }
}

// Returns for each tile with data its middle in cells, its explored share, lowest and highest value.
export function regions(quantity, range) {
  const { values, spreads } = kept[quantity], found = [];
  for (let row = 0; row < SIDE / TILE; row += 1) {
    for (let column = 0; column < SIDE / TILE; column += 1) {
      let cells = 0, low = Infinity, high = -Infinity;
      for (let y = 0; y < TILE; y += 1) {
        for (let x = 0; x < TILE; x += 1) {
          const cell = (row * TILE + y) * SIDE + column * TILE + x;
          if (values[cell] === UNEXPLORED || confidenceOf(quantity, spreads[cell]) === 0) continue;
          cells += 1;
          low = Math.min(low, values[cell]);
          high = Math.max(high, values[cell]);
        }
      }
      if (cells) found.push({ column: (column + 0.5) * TILE, row: (row + 0.5) * TILE, share: cells / TILE ** 2, low: valueOf(quantity, low, range), high: valueOf(quantity, high, range) });
    }
  }
  return found;
}

// Returns the code of one cell.
export function codeAt(quantity, column, row) {
  return kept[quantity].values[row * SIDE + column];
}
