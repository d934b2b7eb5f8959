// Draws the figures with Plotly, which stands in the page before this.
"use strict";
(() => {
  const figures = JSON.parse(document.getElementById("figures").textContent);
  const places = [...document.querySelectorAll("[data-figure]")];
  const config = { displayModeBar: false, responsive: true, scrollZoom: false, doubleClick: false };
  const NARROW = 400;  // px: a phone
  const PRINTED = 330;  // px: two figures beside each other on a sheet

  document.documentElement.classList.add("live");
  for (const place of places) {
    const { data, layout } = figures[Number(place.dataset.figure)];
    if (place.clientWidth < NARROW && data[0].type === "heatmap") {
      data[0].showscale = false;  // the cells have numbers, and the heading names both axes
      layout.yaxis.title = {};
    }
    Plotly.newPlot(place, data, { ...layout, dragmode: false }, config);
  }
  const all = (change) => places.forEach((place) => Plotly.relayout(place, change));
  window.addEventListener("beforeprint", () => all({ autosize: false, width: PRINTED }));
  window.addEventListener("afterprint", () => all({ autosize: true, width: null }));
})();
