"use strict";
// The page's data: base64 text back to typed arrays, made when they are first needed.

function readData(id) {
  return JSON.parse(document.getElementById(id).textContent);
}

function decodeBytes(text) {
  const letters = atob(text);
  const bytes = new Uint8Array(letters.length);
  for (let i = 0; i < bytes.length; i++) bytes[i] = letters.charCodeAt(i);
  return bytes;
}

function decodeWords(text) {
  return new Uint16Array(decodeBytes(text).buffer);
}

// One bit per point, least significant first.
function decodeBits(text, n) {
  const bytes = decodeBytes(text);
  return Uint8Array.from({ length: n }, (_, i) => (bytes[i >> 3] >> (i & 7)) & 1);
}

function indicesOf(mask) {
  const rows = [];
  for (let i = 0; i < mask.length; i++) if (mask[i]) rows.push(i);
  return Uint32Array.from(rows);
}

function gather(array, rows) {
  const out = new array.constructor(rows.length);
  for (let i = 0; i < rows.length; i++) out[i] = array[rows[i]];
  return out;
}

// A value of a packed column: 16-bit steps from low to low + span.
function valueAt({ low, span, words }, row) {
  return low + (span * words[row]) / 65535;
}

// The arrays of a model or a result, decoded once. A served page asks for them first.
const decoded = new WeakMap();
async function load(entry, model) {
  if (entry.src && !entry.asked) entry.asked = fetch(entry.src).then((answer) => answer.json()).then((found) => Object.assign(entry, found));
  await entry.asked;
  if (!decoded.has(entry)) decoded.set(entry, decodeEntry(entry, model));
  return decoded.get(entry);
}

function decodeEntry(entry, model) {
  const found = { columns: {} };
  for (const [name, column] of Object.entries(entry.columns ?? {})) found.columns[name] = { low: column.low, span: column.span, words: decodeWords(column.steps) };
  if (entry.points) found.points = decodeWords(entry.points);
  if (entry.colors) found.colors = decodeBytes(entry.colors);
  if (entry.labels) found.labels = decodeWords(entry.labels);
  if (entry.features) found.features = decodeBits(entry.features, model.shown);
  if (entry.kept) found.rows = indicesOf((found.kept = decodeBits(entry.kept, model.shown)));
  if (entry.nearest) found.rows = new Uint32Array(decodeBytes(entry.nearest).buffer);
  return found;
}

async function unzip(text) {
  const stream = new Blob([decodeBytes(text)]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Response(stream).text();
}
