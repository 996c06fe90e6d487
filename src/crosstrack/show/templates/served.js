"use strict";
(() => {
  const data = JSON.parse(document.getElementById("data").textContent);
  const [space, above, times, slider, now, play] =
    ["space", "plan", "times", "slider", "now", "play"].map((name) => document.getElementById(name));
  const options = { responsive: true, displaylogo: false };
  const numbers = ({ bdata }) =>
    new Float32Array(Uint8Array.from(atob(bdata), (letter) => letter.charCodeAt(0)).buffer);
  const positions = data.vehicles.map((vehicle) => numbers(vehicle.position));
  const colors = data.vehicles.map((vehicle) => vehicle.color);

  const look = { size: 12, color: colors, line: { width: 2, color: "#0f172a" } };
  const nowhere = { x: colors.map(() => null), y: colors.map(() => null) };
  const common = { mode: "markers", name: "vehicles", hoverinfo: "skip", showlegend: false, ...nowhere };
  const here = { ...common, type: "scatter3d", z: colors.map(() => null), marker: { ...look, size: 7 } };
  const mark = { ...common, type: "scatter", marker: look };
  const column = (stop, axis) => positions.map((place) => place[3 * stop + axis]);

  const show = (stop) => {
    const [x, y, z] = [0, 1, 2].map((axis) => column(stop, axis));
    Plotly.restyle(space, { x: [x], y: [y], z: [z] }, [data.space.data.length]);
    Plotly.restyle(above, { x: [x], y: [y] }, [data.plan.data.length]);
    const time = data.stops[stop];
    Plotly.relayout(times, { "shapes[0].x0": time, "shapes[0].x1": time });
    now.textContent = `${time.toFixed(2)} s`;
  };

  let timer = null;
  const stop = () => { clearInterval(timer); timer = null; play.textContent = "▶"; play.setAttribute("aria-label", "Play"); };
  const start = () => {
    play.textContent = "⏸";
    play.setAttribute("aria-label", "Pause");
    if (+slider.value >= +slider.max) slider.value = 0;
    const began = performance.now(), from = data.stops[+slider.value];
    const rate = Math.max(1, data.stops[data.stops.length - 1] / 30);
    timer = setInterval(() => {
      const time = from + rate * (performance.now() - began) / 1000;
      let next = +slider.value;
      while (next < +slider.max && data.stops[next] < time) next += 1;
      if (next !== +slider.value) { slider.value = next; show(next); }
      if (next >= +slider.max) stop();
    }, 50);
  };

  slider.max = data.stops.length - 1;
  slider.value = slider.max;
  slider.addEventListener("input", () => show(+slider.value));
  play.addEventListener("click", () => (timer ? stop() : start()));
  data.times.layout.shapes = [{ type: "line", yref: "paper", y0: 0, y1: 1, x0: 0, x1: 0,
    line: { color: "#0f172a", width: 1 } }];
  Promise.all([
    Plotly.newPlot(space, [...data.space.data, here], data.space.layout, options),
    Plotly.newPlot(above, [...data.plan.data, mark], data.plan.layout, options),
    Plotly.newPlot(times, data.times.data, data.times.layout, options),
  ]).then(() => {
    show(+slider.max);
    document.body.dataset.ready = "yes";
  });
})();
