"use strict";
const data = JSON.parse(document.getElementById("data").textContent);
const at = (id) => document.getElementById(id);
// Colours that are distinct for deuteranopes, too (Okabe and Ito 2008); every layer also has its own shape.
// `noise` and `strong` are the colours of the map, as red, green and blue: the level is coded by lightness alone.
const LOOKS = {
  light: { answer: "#0072b2", truth: "#009e73", rival: "#e69f00", against: "#d55e00", maybe: "#a0447f", drop: "#b2182b", stray: "#4f4f4f", horizon: "#222222", beam: "#00000060", frame: "#888888", ink: "#333333", noise: [255, 255, 255], strong: [45, 65, 105] },
  dark: { answer: "#4a90e0", truth: "#2fd0a0", rival: "#ffe84a", against: "#f06a28", maybe: "#e8a0f8", drop: "#d8509c", stray: "#807868", horizon: "#f0f4f4", beam: "#ffffff70", frame: "#777777", ink: "#c9c9c9", noise: [20, 22, 25], strong: [205, 218, 240] },
};
const night = window.matchMedia("(prefers-color-scheme: dark)");
const looks = () => LOOKS[night.matches ? "dark" : "light"];
let HUE = looks();
const STATUS = {
  ok: ["✓ ok", "This answer is valid up to its horizon. Steps beyond it are reported without that guarantee."],
  degraded: ["! degraded", "Do not act on this answer alone: see the reasons."],
  fault: ["✕ fault", "No answer. The reasons name the fault."],
};
const WAITING = "… scanning";
const LAYERS = [
  ["map", "radar map", true], ["coherent", "coherent image", false], ["hits", "only CA-CFAR detections", false], ["echoes", "echoes", true],
  ["rivals", "runners-up", false], ["sigma", "±2σ", true], ["truth", "ground truth", true], ["drop", "DROP", true], ["maybe", "MAYBE", true], ["horizon", "horizon", true],
];
// Levels up to NOISE_DB above the mean noise have the background's colour; the scale to the strongest covers SPAN_DB.
const [NOISE_DB, SPAN_DB] = [6, 45];
const UNCERTAIN = [5, 4];
const state = { recording: 0, scan: 0, place: null, shown: Object.fromEntries(LAYERS.map(([key, , on]) => [key, on])) };

/** Formats a number in decimal, without a sign for zero. */
const fixed = (v, digits) => v.toFixed(digits).replace(/^-(?=[0.]*$)/, "").replace("-", "−");
const cm = (metres, digits = 1) => `${fixed(100 * metres, digits)} cm`;
const percent = (p) => `${(100 * p).toFixed(1)} %`;
const plus = (v) => `${v < 0 ? "−" : "+"}${Math.abs(100 * v).toFixed(1)} cm`;
function element(tag, text, kind) {
  const node = document.createElement(tag);
  node.textContent = text;
  if (kind) node.className = kind;
  return node;
}
function table(place, head, rows) {
  const row = (cells, tag) => {
    const line = document.createElement("tr");
    for (const cell of cells) line.append(element(tag, cell ?? "–", typeof cell === "string" && !/^[−+\-\d–]/.test(cell) ? "text" : ""));
    return line;
  };
  place.replaceChildren(...(rows.length ? [row(head, "th"), ...rows.map((cells) => row(cells, "td"))] : []));
}
const bytes = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
/**
 * A view of one scan on the page: `at` finds its elements, `scan` its scan; `frame` says how its side view is drawn, and
 * `over` draws on top of that, and `held` is what stays in sight while something is dragged.
 */
function pane(suffix, recording) {
  const view = { at: (id) => at(id + suffix), recording, frame: null, over: null, held: null };
  view.scan = () => recording().scans[state.scan];
  return view;
}

