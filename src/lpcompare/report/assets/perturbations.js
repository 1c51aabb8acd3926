"use strict";
// Eq. 27 error against the amount by which the input was perturbed, one chart per kind.

let perturbationPanels = [];

function perturbationCharts() {
  return [...document.querySelectorAll(".chart[data-perturbation]")];
}

function perturbationCurve(method, levels) {
  const style = charts.methods[method];
  return {
    name: escapeText(method), mode: "lines+markers", x: levels.map(([level]) => level), y: levels.map(([, error]) => error),
    marker: { color: colourOf(style), symbol: style.symbol, size: 8 }, line: { color: colourOf(style), width: 1 },
    hovertemplate: "<b>%{fullData.name}</b>, level %{x:~g}<br>%{y:.3~g} %<extra></extra>",
  };
}

function drawPerturbations() {
  const [model, reduction] = [chosen("perturbation-model"), Number(chosen("perturbation-reduction"))];
  return Promise.all(perturbationCharts().map(({ id, dataset: { perturbation: kind } }) => {
    const found = perturbationPanels.find((d) => d.kind === kind && d.model === model && d.reduction === reduction);
    const traces = shownMethods().filter((method) => found?.curves[method]).map((method) => perturbationCurve(method, found.curves[method]));
    return draw(id, traces, {
      xaxis: axis("Level; 0 is the clean cloud", [], widthOf(id) - 80),
      yaxis: axis(charts.headings.plane_error_pct.label, traces.flatMap((trace) => trace.y), 290),
    });
  }));
}

function startPerturbations() {
  perturbationPanels = JSON.parse(document.getElementById("perturbation-data").textContent);
  for (const id of ["perturbation-model", "perturbation-reduction"]) document.getElementById(id).addEventListener("change", drawPerturbations);
}
