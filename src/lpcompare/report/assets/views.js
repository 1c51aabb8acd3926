"use strict";
// The 3D views: one plotly scene for the original and one for each chosen result, with linked cameras.

const MOST_VIEWS = 6; // browsers give a page only so many WebGL contexts
const CLUSTER_COLOURS = ["#0072b2", "#e69f00", "#009e73", "#cc79a7", "#56b4e9", "#d55e00", "#f0e442", "#882255", "#44aa99", "#999933"];
const MARK_COLOURS = { removed: "#b5bac1", kept: "#0072b2", feature: "#d55e00" };
const GREY_NOTE = "Grey: the method says nothing of it.";
const CAMERAS = {
  y: { up: { x: 0, y: 1, z: 0 }, eye: { x: 0.35, y: 0.35, z: 1.6 }, center: { x: 0, y: 0, z: 0 } },
  z: { up: { x: 0, y: 0, z: 1 }, eye: { x: 0.9, y: -1.2, z: 0.9 }, center: { x: 0, y: 0, z: 0 } },
};
let models = [];
const view = { model: null, reduction: null, colour: "errors", keptOnly: false, size: 2, methods: [], camera: null };

function results() {
  return (view.model.results ?? []).filter((result) => result.reduction === view.reduction);
}

// --- what a point looks like --------------------------------------------------------------------------

function stepped(colours) {
  return colours.flatMap((colour, i) => [[i / colours.length, colour], [(i + 1) / colours.length, colour]]);
}

function brightness() {
  return isDark() ? [[0, "#2b3138"], [1, "#f2f4f7"]] : [[0, "#39424e"], [1, "#d3d9e0"]];
}

// Colour numbers of the originals for the colouring chosen, and their scale; null where a result has none.
function colouring(result) {
  const data = decode(result ?? view.model, view.model);
  if (!result) return originalColouring(data);
  if (view.colour === "errors") {
    return { values: data.errors, colorscale: "Viridis", cmin: 0, cmax: view.model.scales[reductionKey()] || 1 };
  }
  if (view.colour === "marks" && !(data.kept || data.points)) return null;
  if (view.colour === "marks") return { values: marks(data), colorscale: stepped(Object.values(MARK_COLOURS)), cmin: 0, cmax: 3 };
  if (view.colour === "labels" && data.labels) {
    const n = CLUSTER_COLOURS.length;
    return { values: Float32Array.from(data.labels, (label) => (label % n) + 0.5), colorscale: stepped(CLUSTER_COLOURS), cmin: 0, cmax: n };
  }
  if (view.colour === "curvature" && data.curvature) {
    return { values: data.curvature, colorscale: "Cividis", cmin: 0, cmax: quantile(data.curvature, 0.95) };
  }
  return null;
}

function originalColouring(data) {
  const attribute = view.model.attributes?.[view.colour];
  if (attribute) return { values: decodeScalar(attribute), colorscale: "Viridis", cmin: attribute.low, cmax: attribute.low + attribute.span };
  if (view.colour === "colors" && data.colors) return { css: rgbTexts(data.colors) };
  return { values: data.shade, colorscale: brightness(), cmin: 0, cmax: 255 };
}

function rgbTexts(bytes) {
  return Array.from({ length: bytes.length / 3 }, (_, i) => `rgb(${bytes[3 * i]},${bytes[3 * i + 1]},${bytes[3 * i + 2]})`);
}

// 0.5 removed, 1.5 kept, 2.5 kept as a feature point: the middles of three steps.
function marks(data) {
  if (!data.kept) return new Float32Array(view.model.shown).fill(0.5);
  return Float32Array.from(data.kept, (kept, i) => 0.5 + kept + (kept && data.features ? data.features[i] : 0));
}

function reductionKey() {
  return Number(view.reduction.toPrecision(6)).toString();
}

function quantile(values, share) {
  return Float32Array.from(values).sort()[Math.floor(share * (values.length - 1))];
}

// --- traces -------------------------------------------------------------------------------------------

function pointTrace([x, y, z], colours, size) {
  const marker = { symbol: "square", size, line: { width: 0 }, opacity: 1 };
  if (colours.css) marker.color = colours.css;
  else Object.assign(marker, { color: colours.values, colorscale: colours.colorscale, cmin: colours.cmin, cmax: colours.cmax });
  return { type: "scatter3d", mode: "markers", x, y, z, marker, hoverinfo: "none" };
}

