"use strict";
// Called once, at the end of the page.

if (typeof startTable === "function") startTable();
if (typeof startCharts === "function") startCharts();
// The charts wait for the views, so that the first view is there as soon as it can be.
startViews().finally(() => typeof watchCharts === "function" && watchCharts());
watchPrint(() => {
  if (typeof drawCharts === "function") drawCharts();
  showStills(onPaper());
});
watchTheme(() => {
  if (typeof drawCharts === "function" && document.querySelector("#chart-runtime .plot-container")) drawCharts();
  drawViews();
});