/** Cells and bits of a scan's map, decoded once. */
function decoded(map) {
  if (!map.levels) Object.defineProperty(map, "levels", { value: bytes(map.cells) });
  if (!map.bits) Object.defineProperty(map, "bits", { value: bytes(map.hits) });
  return map;
}
/** Returns the median of a map's levels: the noise level if the estimator does not report one. */
function typical(map) {
  const counts = new Array(256).fill(0);
  for (const cell of map.levels) counts[cell] += 1;
  let below = 0;
  const median = counts.findIndex((count) => (below += count) * 2 >= map.levels.length);
  return (median - map.full_scale) * map.db_per_unit;
}
const level = (map, k) => (map.levels[k] - map.full_scale) * map.db_per_unit;
const isHit = (map, k) => (map.bits[k >> 3] >> (k & 7)) & 1;
/** Returns range from the mirror and angle of a point. */
function polar(map, x, y) {
  const down = map.mount_height_m - y;
  return [Math.hypot(x, down), map.depth ? Math.atan2(down, x) : Math.atan2(x, down)];
}
/** Returns the point at a range and angle. */
function cartesian(map, range, angle) {
  const [s, c] = [Math.sin(angle) * range, Math.cos(angle) * range];
  return map.depth ? [c, map.mount_height_m - s] : [s, map.mount_height_m - c];
}
/** Returns row and range bin of a point, if it is within the scan. */
function cellOf(map, x, y) {
  const [range, angle] = polar(map, x, y);
  const row = Math.round((angle - map.first_angle_rad) / map.step_rad);
  const bin = Math.round((range - map.first_range_m) / map.bin_m);
  return row >= 0 && row < map.rows && bin >= 0 && bin < map.bins ? [row, bin] : null;
}

/** Prepares a canvas in the screen's resolution, with a context in CSS pixels. */
function sheet(canvas, height) {
  const width = canvas.parentElement.clientWidth;
  const ratio = window.devicePixelRatio || 1;
  canvas.width = Math.round(width * ratio);
  canvas.height = Math.round(height * ratio);
  canvas.style.height = `${height}px`;
  const context = canvas.getContext("2d");
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.font = "13px system-ui, sans-serif";
  return { context, width, height, ratio };
}

/** Returns the extent of the side view, metres. */
function extent(s) {
  // The bottom of a deep hole is not shown.
  const real = (s.truth?.edges ?? []).filter((p) => p.distance_m < 2.6).map((p) => ({ ...p, height_m: Math.max(p.height_m, -0.5) }));
  const places = [...s.steps, ...real, ...s.maybe, ...(s.drop ? [{ distance_m: s.drop.distance_m, height_m: 0 }] : [])];
  const x = [1.2, s.map?.depth === false ? 0.9 : 1.5, ...places.map((p) => p.distance_m + 0.35)];
  const y = [s.map?.mount_height_m ?? 0.4, ...places.map((p) => p.height_m)];
  return {
    left: Math.min(-0.1, ...places.map((p) => p.distance_m - 0.15)),
    right: Math.max(...x, Math.min(s.horizon_m ?? 0, 2.6) + 0.1),
    bottom: Math.min(0, ...y) - 0.2,
    top: Math.max(...y) + 0.2,
  };
}

/** Returns the colour of a level, 0 to 1. */
function shade(share) {
  const t = Math.max(0, Math.min(1, share));
  return HUE.noise.map((from, k) => Math.round(from + (HUE.strong[k] - from) * t));
}

/** Draws the side view of a pane; `box` is the extent, by default the scan's own. */
function drawSide(view, box = extent(view.scan())) {
  const s = view.scan();
  const canvas = view.at("side");
  const parent = canvas.parentElement.clientWidth;
  const margin = { left: 52, right: 12, top: 12, bottom: 40 };
  const scale = (parent - margin.left - margin.right) / (box.right - box.left);
  const tall = Math.max(160, Math.min(560, scale * (box.top - box.bottom)));
  const fit = Math.min(scale, tall / (box.top - box.bottom));
  const paper = sheet(canvas, tall + margin.top + margin.bottom);
  const g = paper.context;
  const X = (x) => margin.left + (x - box.left) * fit;
  const Y = (y) => margin.top + (box.top - y) * fit;
  const right = X(box.right);
  const frame = { x: (px) => box.left + (px - margin.left) / fit, y: (py) => box.top - (py - margin.top) / fit, X, Y, box };
  view.frame = frame;
  g.clearRect(0, 0, paper.width, paper.height);
  if (s.map && (state.shown.map || state.shown.coherent)) drawMap(g, s, paper, frame, { left: X(box.left), right, top: Y(box.top), bottom: Y(box.bottom) });
  g.save();
  g.beginPath();
  g.rect(X(box.left), Y(box.top), right - X(box.left), Y(box.bottom) - Y(box.top));
  g.clip();
  drawLayers(g, s, frame);
  view.over?.(g, frame);
  g.restore();
  axes(g, { left: X(box.left), right, top: Y(box.top), bottom: Y(box.bottom) }, [box.left, box.right, X], [box.bottom, box.top, Y]);
}

