"use strict";
// The one camera of all views, in units of the box's diagonal around its middle, and what moves it.

const FIELD = Math.PI / 6;
let camera = { yaw: 0.35, pitch: 0.25, distance: 2, target: [0, 0, 0] };

function diagonal(model) {
  return Math.hypot(...model.span) || 1;
}

// Right, up and towards the eye, as unit vectors.
function axes(model) {
  const { yaw, pitch } = camera;
  const turn = (x, y, z) => (model.up === "z" ? [x, -z, y] : [x, y, z]);
  const back = turn(Math.sin(yaw) * Math.cos(pitch), Math.sin(pitch), Math.cos(yaw) * Math.cos(pitch));
  const right = turn(Math.cos(yaw), 0, -Math.sin(yaw));
  const up = turn(-Math.sin(yaw) * Math.sin(pitch), Math.cos(pitch), -Math.cos(yaw) * Math.sin(pitch));
  return { right, up, back };
}

function dot(a, b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

// The matrix from the box (0 to 1 along each side) to the screen, by columns, and the depths that it reaches.
function project(model, aspect) {
  const { right, up, back } = axes(model);
  const off = Math.hypot(...camera.target) + 0.55;
  const [near, far] = [Math.max(camera.distance - off, camera.distance / 100), camera.distance + off];
  const focus = Math.min(1, aspect) / Math.tan(FIELD / 2);
  const column = (vector, w) => {
    const z = dot(vector, back);
    const depth = (-(far + near) * z - w * 2 * far * near) / (far - near);
    return [(focus / aspect) * dot(vector, right), focus * dot(vector, up), depth, -z];
  };
  const sides = model.span.map((side) => side / diagonal(model));
  const corner = sides.map((side, i) => -side / 2 - camera.target[i] - camera.distance * back[i]);
  const columns = sides.map((side, i) => column([0, 1, 2].map((k) => (k === i ? side : 0)), 0));
  return { turn: new Float32Array([...columns.flat(), ...column(corner, 1)]), near, far };
}

// Where a place of the box lies in a view: pixels from the top left, and depth.
function screenPlace(turn, [x, y, z], width, height) {
  const at = (i) => turn[i] * x + turn[4 + i] * y + turn[8 + i] * z + turn[12 + i];
  const w = at(3);
  return [(0.5 + at(0) / w / 2) * width, (0.5 - at(1) / w / 2) * height, w];
}

function orbit(dx, dy) {
  camera.yaw -= dx;
  camera.pitch = Math.min(1.55, Math.max(-1.55, camera.pitch + dy));
}

// Shift what is looked at by parts of the view's height.
function pan(model, dx, dy) {
  const { right, up } = axes(model);
  const reach = 2 * Math.tan(FIELD / 2) * camera.distance;
  camera.target = camera.target.map((c, i) => c - reach * (dx * right[i] - dy * up[i]));
}

function zoom(factor) {
  camera.distance = Math.min(20, Math.max(0.02, camera.distance * factor));
}

// The whole cloud in sight: its farthest point from the middle of the box decides.
function fit(model = view.model) {
  Object.assign(camera, { distance: reachOf(model) / Math.sin(FIELD / 2), target: [0, 0, 0] });
}

const reaches = new WeakMap();
function reachOf(model) {
  const points = decoded.get(model)?.points, sides = model.span.map((side) => side / diagonal(model));
  if (!points) return 0.5;
  if (!reaches.has(model)) {
    let most = 0;
    for (let i = 0; i < points.length; i += 3) {
      most = Math.max(most, ((points[i] / 65535 - 0.5) * sides[0]) ** 2 + ((points[i + 1] / 65535 - 0.5) * sides[1]) ** 2 + ((points[i + 2] / 65535 - 0.5) * sides[2]) ** 2);
    }
    reaches.set(model, Math.sqrt(most) || 0.5);
  }
  return reaches.get(model);
}

const KEYS = {
  ArrowLeft: () => orbit(-0.1, 0), ArrowRight: () => orbit(0.1, 0), ArrowUp: () => orbit(0, 0.1), ArrowDown: () => orbit(0, -0.1),
  "+": () => zoom(0.85), "=": () => zoom(0.85), "-": () => zoom(1.18), f: () => fit(), 0: () => fit(),
};

// Mouse, pen, touch and wheel on one canvas; `moved` is told of every change, `clicked` where nothing moved.
function watchPointers(canvas, model, moved, clicked) {
  const touches = new Map();
  let travelled = 0;
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    touches.set(event.pointerId, [event.clientX, event.clientY]);
    if (touches.size === 1) travelled = 0;
  });
  canvas.addEventListener("pointermove", (event) => {
    const before = touches.get(event.pointerId);
    if (!before) return;
    const now = [event.clientX, event.clientY], height = canvas.clientHeight || 1;
    const [dx, dy] = [(now[0] - before[0]) / height, (now[1] - before[1]) / height];
    travelled += Math.hypot(dx, dy) * height;
    if (touches.size === 2) pinch(touches, event.pointerId, now, height, model());
    else if (event.shiftKey || event.buttons === 2 || event.buttons === 4) pan(model(), dx, dy);
    else orbit(3 * dx, 3 * dy);
    touches.set(event.pointerId, now);
    moved();
  });
  for (const end of ["pointerup", "pointercancel"]) {
    canvas.addEventListener(end, (event) => {
      if (touches.delete(event.pointerId) && end === "pointerup" && travelled < 4 && !touches.size) clicked(event.offsetX, event.offsetY);
    });
  }
  canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    zoom(Math.exp(event.deltaY * (event.deltaMode ? 0.03 : 0.001)));
    moved();
  }, { passive: false });
  canvas.addEventListener("keydown", (event) => {
    if (!(event.key in KEYS) || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    KEYS[event.key]();
    moved();
  });
}

// Two fingers: their distance zooms, their middle shifts.
function pinch(touches, id, now, height, model) {
  const [other] = [...touches.entries()].filter(([key]) => key !== id).map(([, place]) => place);
  const before = touches.get(id);
  const length = (a, b) => Math.hypot(a[0] - b[0], a[1] - b[1]) || 1;
  zoom(length(before, other) / length(now, other));
  pan(model, (now[0] - before[0]) / height / 2, (now[1] - before[1]) / height / 2);
}
