"use strict";
// The 3D views: the original and chosen results of one model, turned together, coloured on one scale.

const MOST_VIEWS = 6;
const MARKS = { removed: [196, 201, 208], kept: [0, 114, 178], feature: [213, 94, 0] };
const view = {
  models: [], model: null, reduction: null, colour: "error", keptOnly: false, methods: [], size: 1, layout: "side", swipe: 0.5, ends: null,
  full: null, picked: null, blink: 0, most: Infinity, coarse: 1,
};

function byId(id) {
  return document.getElementById(id);
}

function results(model = view.model) {
  return (model.results ?? []).filter((result) => result.reduction === view.reduction);
}

function shownEntries() {
  const chosen = view.methods.map((method) => results().find((result) => result.method === method)).filter(Boolean);
  return view.layout === "side" || chosen.length < 1 ? [null, ...chosen] : [chosen[0] ?? null, chosen[1] ?? null];
}

// --- colourings -----------------------------------------------------------------------------------------

// What a model and its results can be coloured by: key -> {title, unit, kind}.
function colourings() {
  const entries = [view.model, ...results()];
  const found = view.model.results ? { error: { title: "plane error", unit: "% of diagonal", kind: "scalar", low: 0 } } : {};
  if (view.model.colors) found.rgb = { title: "its own colors", kind: "rgb" };
  found.shape = { title: "shape", kind: "plain" };
  found.height = { title: "height", unit: "model units", kind: "scalar" };
  if (view.model.results) found.marks = { title: "kept and removed", kind: "category" };
  if (entries.some((entry) => entry.labels)) found.labels = { title: "cluster", kind: "category" };
  for (const entry of entries) {
    for (const name of Object.keys(entry.columns ?? {})) found[name] ??= { title: name, unit: name === "curvature" ? "1 / model unit" : "", kind: "scalar" };
  }
  return found;
}

// Height as a column: 16-bit steps along the axis that points up.
const heights = new WeakMap();
function heightColumn(points) {
  const axis = view.model.up === "z" ? 2 : 1;
  if (!heights.has(points)) heights.set(points, Uint16Array.from({ length: points.length / 3 }, (_, i) => points[3 * i + axis]));
  return { low: view.model.low[axis], span: view.model.span[axis], words: heights.get(points) };
}

function columnOf(data, all, key) {
  return key === "height" ? heightColumn(all.points) : data.columns[key];
}

// 0 removed, 1 kept, 2 kept as a feature point.
const marks = new WeakMap();
function markColumn(data, n) {
  if (!marks.has(data)) {
    const words = new Uint16Array(n);
    for (const row of data.kept ? data.rows : []) words[row] = 1 + (data.features ? data.features[row] : 0);
    marks.set(data, words);
  }
  return marks.get(data);
}

// The layers of one view, each a set of points and how it is coloured.
function layersOf(entry) {
  const all = decoded.get(view.model), data = entry ? decoded.get(entry) : all;
  const layer = { ...paintOf(entry, data, all), points: all.points };
  const own = entry && data.points;
  if (!entry || !(view.keptOnly || (own && view.colour === "marks"))) return [layer];
  if (!own) return [{ ...layer, rows: data.rows, grow: 1.5 }];
  const values = layer.values && gathered(layer.values, data.rows);
  const moved = { ...layer, points: data.points, values, grow: 1.5, ...(view.colour === "marks" ? { kind: "plain", plain: MARKS.kept } : {}) };
  return view.keptOnly ? [moved] : [layer, moved];
}

const gathers = new WeakMap();
function gathered(values, rows) {
  if (!gathers.has(rows)) gathers.set(rows, new Map());
  const known = gathers.get(rows);
  if (!known.has(values)) known.set(values, gather(values, rows));
  return known.get(values);
}

function paintOf(entry, data, all) {
  const found = colourings()[view.colour];
  if (view.colour === "rgb") return { kind: "rgb", rgb: all.colors };
  if (view.colour === "marks" && entry) return { kind: "category", values: markColumn(data, view.model.shown), colours: Object.values(MARKS) };
  if (view.colour === "labels" && data.labels) return { kind: "category", values: data.labels, colours: page.palettes.clusters };
  const column = found.kind === "scalar" && columnOf(data, all, view.colour);
  if (!column) return { kind: "plain" };
  const colours = page.palettes[view.colour === "curvature" ? "cividis" : "viridis"];
  return { kind: "scalar", values: column.words, low: column.low, span: column.span, ends: scaleEnds(), colours };
}