// Which originals a view shows: the rows of the model, or null when it shows a result's own points.
function shownRows(result) {
  if (!result || !view.keptOnly) return null;
  const data = decode(result, view.model);
  return data.kept ? indicesOf(data.kept) : data.nearest;
}

function indicesOf(mask) {
  const rows = [];
  mask.forEach((bit, i) => bit && rows.push(i));
  return Uint32Array.from(rows);
}

function pick(array, rows) {
  return Float32Array.from(rows, (row) => array[row]);
}

function traces(result) {
  const all = decode(view.model, view.model).points;
  const colours = colouring(result) ?? colouring(null);
  const own = result && decode(result, view.model).points;
  const rows = shownRows(result);
  if (rows) {
    const places = own ?? all.map((axis) => pick(axis, rows));
    const values = own && view.colour === "marks" ? new Float32Array(rows.length).fill(1.5) : pick(colours.values, rows);
    return [pointTrace(places, { ...colours, values }, view.size + 0.5)];
  }
  const base = pointTrace(all, colours, view.size);
  if (!own || view.colour !== "marks") return [base];
  return [base, pointTrace(own, { ...colours, values: new Float32Array(own[0].length).fill(1.5) }, view.size + 0.5)];
}

// --- scenes -------------------------------------------------------------------------------------------

// Each part of an axis off: of an axis that is not visible, plotly still turns the letters into triangles.
const NO_AXIS = {
  title: { text: "" }, tickmode: "array", tickvals: [],
  showgrid: false, showline: false, zeroline: false, showbackground: false, showspikes: false,
};

function sceneLayout() {
  const { span, up } = view.model;
  const longest = Math.max(...span) || 1;
  const axis = (i) => ({ ...NO_AXIS, range: span[i] > 0 ? [0, span[i]] : [-longest / 2, longest / 2] });
  const ratio = (i) => Math.max(span[i] / longest, 1e-3);
  return {
    margin: { l: 0, r: 0, t: 0, b: 0 }, showlegend: false, paper_bgcolor: "rgba(0,0,0,0)", uirevision: "kept",
    scene: {
      xaxis: axis(0), yaxis: axis(1), zaxis: axis(2), dragmode: "orbit", bgcolor: themeColour("--panel"),
      aspectmode: "manual", aspectratio: { x: ratio(0), y: ratio(1), z: ratio(2) }, camera: view.camera ?? CAMERAS[up],
    },
  };
}

function caption(result) {
  if (!result) return [view.model.results ? "Original" : view.model.name, `${view.model.total.toLocaleString("en")} points`];
  const mean = Number.isFinite(result.mean) ? `, error ${(+result.mean.toPrecision(3)).toString()} %` : "";
  return [result.method, `${result.count.toLocaleString("en")} points${mean}`];
}

function makePanel(result) {
  const panel = document.createElement("figure");
  panel.className = "view";
  const [title, detail] = caption(result);
  const heading = document.createElement("figcaption");
  const extra = document.createElement("span");
  extra.textContent = detail;
  heading.append(title, extra);
  const scene = Object.assign(document.createElement("div"), { className: "scene", result });
  const readout = Object.assign(document.createElement("div"), { className: "readout" });
  panel.append(heading, scene, readout);
  document.getElementById("view-grid").append(panel);
  return scene;
}

async function drawScene(scene) {
  const config = { displayModeBar: false, responsive: true, scrollZoom: true, plotGlPixelRatio: devicePixelRatio };
  await Plotly.react(scene, traces(scene.result), sceneLayout(), config);
  if (scene.linked) return;
  scene.linked = true;
  scene.on("plotly_relayouting", (change) => follow(scene, change));
  scene.on("plotly_relayout", (change) => follow(scene, change));
  scene.on("plotly_hover", (event) => readOut(scene, event.points[0]));
}

function scenes() {
  return [...document.querySelectorAll("#view-grid .scene")];
}

// The other cameras go where this one goes. What they report while being moved is not passed on.
let leader = null;
async function follow(scene, change) {
  const camera = change["scene.camera"];
  if (!camera || (leader && leader !== scene)) return;
  leader = scene;
  view.camera = camera;
  await Promise.all(scenes().filter((other) => other !== scene && other.linked).map((other) => Plotly.relayout(other, { "scene.camera": camera })));
  leader = null;
}

