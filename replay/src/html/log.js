"use strict";
const data = JSON.parse(document.getElementById("data").textContent);
const byId = (id) => document.getElementById(id);
const canvas = byId("over");
const context = canvas.getContext("2d");
const ROWS = 300; // of a table
const LEFT = 58, RIGHT = 12, STATUS = 26, EVENTS = 26, BOTTOM = 24, HEIGHT = 420;
const SYMBOL = { ok: "●", degraded: "▲", fault: "✖" };
let log, view, farthest;

const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
const metres = (m) => (m === null ? "–" : `${m.toFixed(2)} m`);

function clock(at, fine) {
  const s = Math.max(at, 0) / 1000;
  if (log.begun_ms !== null) {
    const text = new Date(log.begun_ms + at).toISOString();
    return fine ? text.slice(0, 23).replace("T", " ") : text.slice(11, 19);
  }
  const two = (n) => String(n).padStart(2, "0");
  const whole = `${two(Math.floor(s / 3600))}:${two(Math.floor(s / 60) % 60)}:`;
  return whole + (fine ? (s % 60).toFixed(3).padStart(6, "0") : two(Math.floor(s % 60)));
}

const width = () => canvas.clientWidth - LEFT - RIGHT;
const x = (at) => LEFT + ((at - view[0]) / (view[1] - view[0])) * width();
const plot = () => [STATUS + EVENTS + 8, HEIGHT - BOTTOM];
const y = (m) => plot()[1] - (m / farthest) * (plot()[1] - plot()[0]);
const seen = (list, time) => list.filter((item) => time(item) >= view[0] && time(item) <= view[1]);

function tickStep(span) {
  const steps = [1, 2, 5, 10, 20, 50, 100, 200, 500, 1e3, 2e3, 5e3, 1e4, 15e3, 3e4, 6e4, 12e4, 3e5, 6e5, 9e5, 18e5, 36e5, 72e5, 216e5, 432e5];
  return steps.find((step) => span / step <= width() / 90) ?? 864e5;
}

function axes() {
  const [top, bottom] = plot();
  context.strokeStyle = colour("line");
  context.fillStyle = colour("faint");
  context.textAlign = "center";
  const step = tickStep(view[1] - view[0]);
  for (let at = Math.ceil(view[0] / step) * step; at <= view[1]; at += step) {
    context.beginPath();
    context.moveTo(x(at), top);
    context.lineTo(x(at), bottom);
    context.stroke();
    context.fillText(step < 1000 ? `${(at / 1000).toFixed(3)} s` : clock(at, false), x(at), HEIGHT - 7);
  }
  context.textAlign = "right";
  const mark = farthest > 2.5 ? 1 : 0.5;
  for (let m = 0; m <= farthest + 1e-6; m += mark) {
    context.beginPath();
    context.moveTo(LEFT, y(m));
    context.lineTo(LEFT + width(), y(m));
    context.stroke();
    context.fillText(`${m.toFixed(1)} m`, LEFT - 6, y(m) + 4);
  }
  context.fillText("status", LEFT - 6, 17);
  context.fillText("events", LEFT - 6, STATUS + 17);
}

function status() {
  log.answers.forEach((answer, k) => {
    const end = log.answers[k + 1]?.at ?? Math.min(answer.at + 3000, log.length_ms);
    if (end < view[0] || answer.at > view[1]) return;
    const from = Math.max(x(answer.at), LEFT), to = Math.min(x(end), LEFT + width());
    context.fillStyle = colour(answer.status);
    context.fillRect(from, 5, Math.max(to - from - 0.5, 1.5), STATUS - 8);
  });
}

function events() {
  for (const [at, kind] of seen(log.events, (event) => event[0])) {
    const grave = ["fault", "guard fault", "halt", "restart", "silence"].includes(kind);
    context.fillStyle = colour(grave ? "fault" : kind === "sent" || kind === "remark" ? "faint" : "degraded");
    context.beginPath();
    context.moveTo(x(at) - 4, STATUS + 5);
    context.lineTo(x(at) + 4, STATUS + 5);
    context.lineTo(x(at), STATUS + 18);
    context.fill();
  }
}

