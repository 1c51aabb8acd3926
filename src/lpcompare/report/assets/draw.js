"use strict";
// Points drawn by WebGL 2. One context draws every view; its picture is copied to the view's own canvas, so that
// any number of views share one camera, and a view can be printed and saved as it stands.

const POINT_SHADER = `#version 300 es
precision highp float;
layout(location = 0) in vec3 place;
layout(location = 1) in float value;
layout(location = 2) in vec3 rgb;
uniform mat4 turn;
uniform float size;
uniform vec2 range;
uniform vec2 ends;
uniform int kind;
uniform vec3 plain;
uniform sampler2D colours;
out vec3 colour;
void main() {
  gl_Position = turn * vec4(place, 1.0);
  gl_PointSize = clamp(size / gl_Position.w, 1.0, 48.0);
  float share = (range.x + range.y * value - ends.x) / max(ends.y - ends.x, 1e-30);
  if (kind == 1) colour = texture(colours, vec2(clamp(share, 0.0, 1.0) * (255.0 / 256.0) + 0.5 / 256.0, 0.5)).rgb;
  else if (kind == 2) colour = texelFetch(colours, ivec2(int(value * 65535.0 + 0.5) % textureSize(colours, 0).x, 0), 0).rgb;
  else colour = kind == 3 ? rgb : plain;
}`;
const DISC_SHADER = `#version 300 es
precision mediump float;
in vec3 colour;
out vec4 pixel;
void main() {
  vec2 off = gl_PointCoord - 0.5;
  if (dot(off, off) > 0.25) discard;
  pixel = vec4(colour, 1.0);
}`;
const PAGE_SHADER = `#version 300 es
out vec2 at;
void main() {
  at = vec2((gl_VertexID << 1) & 2, gl_VertexID & 2);
  gl_Position = vec4(2.0 * at - 1.0, 0.0, 1.0);
}`;
// Eye-dome lighting: a pixel is darker the more its neighbours lie in front of it (Boucheny, 2009).
const LIGHT_SHADER = `#version 300 es
precision highp float;
in vec2 at;
out vec4 pixel;
uniform sampler2D picture;
uniform sampler2D depths;
uniform vec2 reach;
uniform vec2 step;
uniform vec4 ground;
float distance_at(vec2 place) {
  float depth = texture(depths, place).r;
  if (depth >= 1.0) return 0.0;
  return log2(2.0 * reach.x * reach.y / (reach.y + reach.x - (2.0 * depth - 1.0) * (reach.y - reach.x)));
}
void main() {
  float own = distance_at(at), shade = 0.0;
  if (texture(depths, at).r >= 1.0) { pixel = ground; return; }
  for (int i = 0; i < 8; i++) {
    float angle = 0.7853981634 * float(i), near = distance_at(at + step * vec2(cos(angle), sin(angle)));
    if (near != 0.0) shade += max(0.0, own - near);
  }
  pixel = vec4(texture(picture, at).rgb * max(0.25, exp(-12.0 * shade)), 1.0);
}`;

const KINDS = { plain: 0, scalar: 1, category: 2, rgb: 3 };
let gl = null;
const gpu = { buffers: new WeakMap(), textures: new Map(), width: 0, height: 0 };

// False where the browser has no WebGL 2.
function startGL() {
  const canvas = document.createElement("canvas");
  gl = canvas.getContext("webgl2", { antialias: false, alpha: true, powerPreference: "high-performance" });
  if (!gl) return false;
  canvas.addEventListener("webglcontextlost", (event) => event.preventDefault());
  canvas.addEventListener("webglcontextrestored", () => { prepareGL(); requestDraw(); });
  prepareGL();
  return true;
}

function prepareGL() {
  Object.assign(gpu, { buffers: new WeakMap(), textures: new Map(), width: 0, height: 0 });
  gpu.points = program(POINT_SHADER, DISC_SHADER);
  gpu.light = program(PAGE_SHADER, LIGHT_SHADER);
  gpu.frame = gl.createFramebuffer();
  gl.disable(gl.DITHER);
}

