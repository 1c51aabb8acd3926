"use strict";
// The charts, drawn by plotly.js from the numbers in the page. Better is always up; plotly.js is unpacked when the charts come into sight.

const SYMBOLS = { circle: "●", square: "■", diamond: "◆", "triangle-up": "▲", "triangle-down": "▼", cross: "✚", x: "✖" };
const hiddenMethods = new Set();
const charts = { drawn: false };

function chosen(id) {
  return byId(id).value;
}

// The cells of one method that have every one of these columns, fewest removed first.
function cellsOf(method, model, ...keys) {
  return page.cells
    .filter((c) => c.model === model && c.method === method && keys.every((key) => key in c.values))
    .sort((a, b) => a.reduction - b.reduction);
}

function shownMethods() {
  return Object.keys(page.methods).filter((method) => !hiddenMethods.has(method));
}

// Plotly's error bar from [median, low, high].
function errorBar(spans) {
  return {
    type: "data", symmetric: false, thickness: 1, width: 0,
    array: spans.map(([median, , high]) => high - median), arrayminus: spans.map(([median, low]) => median - low),
  };
}

// Plotly reads a few tags in names; ours are plain text.
function escapeText(text) {
  return text.replaceAll("&", "&amp;").replaceAll("<", "&lt;").replaceAll(">", "&gt;");
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

function trace(method, points, style = page.methods[method]) {
  return {
    name: escapeText(method), mode: "markers", marker: { color: colourOf(style), symbol: style.symbol, size: 8 },
    hovertemplate: "<b>%{fullData.name}</b>, %{text}<br>%{x:.3~g} · %{y:.3~g}<extra></extra>", ...points,
  };
}

function curve(method, model, xKey, yKey) {
  const cells = cellsOf(method, model, xKey, yKey), line = { color: colourOf(page.methods[method]), width: 1, dash: "dot" };
  return trace(method, {
    mode: "lines+markers", line, x: cells.map((c) => c.values[xKey][0]), y: cells.map((c) => c.values[yKey][0]),
    error_x: errorBar(cells.map((c) => c.values[xKey])), error_y: errorBar(cells.map((c) => c.values[yKey])),
    text: cells.map((c) => `${percentText(c.reduction)} removed`),
  });
}

// The methods that no other beats in both, at each reduction: steps through what one gets for the time one has.
function fronts(curves, measure) {
  const sign = page.headings[measure].better === "higher" ? -1 : 1;
  const points = curves.flatMap((c) => c.x.map((x, i) => ({ x, y: c.y[i], reduction: c.text[i] })));
  return Object.values(Object.groupBy(points, (p) => p.reduction)).map((group) => {
    let best = Infinity;
    const front = group.sort((a, b) => a.x - b.x || sign * (a.y - b.y)).filter((p) => sign * p.y < best && ((best = sign * p.y), true));
    return { mode: "lines", line: { shape: "hv", color: themeColour("--quiet"), width: 1.5 }, hoverinfo: "skip", x: front.map((p) => p.x), y: front.map((p) => p.y) };
  }).filter((front) => front.x.length > 1);
}

// Few ticks on a long axis, more on a short one, the values themselves where they hardly differ.
function logTicks(values) {
  const [low, high] = [Math.log10(Math.min(...values)), Math.log10(Math.max(...values))];
  const digits = high - low > 2 ? [1] : high - low > 0.8 ? [1, 2, 5] : [1, 1.5, 2, 3, 4, 5, 6, 8];
  const found = [];
  for (let decade = Math.floor(low) - 1; decade <= high + 1; decade++) found.push(...digits.map((d) => Number(`${d}e${decade}`)));
  return found;
}

// Logarithmic where every value allows it, and the values differ; decibels are logarithms already.
function axis(title, values, pixels, { unit = "", reversed = false } = {}) {
  const lines = { gridcolor: themeColour("--line"), zerolinecolor: themeColour("--line"), automargin: true };
  const base = { ...lines, title: { text: wrapText(title, pixels), standoff: 8 }, ...(reversed ? { autorange: "reversed" } : {}) };
  const [low, high] = [Math.min(...values), Math.max(...values)];
  if (!values.length || low <= 0 || unit === "dB" || high < 1.26 * low) return base;
  const found = logTicks(values);
  return { ...base, type: "log", tickvals: found, ticktext: found.map((tick) => tick.toLocaleString("en", { maximumSignificantDigits: 4 })) };
}

// A measure upwards: better is up.
function measureAxis(measure, values, pixels) {
  const { label, unit, better } = page.headings[measure];
  return axis(`${label}${better ? ", better is up" : ""}`, values, pixels, { unit, reversed: better === "lower" });
}

function widthOf(id) {
  return byId(id).clientWidth;
}

// One name per bar or row, none left out.
function nameAxis() {
  return { automargin: true, dtick: 1, tickfont: { size: 11 }, gridcolor: themeColour("--line") };
}

// On paper with the width of the paper; a bar of buttons only where a pointer can hover over it.
function draw(id, traces, layout) {
  const base = {
    width: onPaper() ? widthOf(id) : undefined, autosize: !onPaper(), showlegend: false, margin: { l: 56, r: 12, t: 12, b: 44 },
    hovermode: "closest", dragmode: "zoom", paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)", font: { color: themeColour("--ink"), size: 12 },
  };
  const config = {
    responsive: true, displaylogo: false, modeBarButtonsToRemove: ["select2d", "lasso2d", "autoScale2d"],
    displayModeBar: matchMedia("(hover: hover)").matches ? "hover" : false,
  };
  return Plotly.react(id, traces, { ...base, ...layout }, config);
}

