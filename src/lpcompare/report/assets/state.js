"use strict";
// What is shown, in the address: a link shows the same. Only what differs from the start is written.

let started = false;

function keepState() {
  if (!started) return;
  const words = new URLSearchParams();
  const put = (key, value, usual) => value !== null && value !== undefined && value !== "" && String(value) !== String(usual) && words.set(key, value);
  if (view.model) {
    put("model", view.model.name, view.models[0].name);
    put("removed", view.reduction);
    put("views", view.methods.join(","));
    put("colour", view.colour, Object.keys(colourings())[0]);
    put("points", view.keptOnly ? "kept" : "all", "all");
    put("layout", view.layout, "side");
    put("swipe", view.swipe, 0.5);
    put("size", view.size, 1);
    put("ends", view.ends?.map((end) => +end.toPrecision(5)).join(","));
    put("picked", view.picked);
    put("full", view.full);
    put("camera", [camera.yaw, camera.pitch, camera.distance, ...camera.target].map((c) => +c.toFixed(4)).join(","), "");
  }
  for (const id of ["filter", "filter-reduction", "chart-model", "chart-measure", "chart-reference"]) {
    const field = byId(id);
    if (field) put(id, field.value, field.dataset.usual ?? "");
  }
  const sorted = document.querySelector("#table th[aria-sort]");
  if (sorted) put("sort", `${sorted.dataset.key} ${sorted.ariaSort}`, "");
  put("columns", byId("all-columns")?.checked ? "all" : "");
  const text = words.toString();
  history.replaceState(null, "", text ? `#${text}` : location.href.split("#")[0]);
}

function readState() {
  const words = new URLSearchParams(location.hash.slice(1)), numbers = (key) => words.get(key).split(",").map(Number);
  const index = Math.max(0, view.models.findIndex((model) => model.name === words.get("model")));
  if (words.has("removed")) view.reduction = Number(words.get("removed"));
  if (words.has("views")) view.methods = words.get("views").split(",").filter(Boolean);
  Object.assign(view, { colour: words.get("colour") ?? view.colour, keptOnly: words.get("points") === "kept" });
  if (["swipe", "blink"].includes(words.get("layout"))) view.layout = words.get("layout");
  for (const key of ["swipe", "size"]) if (words.has(key) && Number.isFinite(Number(words.get(key)))) view[key] = Number(words.get(key));
  if (words.has("ends") && numbers("ends").every(Number.isFinite)) view.ends = numbers("ends");
  byId("view-model").value = String(index);
  chooseModel(index);
  for (const key of ["picked", "full"]) {
    const limit = key === "picked" ? view.model.shown : MOST_VIEWS;
    if (words.has(key) && Number(words.get(key)) < limit) view[key] = Number(words.get(key));
  }
  if (words.has("camera") && numbers("camera").length === 6 && numbers("camera").every(Number.isFinite)) {
    const [yaw, pitch, distance, ...target] = numbers("camera");
    Object.assign(camera, { yaw, pitch, distance: Math.max(0.02, distance), target });
    view.fitted = true;
  }
  byId("view-points").value = view.keptOnly ? "kept" : "all";
  Object.assign(byId("view-layout"), { value: view.layout });
  byId("view-swipe").parentNode.hidden = view.layout !== "swipe";
  byId("view-size").value = view.size;
  byId("view-swipe").value = view.swipe;
  document.documentElement.classList.toggle("filled", view.full !== null);
}

// What of the address belongs to the table and the charts.
function readFields() {
  const words = new URLSearchParams(location.hash.slice(1));
  for (const id of ["filter", "filter-reduction", "chart-model", "chart-measure", "chart-reference"]) {
    if (!byId(id)) continue;
    byId(id).dataset.usual = byId(id).value;
    if (words.has(id)) byId(id).value = words.get(id);
  }
  if (!byId("table")) return;
  byId("all-columns").checked = words.get("columns") === "all";
  const [key, order] = (words.get("sort") ?? "").split(" ");
  const heading = [...byId("table").tHead.rows[0].cells].find((cell) => cell.dataset.key === key);
  if (heading) sortTable(byId("table"), heading, order);
}
