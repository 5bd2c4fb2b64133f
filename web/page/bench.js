
// ---- The control panel: files, settings, downloads; everything without a port. The scanner runs in a worker.
const bench = { items: [], waiting: new Map(), asked: 0, replies: new Map(), about: null };
/** Maximum size of a file, bytes: a browser holds several copies of it. */
const LARGEST = 256e6;

/** Decodes base64 and inflates. */
async function unpacked(text) {
  const stream = new Blob([bytes(text)]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}
/** Joins the low bytes of 16-bit numbers, which come first, with the high ones. */
function joinedPlanes(planes) {
  const half = planes.length / 2;
  return Uint8Array.from(planes, (_, k) => planes[(k >> 1) + (k & 1 ? half : 0)]);
}
const worker = new Worker(URL.createObjectURL(new Blob([at("worker").textContent], { type: "text/javascript" })));
worker.onmessage = ({ data: { id, answer } }) => {
  bench.replies.get(id)(answer);
  bench.replies.delete(id);
};
/** Returns the scanner's answer to a request; `message` may contain the scanner itself. */
function ask(message) {
  return new Promise((resolve) => {
    bench.replies.set((bench.asked += 1), resolve);
    worker.postMessage({ id: bench.asked, ...message });
  });
}
function say(text, wrong = false) {
  at("news").textContent = text;
  at("news").className = wrong ? "wrong" : "";
}

const chosen = () => bench.items[state.recording];
/** Returns the head of a request about an item. */
const head = (what, item) => ({ do: what, name: item.name, array: item.array, meta: item.meta, angles: item.angles, settings: item.settings });

/** Adds an item, or replaces the one with its name; returns its index. */
function put(item) {
  const known = bench.items.findIndex((other) => other.name === item.name && other.live === item.live);
  const k = known < 0 ? bench.items.length : known;
  bench.items[k] = item;
  data.recordings[k] = { name: item.name, pending: true, scans: [] };
  return k;
}
/** Scans an item. If it changes meanwhile, its last state is scanned afterwards. */
async function scanItem(item) {
  item.wanted = true;
  if (item.busy) return;
  item.busy = true;
  document.body.classList.add("busy");
  while (item.wanted) {
    item.wanted = false;
    const answer = await ask({ head: head("scan", item), body: item.data });
    const k = bench.items.indexOf(item);
    if (k < 0 || item.wanted) continue;
    item.own = answer.own ?? item.own;
    data.recordings[k] = answer.error && !answer.scans ? { name: item.name, error: answer.error, scans: [] } : answer;
    if (k === state.recording) state.scan = Math.max(0, Math.min(state.scan, answer.scans?.length - 1 || 0));
    refresh(k);
  }
  item.busy = false;
  document.body.classList.toggle("busy", bench.items.some((other) => other.busy));
}
/** Draws the index, and the recording if it is displayed. */
function refresh(k) {
  const focus = [...document.querySelectorAll("#index button")].indexOf(document.activeElement);
  fillIndex();
  document.querySelectorAll("#index button")[focus]?.focus();
  if (k === state.recording) show();
}

/** Adds a file to the others with its name; returns the name, or throws an error that describes the fault of the file. */
async function keep(file) {
  const [, stem, suffix] = /^(.*?)\.(sigmf-meta|sigmf-data|npy|csv|txt)$/.exec(file.name) ?? [];
  if (!stem) throw new Error("expected .sigmf-meta with .sigmf-data, .npy, or a table of angles (.csv, .txt)");
  if (file.size > LARGEST) throw new Error(`${file.size} bytes, expected at most ${LARGEST}`);
  const binary = suffix === "npy" || suffix === "sigmf-data";
  const content = binary ? new Uint8Array(await file.arrayBuffer()) : await file.text();
  bench.waiting.set(stem, { ...bench.waiting.get(stem), [suffix]: content });
  return stem;
}
/** Returns the recording of this name if all of its files are present, else the suffix of the missing one. */
function whole(name) {
  const parts = bench.waiting.get(name);
  const { npy, "sigmf-meta": meta, "sigmf-data": samples } = parts;
  if (!npy && !(samples && meta)) return { missing: meta ? "sigmf-data" : samples ? "sigmf-meta" : "npy" };
  bench.waiting.delete(name);
  return { item: { name, array: Boolean(npy), meta, angles: parts.csv ?? parts.txt, data: npy ?? samples, settings: {} } };
}
/** Processes files; the two files of a pair may be given one after the other. */
async function take(files) {
  const [wrong, names] = [[], new Set()];
  for (const file of files) {
    try {
      names.add(await keep(file));
    } catch (error) {
      wrong.push(`${file.name}: ${error.message}`);
    }
  }
  let first = null;
  const bare = [];
  for (const name of names) {
    const { item, missing } = whole(name);
    if (missing) wrong.push(`${name}.${missing}: missing; add it, too`);
    else {
      const k = put(item);
      first ??= k;
      scanItem(item);
      if (item.array && !item.meta) bare.push(`${name}.npy`);
    }
  }
  // Values that an array does not contain are assumed: the fields for correcting them are opened.
  const assumed = `${bare.join(", ")}: an array holds samples only; the settings below are assumed until they are changed`;
  if (bare.length) at("set").open = true;
  say([...wrong, ...(bare.length ? [assumed] : [])].join("; "), wrong.length > 0);
  fillIndex();
  if (first !== null) choose(first);
}
at("files").addEventListener("change", async ({ target }) => {
  await take([...target.files]);
  target.value = "";
});
const carriesFiles = (event) => event.dataTransfer?.types.includes("Files");
for (const [kind, over] of [["dragenter", true], ["dragover", true], ["dragleave", false], ["drop", false]]) {
  window.addEventListener(kind, (event) => {
    if (!carriesFiles(event)) return;
    event.preventDefault();
    document.body.classList.toggle("drop", over);
    if (kind === "drop") take([...event.dataTransfer.files]);
  });
}

// Settings: an empty field keeps the recording's value, which is its placeholder.
const form = at("settings-of-scan");
const fields = [...form.elements].filter((field) => field.name);
/** Returns the values of the non-empty fields, in the scanner's units. */
function settings() {
  const set = {};
  for (const field of fields) {
    const scaled = () => Number((Number(field.value) * Number(field.dataset.scale)).toPrecision(12));
    if (field.type === "checkbox") set[field.name] = field.checked;
    else if (field.value !== "") set[field.name] = field.dataset.scale ? scaled() : field.value;
  }
  return set;
}
/** Fills the fields with the settings of the displayed recording. */
function fillSettings() {
  const item = chosen();
  at("set").hidden = !item || Boolean(item.live);
  at("csv").disabled = !item || Boolean(item.live) || !recording().scans.length;
  at("png").disabled = !recording()?.scans.length;
  document.querySelectorAll(".of-array").forEach((label) => { label.hidden = !item?.array; });
  if (!item || item.live) return;
  for (const field of fields) {
    const value = item.settings[field.name];
    const scale = Number(field.dataset.scale ?? 1);
    const own = item.own?.[field.name];
    const shown = (v) => `${Number((v / scale).toPrecision(9))}`;
    if (field.type === "number" && own !== undefined) field.placeholder = shown(own);
    if (field === document.activeElement) continue;
    const unset = field.name === "estimator" ? bench.about?.estimator ?? "" : "";
    if (field.type === "checkbox") field.checked = value ?? false;
    else if (value === undefined) field.value = unset;
    else field.value = field.dataset.scale ? shown(value) : value;
  }
  const plane = form.elements.plane.options[0];
  plane.textContent = item.own ? `as recorded (${item.own.plane})` : "as recorded";
}
form.addEventListener("submit", (event) => event.preventDefault());
form.addEventListener("change", () => {
  const bad = fields.find((field) => !field.validity.valid);
  if (bad) return say(`${bad.labels[0].textContent.trim()}: ${bad.validationMessage}`, true);
  say("");
  chosen().settings = settings();
  scanItem(chosen());
});
form.addEventListener("reset", () => setTimeout(() => {
  say("");
  document.activeElement?.blur();
  chosen().settings = {};
  scanItem(chosen());
}));
document.addEventListener("shown", fillSettings);

function save(name, blob) {
  const link = Object.assign(document.createElement("a"), { href: URL.createObjectURL(blob), download: name });
  document.body.append(link);
  link.click();
  link.remove();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}
at("csv").addEventListener("click", async () => {
  const item = chosen();
  const answer = await ask({ head: head("table", item), body: item.data });
  if (answer.error) return say(answer.error, true);
  save(`${item.name}.csv`, new Blob([answer.csv], { type: "text/csv" }));
});
/** Returns heading, side view and range profile as one picture. */
function picture() {
  const [side, profile] = [at("side"), at("profile")];
  const ratio = side.width / side.clientWidth;
  const [top, s] = [64 * ratio, scan()];
  const canvas = Object.assign(document.createElement("canvas"), { width: side.width, height: top + side.height + (s.map ? profile.height : 0) });
  const g = canvas.getContext("2d");
  g.fillStyle = getComputedStyle(document.body).backgroundColor;
  g.fillRect(0, 0, canvas.width, canvas.height);
  g.fillStyle = HUE.horizon;
  g.font = `600 ${18 * ratio}px system-ui, sans-serif`;
  const several = recording().scans.length > 1 ? `, scan ${state.scan + 1} of ${recording().scans.length}` : "";
  g.fillText(recording().name + several, 12 * ratio, 24 * ratio, canvas.width - 24 * ratio);
  g.font = `${14 * ratio}px system-ui, sans-serif`;
  const stale = document.body.classList.contains("stale") ? "not the present answer; it was " : "";
  g.fillText(stale + s.summary, 12 * ratio, 48 * ratio, canvas.width - 24 * ratio);
  g.drawImage(side, 0, top);
  if (s.map) g.drawImage(profile, 0, top + side.height);
  return canvas;
}
at("png").addEventListener("click", () => picture().toBlob((blob) => save(`${recording().name}.png`, blob), "image/png"));

/** Starts the scanner, then scans the recordings that the page contains. */
async function begin() {
  const started = await ask({ wasm: await unpacked(at("wasm").textContent), head: { do: "about" } });
  if (started.error) return say(started.error, true);
  bench.about = started;
  form.elements.estimator.replaceChildren(...started.estimators.map((word) => element("option", word)));
  form.elements.seed.placeholder = started.seed;
  for (const { name, meta, data: packed } of JSON.parse(at("stock").textContent)) {
    put({ name, array: false, meta, data: joinedPlanes(await unpacked(packed)), settings: {} });
  }
  if (!bench.items.length) return;
  fillIndex();
  show();
  for (const item of [...bench.items]) await scanItem(item);
}
begin().catch((error) => say(`this browser cannot run the scanner: ${error.message}`, true));
