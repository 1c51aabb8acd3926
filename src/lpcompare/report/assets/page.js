"use strict";
// Light and dark, paper, and the start of everything.

const page = readData("page-data");

function isDark() {
  const wish = document.documentElement.style.colorScheme;
  return wish ? wish === "dark" : matchMedia("(prefers-color-scheme: dark)").matches;
}

// The colour that a CSS variable stands for now: as a list of numbers, asked once for light and once for dark, or as text.
const tones = new Map();
function rgbOf(name, key = name + isDark()) {
  if (!tones.has(key)) tones.set(key, themeColour(name).match(/[\d.]+/g).slice(0, 3).map(Number));
  return tones.get(key);
}

function themeColour(name) {
  const probe = element("span");
  probe.style.color = `var(${name})`;
  document.body.append(probe);
  const colour = getComputedStyle(probe).color;
  probe.remove();
  return colour;
}

function colourOf(style) {
  return isDark() ? style.dark : style.color;
}

function onPaper() {
  return document.documentElement.classList.contains("paper");
}

function redraw() {
  if (view.model && gl) { drawScale(); drawAll(); }
  if (charts.drawn) drawCharts();
}

// On paper everything is light, and as wide as the paper.
function watchPrint() {
  const { style, classList } = document.documentElement;
  let wish = "";
  addEventListener("beforeprint", () => {
    wish = style.colorScheme;
    style.colorScheme = "light";
    classList.add("paper");
    redraw();
    if (byId("charts")) drawCharts();
  });
  addEventListener("afterprint", () => {
    style.colorScheme = wish;
    classList.remove("paper");
    redraw();
  });
}

function start() {
  byId("theme").addEventListener("click", () => {
    document.documentElement.style.colorScheme = isDark() ? "light" : "dark";
    redraw();
  });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", redraw);
  if (byId("table")) byId("table").innerHTML = byId("every-column").textContent;
  readFields();
  startTable();
  byId("save-picture")?.addEventListener("click", savePicture);
  byId("save-cloud")?.addEventListener("click", saveClouds);
  // The charts wait for the views, so that the first view is there as soon as it can be.
  startViews().finally(() => { started = true; startCharts(); });
  addEventListener("hashchange", () => { if (view.model) { readState(); showViews(); } });
  watchPrint();
}

start();
