
// ---- The truth of a recording, edited: a list of edges of the world, which each scan sees from where its mirror stood.
// An edge has `x` from the mirror at the first chirp, its `height`, and what each scan says of it: null, or whether it counts.
const truth = { chosen: null, drag: null };
/** Steps of two scans that lie nearer than this in distance and height are one, metres. */
const SAME_M = 0.02;
/** Farthest from a step that a pointer takes it, pixels. */
const GRIP = 22;

const editing = () => at("truth").open && Boolean(chosen()?.edit) && recording().scans.length > 0;
const edges = () => chosen().edit.edges;
/** Distance of an edge from the mirror of the scan that is shown, metres. */
const distanceOf = (edge) => edge.x - chosen().edit.travel[state.scan];
const millimetres = (metres) => Math.round(metres * 1000) / 1000;

/** The editable truth of what a recording says of its scans. */
function editable(told) {
  const edit = { edges: [], travel: told.map((scan) => scan.travel_m), drops: told.map((scan) => scan.truth?.drops), changed: false, fell: false };
  told.forEach(({ travel_m: travel, truth: said }, k) => {
    for (const [list, counted] of [[said?.steps, true], [said?.uncounted, false]]) {
      for (const step of list ?? []) {
        const x = step.distance_m + travel;
        let edge = edit.edges.find((e) => !e.scans[k] && Math.abs(e.x - x) < SAME_M && Math.abs(e.height - step.height_m) < SAME_M);
        if (!edge) edit.edges.push((edge = { x, height: step.height_m, scans: told.map(() => null) }));
        edge.scans[k] = { counted, distance: step.distance_m, snr_db: step.snr_db };
      }
    }
  });
  return edit;
}
/** A list of edges as recordings write it: from the mirror at `travel`, with `of` what a scan says of each. */
function written(all, travel, of, drops) {
  const step = (edge) => {
    const said = of(edge);
    // What was not moved stays as it was.
    const seen = edge.moved ? millimetres(edge.x - travel) : Number((edge.x - travel).toFixed(6));
    const distance = (!edge.moved && said.distance) || seen;
    const snr = edge.moved || typeof said.snr_db !== "number" ? {} : { snr_db: said.snr_db };
    return { distance_m: distance, height_m: edge.height, ...snr };
  };
  const list = (counted) => all.filter((edge) => of(edge)?.counted === counted).map(step).sort((a, b) => a.distance_m - b.distance_m);
  const steps = list(true);
  const up = steps.some((s) => s.height_m > 0);
  if (up && steps.some((s) => s.height_m < 0)) throw new Error("steps up and steps down are counted at once");
  const uncounted = list(false);
  return { direction: up ? "up" : steps.length ? "down" : "none", steps, ...(uncounted.length ? { uncounted } : {}), ...(drops ? { drops } : {}) };
}
/** The truth of every scan, and the whole one, which counts from the mirror at the first chirp. */
function truths({ edges: all, travel, drops, fell }) {
  // Edges that lead down tell the drops where those are not listed: a list of other edges would be false.
  const scans = travel.map((from, k) => written(all, from, (edge) => edge.scans[k], fell ? undefined : drops[k]));
  const anywhere = (edge) => ({ counted: edge.scans.some((said) => said?.counted) });
  return { scans, whole: scans.length > 1 ? written(all, 0, anywhere) : scans[0] };
}

/** Shows what the edges are now: list, drawing, and the truth that answers are held against. */
function showTruth() {
  fillTruth();
  const { edit } = chosen();
  if (edit.changed) {
    recording().scans.forEach((s, k) => {
      const seen = edit.edges.filter((edge) => edge.scans[k]).map((edge) => ({ distance_m: edge.x - edit.travel[k], height_m: edge.height, snr_db: null, counted: edge.scans[k].counted }));
      seen.sort((a, b) => a.distance_m - b.distance_m);
      s.truth = { edges: seen, steps: seen.filter((step) => step.counted), uncounted: seen.filter((step) => !step.counted) };
      // Until it is scanned anew, nobody has judged the answer by this truth.
      Object.assign(s, { wrong: null, flaws: [], exact: null });
    });
    // They stand above the side view, which is to stay where it is under a finger.
    if (!truth.drag) {
      showSteps(panes[0], scan());
      showVerdict(panes[0], scan());
    }
  }
  redrawPlace();
}
function tellTruth(text) {
  at("truth-told").textContent = text;
}
/** Notes that an edge is another than the recording says; `before` is its height until now. */
function change(edge, before = edge.height) {
  chosen().edit.changed = true;
  edge.moved = true;
  if (before < 0 || edge.height < 0) chosen().edit.fell = true;
}
function move(edge, distance, height) {
  const before = edge.height;
  edge.x = millimetres(distance + chosen().edit.travel[state.scan]);
  edge.height = millimetres(height);
  change(edge, before);
  tellTruth(`Step at ${cm(distanceOf(edge))}, ${cm(edge.height)} high`);
  showTruth();
}
function add(distance, height) {
  const { travel } = chosen().edit;
  const x = distance + travel[state.scan];
  // A scan that looks ahead reports neither what leads down nor what it has passed.
  const counts = (from) => !scan().map?.depth || (height > 0 && x > from);
  const edge = { x, height: millimetres(height), scans: travel.map((from) => ({ counted: counts(from) })) };
  edges().push(edge);
  truth.chosen = edge;
  move(edge, distance, height);
}
function remove(edge) {
  chosen().edit.edges = edges().filter((other) => other !== edge);
  change(edge);
  truth.chosen = null;
  tellTruth(`Removed the step at ${cm(distanceOf(edge))}`);
  showTruth();
}
/** The edges that the scan shown has, nearest first. */
const present = () => edges().filter((edge) => edge.scans[state.scan]).sort((a, b) => a.x - b.x);

