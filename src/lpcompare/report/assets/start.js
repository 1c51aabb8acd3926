"use strict";
// Called once, at the end of the page.

if (typeof startTable === "function") startTable();
if (typeof startCharts === "function") startCharts();
startViews();
watchPrint(() => {
  if (typeof drawCharts === "function") drawCharts();
  showStills(onPaper());
});
watchTheme(() => {
  if (typeof drawCharts === "function" && document.querySelector("#chart-runtime .plot-container")) drawCharts();
  drawViews();
});