function program(vertex, fragment) {
  const made = gl.createProgram();
  for (const [kind, source] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    gl.attachShader(made, shader);
  }
  gl.linkProgram(made);
  if (!gl.getProgramParameter(made, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(made));
  return made;
}

function uniform(made, name) {
  return gl.getUniformLocation(made, name);
}

function bufferOf(array, target = gl.ARRAY_BUFFER) {
  let buffer = gpu.buffers.get(array);
  if (!buffer) {
    gpu.buffers.set(array, (buffer = gl.createBuffer()));
    gl.bindBuffer(target, buffer);
    gl.bufferData(target, array, gl.STATIC_DRAW);
  }
  gl.bindBuffer(target, buffer);
}

function texture(width, height, inner, outer, type, pixels) {
  const made = gl.createTexture();
  gl.bindTexture(gl.TEXTURE_2D, made);
  gl.texImage2D(gl.TEXTURE_2D, 0, inner, width, height, 0, outer, type, pixels);
  for (const name of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, name, gl.NEAREST);
  for (const name of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D, name, gl.CLAMP_TO_EDGE);
  return made;
}

// Colours as a texture: [[r, g, b], ...] from 0 to 255.
function palette(colours) {
  const key = colours.join();
  if (!gpu.textures.has(key)) {
    const bytes = Uint8Array.from(colours.flatMap((c) => [...c, 255]));
    gpu.textures.set(key, texture(colours.length, 1, gl.RGBA8, gl.RGBA, gl.UNSIGNED_BYTE, bytes));
  }
  return gpu.textures.get(key);
}

// The pictures that the points are drawn into before they are lit; they grow with the largest view.
function resize(width, height) {
  if (width <= gpu.width && height <= gpu.height) return;
  gpu.width = gl.canvas.width = Math.max(width, gpu.width);
  gpu.height = gl.canvas.height = Math.max(height, gpu.height);
  gl.deleteTexture(gpu.picture);
  gl.deleteTexture(gpu.depths);
  gpu.picture = texture(gpu.width, gpu.height, gl.RGBA8, gl.RGBA, gl.UNSIGNED_BYTE, null);
  gpu.depths = texture(gpu.width, gpu.height, gl.DEPTH_COMPONENT24, gl.DEPTH_COMPONENT, gl.UNSIGNED_INT, null);
  gl.bindFramebuffer(gl.FRAMEBUFFER, gpu.frame);
  gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, gpu.picture, 0);
  gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.TEXTURE_2D, gpu.depths, 0);
}

// Draw layers of points and copy the picture to a canvas. A layer: {points, rows, kind, values, low, span, ends, colours, rgb, plain, grow}.
function paint(context, layers, camera, { size, ground, most }) {
  const { width, height } = context.canvas;
  resize(width, height);
  gl.bindFramebuffer(gl.FRAMEBUFFER, gpu.frame);
  gl.viewport(0, 0, width, height);
  gl.clearColor(0, 0, 0, 0);
  gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
  gl.enable(gl.DEPTH_TEST);
  gl.useProgram(gpu.points);
  gl.uniformMatrix4fv(uniform(gpu.points, "turn"), false, camera.turn);
  for (const layer of layers) drawLayer(layer, size * height * (layer.grow ?? 1), most);
  gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  gl.disable(gl.DEPTH_TEST);
  gl.useProgram(gpu.light);
  gl.activeTexture(gl.TEXTURE1);
  gl.bindTexture(gl.TEXTURE_2D, gpu.depths);
  gl.activeTexture(gl.TEXTURE0);
  gl.bindTexture(gl.TEXTURE_2D, gpu.picture);
  gl.uniform1i(uniform(gpu.light, "picture"), 0);
  gl.uniform1i(uniform(gpu.light, "depths"), 1);
  gl.uniform2f(uniform(gpu.light, "reach"), camera.near, camera.far);
  gl.uniform2f(uniform(gpu.light, "step"), 1.4 / gpu.width, 1.4 / gpu.height);
  gl.uniform4f(uniform(gpu.light, "ground"), ...ground.map((c) => c / 255), 1);
  gl.viewport(0, 0, gpu.width, gpu.height);
  gl.drawArrays(gl.TRIANGLES, 0, 3);
  context.drawImage(gl.canvas, 0, gpu.height - height, width, height, 0, 0, width, height);
}

function drawLayer(layer, size, most) {
  const set = (name, call, ...values) => gl[call](uniform(gpu.points, name), ...values);
  set("size", "uniform1f", size);
  set("kind", "uniform1i", KINDS[layer.kind]);
  set("range", "uniform2f", layer.low ?? 0, layer.span ?? 1);
  set("ends", "uniform2f", ...(layer.ends ?? [0, 1]));
  set("plain", "uniform3f", ...(layer.plain ?? [200, 205, 212]).map((c) => c / 255));
  gl.bindTexture(gl.TEXTURE_2D, palette(layer.colours ?? [[0, 0, 0]]));
  attribute(0, layer.points, 3, gl.UNSIGNED_SHORT);
  attribute(1, layer.values, 1, gl.UNSIGNED_SHORT);
  attribute(2, layer.rgb, 3, gl.UNSIGNED_BYTE);
  if (layer.rows) {
    bufferOf(layer.rows, gl.ELEMENT_ARRAY_BUFFER);
    gl.drawElements(gl.POINTS, Math.min(most, layer.rows.length), gl.UNSIGNED_INT, 0);
  } else gl.drawArrays(gl.POINTS, 0, Math.min(most, layer.points.length / 3));
}

function attribute(place, array, n, type) {
  if (!array) return gl.disableVertexAttribArray(place);
  bufferOf(array);
  gl.enableVertexAttribArray(place);
  gl.vertexAttribPointer(place, n, type, true, 0, 0);
}