/* The line of the free distances [time, m]: a step at each, and a gap where there is none. */
function line(points, name, dash) {
  context.strokeStyle = colour(name);
  context.lineWidth = 2;
  context.setLineDash(dash);
  context.beginPath();
  let last = null, column = -1;
  for (const [at, m] of points) {
    const here = x(at);
    const near = here >= LEFT - 2 * width() && here <= LEFT + 3 * width();
    if (m === null || !near) { last = m === null ? null : m; column = here; if (near && m === null) context.moveTo(here, 0); continue; }
    if (last === null) context.moveTo(here, y(m));
    else { context.lineTo(here, y(last)); if (Math.abs(here - column) >= 0.3 || m !== last) context.lineTo(here, y(m)); }
    last = m;
    column = here;
  }
  context.stroke();
  context.setLineDash([]);
  context.lineWidth = 1;
}

/* Each answer's free distance, also where silence follows and no line leads on, and its steps and drop. */
function marks() {
  for (const answer of seen(log.answers, (one) => one.at)) {
    context.fillStyle = colour("ok");
    if (answer.free_m !== null) context.fillRect(x(answer.at) - 4, y(answer.free_m) - 1, 8, 2);
    context.fillStyle = colour("ink");
    for (const m of answer.steps_m) context.fillRect(x(answer.at) - 2, y(m) - 2, 4, 4);
    context.strokeStyle = colour("fault");
    if (answer.drop_m !== null) context.strokeRect(x(answer.at) - 3, y(answer.drop_m) - 3, 6, 6);
  }
}

function draw() {
  const scale = window.devicePixelRatio || 1;
  canvas.style.height = `${HEIGHT}px`;
  canvas.width = canvas.clientWidth * scale;
  canvas.height = HEIGHT * scale;
  context.setTransform(scale, 0, 0, scale, 0, 0);
  context.font = "12px system-ui, sans-serif";
  axes();
  context.save();
  context.beginPath();
  context.rect(LEFT, 0, width(), HEIGHT);
  context.clip();
  status();
  events();
  line(log.sweeps.map(([at, , m]) => [at, m]), "faint", [2, 2]);
  const voids = log.events.filter((event) => ["silence", "restart", "halt"].includes(event[1])).map(([at]) => [at, null]);
  line(log.answers.map((answer) => [answer.at, answer.free_m]).concat(voids).sort((a, b) => a[0] - b[0]), "ok", []);
  marks();
  context.restore();
  byId("span").textContent = `${clock(view[0], true)} to ${clock(view[1], true)}`;
  tables();
}

function fill(table, heads, rows, count) {
  table.replaceChildren();
  const add = (parent, tag, text, name) => {
    const cell = parent.appendChild(document.createElement(tag));
    cell.textContent = text;
    if (name) cell.className = name;
  };
  const head = table.insertRow();
  heads.forEach((text) => add(head, "th", text, "text"));
  rows.forEach((cells) => { const row = table.insertRow(); cells.forEach(([text, name]) => add(row, "td", text, `text ${name ?? ""}`)); });
  if (count > rows.length) add(table.insertRow(), "td", `… ${count - rows.length} more: zoom in`, "text");
  if (count === 0) add(table.insertRow(), "td", "none here", "text");
}

function tables() {
  const some = seen(log.events, (event) => event[0]);
  fill(byId("events"), ["time", "event", ""], some.slice(0, ROWS).map(([at, kind, text]) => [[clock(at, true)], [kind, kind.includes("fault") ? "fault" : ""], [text]]), some.length);
  const answers = seen(log.answers, (answer) => answer.at);
  fill(byId("answers"), ["time", "scan", "status", "free", "answer"], answers.slice(0, ROWS).map((answer) => [
    [clock(answer.at, true)], [answer.scan], [`${SYMBOL[answer.status]} ${answer.status}`, `mark ${answer.status}`], [metres(answer.free_m)], [answer.text]]), answers.length);
}

function look(from, to) {
  const whole = Math.max(log.length_ms, 1000);
  const span = Math.min(Math.max(to - from, 50), 1.04 * whole);
  const begin = Math.min(Math.max(from, -0.02 * whole), 1.02 * whole - span);
  view = [begin, begin + span];
  draw();
}

function zoom(factor, place) {
  const at = place ?? (view[0] + view[1]) / 2;
  look(at - (at - view[0]) * factor, at + (view[1] - at) * factor);
}

const all = () => look(-0.02 * Math.max(log.length_ms, 1000), 1.02 * Math.max(log.length_ms, 1000));
const timeAt = (event) => view[0] + ((event.offsetX - LEFT) / width()) * (view[1] - view[0]);