// --- panels ---------------------------------------------------------------------------------------------

function captionOf(entry) {
  if (!entry) return [view.model.results ? "Original" : view.model.name, `${view.model.total.toLocaleString("en")} points`];
  const parts = [`${entry.count.toLocaleString("en")} points`];
  if (view.colour === "error") parts.push(`mean ${short(entry.mean)}, 95 % ${short(entry.p95)}, max ${short(entry.max)} %`);
  return [entry.method, parts.join(" · ")];
}

function short(value) {
  return Number.isFinite(value) ? String(+value.toPrecision(3)) : "n/a";
}

function element(name, properties = {}, ...children) {
  const made = Object.assign(document.createElement(name), properties);
  made.append(...children);
  return made;
}

function makePanel() {
  const canvas = element("canvas", { tabIndex: 0 });
  canvas.setAttribute("role", "img");
  const fill = element("button", { type: "button", className: "fill", textContent: "⤢" });
  const panel = element("figure", { className: "view" }, element("figcaption"), canvas, fill, element("div", { className: "readout" }));
  fill.addEventListener("click", () => fillWindow(view.full === null ? panels().indexOf(panel) : null));
  watchPointers(canvas, () => view.model, () => { moving(); keepState(); }, (x, y) => pick(canvas, x, y));
  byId("view-grid").append(panel);
  return panel;
}

function panels() {
  return [...document.querySelectorAll("#view-grid .view")];
}

// As many panels as are wanted, each with what it shows; then draw them.
let turn = 0;
async function showViews() {
  if (!view.model || !gl) return;
  const mine = ++turn;
  const wanted = view.model.results ? shownEntries() : [null];
  await load(view.model, view.model);
  if (!view.fitted) fit();
  view.fitted = true;
  for (const entry of wanted) if (entry) await load(entry, view.model);
  if (mine !== turn) return;
  const single = view.layout !== "side" && view.model.results;
  const n = single ? 1 : wanted.length;
  while (panels().length > n) panels().at(-1).remove();
  while (panels().length < n) makePanel();
  panels().forEach((panel, i) => dressPanel(panel, single ? wanted : [wanted[i]]));
  drawChips();
  drawScale();
  watchBlink();
  keepState();
  requestDraw();
}

function dressPanel(panel, entries) {
  panel.entries = entries;
  const [title, detail] = entries.length > 1 ? [entries.map((e) => captionOf(e)[0]).join(view.layout === "swipe" ? " | " : " ⇄ "), ""] : captionOf(entries[0]);
  panel.querySelector("figcaption").replaceChildren(element("b", { textContent: title }), element("span", { textContent: detail }));
  panel.querySelector("canvas").setAttribute("aria-label", `${title}, ${detail} Arrow keys turn, plus and minus zoom, f fits.`);
  const filled = view.full !== null;
  panel.classList.toggle("full", panels()[view.full] === panel);
  panel.querySelector(".fill").setAttribute("aria-label", filled ? "Back to the page" : `Let ${title} fill the window`);
  panel.querySelector(".fill").textContent = filled ? "✕" : "⤢";
  readOut(panel);
}

function fillWindow(index) {
  view.full = index;
  document.documentElement.classList.toggle("filled", index !== null);
  for (const panel of panels()) dressPanel(panel, panel.entries);
  keepState();
  requestDraw();
}

// --- drawing --------------------------------------------------------------------------------------------

let asked = 0, rest = 0;
function requestDraw() {
  asked ||= requestAnimationFrame(() => { asked = 0; drawAll(); });
}

// While the camera moves, only as many points and pixels as keep up; all of them once it rests. The points are in random order.
function moving() {
  clearTimeout(rest);
  rest = setTimeout(() => { view.most = Infinity; requestDraw(); }, 250);
  if (view.most === Infinity) view.most = view.pace ?? 400_000;
  requestDraw();
}

function drawAll() {
  const began = performance.now(), still = view.most === Infinity, ground = rgbOf("--panel"), drawn = panels().filter((panel) => panel.entries && (view.full === null || panel.classList.contains("full")));
  for (const panel of drawn) drawPanel(panel, ground, still ? 1 : view.coarse);
  requestAnimationFrame(() => keepPace(performance.now() - began));
  byId("view-grid").dataset.drawn = drawn.length;
}

// Views that move have fewer points and pixels where a frame takes long, up to the next: graphics work on after our calls.
function keepPace(took) {
  if (took > 100) view.coarse = 0.6;
  if (view.most < Infinity) view.most = view.pace = Math.max(20_000, Math.min(4_000_000, view.most * (took > 70 ? 0.6 : took < 30 ? 1.3 : 1)));
}

