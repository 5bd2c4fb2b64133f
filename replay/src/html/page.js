
// ---- The page: selection, pointer and display.
/** Two scans side by side, or one. */
const sides = Boolean(data.compare);
const panes = sides ? data.recordings.map((r, k) => pane(`-${"ab"[k]}`, () => r)) : [pane("", () => data.recordings[state.recording])];
const recording = panes[0].recording;
const scan = panes[0].scan;
/** Returns the panes with a scan: one of two sequences may be longer. */
const shownPanes = () => panes.filter((view) => view.scan());

function point(view, event) {
  const { frame } = view;
  const box = view.at("side").getBoundingClientRect();
  const [px, py] = [event.clientX - box.left, event.clientY - box.top];
  const outside = frame.x(px) < frame.box.left || frame.x(px) > frame.box.right || frame.y(py) < frame.box.bottom || frame.y(py) > frame.box.top;
  view.at("tip").hidden = outside;
  if (outside) return;
  state.place = [frame.x(px), frame.y(py)];
  tip(view, px, py);
  redrawPlace();
}
/** Draws everything that depends on the selected point. */
function redrawPlace() {
  // Two views side by side have the same scale.
  const boxes = shownPanes().map((view) => extent(view.scan()));
  const widest = (key, most) => most(...boxes.map((box) => box[key]));
  const box = panes[0].held ?? { left: widest("left", Math.min), right: widest("right", Math.max), bottom: widest("bottom", Math.min), top: widest("top", Math.max) };
  for (const view of shownPanes()) {
    drawSide(view, box);
    drawProfile(view);
  }
}
/** Moves the selected point by arrow keys: a centimetre, five with shift. */
function byKey(view, event) {
  const way = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
  if (event.key === "Escape") view.at("tip").hidden = true;
  if (!way || !state.place) return;
  event.preventDefault();
  const step = event.shiftKey ? 0.05 : 0.01;
  const within = (v, from, to) => Math.max(from, Math.min(to, v));
  const { frame } = view;
  const { left, right, bottom, top } = frame.box;
  state.place = [within(state.place[0] + step * way[0], left, right), within(state.place[1] + step * way[1], bottom, top)];
  tip(view, frame.X(state.place[0]), frame.Y(state.place[1]));
  redrawPlace();
}
function tip(view, px, py) {
  const s = view.scan();
  const note = view.at("tip");
  const [x, y] = state.place;
  const cell = s.map && cellOf(s.map, x, y);
  note.hidden = !s.map;
  if (!s.map) return;
  const [range] = polar(s.map, x, y);
  const lines = [`${cm(x)} from the mirror, ${cm(y)} high`, `range ${cm(range)} from the mirror, ${cm(range + s.map.mirror_offset_m)} from the radar`];
  if (cell) {
    decoded(s.map);
    lines.push(`level ${fixed(level(s.map, cell[0] * s.map.bins + cell[1]), 1)} dB of full scale`);
  } else lines.push("outside of the scan");
  const near = (s.inspection?.scatterers ?? []).map((e) => [Math.hypot(e.x_m - x, e.y_m - y), e]).sort((a, b) => a[0] - b[0])[0];
  if (near && near[0] < 0.03) lines.push(`echo: ${near[1].role}, ${near[1].snr_db.toFixed(1)} dB${near[1].against ? ", against the answer" : ""}`);
  note.replaceChildren(...lines.map((line) => element("div", line)));
  const width = view.at("side").parentElement.clientWidth;
  // Beside the pointer, on the side with more space.
  note.style.left = px < width / 2 ? `${px + 16}px` : "";
  note.style.right = px < width / 2 ? "" : `${width - px + 16}px`;
  note.style.top = `${py + 14}px`;
}

