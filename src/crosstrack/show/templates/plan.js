"use strict";
(() => {
  const data = JSON.parse(document.getElementById("data").textContent);
  const options = { responsive: true, displaylogo: false };
  Promise.all(["space", "plan", "times"].map((name) =>
    Plotly.newPlot(document.getElementById(name), data[name].data, data[name].layout, options),
  )).then(() => { document.body.dataset.ready = "yes"; });
})();