// Below every view: what it says about the point under the pointer.
function readOut(source, hit) {
  const rows = shownRows(source.result);
  const row = rows ? rows[hit.pointNumber] : hit.curveNumber === 0 ? hit.pointNumber : null;
  if (row === null || row === undefined) return;
  const place = [hit.x, hit.y, hit.z].map((value, i) => +(value + view.model.low[i]).toPrecision(7));
  for (const scene of scenes()) {
    scene.nextElementSibling.textContent = scene.result ? describe(scene.result, row) : `Point at ${place.join(", ")}${attributesOf(row)}`;
  }
}

function describe(result, row) {
  const data = decode(result, view.model);
  const parts = [`error ${(+data.errors[row].toPrecision(3)).toString()} %`];
  if (data.kept) parts.push(data.kept[row] ? "kept" : "removed");
  if (data.labels) parts.push(`cluster ${data.labels[row]}`);
  if (data.curvature) parts.push(`curvature ${data.curvature[row].toPrecision(3)}`);
  if (data.features && data.features[row]) parts.push("feature");
  return parts.join(" · ");
}

function attributesOf(row) {
  return Object.entries(view.model.attributes ?? {}).map(([name, values]) => ` · ${name} ${decodeScalar(values)[row].toPrecision(4)}`).join("");
}

// WebGL does not reach paper: in its place a picture of what each scene shows.
function showStills(wanted) {
  for (const still of document.querySelectorAll("#view-grid .still")) still.remove();
  if (!wanted) return;
  for (const scene of scenes().filter((drawn) => drawn.linked)) {
    scene._fullLayout.scene._scene.glplot.redraw();
    const source = scene.querySelector("canvas");
    const still = Object.assign(document.createElement("canvas"), { className: "still", width: source.width, height: source.height });
    still.getContext("2d").drawImage(source, 0, 0);
    scene.after(still);
  }
}

// --- controls -----------------------------------------------------------------------------------------

function fillSelect(id, options, value) {
  const select = document.getElementById(id);
  select.replaceChildren(...options.map(([key, text]) => new Option(text, key, false, key === value)));
}

function has(name) {
  return (view.model.results ?? []).some((result) => result[name]);
}

function colourOptions() {
  if (!view.model.results) {
    const own = view.model.colors ? [["colors", "its own colours"]] : [];
    return [...own, ["shade", "shape"], ...Object.keys(view.model.attributes ?? {}).map((name) => [name, name])];
  }
  const options = [["errors", "error (eq. 27)"], ["marks", has("features") ? "feature, kept, removed" : "kept, removed"]];
  if (has("labels")) options.push(["labels", "cluster"]);
  if (has("curvature")) options.push(["curvature", "curvature"]);
  return options;
}

// The lowest and the highest error: what there is to see.
function defaultMethods() {
  const ordered = results().filter((r) => Number.isFinite(r.mean)).sort((a, b) => a.mean - b.mean);
  return [...new Set([ordered[0], ordered.at(-1)].filter(Boolean).map((result) => result.method))];
}

// Large enough that neighbouring points touch on a surface that fills the view.
function pointSize() {
  const size = 2 * Math.sqrt(30000 / view.model.shown);
  return Math.min(8, Math.max(1, Math.round(2 * size) / 2));
}

function chooseModel(index) {
  view.model = models[index];
  view.camera = null;
  const reductions = [...new Set((view.model.results ?? []).map((result) => result.reduction))].sort();
  if (!reductions.includes(view.reduction)) view.reduction = reductions.at(-1) ?? null;
  fillSelect("view-reduction", reductions.map((r) => [String(r), `${+(100 * r).toPrecision(6)} %`]), String(view.reduction));
  view.size = pointSize();
  document.getElementById("view-size").value = view.size;
  const options = colourOptions();
  if (!options.some(([key]) => key === view.colour)) view.colour = options[0][0];
  fillSelect("view-colour", options, view.colour);
  const known = new Set(results().map((result) => result.method));
  view.methods = view.methods.filter((method) => known.has(method));
  if (!view.methods.length) view.methods = defaultMethods();
  showNote();
}

function showNote() {
  const { shown, total } = view.model;
  const thinned = shown < total ? `${shown.toLocaleString("en")} of its ${total.toLocaleString("en")} points are shown, drawn at random; every number is computed from all. ` : "";
  const linked = view.model.results ? "Drag to turn: all views turn together. " : "Drag to turn. ";
  document.getElementById("view-note").textContent = `${thinned}${linked}Scroll or pinch to zoom; point at the cloud to read its values.`;
}