/** Draws the map, or in its place the coherent image: rows added up by their phases, in which a point gains some 12 dB. */
function drawMap(g, s, paper, frame, at) {
  const coherent = state.shown.coherent && s.coherent;
  const map = coherent ? (s.coherent.map ??= decoded({ ...s.map, ...s.coherent })) : decoded(s.map);
  const [w, h] = [Math.floor((at.right - at.left) * paper.ratio), Math.floor((at.bottom - at.top) * paper.ratio)];
  if (w < 1 || h < 1) return;
  const image = new ImageData(w, h);
  const noise = coherent ? s.coherent.noise_dbfs : s.inspection?.noise_dbfs;
  const floor = (noise ?? typical(map)) + NOISE_DB;
  for (let py = 0; py < h; py += 1) {
    const y = frame.y(at.top + (py + 0.5) / paper.ratio);
    for (let px = 0; px < w; px += 1) {
      const cell = cellOf(map, frame.x(at.left + (px + 0.5) / paper.ratio), y);
      if (!cell) continue;
      const k = cell[0] * map.bins + cell[1];
      if (state.shown.hits && !coherent && !isHit(map, k)) continue;
      image.data.set([...shade((level(map, k) - floor) / SPAN_DB), 255], 4 * (py * w + px));
    }
  }
  g.putImageData(image, Math.round(at.left * paper.ratio), Math.round(at.top * paper.ratio));
}

