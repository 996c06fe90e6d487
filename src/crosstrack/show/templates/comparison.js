"use strict";
(() => {
  const { groups } = JSON.parse(document.getElementById("data").textContent);
  if (!groups.length) { document.body.dataset.ready = "yes"; return; }
  const names = ["plan", "boxes", "speeds", "tracking", "times"];
  const options = { responsive: true, displaylogo: false };
  const buttons = [...document.querySelectorAll("#legend button[data-tracker]")];
  const choice = document.getElementById("group");
  const hidden = new Set();

  const draw = (name, group) => {
    const place = document.getElementById(name), figure = groups[group][name];
    if (!figure) return Promise.resolve();
    const traces = figure.data.map((trace) => ({ ...trace, visible: !hidden.has(trace.meta) }));
    // zooming is kept while trackers come and go, not from one mission to the next
    return Plotly.react(place, traces, { ...figure.layout, uirevision: group }, options)
      .then(() => Plotly.Plots.resize(place));
  };
  const show = () => {
    const group = choice ? +choice.value : 0;
    document.querySelectorAll("[data-group]").forEach((section) => { section.hidden = +section.dataset.group !== group; });
    buttons.forEach((button) => button.setAttribute("aria-pressed", !hidden.has(+button.dataset.tracker)));
    document.querySelectorAll("tr[data-tracker]").forEach((row) => {
      row.style.opacity = hidden.has(+row.dataset.tracker) ? 0.4 : 1;
    });
    // first, so that a pane beside one that goes is as wide as it will be
    names.forEach((name) => { document.getElementById(name).parentElement.hidden = !groups[group][name]; });
    return Promise.all(names.map((name) => draw(name, group)));
  };

  buttons.forEach((button) => {
    const tracker = +button.dataset.tracker;
    button.title = "Click to show or hide, double-click to show alone";
    button.addEventListener("click", () => { if (!hidden.delete(tracker)) hidden.add(tracker); show(); });
    button.addEventListener("dblclick", () => {
      buttons.forEach((other) => hidden.add(+other.dataset.tracker));
      hidden.delete(tracker);
      show();
    });
  });
  document.getElementById("all")?.addEventListener("click", () => { hidden.clear(); show(); });
  choice?.addEventListener("change", show);
  show().then(() => { document.body.dataset.ready = "yes"; });
})();
