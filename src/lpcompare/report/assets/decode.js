"use strict";
// Base64 from the page back to arrays; the counterpart of lpcompare/report/packing.py.

function decodeBytes(text) {
  const letters = atob(text);
  const bytes = new Uint8Array(letters.length);
  for (let i = 0; i < bytes.length; i++) bytes[i] = letters.charCodeAt(i);
  return bytes;
}

function decodeWords(text) {
  return new Uint16Array(decodeBytes(text).buffer);
}

// 16-bit steps between low and low + span.
function decodeScalar({ low, span, steps }) {
  return Float32Array.from(decodeWords(steps), (step) => low + (span * step) / 65535);
}

// One bit per point, least significant first.
function decodeBits(text, n) {
  const bytes = decodeBytes(text);
  return Uint8Array.from({ length: n }, (_, i) => (bytes[i >> 3] >> (i & 7)) & 1);
}

// Coordinates from the low corner of the bounding box, so that large offsets cost no digits.
function decodePoints(text, span) {
  const steps = decodeWords(text);
  return [0, 1, 2].map((axis) => Float32Array.from({ length: steps.length / 3 }, (_, i) => (span[axis] * steps[3 * i + axis]) / 65535));
}

// Decode a result or a cloud when it is first shown, and remember it.
const decoded = new WeakMap();
function decode(entry, model) {
  if (!decoded.has(entry)) decoded.set(entry, decodeEntry(entry, model));
  return decoded.get(entry);
}

function decodeEntry(entry, model) {
  const found = {};
  if (entry.points) found.points = decodePoints(entry.points, model.span);
  if (entry.shade) found.shade = decodeBytes(entry.shade);
  if (entry.colors) found.colors = decodeBytes(entry.colors);
  if (entry.errors) found.errors = decodeScalar(entry.errors);
  if (entry.kept) found.kept = decodeBits(entry.kept, model.shown);
  if (entry.nearest) found.nearest = new Uint32Array(decodeBytes(entry.nearest).buffer);
  if (entry.labels) found.labels = decodeWords(entry.labels);
  if (entry.curvature) found.curvature = decodeScalar(entry.curvature);
  if (entry.features) found.features = decodeBits(entry.features, model.shown);
  return found;
}