/** Draws a staircase from the ground in front of it to a little behind its last edge. */
function surface(g, steps, { X, Y, box }) {
  let y = 0;
  g.beginPath();
  g.moveTo(X(box.left), Y(0));
  for (const step of steps) {
    g.lineTo(X(step.distance_m), Y(y));
    y = step.height_m;
    g.lineTo(X(step.distance_m), Y(y));
  }
  g.lineTo(X((steps.at(-1)?.distance_m ?? box.right) + 0.25), Y(y));
  g.stroke();
}
function stroke(g, colour, width, dash = []) {
  g.strokeStyle = colour;
  g.lineWidth = width;
  g.setLineDash(dash);
}
function drawLayers(g, s, frame) {
  const { X, Y, box } = frame;
  if (s.map) {
    stroke(g, HUE.horizon, 1.5);
    g.strokeRect(X(0) - 4, Y(s.map.mount_height_m) - 4, 8, 8);
    g.fillStyle = HUE.horizon;
    g.fillText("mirror", X(0) + 8, Y(s.map.mount_height_m) - 6);
  }
  if (state.shown.rivals) {
    for (const rival of (s.rivals ?? []).filter((r) => !r.winner && r.edges.length)) {
      stroke(g, HUE.rival, 6, [3, 4]);
      surface(g, rival.edges, frame);
    }
  }
  if (state.shown.truth && s.truth) {
    stroke(g, HUE.truth, 4, [9, 6]);
    surface(g, s.truth.edges, frame);
  }
  if (s.status !== "fault") {
    // The part beyond the horizon is dashed.
    stroke(g, HUE.answer, 1.8, UNCERTAIN);
    surface(g, s.steps, frame);
    g.save();
    g.beginPath();
    g.rect(0, 0, X(s.horizon_m ?? box.right), Y(box.bottom) + 1);
    g.clip();
    stroke(g, HUE.answer, 2.5);
    surface(g, s.steps, frame);
    g.restore();
  }
  if (state.shown.sigma) {
    stroke(g, HUE.answer, 1.2);
    for (const p of s.steps) {
      const [w, h] = [2 * p.distance_sigma_m, 2 * p.height_sigma_m];
      g.strokeRect(X(p.distance_m - w), Y(p.height_m + h), X(p.distance_m + w) - X(p.distance_m - w), Y(p.height_m - h) - Y(p.height_m + h));
    }
  }
  if (state.shown.drop && s.drop) drawDrop(g, s.drop, frame);
  if (state.shown.maybe) s.maybe.forEach((m) => drawMaybe(g, m, frame));
  if (state.shown.echoes) (s.inspection?.scatterers ?? []).forEach((e) => drawEcho(g, e, frame));
  if (state.shown.horizon && s.horizon_m > 0) {
    stroke(g, HUE.horizon, 1.5, [1, 4]);
    g.beginPath();
    g.moveTo(X(s.horizon_m), Y(box.top));
    g.lineTo(X(s.horizon_m), Y(box.bottom));
    g.stroke();
    g.fillStyle = HUE.horizon;
    const end = g.measureText("horizon").width + 6;
    g.fillText("horizon", X(s.horizon_m) + (X(s.horizon_m) + end < X(box.right) ? 4 : -end), Y(box.top) + 14);
  }
  if (state.place && s.map) {
    const [, angle] = polar(s.map, ...state.place);
    const far = cartesian(s.map, s.map.first_range_m + s.map.bins * s.map.bin_m, angle);
    stroke(g, HUE.beam, 1);
    g.beginPath();
    g.moveTo(X(0), Y(s.map.mount_height_m));
    g.lineTo(X(far[0]), Y(far[1]));
    g.stroke();
  }
  g.setLineDash([]);
}
/** Draws a drop edge: a vertical line with its band of ±3σ. */
function drawDrop(g, d, { X, Y, box }) {
  const [near, far] = [-3, 3].map((k) => X(d.distance_m + k * d.distance_sigma_m));
  g.fillStyle = `${HUE.drop}30`;
  g.fillRect(near, Y(box.top), far - near, Y(box.bottom) - Y(box.top));
  stroke(g, HUE.drop, 2.5);
  g.beginPath();
  g.moveTo(X(d.distance_m), Y(box.top));
  g.lineTo(X(d.distance_m), Y(box.bottom));
  g.stroke();
  g.fillStyle = HUE.drop;
  const words = `ground ends, ${percent(d.probability)}`;
  const end = g.measureText(words).width + 6;
  g.fillText(words, X(d.distance_m) + (X(d.distance_m) + end < X(box.right) ? 4 : -end), Y(box.top) + 30);
}
function drawMaybe(g, m, frame) {
  const [x, y] = [frame.X(m.distance_m), frame.Y(m.height_m)];
  stroke(g, HUE.maybe, 2);
  g.beginPath();
  g.moveTo(x, y - 8);
  g.lineTo(x + 8, y);
  g.lineTo(x, y + 8);
  g.lineTo(x - 8, y);
  g.closePath();
  g.stroke();
  g.fillStyle = HUE.maybe;
  g.fillText(`maybe ${percent(m.probability)}`, x + 11, y + 4);
}
function drawEcho(g, echo, frame) {
  const [x, y, r] = [frame.X(echo.x_m), frame.Y(echo.y_m), 2.5 + Math.max(0, echo.snr_db) / 14];
  const stray = echo.role === "stray";
  stroke(g, echo.against ? HUE.against : stray ? HUE.stray : HUE.answer, 1.8);
  g.beginPath();
  if (echo.against) {
    g.moveTo(x - r, y - r);
    g.lineTo(x + r, y + r);
    g.moveTo(x - r, y + r);
    g.lineTo(x + r, y - r);
  } else if (stray) g.rect(x - r, y - r, 2 * r, 2 * r);
  else g.arc(x, y, r, 0, 2 * Math.PI);
  g.stroke();
}