function drawCurves(id, xKey, measure, front) {
  const curves = shownMethods().map((method) => curve(method, chosen("chart-model"), xKey, measure)).filter((c) => c.x.length);
  const [xs, ys] = ["x", "y"].map((key) => curves.flatMap((c) => c[key])), steps = front ? fronts(curves, measure) : [];
  if (front) byId("chart-front").hidden = !steps.length;
  return draw(id, [...steps, ...curves], {
    xaxis: axis(page.headings[xKey].label, xs, widthOf(id) - 80), yaxis: measureAxis(measure, ys, 290),
  });
}

// Each method beside the reference at the same reduction, a panel for each model: a ratio, of decibels a difference.
function drawRatio(measure) {
  const reference = chosen("chart-reference"), { unit, title, better } = page.headings[measure], decibels = unit === "dB";
  const models = page.models.length > 8 ? [chosen("chart-model")] : page.models;
  byId("chart-ratio-name").textContent = `${decibels ? "Difference" : "Ratio"} to ${reference}, the best on top`;
  const traces = models.flatMap((model, panel) => {
    const base = new Map(cellsOf(reference, model, measure).map((c) => [c.reduction, c.values[measure][0]]));
    return shownMethods().map((method) => {
      const cells = cellsOf(method, model, measure).filter((c) => decibels || base.get(c.reduction) > 0).filter((c) => base.has(c.reduction));
      const spans = cells.map((c) => c.values[measure].map((value) => (decibels ? value - base.get(c.reduction) : value / base.get(c.reduction))));
      const points = { x: spans.map(([median]) => median), y: cells.map(() => escapeText(method)), error_x: errorBar(spans), text: cells.map((c) => `${percentText(c.reduction)} removed`) };
      const made = trace(method, { ...points, xaxis: `x${panel + 1}` });
      made.marker = { ...made.marker, size: cells.map((c) => 4 + 8 * c.reduction), line: { color: themeColour("--ground"), width: 0.5 } };
      return { ...made, hovertemplate: `<b>%{y}</b>, ${escapeText(model)}, %{text}<br>%{x:.3~g}<extra></extra>` };
    });
  }).filter((t) => t.x.length);
  const worst = new Map();
  for (const t of traces) worst.set(t.y[0], Math.max(worst.get(t.y[0]) ?? -Infinity, ...t.x.map((x) => (better === "higher" ? -x : x))));
  const order = [...worst.entries()].sort((a, b) => b[1] - a[1]).map(([name]) => name), at = decibels ? 0 : 1;
  const layout = { yaxis: { ...nameAxis(), categoryorder: "array", categoryarray: order }, shapes: [], annotations: [] };
  models.forEach((model, i) => {
    const domain = [i / models.length + 0.01, (i + 1) / models.length - 0.01], values = traces.filter((t) => t.xaxis === `x${i + 1}`).flatMap((t) => t.x);
    layout[`xaxis${i + 1}`] = { ...axis(models.length > 1 ? "" : `${title}, ${decibels ? "minus" : "times"} ${reference}`, values, widthOf("chart-ratio") - 170, { unit }), domain };
    layout.shapes.push({ type: "line", x0: at, x1: at, y0: 0, y1: 1, xref: `x${i + 1}`, yref: "paper", line: { color: themeColour("--quiet"), width: 1 } });
    if (models.length > 1) layout.annotations.push({ text: escapeText(model), x: (domain[0] + domain[1]) / 2, y: 1, xref: "paper", yref: "paper", yanchor: "bottom", showarrow: false, font: { size: 11 } });
  });
  return draw("chart-ratio", traces, { ...layout, margin: { l: 56, r: 12, t: models.length > 1 ? 24 : 12, b: 44 } });
}

// What the method says of its stages, and what is left of the call.
function stageSeconds(cell) {
  const told = Object.values(cell.timings).reduce((sum, value) => sum + value, 0);
  return { ...cell.timings, "not told apart": Math.max(0, cell.values.runtime_s[0] - told) };
}

