
// ---- A scanner at a serial port: bytes go to the scanner's own parser, which says what is known of it.
/** Answers of a port that the slider keeps. */
const KEPT = 200;
const TICK_MS = 250;
const port = { open: null, item: null, stop: false };

/** Tells the parser what happened at the port, and shows what is known now. */
async function news(what, more = {}, body = undefined) {
  const told = await ask({ head: { do: "port", now: Math.round(performance.now()), what, ...more }, body });
  if (told.error) return say(told.error, true);
  const { pulse, standing: [word, meaning], damaged, age_ms: age } = told;
  const parts = [told.entry || port.item?.answered ? `${word}: ${meaning}` : "no answer yet"];
  if (pulse) parts.push(`scanner ${pulse.state}, scan ${pulse.scan}, up ${(pulse.uptime_ms / 1000).toFixed(0)} s`);
  if (age !== null) parts.push(`answer ${(age / 1000).toFixed(1)} s old`);
  parts.push(damaged === 1 ? "1 damaged sentence" : `${damaged} damaged sentences`);
  if (told.trouble) parts.push(told.trouble);
  at("live-state").textContent = parts.join("; ");
  at("live-help").replaceChildren(...told.help.map((line) => element("li", line)));
  fillLog(told.log);
  if (told.entry) keepAnswer(told.entry);
}
function fillLog(log) {
  const pre = at("live-log");
  const below = pre.scrollTop + pre.clientHeight >= pre.scrollHeight - 4;
  const mark = { damaged: "✕ ", in: "  ", out: "> ", note: "· " };
  pre.replaceChildren(...log.map(([, way, text]) => element("div", `${mark[way]}${text}`, way)));
  if (below) pre.scrollTop = pre.scrollHeight;
}
/** Puts an answer behind those before; the slider goes along where it stood at the last one. */
function keepAnswer(entry) {
  const k = bench.items.indexOf(port.item);
  const before = port.item.answered ? data.recordings[k].scans : [];
  const last = state.recording !== k || state.scan >= before.length - 1;
  port.item.answered = true;
  const scans = [...before, ...entry.scans].slice(-KEPT);
  data.recordings[k] = { ...entry, scans };
  if (last && state.recording === k) state.scan = scans.length - 1;
  refresh(k);
}

/** Reads until the port goes away or is given up. */
async function listen(device) {
  // A stream that broke for a damaged byte is followed by a new one; without one the port has gone.
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
async function connect() {
  const device = await navigator.serial.requestPort();
  const baud = Number(at("baud").value);
  await device.open({ baudRate: baud });
  const { usbVendorId: vendor, usbProductId: product } = device.getInfo?.() ?? {};
  const hex = (number) => number.toString(16).padStart(4, "0");
  const name = vendor === undefined ? "serial port" : `serial port ${hex(vendor)}:${hex(product)}`;
  Object.assign(port, { open: device, stop: false, why: "", item: { name, live: true, settings: {} } });
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
  port.open = null;
  at("connect").textContent = "Connect to a serial port…";
}
at("connect").addEventListener("click", async () => {
  if (port.open) {
    port.stop = true;
    return port.reader?.cancel();
  }
  try {
    say("");
    await connect();
  } catch (error) {
    // That no port was chosen is no failure.
    if (error.name !== "NotFoundError") say(`serial port: ${error.message}`, true);
  }
});
at("live-none").hidden = "serial" in navigator;
at("live-some").hidden = !("serial" in navigator);