function tip(event) {
  const place = timeAt(event), reach = (10 / width()) * (view[1] - view[0]);
  const near = (list, time) => list.filter((item) => Math.abs(time(item) - place) <= reach).sort((a, b) => Math.abs(time(a) - place) - Math.abs(time(b) - place))[0];
  const some = event.offsetY < STATUS + EVENTS && event.offsetY > STATUS ? near(log.events, (one) => one[0]) : undefined;
  const answer = near(log.answers, (one) => one.at), sweep = near(log.sweeps, (one) => one[0]);
  const text = some ? `${clock(some[0], true)} ${some[1]}: ${some[2]}`
    : answer ? `${clock(answer.at, true)} scan ${answer.scan}, free ${metres(answer.free_m)}: ${answer.text}`
    : sweep ? `${clock(sweep[0], true)} guard ${sweep[1]}: free ${metres(sweep[2])}, ends: ${sweep[3]}` : "";
  byId("tip").hidden = text === "";
  byId("tip").textContent = text;
  byId("tip").style.left = `${Math.min(event.offsetX + 12, canvas.clientWidth * 0.6)}px`;
  byId("tip").style.top = `${event.offsetY + 14}px`;
}

const pointers = new Map();
canvas.addEventListener("wheel", (event) => { event.preventDefault(); zoom(Math.exp(event.deltaY * 0.0015), timeAt(event)); }, { passive: false });
canvas.addEventListener("dblclick", all);
canvas.addEventListener("pointerdown", (event) => { canvas.setPointerCapture(event.pointerId); pointers.set(event.pointerId, event.offsetX); });
["pointerup", "pointercancel"].forEach((name) => canvas.addEventListener(name, (event) => pointers.delete(event.pointerId)));
canvas.addEventListener("pointerleave", () => { byId("tip").hidden = true; });
canvas.addEventListener("pointermove", (event) => {
  if (!pointers.has(event.pointerId)) return tip(event);
  const before = [...pointers.values()], moved = event.offsetX - pointers.get(event.pointerId);
  pointers.set(event.pointerId, event.offsetX);
  const after = [...pointers.values()], perPixel = (view[1] - view[0]) / width();
  if (before.length === 2) {
    const factor = Math.max(Math.abs(before[0] - before[1]), 10) / Math.max(Math.abs(after[0] - after[1]), 10);
    zoom(factor, view[0] + ((after[0] + after[1]) / 2 - LEFT) * perPixel);
  } else look(view[0] - moved * perPixel, view[1] - moved * perPixel);
});
canvas.addEventListener("keydown", (event) => {
  const span = view[1] - view[0];
  const act = { "+": () => zoom(0.5), "=": () => zoom(0.5), "-": () => zoom(2), "0": all, ArrowLeft: () => look(view[0] - span / 5, view[1] - span / 5), ArrowRight: () => look(view[0] + span / 5, view[1] + span / 5) }[event.key];
  if (act) { event.preventDefault(); act(); }
});
byId("in").onclick = () => zoom(0.5);
byId("out").onclick = () => zoom(2);
byId("all").onclick = all;
window.addEventListener("resize", draw);
window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", draw);

function choose(k) {
  log = data.logs[k];
  const reach = log.answers.flatMap((answer) => [answer.free_m, answer.drop_m, ...answer.steps_m]).concat(log.sweeps.map((sweep) => sweep[2]));
  farthest = Math.max(1, Math.ceil(2 * reach.reduce((most, m) => Math.max(most, m ?? 0), 0)) / 2);
  const count = (status) => log.answers.filter((answer) => answer.status === status).length;
  byId("name").textContent = log.name;
  const times = { log: "times of the log", LIVE: "times by LIVE", none: "no times: a second an answer" }[log.clock];
  byId("summary").textContent = `${log.answers.length} answers: ${count("ok")} ok, ${count("degraded")} degraded, ${count("fault")} fault; ${log.sweeps.length} guard sweeps; ${log.events.length} events; ${(log.length_ms / 1000).toFixed(1)} s, ${times}`;
  [...byId("logs").children].forEach((button, place) => button.setAttribute("aria-pressed", String(place === k)));
  all();
}

const legend = (name, text) => { const item = byId("legend").appendChild(document.createElement("span")); item.textContent = text; item.className = name; };
legend("ok", "━ free distance of the answers");
legend("", "┅ free distance of guard sweeps");
legend("", "▪ steps");
legend("fault", "□ drop");
legend("ok", "● ok");
legend("degraded", "▲ degraded");
legend("fault", "✖ fault; ▼ fault, restart, silence");
if (data.logs.length > 1) data.logs.forEach((one, k) => {
  const button = byId("logs").appendChild(document.createElement("button"));
  button.textContent = one.name;
  button.onclick = () => choose(k);
});
byId("made").textContent = `stairscan ${data.version}, ${data.revision}`;
choose(0);
