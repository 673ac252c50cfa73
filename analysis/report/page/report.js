// Draws the charts and views of the page with plotly. Without this script the images stay.
(async () => {
  "use strict";
  const narrow = 460;
  // Of the views: the mill in the scene, and the diameter of a ball of radius R over the height.
  const ZOOM = 2, SCALE = 0.36;
  const text = async (id) => {
    const packed = document.getElementById(id).textContent;
    const bytes = Uint8Array.from(atob(packed), (c) => c.charCodeAt(0));
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
    return new Response(stream).text();
  };
  // Printing shows all that is folded.
  let opened = [];
  addEventListener("beforeprint", () => {
    opened = [...document.querySelectorAll("details:not([open])")];
    opened.forEach((d) => (d.open = true));
  });
  addEventListener("afterprint", () => opened.forEach((d) => (d.open = false)));
  if (typeof DecompressionStream === "undefined") return;

  const script = document.createElement("script");
  script.textContent = await text("plotly");
  document.head.append(script);
  const { charts, views } = JSON.parse(await text("content"));
  const config = { responsive: true, displaylogo: false, scrollZoom: false };
  let angle = null;

  // Places the panels in a grid; on a phone one below the other.
  function layoutOf(chart, width) {
    const columns = width < narrow ? 1 : chart.columns;
    const rows = Math.ceil(chart.panels.length / columns);
    const names = [...new Set(chart.panels.flatMap((p) => p.lines.map((l) => l.name)))];
    const legend = 26 * Math.ceil((names.length * 170) / width) + 20;
    const row = chart.panels[0].equal
      ? width / columns
      : Math.max(190, (width * chart.aspect) / Math.ceil(chart.panels.length / chart.columns));
    const height = rows * Math.min(row, 520) + legend;
    const layout = {
      height, margin: { l: 62, r: 12, t: 26, b: 44 + legend }, paper_bgcolor: "#fff",
      plot_bgcolor: "#fff", font: { size: 12, color: "#1d2530" }, hovermode: "closest",
      legend: { orientation: "h", y: -50 / (height - 70 - legend), yanchor: "top" },
      annotations: [], shapes: [],
    };
    layout.shapes = bandsOf(chart);
    chart.panels.forEach((panel, i) => {
      const n = i ? i + 1 : "", column = i % columns, line = Math.floor(i / columns);
      const gapX = columns > 1 ? 0.1 : 0, gapY = rows > 1 ? (panel.title ? 84 : 62) / height : 0;
      const w = (1 - gapX * (columns - 1)) / columns, h = (1 - gapY * (rows - 1)) / rows;
      const x0 = column * (w + gapX), y0 = 1 - line * (h + gapY) - h;
      const axis = (a) => ({
        title: { text: a.title.replace("\n", "<br>"), standoff: 6 }, range: a.range,
        type: a.log ? "log" : "linear", gridcolor: "#e6e6e6", zeroline: false, automargin: true,
      });
      layout["xaxis" + n] = { ...axis(panel.x), domain: [x0, x0 + w], anchor: "y" + n };
      layout["yaxis" + n] = { ...axis(panel.y), domain: [y0, y0 + h], anchor: "x" + n };
      if (panel.equal) layout["yaxis" + n].scaleanchor = "x" + n;
      if (panel.title) {
        layout.annotations.push({ text: panel.title, showarrow: false, xref: "paper",
          yref: "paper", x: x0 + w / 2, y: y0 + h, xanchor: "center", yanchor: "bottom" });
      }
    });
    return layout;
  }

  function tracesOf(chart) {
    const seen = new Set();
    return chart.panels.flatMap((panel, i) => panel.lines.map((l) => {
      const first = l.name !== "" && !seen.has(l.name);
      seen.add(l.name);
      return { type: "scatter", x: l.x, y: l.y, name: l.name, mode: l.mode,
        legendgroup: l.name || "own" + i, showlegend: first,
        line: { color: l.color, dash: l.dash, width: l.width },
        marker: { color: l.color, symbol: l.symbol, size: l.size },
        hoverinfo: l.name ? "x+y+name" : "x+y",
        xaxis: "x" + (i ? i + 1 : ""), yaxis: "y" + (i ? i + 1 : "") };
    }));
  }

  const overAngle = (chart) => chart.panels.some((p) => p.x.title.startsWith("mill rotation angle"));
  const across = (i, x0, x1, rest) => ({ x0, x1, y0: 0, y1: 1, xref: "x" + (i ? i + 1 : ""),
    yref: "y" + (i ? i + 1 : "") + " domain", ...rest });
  const bandsOf = (chart) => chart.panels.flatMap((panel, i) => panel.bands.map((band) =>
    across(i, band.x0, band.x1, { type: "rect", layer: "below", fillcolor: band.color,
      line: { width: 0 }, label: { text: band.name, textposition: "top center" } })));
  // The mill angle of the views, as a line in every panel.
  const rule = (chart) => [...bandsOf(chart), ...chart.panels.map((_, i) =>
    across(i, angle, angle, { type: "line", line: { color: "#b3261e", width: 1.5 } }))];

  function drawChart(figure) {
    const chart = charts[figure.dataset.chart];
    const image = figure.querySelector("img");
    const plot = document.createElement("div");
    plot.className = "plot";
    plot.setAttribute("role", "group");
    plot.setAttribute("aria-label", image.alt + " (interactive)");
    image.before(plot);
    Plotly.newPlot(plot, tracesOf(chart), layoutOf(chart, figure.clientWidth), config);
    figure.classList.add("drawn");
    if (angle !== null && overAngle(chart)) Plotly.relayout(plot, { shapes: rule(chart) });
  }

  const decoded = (packed, Type) =>
    new Type(Uint8Array.from(atob(packed), (c) => c.charCodeAt(0)).buffer);

  // The balls of each class; of one class all of them.
  function ballsAt(view, i) {
    const places = decoded(view.frames[i].places, Int16Array);
    const speeds = decoded(view.frames[i].speeds, Uint8Array);
    const kinds = view.classes.length ? decoded(view.frames[i].kinds, Uint8Array) : null;
    const found = Array.from({ length: view.classes.length || 1 },
      () => ({ x: [], y: [], z: [], speed: [] }));
    const unit = 1.2 / 32767;
    for (let k = 0; k < speeds.length; ++k) {
      const of = found[kinds ? kinds[k] : 0];
      of.x.push(places[3 * k] * unit); of.y.push(places[3 * k + 1] * unit);
      of.z.push(places[3 * k + 2] * unit); of.speed.push((speeds[k] / 255) * view.top);
    }
    return found;
  }

  // Both ends of the liner and edges along the axis, as one line, turned by the mill angle.
  function linerAt(view, turned) {
    const c = Math.cos(turned), s = Math.sin(turned), x = [], y = [], z = [];
    const add = (k, side) => {
      const px = view.liner[0][k], pz = view.liner[1][k];
      x.push(px * c + pz * s); y.push(side * view.half); z.push(pz * c - px * s);
    };
    const n = view.liner[0].length;
    for (let k = 0; k < n; ++k) add(k, -1);
    for (let k = 0; k < n; ++k) add(k, 1);
    for (let k = 0; k < n; ++k) add(k, k % 2 ? -1 : 1);
    return { x, y, z };
  }

  function drawView(box) {
    const view = views[box.dataset.view], plot = box.querySelector(".plot");
    const slider = box.querySelector("input"), button = box.querySelector("button");
    const output = box.querySelector("output");
    box.hidden = false;
    const height = Math.min(560, plot.clientWidth), balls = ballsAt(view, 0);
    const liner = linerAt(view, view.angles[0]);
    const size = (ball) => Math.max(0.8, height * SCALE * ball);
    const bySpeed = (speed) => ({ size: size(view.ball), color: speed, cmin: 0, cmax: view.top,
      colorscale: "Viridis", colorbar: { title: { text: "speed / ωR", side: "top" }, thickness: 12,
        len: 0.9, orientation: "h", y: 0, yanchor: "top" } });
    const byClass = (kind) => ({ size: size(kind.ball), color: kind.color });
    const hidden = { visible: false, showspikes: false };
    Plotly.newPlot(plot, [
      ...balls.map(({ x, y, z, speed }, i) => ({ type: "scatter3d", mode: "markers", x, y, z,
        hoverinfo: "skip", name: view.classes.length ? view.classes[i].name : "",
        marker: { line: { width: 0 },
          ...(view.classes.length ? byClass(view.classes[i]) : bySpeed(speed)) } })),
      { type: "scatter3d", mode: "lines", ...liner, line: { color: "#7a828b", width: 2 },
        hoverinfo: "skip", showlegend: false },
    ], {
      height: height + 60, margin: { l: 0, r: 0, t: 0, b: 60 }, paper_bgcolor: "#fff",
      showlegend: view.classes.length > 0,
      legend: { orientation: "h", y: 0, yanchor: "top", itemsizing: "constant" },
      scene: { aspectmode: "manual", aspectratio: { x: ZOOM, y: ZOOM * view.half, z: ZOOM },
        xaxis: { ...hidden, range: [-1, 1] }, yaxis: { ...hidden, range: [-view.half, view.half] },
        zaxis: { ...hidden, range: [-1, 1] },
        camera: { eye: { x: 0.25, y: -1.6, z: 0.15 }, up: { x: 0, y: 0, z: 1 },
          projection: { type: "orthographic" } } },
    }, config);
    const show = async (frame) => {
      const at = ballsAt(view, frame), wall = linerAt(view, view.angles[frame]);
      slider.value = frame;
      angle = view.angles[frame];
      output.textContent = angle.toFixed(2) + " rad";
      slider.setAttribute("aria-valuetext", output.textContent);
      const all = [...at, wall], each = (axis) => all.map((one) => one[axis]);
      const colours = view.classes.length ? {} : { "marker.color": [at[0].speed] };
      await Plotly.restyle(plot, { x: each("x"), y: each("y"), z: each("z"), ...colours },
        all.map((_, k) => k));
      document.querySelectorAll("figure.drawn").forEach((figure) => {
        const chart = charts[figure.dataset.chart];
        if (overAngle(chart)) {
          Plotly.relayout(figure.querySelector(".plot"), { shapes: rule(chart) });
        }
      });
    };
    slider.addEventListener("input", () => show(Number(slider.value)));
    let playing = false;
    button.addEventListener("click", async () => {
      playing = !playing;
      button.textContent = playing ? "Pause" : "Play";
      while (playing) {
        await show((Number(slider.value) + 1) % view.frames.length);
        await new Promise((done) => setTimeout(done, 250));
      }
    });
    output.textContent = view.angles[0].toFixed(2) + " rad";
  }

  // Each is drawn when it comes near the window.
  const seen = new IntersectionObserver((entries) => entries.forEach((entry) => {
    if (!entry.isIntersecting) return;
    seen.unobserve(entry.target);
    if (entry.target.dataset.chart) drawChart(entry.target);
    else drawView(entry.target.querySelector(".view") || entry.target);
  }), { rootMargin: "300px" });
  document.querySelectorAll("figure.chart").forEach((figure) => seen.observe(figure));
  document.querySelectorAll(".view").forEach((view) => { view.hidden = false; seen.observe(view); });
  document.documentElement.dataset.ready = "true";
})();
