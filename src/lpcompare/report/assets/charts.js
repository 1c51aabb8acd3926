"use strict";
// The charts, drawn by plotly.js from the numbers in the page for the model, measure and reference chosen.

const SYMBOLS = { circle: "●", square: "■", diamond: "◆", "triangle-up": "▲", "triangle-down": "▼", cross: "✚", x: "✖" };
let charts = null;
const hiddenMethods = new Set();

function chosen(id) {
  return document.getElementById(id).value;
}

// The cells of one method on the chosen model that have every one of these columns, fewest points last.
function cellsOf(method, ...keys) {
  return charts.cells
    .filter((c) => c.model === chosen("chart-model") && c.method === method && keys.every((key) => key in c.values))
    .sort((a, b) => a.reduction - b.reduction);
}

function shownMethods() {
  return Object.keys(charts.methods).filter((method) => !hiddenMethods.has(method));
}

// Plotly's error bar from [median, low, high].
function errorBar(spans) {
  return {
    type: "data", symmetric: false, thickness: 1, width: 0,
    array: spans.map(([median, , high]) => high - median),
    arrayminus: spans.map(([median, low]) => median - low),
  };
}

function colourOf(style) {
  return isDark() ? style.dark : style.color;
}

// Lines of text that fit a length in pixels.
function wrapText(text, pixels) {
  const lines = [""];
  for (const word of text.split(" ")) {
    if (lines.at(-1) && 7 * (lines.at(-1).length + word.length) > pixels) lines.push(word);
    else lines[lines.length - 1] += `${lines.at(-1) && " "}${word}`;
  }
  return lines.map(escapeText).join("<br>");
}

function percentText(share) {
  return `${+(100 * share).toPrecision(6)} %`;
}

function curve(method, xKey, yKey) {
  const cells = cellsOf(method, xKey, yKey);
  const style = charts.methods[method];
  return {
    name: escapeText(method), mode: "lines+markers",
    x: cells.map((c) => c.values[xKey][0]), y: cells.map((c) => c.values[yKey][0]),
    error_x: errorBar(cells.map((c) => c.values[xKey])), error_y: errorBar(cells.map((c) => c.values[yKey])),
    text: cells.map((c) => `${percentText(c.reduction)} removed`),
    marker: { color: colourOf(style), symbol: style.symbol, size: 8 }, line: { color: colourOf(style), width: 1, dash: "dot" },
    hovertemplate: "<b>%{fullData.name}</b>, %{text}<br>%{x:.3~g} · %{y:.3~g}<extra></extra>",
  };
}

// Plotly reads a few tags in names; ours are plain text.
function escapeText(text) {
  return text.replaceAll("&", "&amp;").replaceAll("<", "&lt;").replaceAll(">", "&gt;");
}

// The fronts as steps: what is the lowest error for the time one has.
function frontCurves(measure) {
  const fronts = charts.fronts[chosen("chart-model")]?.[measure] ?? {};
  return Object.entries(fronts).map(([reduction, methods]) => {
    const cells = methods.map((m) => cellsOf(m, "runtime_s", measure).find((c) => c.reduction === Number(reduction)));
    return {
      mode: "lines", line: { shape: "hv", color: themeColour("--quiet"), width: 1.5 }, hoverinfo: "skip",
      x: cells.map((c) => c.values.runtime_s[0]), y: cells.map((c) => c.values[measure][0]),
    };
  });
}

// Few ticks on a long axis, more on a short one, the values themselves where they hardly differ.
function logTicks(values) {
  const [low, high] = [Math.log10(Math.min(...values)), Math.log10(Math.max(...values))];
  if (high - low < 0.1) return [...new Set([Math.min(...values), Math.max(...values)])];
  const digits = high - low > 2 ? [1] : high - low > 0.8 ? [1, 2, 5] : [1, 1.5, 2, 3, 4, 5, 6, 8];
  const ticks = [];
  for (let decade = Math.floor(low) - 1; decade <= high + 1; decade++) ticks.push(...digits.map((d) => Number(`${d}e${decade}`)));
  return ticks;
}

