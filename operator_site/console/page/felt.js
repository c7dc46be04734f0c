// D, what was felt: tiles kept for each quantity and painted through the colour tables, with confidence as opacity.
import { MATERIALS, NOT_FELT, OPACITY, TABLES } from "./colours.js";

export const QUANTITIES = ["temperature", "roughness", "stiffness", "material"], SIDE = 256, TILE = 32, NOT = 65535;
const LOGARITHMIC = ["roughness", "stiffness"], CODES = 65534;
const kept = QUANTITIES.map(() => ({ values: new Uint16Array(SIDE * SIDE).fill(NOT), confidence: new Uint8Array(SIDE * SIDE) }));

export function forgetFelt() {
  for (const { values, confidence } of kept) { values.fill(NOT); confidence.fill(0); }
}

export function keepTile(tile) {
  const { values, confidence } = kept[tile.quantity];
  for (let row = 0; row < TILE; row += 1) {
    const to = (tile.row * TILE + row) * SIDE + tile.column * TILE, from = row * TILE;
    values.set(tile.values.subarray(from, from + TILE), to);
    confidence.set(tile.confidence.subarray(from, from + TILE), to);
  }
}

// The value that a cell's code stands for; ranges as the state tells them.
export function valueOf(quantity, code, range) {
  if (quantity === "material") return code;
  const share = code / CODES, [low, high] = range;
  return LOGARITHMIC.includes(quantity) ? low * (high / low) ** share : low + share * (high - low);
}

// Where a value stands between the ends of the legend: 0..1 inside.
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
  return ink.map((part, at) => Math.round(share * part + (1 - share) * NOT_FELT[at]));
}

// Paints tiles into 256 x 256 pixels, far edge on top: colours, and masks of what is stippled or dotted.
export class Painting {
  constructor() {
    [this.colours, this.stippled, this.dotted] = [0, 1, 2].map(() => Object.assign(document.createElement("canvas"), { width: SIDE, height: SIDE }));
    this.image = new ImageData(TILE, TILE);
    this.mask = new ImageData(TILE, TILE);
    this.dots = new ImageData(TILE, TILE);
    this.beyond = [false, false];
  }

  tile(quantity, column, row, range, legend, sure) {
    const { values, confidence } = kept[QUANTITIES.indexOf(quantity)];
    [this.image, this.mask, this.dots].forEach(image => image.data.fill(0));
    for (let y = 0; y < TILE; y += 1) {
      for (let x = 0; x < TILE; x += 1) {
        const cell = (row * TILE + y) * SIDE + column * TILE + x, code = values[cell];
        if (code === NOT) continue;
        const pixel = 4 * ((TILE - 1 - y) * TILE + x), step = confidence[cell];
        if (step === 0) { this.dots.data[pixel + 3] = 255; continue; }
        const place = quantity === "material" ? code : placeOf(quantity, valueOf(quantity, code, range), legend);
        if (quantity !== "material") { if (place < 0) this.beyond[0] = true; if (place > 1) this.beyond[1] = true; }
        const ink = sure ? [1, 1, 1].map(part => 255 * part * OPACITY[step]) : over(inkOf(quantity, place), step);
        this.image.data.set([ink[0], ink[1], ink[2], 255], pixel);
        if (step === 1 && !sure) this.mask.data[pixel + 3] = 255;
      }
    }
    const left = column * TILE, top = SIDE - (row + 1) * TILE;
    this.colours.getContext("2d").putImageData(this.image, left, top);
    this.stippled.getContext("2d").putImageData(this.mask, left, top);
    this.dotted.getContext("2d").putImageData(this.dots, left, top);
  }

  all(quantity, range, legend, sure) {
    this.beyond = [false, false];
    for (let row = 0; row < SIDE / TILE; row += 1) for (let column = 0; column < SIDE / TILE; column += 1) this.tile(quantity, column, row, range, legend, sure);
  }
}

// For each tile in which something was felt: its middle in cells, how much was felt, lowest and highest value.
export function regions(quantity, range) {
  const { values, confidence } = kept[QUANTITIES.indexOf(quantity)], found = [];
  for (let row = 0; row < SIDE / TILE; row += 1) {
    for (let column = 0; column < SIDE / TILE; column += 1) {
      let felt = 0, low = Infinity, high = -Infinity;
      for (let y = 0; y < TILE; y += 1) {
        for (let x = 0; x < TILE; x += 1) {
          const cell = (row * TILE + y) * SIDE + column * TILE + x;
          if (values[cell] === NOT || confidence[cell] === 0) continue;
          felt += 1;
          low = Math.min(low, values[cell]);
          high = Math.max(high, values[cell]);
        }
      }
      if (felt) found.push({ column: (column + 0.5) * TILE, row: (row + 0.5) * TILE, share: felt / TILE ** 2, low: valueOf(quantity, low, range), high: valueOf(quantity, high, range) });
    }
  }
  return found;
}

// The code of one cell, for letters on the map of materials.
export function codeAt(quantity, column, row) {
  const cell = row * SIDE + column;
  return column < 0 || row < 0 || column >= SIDE || row >= SIDE ? NOT : kept[QUANTITIES.indexOf(quantity)].values[cell];
}