function drawChips() {
  const chips = results().map(({ method }) => {
    const button = document.createElement("button");
    button.type = "button";
    button.textContent = method;
    button.setAttribute("aria-pressed", view.methods.includes(method));
    button.addEventListener("click", () => toggleView(method));
    return button;
  });
  document.getElementById("view-methods").replaceChildren(...chips);
}

// A seventh view takes the place of the one chosen first.
function toggleView(method) {
  const others = view.methods.filter((name) => name !== method);
  view.methods = others.length < view.methods.length ? others : [...others, method].slice(1 - MOST_VIEWS);
  drawViews();
}

function drawLegend() {
  const legend = document.getElementById("view-legend");
  const cmax = view.model.scales?.[reductionKey()];
  legend.replaceChildren();
  if (view.colour === "errors" && cmax) {
    const bar = Object.assign(document.createElement("span"), { className: "bar" });
    const where = view.keptOnly ? " Only the points kept are shown: what was lost lies between them." : "";
    legend.append("0", bar, `${+cmax.toPrecision(2)} % of the diagonal and above: distance of each original point to the plane through its nearest kept points, one scale for all views.${where}`);
  } else if (view.colour === "marks") {
    for (const [name, colour] of Object.entries(MARK_COLOURS)) if (name !== "feature" || has("features")) legend.append(legendKey(name, colour));
  } else if (view.colour === "curvature") legend.append(`Absolute curvature: dark is flat, bright is curved; the scale ends at the 95th percentile. ${GREY_NOTE}`);
  else if (view.colour === "labels") legend.append(`The clusters of each method, ten colours in turn. ${GREY_NOTE}`);
}

function legendKey(name, colour) {
  const item = document.createElement("span");
  const dot = Object.assign(document.createElement("span"), { className: "key" });
  dot.style.background = colour;
  item.append(dot, name);
  return item;
}

// Until what was drawn is on the screen: a callback before the next frame, and a turn after it.
function nextFrame() {
  return new Promise((shown) => requestAnimationFrame(() => setTimeout(shown)));
}

// Draw what is chosen, each view on the screen before work on the next one begins; panels that are still wanted stay, so that their WebGL context is used again.
// A newer choice ends an older drawing.
let turn = 0;
async function drawViews() {
  if (!view.model) return;
  const mine = ++turn;
  drawChips();
  drawLegend();
  const wanted = [null, ...view.methods.map((method) => results().find((result) => result.method === method)).filter(Boolean)];
  for (const scene of scenes()) {
    if (!wanted.includes(scene.result)) {
      Plotly.purge(scene);
      scene.parentNode.remove();
    }
  }
  for (const result of wanted) {
    const scene = scenes().find((other) => other.result === result) ?? makePanel(result);
    await drawScene(scene);
    await nextFrame();
    if (mine !== turn) return;
  }
  document.getElementById("view-grid").dataset.drawn = wanted.length;
}

function resetCamera() {
  view.camera = null;
  const camera = CAMERAS[view.model.up];
  return Promise.all(scenes().map((scene) => Plotly.relayout(scene, { "scene.camera": camera })));
}

function onChoice(id, act) {
  document.getElementById(id).addEventListener("change", (event) => {
    act(event.target.value);
    drawViews();
  });
}

async function startViews() {
  models = JSON.parse(document.getElementById("view-data").textContent);
  if (!models.length) return;
  fillSelect("view-model", models.map((model, i) => [String(i), model.name]), "0");
  chooseModel(0);
  for (const item of document.querySelectorAll(".of-results")) item.hidden = !view.model.results;
  onChoice("view-model", (value) => {
    for (const scene of scenes()) { Plotly.purge(scene); scene.parentNode.remove(); }
    chooseModel(Number(value));
  });
  onChoice("view-reduction", (value) => {
    view.reduction = Number(value);
    if (!view.methods.some((method) => results().some((result) => result.method === method))) view.methods = defaultMethods();
  });
  onChoice("view-colour", (value) => (view.colour = value));
  onChoice("view-points", (value) => (view.keptOnly = value === "kept"));
  onChoice("view-size", (value) => (view.size = Number(value)));
  document.getElementById("view-reset").addEventListener("click", resetCamera);
  await drawViews();
}