// Logarithmic where every value allows it.
function axis(title, values, pixels) {
  const lines = { gridcolor: themeColour("--line"), zerolinecolor: themeColour("--line"), automargin: true };
  const base = { ...lines, title: { text: wrapText(title, pixels), standoff: 8 } };
  if (!values.length || values.some((value) => value <= 0)) return base;
  const ticks = logTicks(values);
  return { ...base, type: "log", tickvals: ticks, ticktext: ticks.map((tick) => tick.toLocaleString("en", { maximumSignificantDigits: 4 })) };
}

function widthOf(id) {
  return document.getElementById(id).clientWidth;
}

// One name per bar or row, none left out.
function nameAxis() {
  return { automargin: true, dtick: 1, tickfont: { size: 11 }, gridcolor: themeColour("--line") };
}

// On paper with the width of the paper; a bar of buttons only where a pointer can hover over it.
function draw(id, traces, layout) {
  const base = {
    width: onPaper() ? widthOf(id) : undefined, autosize: !onPaper(),
    showlegend: false, margin: { l: 56, r: 12, t: 12, b: 44 }, hovermode: "closest", dragmode: "zoom",
    paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)", font: { color: themeColour("--ink"), size: 12 },
  };
  const config = {
    responsive: true, displaylogo: false, modeBarButtonsToRemove: ["select2d", "lasso2d", "autoScale2d"],
    displayModeBar: matchMedia("(hover: hover)").matches ? "hover" : false,
  };
  return Plotly.react(id, traces, { ...base, ...layout }, config);
}

function drawCurves(id, xKey, measure, front) {
  const curves = shownMethods().map((method) => curve(method, xKey, measure));
  const [xs, ys] = ["x", "y"].map((key) => curves.flatMap((trace) => trace[key]));
  const { headings } = charts;
  return draw(id, [...front, ...curves], {
    xaxis: axis(headings[xKey].label, xs, widthOf(id) - 80), yaxis: axis(headings[measure].label, ys, 290),
  });
}

// Each method over the reference at the same reduction; 1 is the reference itself.
function ratioTraces(measure, reference) {
  const base = new Map(cellsOf(reference, measure).map((c) => [c.reduction, c.values[measure]]));
  return shownMethods().map((method) => {
    const cells = cellsOf(method, measure).filter((c) => base.has(c.reduction) && base.get(c.reduction)[0] > 0);
    const spans = cells.map((c) => c.values[measure].map((value) => value / base.get(c.reduction)[0]));
    const style = charts.methods[method];
    return {
      name: escapeText(method), mode: "markers", x: spans.map(([median]) => median), y: cells.map(() => escapeText(method)),
      error_x: errorBar(spans), text: cells.map((c) => `${percentText(c.reduction)} removed`),
      marker: {
        color: colourOf(style), symbol: style.symbol, size: cells.map((c) => 4 + 8 * c.reduction),
        opacity: 1, line: { color: themeColour("--ground"), width: 0.5 },
      },
      hovertemplate: "<b>%{y}</b>, %{text}<br>%{x:.3~g} times<extra></extra>",
    };
  });
}

function drawRatio(measure) {
  const reference = chosen("chart-reference");
  document.getElementById("chart-reference-name").textContent = reference;
  const traces = ratioTraces(measure, reference).filter((trace) => trace.x.length);
  traces.sort((a, b) => Math.max(...b.x) - Math.max(...a.x));
  const line = { type: "line", x0: 1, x1: 1, y0: 0, y1: 1, yref: "paper", line: { color: themeColour("--quiet"), width: 1 } };
  return draw("chart-ratio", traces, {
    xaxis: axis(`${charts.headings[measure].title}, times ${reference}`, traces.flatMap((t) => t.x), widthOf("chart-ratio") - 170),
    yaxis: nameAxis(), shapes: [line],
  });
}

// What the method says of its stages, and what is left of the call.
function stageSeconds(cell) {
  const told = Object.values(cell.timings).reduce((sum, value) => sum + value, 0);
  return { ...cell.timings, "not told apart": Math.max(0, cell.values.runtime_s[0] - told) };
}