/** A control with its name for those who do not see where it stands. */
function control(tag, label, properties) {
  const node = Object.assign(document.createElement(tag), properties);
  node.setAttribute("aria-label", label);
  return node;
}
/** One line of the list: fields for distance and height, whether it counts, a button that removes it. */
function line(edge, k) {
  const field = (name, metres, put) => {
    const input = control("input", `${name} of step ${k + 1}, cm`, { type: "number", step: "any", value: `${Number((100 * metres).toFixed(1))}` });
    input.addEventListener("change", () => { if (input.value !== "" && input.validity.valid) put(Number(input.value) / 100); });
    return input;
  };
  const tick = control("input", `step ${k + 1} is counted`, { type: "checkbox", checked: edge.scans[state.scan].counted });
  tick.addEventListener("change", () => {
    edge.scans[state.scan].counted = tick.checked;
    chosen().edit.changed = true;
    chosen().edit.fell ||= edge.height < 0;
    showTruth();
  });
  const button = control("button", `remove step ${k + 1}`, { type: "button", textContent: "Remove" });
  button.addEventListener("click", () => remove(edge));
  const row = document.createElement("tr");
  const far = field("distance", distanceOf(edge), (v) => move(edge, v, edge.height));
  const high = field("height", edge.height, (v) => move(edge, distanceOf(edge), v));
  for (const content of [`${k + 1}`, far, high, tick, button]) {
    const cell = document.createElement("td");
    cell.append(content);
    row.append(cell);
  }
  row.className = edge === truth.chosen ? "winner" : "";
  row.addEventListener("focusin", () => { truth.chosen = edge; redrawPlace(); });
  return row;
}
/** Fills the list; the control that has the focus keeps it. */
function fillTruth() {
  const [rows, list] = [present(), at("truth-steps")];
  const controls = () => [...list.querySelectorAll("input, button")];
  const focus = controls().indexOf(document.activeElement);
  const head = document.createElement("tr");
  head.append(...["step", "distance, cm", "height, cm", "counted", ""].map((word) => element("th", word)));
  list.replaceChildren(...(rows.length ? [head, ...rows.map(line)] : []));
  controls()[focus]?.focus();
  at("truth-discard").disabled = !chosen().edit.changed && !chosen().before;
}