/** Shows a recording's name, and everything of its scan except the drawings. */
function showPane(view) {
  const [{ at }, r, s] = [view, view.recording(), view.scan()];
  at("name").textContent = r.name;
  at("description").textContent = [r.description, r.disturbance && `injected fault: ${r.disturbance}`].filter(Boolean).join(" – ");
  at("pane").querySelectorAll(":scope > section:not([id|=verdict]), :scope > details").forEach((part) => { part.hidden = !s; });
  if (s) {
    at("tip").hidden = true;
    showVerdict(view, s);
    showSteps(view, s);
    showDetails(view, s);
    return;
  }
  if (r.guard) {
    showGuard(view, r.guard);
    return;
  }
  const missing = r.scans.length ? `the recording holds ${r.scans.length} scan${r.scans.length > 1 ? "s" : ""}` : r.error ?? "";
  Object.assign(at("status"), { textContent: "✕ not scanned", className: "fault" });
  at("summary").textContent = missing;
  ["advice", "why", "maybes", "steps"].forEach((id) => at(id).replaceChildren());
  if (r.pending) Object.assign(at("status"), { textContent: WAITING, className: "" });
}
/** Shows guard sweeps: the worst status, and the free distance of each sweep as a picture. */
function showGuard({ at }, guard) {
  Object.assign(at("status"), { textContent: STATUS[guard.status][0], className: guard.status });
  at("summary").textContent = guard.summary;
  ["advice", "why", "maybes", "steps"].forEach((id) => at(id).replaceChildren());
  const source = (svg) => `data:image/svg+xml,${encodeURIComponent(svg)}`;
  const strip = Object.assign(document.createElement("img"), { src: source(guard.strip), alt: "Free distance of each guard sweep, in metres" });
  strip.style.maxWidth = "100%";
  // Scaled down to a phone, the wide drawing's text would be 6 px high.
  const narrow = Object.assign(document.createElement("source"), { srcset: source(guard.narrow), media: "(max-width: 640px)" });
  const picture = document.createElement("picture");
  picture.append(narrow, strip);
  at("advice").replaceChildren(picture, element("pre", guard.sentences.join("\n")));
}
/** Marks the selected recording in the index and scrolls the index to it, without moving the page. */
function showIndex() {
  const index = at("index");
  if (!index) return;
  [...index.children].forEach((button, k) => button.setAttribute("aria-current", k === state.recording));
  const button = index.children[state.recording];
  if (button) index.scrollTop = Math.min(button.offsetTop - index.offsetTop, Math.max(index.scrollTop, button.offsetTop + button.offsetHeight - index.offsetTop - index.clientHeight));
}
function show() {
  showIndex();
  const count = Math.max(...panes.map((view) => view.recording().scans.length));
  at("scans").hidden = count < 2;
  at("scan").max = Math.max(1, count);
  at("scan").value = state.scan + 1;
  at("scan-number").textContent = `${state.scan + 1} of ${count}`;
  const s = shownPanes()[0]?.scan();
  if (s) {
    const strongest = (s.inspection?.scatterers ?? [])[0];
    state.place = strongest ? [strongest.x_m, strongest.y_m] : s.map ? cartesian(s.map, 0.5, s.map.first_angle_rad + (s.map.rows / 2) * s.map.step_rad) : null;
  }
  panes.forEach(showPane);
  redraw();
  document.dispatchEvent(new Event("shown"));
}
function redraw() {
  for (const view of shownPanes()) {
    // An answer of a port has no map.
    view.at("pane").querySelectorAll(".of-map").forEach((part) => { part.hidden = !view.scan().map; });
    legend(view, view.scan());
  }
  redrawPlace();
}
function choose(k) {
  Object.assign(state, { recording: k, scan: 0 });
  show();
}
function fillIndex() {
  if (!at("index")) return;
  at("index").hidden = data.recordings.length < 2;
  at("index").replaceChildren(...data.recordings.map((r, k) => {
    const button = document.createElement("button");
    const worst = r.scans.find((s) => s.status === "fault") ?? r.scans.find((s) => s.status === "degraded") ?? r.scans[0];
    const wrong = r.scans.some((s) => s.status === "ok" && s.wrong);
    // The last answer of a port is stale if there is no current one.
    const [mark, kind] = r.stale ? ["✕ stale", "fault"] : worst ? [STATUS[worst.status][0], worst.status] : r.guard ? [STATUS[r.guard.status][0], r.guard.status] : r.pending ? [WAITING, ""] : ["✕ not scanned", "fault"];
    button.append(element("span", mark, `mark ${kind}`), element("span", r.name));
    if (wrong) button.append(element("span", "ok and wrong", "mark wrong"));
    button.append(element("span", (worst ?? r.guard)?.summary ?? r.error ?? ""));
    button.setAttribute("aria-current", k === state.recording);
    button.addEventListener("click", () => choose(k));
    return button;
  }));
}
for (const [key, word] of LAYERS) {
  const label = document.createElement("label");
  const box = Object.assign(document.createElement("input"), { type: "checkbox", checked: state.shown[key], id: `layer-${key}` });
  box.addEventListener("change", () => { state.shown[key] = box.checked; redraw(); });
  label.append(box, ` ${word}`);
  at("layers").append(label);
}
for (const view of panes) {
  const side = view.at("side");
  side.addEventListener("pointermove", (event) => point(view, event));
  side.addEventListener("pointerdown", (event) => point(view, event));
  side.addEventListener("keydown", (event) => byKey(view, event));
  // Lifting a finger ends the pointer; the note stays readable.
  side.addEventListener("pointerleave", (event) => { if (event.pointerType === "mouse") view.at("tip").hidden = true; });
}
at("scan").addEventListener("input", (event) => { state.scan = Number(event.target.value) - 1; show(); });
window.addEventListener("resize", redraw);
night.addEventListener("change", () => {
  HUE = looks();
  redraw();
});
at("made").textContent = `Made by cargo sim ${data.made ?? "report"}, stairscan ${data.version}, revision ${data.revision}, with the scanner's own answers.`;
if (data.recordings.length) {
  fillIndex();
  show();
}
