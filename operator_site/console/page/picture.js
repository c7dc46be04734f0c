// Decodes binary messages; raises BadPicture for a wrong length, version or range.
export class BadPicture extends Error {}

export const PICTURE = 1, TILE = 2, SNAPSHOT = 3;
export const FINGER_COUNT = 5, SIGNAL_COUNT = 5, BIN_FLOATS = 2 * FINGER_COUNT * SIGNAL_COUNT, LONGEST_BINS = 300;
export const SIGNALS = { force_n: 0, contact_n: 1, motor_hz: 2, plate_c: 3, skin_c: 4 };
export const ROW = { x_m: 0, y_m: 1, surface_m: 2, force_n: 3, contact_n: 4, motor_hz: 5, plate_c: 6, skin_c: 7, plate_set_c: 8, mode: 9, stiffness_n_m: 10, age_s: 11 };
const ROW_FLOATS = 12, MAGIC = 0x7ea7, VERSION = 1, HEADER = 32, TILE_HEADER = 12, TILE_CELLS = 1024, LARGEST = 1e7;
export const TILE_BYTES = TILE_HEADER + 3 * TILE_CELLS;

function sane(values) {
  for (const value of values) if (Math.abs(value) > LARGEST) throw new BadPicture(`value ${value}`);
}

export function decode(buffer) {
  if (buffer.byteLength < TILE_HEADER) throw new BadPicture(`${buffer.byteLength} bytes`);
  const view = new DataView(buffer);
  if (view.getUint16(0, true) !== MAGIC || view.getUint8(2) !== VERSION) throw new BadPicture("not a picture of version 1");
  const kind = view.getUint8(3);
  if (kind === TILE) return decodeTile(view, buffer);
  if (kind !== PICTURE && kind !== SNAPSHOT) throw new BadPicture(`kind ${kind}`);
  return decodePicture(view, buffer, kind);
}

function decodePicture(view, buffer, kind) {
  if (buffer.byteLength < HEADER) throw new BadPicture(`${buffer.byteLength} bytes`);
  const bins = view.getUint16(28, true);
  if (bins > LONGEST_BINS || view.getUint8(30) !== FINGER_COUNT || view.getUint8(31) !== SIGNAL_COUNT) throw new BadPicture("shape");
  const rowBytes = 4 * ROW_FLOATS * FINGER_COUNT;
  if (buffer.byteLength !== HEADER + rowBytes + 4 * BIN_FLOATS * bins) throw new BadPicture(`${buffer.byteLength} bytes for ${bins} bins`);
  const flags = view.getUint32(12, true), time_s = view.getFloat64(16, true), span_s = view.getFloat32(24, true);
  if ((flags & 7) > 3 || !(time_s >= 0) || !(time_s < 1e12) || !(span_s > 0.001) || !(span_s < 10)) throw new BadPicture("range");
  const rows = new Float32Array(buffer, HEADER, ROW_FLOATS * FINGER_COUNT);
  const values = new Float32Array(buffer, HEADER + rowBytes, BIN_FLOATS * bins);
  sane(rows);
  sane(values);
  return {
    kind, sequence: view.getUint32(8, true), time_s, span_s, bins, rows, values, state: flags & 7,
    contact: finger => Boolean(flags & (1 << (8 + finger))), limit: finger => Boolean(flags & (1 << (16 + finger))), inUse: finger => Boolean(flags & (1 << (24 + finger))),
    of: (finger, name) => rows[finger * ROW_FLOATS + ROW[name]],
  };
}

function decodeTile(view, buffer) {
  if (buffer.byteLength !== TILE_BYTES) throw new BadPicture(`tile of ${buffer.byteLength} bytes`);
  const quantity = view.getUint8(4), column = view.getUint8(5), row = view.getUint8(6);
  if (quantity > 3 || column > 7 || row > 7) throw new BadPicture("tile out of the map");
  return { kind: TILE, quantity, column, row, values: new Uint16Array(buffer, TILE_HEADER, TILE_CELLS), spreads: new Uint8Array(buffer, TILE_HEADER + 2 * TILE_CELLS, TILE_CELLS) };
}