function drawPanel(panel, ground, share) {
  const canvas = panel.querySelector("canvas"), ratio = share * Math.min(2, devicePixelRatio);
  const [width, height] = [canvas.clientWidth, canvas.clientHeight].map((side) => Math.max(1, Math.round(side * ratio)));
  if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
  const context = canvas.getContext("2d"), seen = project(view.model, width / height);
  const options = { size: pointSize(), ground, most: view.most };
  const [first, second] = view.layout === "blink" && view.blink ? panel.entries.toReversed() : panel.entries;
  paint(context, layersOf(first), seen, options);
  if (view.layout === "swipe" && panel.entries.length > 1) swipe(context, layersOf(second), seen, options);
  panel.seen = seen;
  if (view.picked !== null) drawPick(context, seen);
}

function swipe(context, layers, seen, options) {
  const { width, height } = context.canvas, at = Math.round(view.swipe * width);
  context.save();
  context.beginPath();
  context.rect(at, 0, width - at, height);
  context.clip();
  paint(context, layers, seen, options);
  context.restore();
  context.fillStyle = themeColour("--ink");
  context.fillRect(at - 1, 0, 2, height);
}

// Neighbouring points touch on a surface that fills the box.
function pointSize() {
  return (3.4 * view.size) / Math.sqrt(Math.max(200, view.model.shown));
}

function watchBlink() {
  clearInterval(view.timer);
  if (view.layout === "blink") view.timer = setInterval(() => { view.blink = 1 - view.blink; requestDraw(); }, 700);
}

// --- picking --------------------------------------------------------------------------------------------

function placeOf(row) {
  const { points } = decoded.get(view.model);
  return [0, 1, 2].map((axis) => points[3 * row + axis] / 65535);
}

// The nearest point to the eye among those under the pointer.
function pick(canvas, x, y) {
  const panel = canvas.parentNode, { turn } = panel.seen, { points } = decoded.get(view.model);
  const [width, height] = [canvas.clientWidth, canvas.clientHeight];
  const rows = view.keptOnly && panel.entries[0] ? decoded.get(panel.entries[0]).rows : null;
  let best = null, depth = Infinity;
  for (let i = 0; i < (rows ? rows.length : points.length / 3); i++) {
    const row = rows ? rows[i] : i;
    const [px, py, w] = screenPlace(turn, [points[3 * row] / 65535, points[3 * row + 1] / 65535, points[3 * row + 2] / 65535], width, height);
    if (w < depth && Math.hypot(px - x, py - y) < 6) [best, depth] = [row, w];
  }
  view.picked = best;
  for (const other of panels()) readOut(other);
  keepState();
  requestDraw();
}

function drawPick(context, { turn }) {
  const { width, height } = context.canvas, [x, y] = screenPlace(turn, placeOf(view.picked), width, height);
  for (const [colour, line] of [["#fff", 5], ["#d00", 2.5]]) {
    context.strokeStyle = colour;
    context.lineWidth = line;
    context.beginPath();
    context.arc(x, y, 9, 0, 2 * Math.PI);
    context.stroke();
  }
}

// Below every view: what it says about the picked point.
function readOut(panel) {
  const text = view.picked === null || !panel.entries ? "" : panel.entries.map((entry) => describe(entry, view.picked)).join(" ⇄ ");
  panel.querySelector(".readout").textContent = text;
}

function describe(entry, row) {
  const all = decoded.get(view.model), data = entry ? decoded.get(entry) : all;
  const parts = Object.entries(data.columns).map(([name, column]) => `${name === "error" ? "plane error" : name} ${+valueAt(column, row).toPrecision(4)}${name === "error" ? " %" : ""}`);
  if (!entry) parts.unshift(`point ${placeOf(row).map((p, i) => +(view.model.low[i] + view.model.span[i] * p).toPrecision(7)).join(", ")}`);
  if (data.kept) parts.push(data.kept[row] ? "kept" : "removed");
  if (data.labels) parts.push(`cluster ${data.labels[row]}`);
  if (data.features && data.features[row]) parts.push("feature");
  return parts.join(" · ");
}

// --- controls -------------------------------------------------------------------------------------------

function fillSelect(id, options, value) {
  byId(id).replaceChildren(...options.map(([key, text]) => new Option(text, key, false, key === value)));
}

