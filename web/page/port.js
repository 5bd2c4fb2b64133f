
// ---- A scanner at a serial port: bytes go to the scanner's own parser, which returns the scanner's state.
/** Number of a port's answers on the slider. */
const KEPT = 200;
const TICK_MS = 250;
const port = { open: null, item: null, stop: false, standing: null };

/** Passes an event of the port to the parser, and shows the new state. */
async function news(what, more = {}, body = undefined) {
  const told = await ask({ head: { do: "port", now: Math.round(performance.now()), what, ...more }, body });
  if (told.error) return say(told.error, true);
  const { pulse, standing, damaged, age_ms: age } = told;
  for (const answer of told.answers) keepAnswer(answer);
  const parts = [port.item.answered ? standing.join(": ") : "no answer yet"];
  if (pulse) parts.push(`scanner ${pulse.state}, scan ${pulse.scan}, up ${(pulse.uptime_ms / 1000).toFixed(0)} s`);
  if (age !== null) parts.push(`answer ${(age / 1000).toFixed(1)} s old`);
  parts.push(damaged === 1 ? "1 damaged sentence" : `${damaged} damaged sentences`);
  if (told.trouble) parts.push(told.trouble);
  at("live-state").textContent = parts.join("; ");
  at("live-help").replaceChildren(...told.help.map((line) => element("li", line)));
  fillLog(told.log);
  const before = port.standing?.[0];
  port.standing = standing;
  const k = bench.items.indexOf(port.item);
  data.recordings[k].stale = port.item.answered && standing[0] !== "fresh";
  if (told.answers.length || before !== standing[0]) refresh(k);
}
function fillLog(log) {
  const pre = at("live-log");
  const below = pre.scrollTop + pre.clientHeight >= pre.scrollHeight - 4;
  pre.replaceChildren(...log.map(([, way, text]) => element("div", text, way)));
  if (below) pre.scrollTop = pre.scrollHeight;
}
/** Appends an answer. The slider follows if it was at the last one. */
function keepAnswer(answer) {
  const k = bench.items.indexOf(port.item);
  const before = data.recordings[k].scans;
  const last = state.scan >= before.length - 1;
  port.item.answered = true;
  const scans = [...before, answer].slice(-KEPT);
  data.recordings[k] = { name: port.item.name, description: "live", settings: [], stale: false, scans };
  if (last && state.recording === k) state.scan = scans.length - 1;
}
/** Marks a stale answer of a port. */
function markStale() {
  const live = Boolean(chosen()?.live) && recording().scans.length > 0;
  const earlier = live && (chosen() !== port.item || state.scan < recording().scans.length - 1);
  const [word, meaning] = earlier ? ["earlier", "an earlier answer, kept to look at"] : port.standing ?? ["fresh", ""];
  const stale = live && word !== "fresh";
  document.body.classList.toggle("stale", stale);
  if (!stale) return;
  Object.assign(at("status"), { textContent: earlier ? "earlier answer" : "✕ stale", className: earlier ? "" : "fault" });
  at("advice").textContent = `Do not act on it: ${meaning}. It was ${scan().status}.`;
}
document.addEventListener("shown", markStale);

/** Reads until the port disappears or is closed. */
async function listen(device) {
  // After a damaged byte the browser ends the stream and opens a new one; without a new one the port has disappeared.
  while (device.readable && !port.stop) {
    port.reader = device.readable.getReader();
    try {
      for (;;) {
        const { value, done } = await port.reader.read();
        if (done) break;
        await news("bytes", {}, value);
      }
    } catch (error) {
      port.why = error.message;
      if (device.readable) await news("tick");
    } finally {
      port.reader.releaseLock();
    }
  }
}
/** Opens a port and shows its data until it disappears. */
async function connect(device) {
  const baud = Number(at("baud").value);
  await device.open({ baudRate: baud });
  const { usbVendorId: vendor, usbProductId: product } = device.getInfo?.() ?? {};
  const hex = (number) => number.toString(16).padStart(4, "0");
  const name = vendor === undefined ? "serial port" : `serial port ${hex(vendor)}:${hex(product)}`;
  Object.assign(port, { open: device, stop: false, why: "", standing: null, again: null, item: { name, live: true, settings: {} } });
  const k = put(port.item);
  data.recordings[k] = { name, error: "no answer yet", scans: [] };
  at("connect").textContent = "Disconnect";
  await news("opened", { port: name, baud });
  fillIndex();
  choose(k);
  const tick = setInterval(() => news("tick"), TICK_MS);
  await listen(device);
  clearInterval(tick);
  await news("gone", { why: port.stop ? "disconnected" : port.why || "the device was lost" });
  await device.close().catch(() => {});
  // The port is reopened when it is plugged in again.
  Object.assign(port, { open: null, again: port.stop ? null : device });
  at("connect").textContent = "Connect to a serial port…";
}
/** Opens a port, and shows the cause of a failure. */
async function tryPort(find) {
  try {
    say("");
    await connect(await find());
  } catch (error) {
    // Not choosing a port is not a failure.
    if (error.name !== "NotFoundError") say(`serial port: ${error.message}`, true);
  }
}
at("connect").addEventListener("click", () => {
  if (!port.open) return tryPort(() => navigator.serial.requestPort());
  port.stop = true;
  return port.reader?.cancel();
});
navigator.serial?.addEventListener("connect", ({ target }) => {
  if (!port.open && port.again === target) tryPort(() => target);
});
at("live-none").hidden = "serial" in navigator;
at("live-some").hidden = !("serial" in navigator);
