
// ---- Texts and tables of a scan.
/** Status, summary and reasons of a pane's scan. */
function showVerdict({ at }, s) {
  const [word, advice] = STATUS[s.status];
  at("status").textContent = word;
  at("status").className = s.status;
  at("summary").textContent = s.summary.replace(/^[^:]*: /, "");
  at("advice").textContent = advice + (s.wrong ? ` By the recording's ground truth the answer is wrong: ${s.flaws.join("; ")}.` : "");
  at("why").replaceChildren(...s.why.map(([reason, meaning]) => {
    const item = document.createElement("li");
    item.append(element("code", reason), ` – ${meaning}`);
    return item;
  }));
  const drop = s.drop ? [element("li", `DROP at ${cm(s.drop.distance_m)}: the ground ends, not before ${cm(Math.max(0, s.drop.distance_m - 3 * s.drop.distance_sigma_m))}${s.drop.depth_m === null ? "" : `, ${cm(s.drop.depth_m, 0)} deep`} (${percent(s.drop.probability)})`)] : [];
  at("maybes").replaceChildren(...drop, ...s.maybe.map((m) => element("li", `MAYBE at ${cm(m.distance_m)}: ${m.height_m < 0 ? "the ground may end" : `something ${cm(m.height_m, 0)} high`} (${percent(m.probability)})`)));
}
function showSteps({ at }, s) {
  const real = s.truth?.steps ?? [];
  const nearest = (step) => real.filter((t) => Math.abs(t.distance_m - step.distance_m) <= 0.1).sort((a, b) => Math.abs(a.distance_m - step.distance_m) - Math.abs(b.distance_m - step.distance_m))[0];
  const head = ["step", "distance ± 2σ", "height ± 2σ", "tread", "riser", "quality"];
  if (s.truth) head.push("distance is off by", "height is off by");
  const rows = s.steps.map((p, k) => {
    const cells = [`${k + 1}`, `${fixed(100 * p.distance_m, 1)} ± ${cm(2 * p.distance_sigma_m)}`, `${fixed(100 * p.height_m, 1)} ± ${cm(2 * p.height_sigma_m)}`,
      p.tread_m === null ? "–" : cm(p.tread_m), p.riser_m === null ? "–" : cm(p.riser_m), `${p.quality} %`];
    const t = nearest(p);
    const without = (s.truth?.uncounted ?? []).some((u) => Math.abs(u.distance_m - p.distance_m) <= 0.1) ? "not counted" : "not there";
    if (s.truth) cells.push(t ? plus(p.distance_m - t.distance_m) : without, t ? plus(p.height_m - t.height_m) : without);
    return cells;
  });
  const told = (t) => s.steps.some((p) => nearest(p) === t);
  for (const t of real.filter((t) => !told(t))) rows.push([t.snr_db === null ? "missed" : `missed (${t.snr_db.toFixed(0)} dB)`, cm(t.distance_m), cm(t.height_m), "–", "–", "–", "–", "–"]);
  table(at("steps"), head, rows);
}
function showDetails({ at, recording }, s) {
  table(at("rivals"), ["hypothesis", "first edge", "score, nats", "probability"], (s.rivals ?? []).map((r) => [r.winner ? `${r.name} (the answer's)` : r.name, r.edges.length ? cm(r.edges[0].distance_m) : undefined, r.score === undefined ? undefined : fixed(r.score, 1), r.probability === undefined ? undefined : percent(r.probability)]));
  table(at("echoes"), ["role", "dB", "distance", "height", "range from the radar"], (s.inspection?.scatterers ?? []).map((e) => [e.against ? `${e.role} (against)` : e.role, e.snr_db.toFixed(1), cm(e.x_m), cm(e.y_m), cm(e.range_m + s.map.mirror_offset_m)]));
  at("sentences").textContent = s.sentences.join("\n");
  table(at("settings"), ["key", "value"], recording().settings ?? []);
}
function legend({ at }, s) {
  const line = (colour, dash, width) => `<svg viewBox="0 0 24 12"><path d="M0 6H24" stroke="${colour}" stroke-width="${width}" stroke-dasharray="${dash}"/></svg>`;
  const shape = (colour, path) => `<svg viewBox="0 0 24 12"><path d="${path}" stroke="${colour}" stroke-width="1.8" fill="none"/></svg>`;
  const items = [[line(HUE.answer, "", 2.5), "answer"]];
  if (s.horizon_m !== null && s.steps.some((p) => p.distance_m > s.horizon_m)) items.push([line(HUE.answer, UNCERTAIN.join(" "), 1.8), "beyond its horizon: not valid"]);
  if (state.shown.sigma && s.steps.length) items.push([shape(HUE.answer, "M4 2H20V10H4Z"), "±2σ of a step"]);
  if (state.shown.horizon && s.horizon_m > 0) items.push([line(HUE.horizon, "1 4", 1.5), "horizon"]);
  if (state.place && s.map) items.push([line(HUE.beam, "", 1), "beam through the place pointed at"]);
  if (s.truth && state.shown.truth) items.push([line(HUE.truth, "7 4", 4), "ground truth"]);
  if (state.shown.rivals) items.push([line(HUE.rival, "3 4", 6), "runners-up"]);
  if (state.shown.echoes && s.inspection) items.push([shape(HUE.answer, "M7 6a5 5 0 1 0 10 0a5 5 0 1 0 -10 0"), "echo explained by the answer"], [shape(HUE.against, "M7 1L17 11M7 11L17 1"), "echo against the answer"], [shape(HUE.stray, "M7 1H17V11H7Z"), "unexplained echo"]);
  if (state.shown.drop && s.drop) items.push([line(HUE.drop, "", 2.5), "DROP: the ground ends, band of ±3σ"]);
  if (state.shown.maybe && s.maybe.length) items.push([shape(HUE.maybe, "M12 0L18 6L12 12L6 6Z"), "MAYBE"]);
  at("legend").innerHTML = items.map(([picture, word]) => `<span>${picture}${word}</span>`).join("");
}
