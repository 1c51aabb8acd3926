"use strict";
// Eq. 27 error against the amount of damage to the input, one chart per kind of damage.

let damagePanels = [];

function damageCharts() {
  return [...document.querySelectorAll(".chart[data-damage]")];
}

function damageCurve(method, levels) {
  const style = charts.methods[method];
  return {
    name: escapeText(method), mode: "lines+markers", x: levels.map(([level]) => level), y: levels.map(([, error]) => error),
    marker: { color: colourOf(style), symbol: style.symbol, size: 8 }, line: { color: colourOf(style), width: 1 },
    hovertemplate: "<b>%{fullData.name}</b>, level %{x:~g}<br>%{y:.3~g} %<extra></extra>",
  };
}

function drawDamage() {
  const [model, reduction] = [chosen("damage-model"), Number(chosen("damage-reduction"))];
  return Promise.all(damageCharts().map(({ id, dataset: { damage: kind } }) => {
    const found = damagePanels.find((d) => d.kind === kind && d.model === model && d.reduction === reduction);
    const traces = shownMethods().filter((method) => found?.curves[method]).map((method) => damageCurve(method, found.curves[method]));
    return draw(id, traces, {
      xaxis: axis("Level; 0 is the clean cloud", [], widthOf(id) - 80),
      yaxis: axis(charts.headings.plane_error_pct.label, traces.flatMap((trace) => trace.y), 290),
    });
  }));
}

function startDamage() {
  damagePanels = JSON.parse(document.getElementById("damage-data").textContent);
  for (const id of ["damage-model", "damage-reduction"]) document.getElementById(id).addEventListener("change", drawDamage);
}