/** Returns round marks of an axis with room for the numbers. */
function ticks(from, to, room) {
  const raw = (to - from) / Math.max(1, room);
  const ten = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].map((m) => m * ten).find((candidate) => candidate >= raw);
  const list = [];
  for (let k = Math.ceil(from / step); k * step <= to + 1e-9; k += 1) list.push(k * step);
  return [list, step];
}
function axes(g, at, [x0, x1, X], [y0, y1, Y], words = ["distance from the mirror, m", "height, m"]) {
  g.setLineDash([]);
  g.strokeStyle = HUE.frame;
  g.lineWidth = 1;
  g.strokeRect(at.left, at.top, at.right - at.left, at.bottom - at.top);
  g.fillStyle = HUE.ink;
  const text = (v, step) => (Math.abs(v) < 1e-9 ? 0 : v).toFixed(step < 0.1 ? 2 : step < 1 ? 1 : 0).replace("-", "−");
  g.textAlign = "center";
  const [xs, xStep] = ticks(x0, x1, (at.right - at.left) / 70);
  for (const x of xs) g.fillText(text(x, xStep), X(x), at.bottom + 16);
  g.fillText(words[0], (at.left + at.right) / 2, at.bottom + 33);
  g.textAlign = "right";
  const [ys, yStep] = ticks(y0, y1, (at.bottom - at.top) / 40);
  for (const y of ys) g.fillText(text(y, yStep), at.left - 5, Y(y) + 4);
  g.save();
  g.translate(13, (at.top + at.bottom) / 2);
  g.rotate(-Math.PI / 2);
  g.textAlign = "center";
  g.fillText(words[1], 0, 0);
  g.restore();
  g.textAlign = "left";
}

/** Draws the range profile of the row through the selected point. */
function drawProfile(view) {
  const map = view.scan().map;
  const paper = sheet(view.at("profile"), 230);
  const g = paper.context;
  g.clearRect(0, 0, paper.width, paper.height);
  const cell = map && state.place && cellOf(map, ...state.place);
  view.at("profile-title").textContent = cell ? profileTitle(map, cell[0]) : "Range profile";
  if (!cell) return;
  decoded(map);
  const box = { left: 52, right: paper.width - 12, top: 10, bottom: paper.height - 40 };
  const first = map.first_range_m + map.mirror_offset_m;
  const [x0, x1] = [first, first + map.bins * map.bin_m];
  const levels = Array.from({ length: map.bins }, (_, bin) => level(map, cell[0] * map.bins + bin));
  const [y0, y1] = [Math.min(...levels) - 3, Math.max(...levels) + 5];
  const X = (x) => box.left + ((x - x0) / (x1 - x0)) * (box.right - box.left);
  const Y = (y) => box.bottom - ((y - y0) / (y1 - y0)) * (box.bottom - box.top);
  stroke(g, HUE.answer, 1.5);
  g.beginPath();
  levels.forEach((db, bin) => g.lineTo(X(first + bin * map.bin_m), Y(db)));
  g.stroke();
  g.fillStyle = HUE.against;
  levels.forEach((db, bin) => {
    if (isHit(map, cell[0] * map.bins + bin)) g.fillRect(X(first + bin * map.bin_m) - 2.5, Y(db) - 2.5, 5, 5);
  });
  stroke(g, HUE.beam, 1);
  g.beginPath();
  g.moveTo(X(first + cell[1] * map.bin_m), box.top);
  g.lineTo(X(first + cell[1] * map.bin_m), box.bottom);
  g.stroke();
  axes(g, box, [x0, x1, X], [y0, y1, Y], ["range from the radar, m", "level, dB of full scale"]);
}
function profileTitle(map, row) {
  const degrees = ((map.first_angle_rad + row * map.step_rad) * 180) / Math.PI;
  const where = map.depth ? `${Math.abs(degrees).toFixed(2)}° ${degrees < 0 ? "above" : "below"} the horizontal` : `${degrees.toFixed(2)}° from straight down`;
  return `Range profile of row ${row + 1}, ${where}`;
}