function chooseModel(index) {
  view.model = view.models[index] ?? view.models[0];
  const reductions = [...new Set((view.model.results ?? []).map((result) => result.reduction))].sort((a, b) => a - b);
  if (!reductions.includes(view.reduction)) view.reduction = reductions.at(-1) ?? null;
  fillSelect("view-reduction", reductions.map((r) => [String(r), percentText(r)]), String(view.reduction));
  const options = Object.entries(colourings());
  if (!(view.colour in colourings())) view.colour = options[0][0];
  fillSelect("view-colour", options.map(([key, { title }]) => [key, title]), view.colour);
  const known = new Set(results().map((result) => result.method));
  view.methods = view.methods.filter((method) => known.has(method));
  if (!view.methods.length) view.methods = (view.model.defaults ?? []).filter((method) => known.has(method));
  showNote();
}

function showNote() {
  const { shown, total } = view.model;
  const thinned = shown < total ? `${shown.toLocaleString("en")} of its ${total.toLocaleString("en")} points are shown, drawn at random; every number is computed from all. ` : "";
  byId("view-note").textContent = `${thinned}Drag turns${view.model.results ? " all views" : ""}, the wheel or two fingers zoom, Shift or the right button shifts; a click on a point reads its values.`;
}

function percentText(share) {
  return `${+(100 * share).toPrecision(6)} %`;
}

// One button for each result, by family; the reference is marked.
function drawChips() {
  const families = Object.groupBy(results(), ({ method }) => page.methods[method]?.family || "other");
  const chips = Object.entries(families).flatMap(([family, group]) => [
    element("span", { className: "family", textContent: family }),
    ...group.map(({ method }) => {
      const button = element("button", { type: "button", textContent: method + (method === page.reference ? " (reference)" : "") });
      button.setAttribute("aria-pressed", view.methods.includes(method));
      button.addEventListener("click", () => toggleView(method));
      return button;
    }),
  ]);
  const focused = [...byId("view-methods").children].indexOf(document.activeElement);
  byId("view-methods").replaceChildren(...chips);
  if (focused >= 0) byId("view-methods").children[focused]?.focus();
}

// A view too many takes the place of the one chosen first.
function toggleView(method) {
  const others = view.methods.filter((name) => name !== method);
  view.methods = others.length < view.methods.length ? others : [...others, method].slice(1 - MOST_VIEWS);
  showViews();
}

// A row of the table: its model, reduction and method.
function openView(name, reduction, method) {
  const index = view.models.findIndex((model) => model.name === name);
  if (index < 0) return;
  if (view.models[index] !== view.model) Object.assign(view, { ends: null, picked: null, fitted: false });
  view.reduction = reduction;
  if (!view.methods.includes(method)) view.methods = [...view.methods, method].slice(1 - MOST_VIEWS);
  byId("view-model").value = String(index);
  chooseModel(index);
  showViews();
  byId("views").scrollIntoView({ behavior: "smooth" });
}

function onChoice(id, act) {
  byId(id).addEventListener("input", (event) => {
    act(event.target.value);
    showViews();
  });
}

function startControls() {
  onChoice("view-model", (value) => { Object.assign(view, { ends: null, picked: null, fitted: false }); chooseModel(Number(value)); });
  onChoice("view-reduction", (value) => { Object.assign(view, { reduction: Number(value), ends: null }); chooseModel(view.models.indexOf(view.model)); });
  onChoice("view-colour", (value) => Object.assign(view, { colour: value, ends: null }));
  onChoice("view-points", (value) => (view.keptOnly = value === "kept"));
  onChoice("view-layout", (value) => { view.layout = value; byId("view-swipe").parentNode.hidden = value !== "swipe"; });
  byId("view-size").addEventListener("input", (event) => { view.size = Number(event.target.value); keepState(); requestDraw(); });
  byId("view-swipe").addEventListener("input", (event) => { view.swipe = Number(event.target.value); keepState(); requestDraw(); });
  byId("view-fit").addEventListener("click", () => { fit(); keepState(); requestDraw(); });
  addEventListener("keydown", (event) => event.key === "Escape" && view.full !== null && fillWindow(null));
  addEventListener("resize", requestDraw);
}

async function startViews() {
  view.models = readData("view-data");
  if (!view.models.length) return;
  fillSelect("view-model", view.models.map((model, i) => [String(i), model.name]), "0");
  const able = startGL();
  byId("view-still").hidden = able;
  byId("view-live").hidden = !able;
  if (!able) return;
  readState();
  for (const item of document.querySelectorAll(".of-results")) item.hidden = !view.model.results;
  startControls();
  startScale();
  await showViews();
}