/** Grips of the edges, over the side view. */
panes[0].over = (g, { X, Y }) => {
  if (!editing()) return;
  for (const edge of present()) {
    const { counted } = edge.scans[state.scan];
    stroke(g, HUE.truth, edge === truth.chosen ? 4 : 2, counted ? [] : [3, 3]);
    g.beginPath();
    g.arc(X(distanceOf(edge)), Y(edge.height), edge === truth.chosen ? 10 : 8, 0, 2 * Math.PI);
    g.stroke();
  }
};
/** The edge that a pointer takes, if one is near. */
function gripped(event) {
  const box = at("side").getBoundingClientRect();
  const { X, Y } = panes[0].frame;
  const [px, py] = [event.clientX - box.left, event.clientY - box.top];
  const near = present().map((edge) => [Math.hypot(X(distanceOf(edge)) - px, Y(edge.height) - py), edge]).sort((a, b) => a[0] - b[0])[0];
  return near && near[0] <= GRIP ? { edge: near[1], off: [X(distanceOf(near[1])) - px, Y(near[1].height) - py] } : null;
}
/** Lets go of what is dragged. */
function drop() {
  if (!truth.drag) return;
  truth.drag = null;
  panes[0].held = null;
  showTruth();
}
const dragging = {
  pointerdown(event) {
    truth.drag = gripped(event);
    if (!truth.drag) return;
    truth.chosen = truth.drag.edge;
    // The scale stays as it was while the step moves.
    panes[0].held = panes[0].frame.box;
    at("side").setPointerCapture(event.pointerId);
    event.stopImmediatePropagation();
  },
  pointermove(event) {
    if (!truth.drag) return;
    event.stopImmediatePropagation();
    const box = at("side").getBoundingClientRect();
    const [{ edge, off }, { x, y }] = [truth.drag, panes[0].frame];
    move(edge, x(event.clientX - box.left + off[0]), y(event.clientY - box.top + off[1]));
  },
  pointerup: drop,
  pointercancel: drop,
};
for (const [kind, act] of Object.entries(dragging)) {
  at("side").addEventListener(kind, (event) => { if (editing()) act(event); }, { capture: true });
}
const WAYS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
at("side").addEventListener("keydown", (event) => {
  if (!editing()) return;
  const [all, way, edge] = [present(), WAYS[event.key], truth.chosen];
  if (event.key === "PageUp" || event.key === "PageDown") {
    const k = all.indexOf(edge) + (event.key === "PageDown" ? 1 : -1);
    truth.chosen = all[Math.max(0, Math.min(all.length - 1, k))] ?? null;
    if (truth.chosen) tellTruth(`Step at ${cm(distanceOf(truth.chosen))}, ${cm(truth.chosen.height)} high`);
    showTruth();
  } else if (event.key === "Delete" && edge) remove(edge);
  else if (event.key === "Insert" && state.place) add(...state.place);
  else if (way && edge) move(edge, distanceOf(edge) + way[0] * (event.shiftKey ? 0.05 : 0.01), edge.height + way[1] * (event.shiftKey ? 0.05 : 0.01));
  else return;
  event.preventDefault();
  event.stopImmediatePropagation();
}, { capture: true });

/** Puts the edited truth into the recording's metadata; returns whether that could be done. */
async function commit(item) {
  if (!item.edit?.changed) return true;
  let told;
  try {
    told = truths(item.edit);
  } catch (error) {
    say(`${item.name}: ${error.message}`, true);
    return false;
  }
  const answer = await ask({ head: { ...head("truth", item), ...told }, body: item.data });
  if (answer.error) {
    say(answer.error, true);
    return false;
  }
  item.before ??= { meta: item.meta, array: item.array, data: item.data };
  // Samples of another form become those of a recording, which the metadata belong to.
  if (answer.data) Object.assign(item, { array: false, data: bytes(answer.data), converted: true });
  Object.assign(item, { meta: answer.meta, edit: null });
  say("");
  return true;
}
/** Leaves the mode: the recording is scanned anew against its truth. */
async function finish(item) {
  truth.chosen = null;
  if (item?.edit?.changed && (await commit(item))) scanItem(item);
}
at("truth-add").addEventListener("click", () => {
  const last = present().at(-1);
  add(...(last ? [distanceOf(last) + 0.28, last.height + 0.17 * (Math.sign(last.height) || 1)] : [0.8, 0.17]));
});
at("truth-save").addEventListener("click", async () => {
  const item = chosen();
  if (!(await commit(item))) return;
  if (item.meta === undefined) return say(`${item.name}: expected a step, or metadata to save`, true);
  save(`${item.name}.sigmf-meta`, new Blob([item.meta], { type: "application/json" }));
  if (item.converted) save(`${item.name}.sigmf-data`, new Blob([item.data], { type: "application/octet-stream" }));
  scanItem(item);
});
at("truth-discard").addEventListener("click", () => {
  const item = chosen();
  Object.assign(item, item.before ?? {}, { before: undefined, converted: false, edit: null });
  tellTruth("");
  say("");
  scanItem(item);
});
at("truth").addEventListener("toggle", () => {
  document.body.classList.toggle("truth", at("truth").open);
  if (!at("truth").open) finish(chosen());
  show();
});
document.addEventListener("shown", () => {
  const [item, r] = [chosen(), recording()];
  at("truth").hidden = !item || Boolean(item.live) || !r?.scans.length;
  if (truth.item !== item) {
    const left = truth.item;
    Object.assign(truth, { item, chosen: null, drag: null });
    tellTruth("");
    finish(left);
  }
  if (at("truth").hidden) return;
  // What was not changed follows the recording, which may have been scanned anew.
  if (!item.edit?.changed && item.edit?.of !== r) item.edit = { ...editable(r.truth), of: r };
  if (editing()) showTruth();
});
