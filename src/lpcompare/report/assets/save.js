"use strict";
// Files made from the page: pictures of the views, the table, a reduced cloud, a reference.

function saveBlob(name, blob) {
  const link = element("a", { href: URL.createObjectURL(blob), download: name.replace(/[^\w.=-]+/g, "-") });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}

function saveText(name, text) {
  saveBlob(name, new Blob([text], { type: "text/plain" }));
}

// The views side by side, with their captions.
function savePicture() {
  const canvases = panels().map((panel) => panel.querySelector("canvas")).filter((canvas) => canvas.offsetParent);
  const whole = element("canvas", { width: canvases.reduce((sum, canvas) => sum + canvas.width, 0), height: canvases[0].height + 40 });
  const context = whole.getContext("2d");
  Object.assign(context, { fillStyle: themeColour("--ground"), font: "22px sans-serif", textBaseline: "middle" });
  context.fillRect(0, 0, whole.width, whole.height);
  context.fillStyle = themeColour("--ink");
  let x = 0;
  for (const canvas of canvases) {
    context.drawImage(canvas, x, 40);
    context.fillText(canvas.parentNode.querySelector("figcaption").textContent, x + 10, 20, canvas.width - 20);
    x += canvas.width;
  }
  whole.toBlob((blob) => saveBlob(`${view.model.name}.png`, blob));
}

// Every shown result as PLY, its coordinates as the page holds them.
function saveClouds() {
  const entries = shownEntries().filter(Boolean);
  for (const entry of entries.length ? entries : [null]) {
    const name = entry ? `${view.model.name}-${entry.method}-${+(100 * entry.reduction).toPrecision(6)}` : view.model.name;
    saveBlob(`${name}.ply`, new Blob([plyOf(entry)], { type: "application/octet-stream" }));
  }
}

function plyOf(entry) {
  const all = decoded.get(view.model), data = entry ? decoded.get(entry) : all;
  const points = data.points ?? all.points, rows = entry && !data.points ? data.rows : null;
  const n = rows ? rows.length : points.length / 3, { low, span } = view.model;
  const head = `ply\nformat binary_little_endian 1.0\ncomment coordinates rounded to 1/65535 of the box, as on the page\nelement vertex ${n}\nproperty double x\nproperty double y\nproperty double z\nend_header\n`;
  const places = new Float64Array(3 * n);
  for (let i = 0; i < n; i++) for (let k = 0; k < 3; k++) places[3 * i + k] = low[k] + (span[k] * points[3 * (rows ? rows[i] : i) + k]) / 65535;
  const text = new TextEncoder().encode(head), bytes = new Uint8Array(text.length + places.byteLength);
  bytes.set(text);
  bytes.set(new Uint8Array(places.buffer), text.length);
  return bytes;
}
