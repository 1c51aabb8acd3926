"use strict";
// The colour scale of the views: ticks, unit, a histogram of each shown result, and two ends that can be dragged.

const BINS = 64;

function isScalar() {
  return colourings()[view.colour]?.kind === "scalar";
}

// The columns that are shown now, with the method that they belong to.
function shownColumns() {
  const all = decoded.get(view.model);
  const entries = view.model.results && view.colour !== "height" ? shownEntries().filter(Boolean) : [null];
  return entries.map((entry) => ({ method: entry?.method, ...columnOf(entry ? decoded.get(entry) : all, all, view.colour) })).filter((column) => column.words);
}

// A share of the values of a column lies below this one.
function quantile(column, share) {
  const sorted = Uint16Array.from(column.words).sort();
  return valueAt({ ...column, words: sorted }, Math.round(share * (sorted.length - 1)));
}

const tops = new WeakMap();
function topOf(column) {
  if (!tops.has(column.words)) tops.set(column.words, quantile(column, 0.99));
  return tops.get(column.words);
}

// What the ends can reach: from the smallest value to the largest that is not a single point's.
function scaleReach() {
  const columns = shownColumns();
  const low = colourings()[view.colour].low ?? Math.min(...columns.map((column) => column.low));
  const high = view.colour === "error" ? Math.min(3 * defaultTop(), 1.2 * Math.max(defaultTop(), ...columns.map(topOf))) : Math.max(...columns.map((column) => column.low + column.span));
  return [low, high > low ? high : low + 1];
}

function defaultTop() {
  return view.model.scales?.[String(+view.reduction.toPrecision(6))] ?? 1;
}

function scaleEnds() {
  if (view.ends) return view.ends;
  const columns = shownColumns();
  if (!columns.length) return [0, 1];
  if (view.colour === "error") return [0, defaultTop()];
  const low = Math.min(...columns.map((column) => column.low));
  return [low, view.colour === "curvature" ? Math.max(...columns.map((column) => quantile(column, 0.95))) : Math.max(...columns.map((column) => column.low + column.span))];
}

// Round numbers, about five of them, from low to high.
function ticks(low, high) {
  const rough = (high - low) / 5, power = 10 ** Math.floor(Math.log10(rough));
  const step = power * [1, 2, 5, 10].find((digit) => digit * power >= rough);
  const first = Math.ceil(low / step);
  return Array.from({ length: Math.floor(high / step + 1e-9) - first + 1 }, (_, i) => +((first + i) * step).toPrecision(6));
}

function histogram(column, low, high) {
  const bins = new Float64Array(BINS);
  for (const word of column.words) {
    const bin = Math.floor((BINS * (column.low + (column.span * word) / 65535 - low)) / (high - low));
    bins[Math.min(BINS - 1, Math.max(0, bin))]++;
  }
  return bins;
}

function drawScale() {
  const colouring = colourings()[view.colour], columns = isScalar() ? shownColumns() : [];
  byId("scale").hidden = !columns.length;
  drawKeys(colouring);
  if (!columns.length) return;
  const [low, high] = scaleReach();
  drawHistogram(columns, low, high);
  byId("scale-ticks").replaceChildren(...ticks(low, high).map((tick) => {
    const mark = element("span", { textContent: String(tick) });
    mark.style.left = `${(100 * (tick - low)) / (high - low)}%`;
    return mark;
  }));
  for (const [id, i] of [["scale-low", 0], ["scale-high", 1]]) {
    Object.assign(byId(id), { min: low, max: high, step: (high - low) / 500 });
    byId(id).value = scaleEnds()[i];
  }
  paintScale();
}

// The bar between the two ends, and what they say.
function paintScale() {
  const [low, high] = scaleReach(), [first, last] = scaleEnds(), colouring = colourings()[view.colour];
  const share = (value) => `${(100 * (value - low)) / (high - low)}%`;
  const colours = page.palettes[view.colour === "curvature" ? "cividis" : "viridis"].filter((_, i) => i % 15 === 0).map((c) => `rgb(${c})`);
  byId("scale-bar").style.background = `linear-gradient(90deg, ${colours.map((c, i) => `${c} calc(${share(first)} + (${share(last)} - ${share(first)}) * ${i / (colours.length - 1)})`).join(", ")})`;
  byId("scale-text").textContent = `${colouring.title}${colouring.unit ? ` [${colouring.unit}]` : ""}: colors from ${short(first)} to ${short(last)}`;
}

// Square roots of the counts, so that a few far points are seen.
function drawHistogram(columns, low, high) {
  const counts = columns.map((column) => histogram(column, low, high)), most = Math.max(...counts.flatMap((c) => [...c])) || 1;
  const paths = counts.map((bins, i) => {
    const path = document.createElementNS("http://www.w3.org/2000/svg", "path");
    path.setAttribute("d", `M0,40 ${[...bins].map((n, k) => `L${k},${40 - 38 * Math.sqrt(n / most)} L${k + 1},${40 - 38 * Math.sqrt(n / most)}`).join(" ")} L${BINS},40`);
    path.style.stroke = colourOf(page.methods[columns[i].method] ?? { color: "#888888", dark: "#999999" });
    return path;
  });
  byId("scale-histogram").replaceChildren(...paths);
  byId("scale-names").replaceChildren(...columns.filter(({ method }) => method).map(({ method }) => legendKey(method, colourOf(page.methods[method]))));
}

// Swatches of a colouring that has names.
function drawKeys(colouring) {
  const features = results().some((result) => result.features);
  const named = view.colour === "marks" ? Object.entries(MARKS).filter(([name]) => name !== "feature" || features) : [];
  const clusters = view.colour === "labels" ? page.palettes.clusters.map((colour, i) => [`${i}, ${i + 10}, …`, colour]) : [];
  byId("scale-keys").replaceChildren(...[...named, ...clusters].map(([name, colour]) => legendKey(name, `rgb(${colour})`)));
  if (colouring.kind === "category" && clusters.length) byId("scale-keys").prepend("clusters: ");
}

function legendKey(name, colour) {
  const dot = element("i", { className: "key" });
  dot.style.background = colour;
  return element("span", {}, dot, name);
}

function startScale() {
  for (const id of ["scale-low", "scale-high"]) {
    byId(id).addEventListener("input", () => {
      const [low, high] = [Number(byId("scale-low").value), Number(byId("scale-high").value)];
      view.ends = id === "scale-low" ? [low, Math.max(low, high)] : [Math.min(low, high), high];
      paintScale();
      keepState();
      requestDraw();
    });
  }
  byId("scale-reset").addEventListener("click", () => { view.ends = null; showViews(); });
}
