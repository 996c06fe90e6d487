"use strict";
(() => {
  const data = JSON.parse(document.getElementById("data").textContent);
  const space = document.getElementById("space");
  const above = document.getElementById("plan");
  const times = document.getElementById("times");
  const slider = document.getElementById("slider");
  const now = document.getElementById("now");
  const play = document.getElementById("play");
  const coloring = document.getElementById("coloring");
  const options = { responsive: true, displaylogo: false };

  const numbers = ({ dtype, bdata }) => {
    const bytes = Uint8Array.from(atob(bdata), (letter) => letter.charCodeAt(0));
    return dtype === "i4" ? new Int32Array(bytes.buffer) : new Float32Array(bytes.buffer);
  };
  const vehicles = data.vehicles.map((vehicle) => Object.fromEntries(
    Object.entries(vehicle).map(([key, value]) => [key, value.bdata ? numbers(value) : value])));

  // The flown paths, unpacked once, so that a trail is a slice of them.
  const flown = data.space.data.filter((trace) => trace.meta === "flown");
  const firstFlown = data.space.data.indexOf(flown[0]);
  flown.forEach((trace) => ["x", "y", "z"].forEach((axis) => { trace[axis] = numbers(trace[axis]); }));
  const paths = flown.map((trace) => ({ x: trace.x, y: trace.y, z: trace.z }));

  const size = (() => {
    let largest = 1;
    for (const axis of ["x", "y", "z"]) {
      for (const path of paths) {
        let low = Infinity, high = -Infinity;
        for (const value of path[axis]) { low = Math.min(low, value); high = Math.max(high, value); }
        if (high > low) largest = Math.max(largest, high - low);
      }
    }
    return 0.025 * largest;
  })();

  // Rotate a body vector (forward, left, up) by a quaternion xyzw and add the position.
  const place = (vehicle, stop, [a, b, c]) => {
    const [x, y, z, w] = vehicle.attitude.subarray(4 * stop, 4 * stop + 4);
    const [tx, ty, tz] = [2 * (y * c - z * b), 2 * (z * a - x * c), 2 * (x * b - y * a)];
    const at = vehicle.position.subarray(3 * stop, 3 * stop + 3);
    return [
      at[0] + a + w * tx + y * tz - z * ty,
      at[1] + b + w * ty + z * tx - x * tz,
      at[2] + c + w * tz + x * ty - y * tx,
    ];
  };
  const arms = [[1, 1, 0], [-1, -1, 0], null, [1, -1, 0], [-1, 1, 0], null, [0, 0, 0], [1.6, 0, 0]]
    .map((tip) => tip && tip.map((value) => value * size));
  const columns = (rows) => [0, 1, 2].map((axis) => rows.map((row) => (row ? row[axis] : null)));

  const body = (vehicle, stop) => columns(arms.map((tip) => tip && place(vehicle, stop, tip)));
  const sight = (vehicle, stop) => columns([
    Array.from(vehicle.position.subarray(3 * stop, 3 * stop + 3)),
    Array.from(vehicle.aim.subarray(3 * stop, 3 * stop + 3)),
  ]);
  const trail = (index, stop) => {
    const { head, tail } = vehicles[index];
    return ["x", "y", "z"].map((axis) => Array.from(paths[index][axis].subarray(tail[stop], head[stop] + 1)));
  };

  const moving = vehicles.flatMap((vehicle) => [
    { type: "scatter3d", mode: "lines", name: "trail", line: { width: 10, color: vehicle.color }, opacity: 0.5 },
    { type: "scatter3d", mode: "lines", name: "vehicle", line: { width: 7, color: "#0f172a" } },
    { type: "scatter3d", mode: "lines+markers", name: data.aim, line: { width: 2, color: "#f97316" },
      marker: { size: [0.1, 5], color: "#f97316", line: { width: 0 } } },
  ]).map((trace) => ({ ...trace, x: [null], y: [null], z: [null], hoverinfo: "skip", showlegend: trace.name === data.aim && vehicles.length === 1 }));
  const firstMoving = data.space.data.length;
  const movingIndices = moving.map((_, index) => firstMoving + index);

  const marks = vehicles.map((vehicle) => ({ type: "scatter", mode: "markers", x: [null], y: [null],
    marker: { size: 12, color: vehicle.color, line: { width: 2, color: "#0f172a" } }, hoverinfo: "skip", showlegend: false }));
  const firstMark = data.plan.data.length;

  // Moving obstacles: where their points are at time 0, and how far they have moved at every stop.
  const shifts = data.shifts.map(numbers);
  const movers = [[space, data.space.data, "xyz"], [above, data.plan.data, "xy"]].map(([plot, traces, axes]) => {
    const found = traces.filter((trace) => trace.meta === "mover");
    const origins = found.map((trace) => [...axes].map((axis) => numbers(trace[axis])));
    return { plot, axes, origins, indices: found.map((trace) => traces.indexOf(trace)) };
  });
  const moveObstacles = (stop) => {
    for (const { plot, axes, origins, indices } of movers) {
      if (!indices.length) continue;
      Plotly.restyle(plot, Object.fromEntries([...axes].map((axis, number) => [axis,
        origins.map((origin, mover) => Array.from(origin[number], (value) => value + shifts[mover][3 * stop + number])),
      ])), indices);
    }
  };

  const show = (stop) => {
    moveObstacles(stop);
    const time = data.stops[stop];
    const lines = vehicles.flatMap((vehicle, index) => [trail(index, stop), body(vehicle, stop), sight(vehicle, stop)]);
    Plotly.restyle(space, { x: lines.map((line) => line[0]), y: lines.map((line) => line[1]), z: lines.map((line) => line[2]) },
      movingIndices);
    Plotly.restyle(above, {
      x: vehicles.map((vehicle) => [vehicle.position[3 * stop]]),
      y: vehicles.map((vehicle) => [vehicle.position[3 * stop + 1]]),
    }, marks.map((_, index) => firstMark + index));
    Plotly.relayout(times, { "shapes[0].x0": time, "shapes[0].x1": time });
    const first = vehicles[0];
    now.textContent = `${time.toFixed(2)} s` + (vehicles.length > 1 ? "" :
      ` · ${first.speed_at[stop].toFixed(2)} m/s · error ${first.error_at[stop].toFixed(3)} m`);
  };

  const paint = () => {
    const kind = coloring.value;
    const plain = kind === "flight";
    const top = plain ? 1 : vehicles.reduce((most, vehicle) =>
      vehicle[kind].reduce((a, b) => Math.max(a, b || 0), most), data.least[kind]);
    vehicles.forEach((vehicle, index) => {
      Plotly.restyle(space, {
        line: [plain ? { width: 7, color: vehicle.color } : {
          width: 7, color: Array.from(vehicle[kind]), cmin: 0, cmax: top, colorscale: data.scale, showscale: index === 0,
          colorbar: { title: { text: kind === "speed" ? "speed (m/s)" : "error (m)", side: "right" },
            thickness: 12, len: 0.7, x: 1 },
        }],
      }, [firstFlown + index]);
    });
  };

  let timer = null;
  const stop = () => { clearInterval(timer); timer = null; play.textContent = "▶"; play.setAttribute("aria-label", "Play"); };
  const start = () => {
    play.textContent = "⏸";
    play.setAttribute("aria-label", "Pause");
    if (+slider.value >= +slider.max) slider.value = 0;
    const began = performance.now(), from = data.stops[+slider.value];
    const rate = Math.max(1, (data.stops[data.stops.length - 1] - data.stops[0]) / 30);
    timer = setInterval(() => {
      const time = from + rate * (performance.now() - began) / 1000;
      let next = +slider.value;
      while (next < +slider.max && data.stops[next] < time) next += 1;
      if (next !== +slider.value) { slider.value = next; show(next); }
      if (next >= +slider.max) stop();
    }, 50);
  };

  slider.max = data.stops.length - 1;
  slider.addEventListener("input", () => show(+slider.value));
  play.addEventListener("click", () => (timer ? stop() : start()));
  coloring.addEventListener("change", paint);
  if (vehicles.length > 1) coloring.value = "flight";

  data.times.layout.shapes = [{ type: "line", yref: "paper", y0: 0, y1: 1, x0: 0, x1: 0,
    line: { color: "#0f172a", width: 1 } }];
  Promise.all([
    Plotly.newPlot(space, [...data.space.data, ...moving], data.space.layout, options),
    Plotly.newPlot(above, [...data.plan.data, ...marks], data.plan.layout, options),
    Plotly.newPlot(times, data.times.data, data.times.layout, options),
  ]).then(() => {
    paint();
    show(0);
    document.body.dataset.ready = "yes";
  });
})();
