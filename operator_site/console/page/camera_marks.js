// Registers the camera's picture with the map: four marks, each touched by a finger and tapped in the picture.
import { ask } from "./actions.js";
import { pickInPicture } from "./camera.js";
import { controls, now } from "./now.js";
import { WORDS } from "./words.js";

const MARKS = 4, LEAST = 1e-4;

// Fits mm of the map to places in the picture, each 0 to 1, by least squares. Returns {matrix: a d b e c f with
// x = a u + b v + c and y = d u + e v + f, error_mm: expected distance of a place}; null where the marks are on one line.
export function fitMarks(marks) {
  const mean = name => marks.reduce((sum, mark) => sum + mark[name], 0) / marks.length, [u, v, x, y] = ["u", "v", "x", "y"].map(mean);
  const sum = (p, mp, q, mq) => marks.reduce((total, mark) => total + (mark[p] - mp) * (mark[q] - mq), 0);
  const uu = sum("u", u, "u", u), uv = sum("u", u, "v", v), vv = sum("v", v, "v", v), determinant = uu * vv - uv * uv;
  if (marks.length < MARKS || determinant < LEAST * LEAST) return null;
  const row = (name, m) => { const up = sum("u", u, name, m), vp = sum("v", v, name, m); return [(up * vv - vp * uv) / determinant, (vp * uu - up * uv) / determinant]; };
  const [a, b] = row("x", x), [d, e] = row("y", y), c = x - a * u - b * v, f = y - d * u - e * v;
  const squares = marks.reduce((total, mark) => total + (a * mark.u + b * mark.v + c - mark.x) ** 2 + (d * mark.u + e * mark.v + f - mark.y) ** 2, 0);
  return { matrix: [a, d, b, e, c, f], error_mm: Math.sqrt(squares / (marks.length - 3)) }; // six of 2 n coordinates are fitted
}

// Asks for the marks; `say` shows a text, `done` takes the fit, or null.
export function askMarks(say, done) {
  const marks = [];
  say(WORDS.markAsk(1, MARKS));
  pickInPicture((u, v) => {
    if (!now.picture?.contact(now.active)) { say(WORDS.markTouch); return; }
    marks.push({ u, v, x: now.picture.of(now.active, "x_m") * 1000, y: now.picture.of(now.active, "y_m") * 1000 });
    if (marks.length < MARKS) { say(WORDS.markAsk(marks.length + 1, MARKS)); return; }
    pickInPicture(null);
    const fit = fitMarks(marks);
    say(fit ? WORDS.markError(fit.error_mm) : WORDS.markLine);
    done(fit);
    // Recorded, so that the report can cover the picture elsewhere.
    if (fit && controls()) ask("camera_marks", Object.fromEntries(marks.flatMap((mark, n) => Object.entries(mark).map(([name, value]) => [`${name}${n + 1}`, value]))));
  });
}