function drawStages() {
  const rows = shownMethods()
    .flatMap((method) => cellsOf(method, chosen("chart-model"), "runtime_s").filter((c) => c.reduction === Number(chosen("chart-reduction"))))
    .sort((a, b) => b.values.runtime_s[0] - a.values.runtime_s[0])
    .map((cell) => ({ method: escapeText(cell.method), stages: stageSeconds(cell) }));
  const colours = [...page.stages.map(([stage, style]) => [stage, colourOf(style)]), ["not told apart", themeColour("--faint")]];
  const traces = colours.filter(([stage]) => rows.some((row) => stage in row.stages)).map(([stage, colour]) => ({
    type: "bar", orientation: "h", name: escapeText(stage), y: rows.map((row) => row.method), x: rows.map((row) => row.stages[stage] ?? 0),
    marker: { color: colour, line: { color: themeColour("--ground"), width: 0.5 } },
    hovertemplate: "<b>%{y}</b>, %{fullData.name}<br>%{x:.3~g} s<extra></extra>",
  }));
  return draw("chart-stages", traces, {
    barmode: "stack", showlegend: true, legend: { orientation: "h", x: 0, xref: "container", y: 0, yref: "container", traceorder: "normal" },
    xaxis: { ...axis("Seconds", [], 200), rangemode: "tozero" }, yaxis: { ...nameAxis(), autorange: "reversed" },
  });
}

function perturbationCharts() {
  return [...document.querySelectorAll(".chart[data-perturbation]")];
}

// Plane error against the amount by which the input was perturbed, one chart per kind.
function drawPerturbations() {
  const [model, reduction] = [chosen("perturbation-model"), Number(chosen("perturbation-reduction"))];
  return perturbationCharts().map(({ id, dataset: { perturbation: kind } }) => {
    const found = page.panels.find((p) => p.kind === kind && p.model === model && p.reduction === reduction)?.curves ?? {};
    const traces = shownMethods().filter((method) => found[method]?.length).map((method) => trace(method, {
      mode: "lines+markers", x: found[method].map(([level]) => level), y: found[method].map(([, error]) => error),
      line: { color: colourOf(page.methods[method]), width: 1 }, hovertemplate: "<b>%{fullData.name}</b>, level %{x:~g}<br>%{y:.3~g} %<extra></extra>",
    }));
    return draw(id, traces, {
      xaxis: axis("Level; 0 is the clean cloud", [], widthOf(id) - 80), yaxis: measureAxis("plane_error_pct", traces.flatMap((t) => t.y), 290),
    });
  });
}

// plotly.js lies in the page packed.
async function drawCharts() {
  charts.ready ??= unzip(byId("plotly").textContent).then((text) => document.head.append(element("script", { textContent: text })));
  await charts.ready;
  charts.drawn = true;
  const measure = chosen("chart-measure");
  const drawn = [drawCurves("chart-runtime", "runtime_s", measure, true), drawRatio(measure), drawStages(), ...perturbationCharts().length ? drawPerturbations() : []];
  if (byId("chart-count")) drawn.push(drawCurves("chart-count", "n_output", measure, false));
  await Promise.all(drawn);
  byId("charts").dataset.drawn = "yes";
}

// One method at full strength and the others faint; all alike with no method.
function pickOut(method) {
  for (const { id, data } of document.querySelectorAll(".chart:not(#chart-stages)")) {
    const faint = (t) => method !== null && t.name !== escapeText(method);
    if (data) Plotly.restyle(id, { opacity: data.map((t) => (faint(t) ? 0.12 : 1)) });
  }
}

function startLegend() {
  const families = Object.groupBy(Object.keys(page.methods), (method) => page.methods[method].family || "other");
  for (const [family, group] of Object.entries(families)) {
    byId("chart-legend").append(element("span", { className: "family", textContent: family }));
    for (const method of group) {
      const style = page.methods[method], symbol = element("span", { className: "symbol", textContent: SYMBOLS[style.symbol] });
      const button = element("button", { type: "button" }, symbol, method);
      symbol.style.color = `light-dark(${style.color}, ${style.dark})`;
      symbol.ariaHidden = "true";
      button.dataset.method = method;
      button.setAttribute("aria-pressed", "true");
      button.addEventListener("click", () => {
        const shown = hiddenMethods.delete(method);
        if (!shown) hiddenMethods.add(method);
        button.setAttribute("aria-pressed", shown);
        drawCharts();
      });
      for (const [event, who] of [["mouseenter", method], ["mouseleave", null], ["focus", method], ["blur", null]]) button.addEventListener(event, () => pickOut(who));
      byId("chart-legend").append(button);
    }
  }
}

// Draw the charts when they come into sight.
function startCharts() {
  if (!byId("chart-runtime")) return;
  startLegend();
  const height = 130 + 20 * Object.keys(page.methods).length + 8 * page.stages.length;
  for (const tall of document.querySelectorAll(".chart.tall")) tall.style.height = `${Math.max(300, height)}px`;
  for (const select of document.querySelectorAll("#charts select, #perturbations select")) {
    select.addEventListener("change", () => { drawCharts(); keepState(); });
  }
  // When they come into sight, or after a while: paper cannot wait for them.
  const begin = () => { watcher.disconnect(); clearTimeout(later); drawCharts(); };
  const watcher = new IntersectionObserver((seen) => seen.some((entry) => entry.isIntersecting) && begin(), { rootMargin: "400px" });
  const later = setTimeout(begin, 4000);
  watcher.observe(byId("charts"));
}
