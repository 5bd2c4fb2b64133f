
// ---- Two scans side by side: their differences, then both views.
/** Fills the tables of differences once: they contain all scans. */
function showDifferences() {
  const { rows, settings } = data.compare;
  const names = data.recordings.map((r) => r.name);
  const signs = (text) => text.replaceAll("-", "−");
  const several = rows.some((row) => row.scan !== null);
  const head = [...(several ? ["scan"] : []), "", ...names, "difference", "σ of both"];
  const cells = (row) => [...(several ? [row.scan === null ? "–" : `${row.scan}`] : []), row.what, row.first, row.second, signs(row.by), row.sigma];
  table(at("differing"), head, rows.map(cells));
  table(at("settings-differing"), ["setting", ...names], settings);
  at("beside").textContent = names.join(" beside ");
  at("same").hidden = rows.length > 0;
}
showDifferences();