function drawStages() {
  const reduction = Number(chosen("chart-reduction"));
  const rows = shownMethods()
    .flatMap((method) => cellsOf(method, "runtime_s").filter((c) => c.reduction === reduction))
    .sort((a, b) => b.values.runtime_s[0] - a.values.runtime_s[0])
    .map((cell) => ({ method: escapeText(cell.method), stages: stageSeconds(cell) }));
  const colours = charts.stages.map(([stage, style]) => [stage, colourOf(style)]);
  const stages = [...colours, ["not told apart", themeColour("--faint")]].filter(([stage]) => rows.some((row) => stage in row.stages));
  const traces = stages.map(([stage, colour]) => ({
    type: "bar", orientation: "h", name: escapeText(stage), y: rows.map((row) => row.method), x: rows.map((row) => row.stages[stage] ?? 0),
    marker: { color: colour, line: { color: themeColour("--ground"), width: 0.5 } },
    hovertemplate: "<b>%{y}</b>, %{fullData.name}<br>%{x:.3~g} s<extra></extra>",
  }));
  return draw("chart-stages", traces, {
    barmode: "stack", showlegend: true, legend: { orientation: "h", x: 0, xref: "container", y: 0, yref: "container", traceorder: "normal" },
    xaxis: { ...axis("Seconds", [], 200), rangemode: "tozero" }, yaxis: { ...nameAxis(), autorange: "reversed" },
  });
}

function drawCharts() {
  if (!charts) return Promise.resolve();
  const measure = chosen("chart-measure");
  return Promise.all([
    drawCurves("chart-runtime", "runtime_s", measure, frontCurves(measure)),
    drawCurves("chart-count", "n_output", measure, []),
    drawRatio(measure),
    drawStages(),
    perturbationCharts().length ? drawPerturbations() : null,
  ]);
}

function toggleMethod(button) {
  const method = button.dataset.method;
  const shown = hiddenMethods.delete(method);
  if (!shown) hiddenMethods.add(method);
  button.setAttribute("aria-pressed", shown);
  drawCharts();
}

// One method at full strength and the others faint; all alike with no method.
function pickOut(method) {
  for (const id of ["chart-runtime", "chart-count", "chart-ratio", ...perturbationCharts().map((chart) => chart.id)]) {
    const { data } = document.getElementById(id);
    const faint = (trace) => method !== null && trace.name !== escapeText(method);
    if (data) Plotly.restyle(id, { opacity: data.map((trace) => (faint(trace) ? 0.12 : 1)) });
  }
}

function startLegend() {
  for (const [method, style] of Object.entries(charts.methods)) {
    const button = document.createElement("button");
    const symbol = document.createElement("span");
    button.type = "button";
    button.dataset.method = method;
    button.setAttribute("aria-pressed", "true");
    symbol.className = "symbol";
    symbol.style.color = `light-dark(${style.color}, ${style.dark})`;
    symbol.textContent = SYMBOLS[style.symbol];
    button.append(symbol, method);
    button.addEventListener("click", () => toggleMethod(button));
    button.addEventListener("mouseenter", () => pickOut(method));
    button.addEventListener("mouseleave", () => pickOut(null));
    document.getElementById("chart-legend").append(button);
  }
}

function startCharts() {
  if (!document.getElementById("chart-runtime")) return;
  charts = JSON.parse(document.getElementById("chart-data").textContent);
  startLegend();
  if (perturbationCharts().length) startPerturbations();
  const height = 130 + 20 * Object.keys(charts.methods).length + 8 * charts.stages.length;
  for (const tall of document.querySelectorAll(".chart.tall")) tall.style.height = `${Math.max(300, height)}px`;
  for (const id of ["chart-model", "chart-measure", "chart-reference", "chart-reduction"]) {
    document.getElementById(id).addEventListener("change", drawCharts);
  }
}

// Draw the charts when they come into sight.
function watchCharts() {
  if (!charts) return;
  const watcher = new IntersectionObserver((seen) => {
    if (seen.some((entry) => entry.isIntersecting)) {
      watcher.disconnect();
      drawCharts();
    }
  }, { rootMargin: "400px" });
  watcher.observe(document.getElementById("charts"));
}
