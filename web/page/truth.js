
// ---- Editor of a recording's ground truth: a list of edges in world coordinates, seen from the mirror's position in each scan.
// An edge has `x` relative to the mirror at the first chirp, its `height`, and an entry for each scan: null, or whether it is counted.
const truth = { chosen: null, drag: null };
/** Maximum difference in distance and height between entries of the same step in two scans, metres. */
const SAME_M = 0.02;
/** Maximum distance of the pointer from a step that it grips, pixels. */
const GRIP = 22;

const editing = () => at("truth").open && Boolean(chosen()?.edit) && recording().scans.length > 0;
const edges = () => chosen().edit.edges;
/** Returns the distance of an edge from the mirror in the displayed scan, metres. */
const distanceOf = (edge) => edge.x - chosen().edit.travel[state.scan];
const millimetres = (metres) => Math.round(metres * 1000) / 1000;

/** Converts the ground truth of a recording's scans to the editable form. */
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
/** Returns the edges in the format of recordings: relative to the mirror at `travel`, with the entry `of` of a scan for each. */
function written(all, travel, of, drops) {
  const step = (edge) => {
    const said = of(edge);
    // Unmoved edges keep their exact values.
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
/** Returns the ground truth of every scan, and that relative to the mirror at the first chirp. */
function truths({ edges: all, travel, drops, fell }) {
  // Without a list of drops, downward edges define them; an incomplete list would be wrong.
  const scans = travel.map((from, k) => written(all, from, (edge) => edge.scans[k], fell ? undefined : drops[k]));
  const anywhere = (edge) => ({ counted: edge.scans.some((said) => said?.counted) });
  return { scans, whole: scans.length > 1 ? written(all, 0, anywhere) : scans[0] };
}

/** Shows the current edges: list, drawing, and the ground truth for scoring. */
function showTruth() {
  fillTruth();
  const { edit } = chosen();
  if (edit.changed) {
    recording().scans.forEach((s, k) => {
      const seen = edit.edges.filter((edge) => edge.scans[k]).map((edge) => ({ distance_m: edge.x - edit.travel[k], height_m: edge.height, snr_db: null, counted: edge.scans[k].counted }));
      seen.sort((a, b) => a.distance_m - b.distance_m);
      s.truth = { edges: seen, steps: seen.filter((step) => step.counted), uncounted: seen.filter((step) => !step.counted) };
      // The answer has not been scored against this ground truth until the next scan.
      Object.assign(s, { wrong: null, flaws: [], exact: null });
    });
    // The tables are above the side view, which must not move under a finger.
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
/** Marks an edge as changed; `before` is its previous height. */
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
  // A scan of the depth plane reports neither downward edges nor those behind the mirror.
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
/** Returns the edges of the displayed scan, nearest first. */
const present = () => edges().filter((edge) => edge.scans[state.scan]).sort((a, b) => a.x - b.x);

/** Returns a control with an accessible name. */
function control(tag, label, properties) {
  const node = Object.assign(document.createElement(tag), properties);
  node.setAttribute("aria-label", label);
  return node;
}
/** Returns one line of the list: fields for distance and height, whether it is counted, a button to remove it. */
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
/** Fills the list; the focus is kept. */
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
/** Returns the edge near the pointer, if there is one. */
function gripped(event) {
  const box = at("side").getBoundingClientRect();
  const { X, Y } = panes[0].frame;
  const [px, py] = [event.clientX - box.left, event.clientY - box.top];
  const near = present().map((edge) => [Math.hypot(X(distanceOf(edge)) - px, Y(edge.height) - py), edge]).sort((a, b) => a[0] - b[0])[0];
  return near && near[0] <= GRIP ? { edge: near[1], off: [X(distanceOf(near[1])) - px, Y(near[1].height) - py] } : null;
}
/** Ends dragging. */
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
    // The scale is fixed while the step is dragged.
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

/** Writes the edited ground truth into the recording's metadata; returns whether it succeeded. */
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
  // Samples in another format are converted to a recording, to which the metadata belong.
  if (answer.data) Object.assign(item, { array: false, data: bytes(answer.data), converted: true });
  Object.assign(item, { meta: answer.meta, edit: null });
  say("");
  return true;
}
/** Leaves the editor: the recording is scanned again and scored against its ground truth. */
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
  // An unchanged ground truth is updated from the recording, which may have been scanned again.
  if (!item.edit?.changed && item.edit?.of !== r) item.edit = { ...editable(r.truth), of: r };
  if (editing()) showTruth();
});
