  // ---- plots ---------------------------------------------------------------------------------

  function colourOf(colour) {
    if (colour === "critical") return "rgb(1, 1, 1)";
    return typeof colour === "number" ? page.colours[colour % page.colours.length] : colour;
  }

  function plotlyTrace(trace) {
    const axis = trace.axis ? String(trace.axis + 1) : "";
    const filled = trace.fill !== "none";
    const colour = colourOf(trace.colour);
    return {
      type: "scatter", name: trace.name, legendgroup: trace.name, showlegend: trace.legend,
      x: arrays[trace.x], y: arrays[trace.y], yaxis: `y${axis}`, xaxis: "x",
      mode: trace.look === "points" ? "markers" : trace.symbol ? "lines+markers" : "lines", visible: isChosen(trace.when),
      line: { color: trace.fill === "to previous" ? "rgba(0,0,0,0)" : colour, width: trace.width, dash: trace.look === "points" ? "solid" : trace.look, simplify: false },
      marker: { color: colour, symbol: trace.symbol || "circle", size: trace.look === "points" ? Math.max(5, trace.width) : 5 },
      fill: { none: "none", "to previous": "tonexty", itself: "toself" }[trace.fill],
      fillcolor: filled ? colour : undefined, hoverinfo: filled ? "skip" : "x+y+name",
      connectgaps: false, ...labelOf(trace),
    };
  }

  // A text at the last point of a line.
  function labelOf(trace) {
    if (!trace.label) return {};
    const text = Array.from(arrays[trace.x], (_, n) => (n === arrays[trace.x].length - 1 ? trace.label : ""));
    return { mode: "lines+text", text, textposition: "middle right", cliponaxis: false, textfont: { size: 10 } };
  }

  function plotlyLayout(spec, width) {
    const count = spec.axes.length;
    const layout = {
      margin: { l: spec.axes.some((axis) => axis.title.includes("<br>")) ? 84 : 70, r: spec.traces.some((trace) => trace.label) ? 58 : 14, t: 8, b: 46 }, height: spec.height, width,
      paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)",
      font: { family: "system-ui, sans-serif", size: 12 }, hovermode: "closest",
      legend: { orientation: "h", x: 0, y: 1, yanchor: "bottom", font: { size: 12 } },
      xaxis: { title: { text: spec.xTitle, standoff: 8 }, zeroline: false, showline: true, ticks: "outside", ticklabeloverflow: "allow", anchor: count > 1 ? `y${count}` : "y" },
      dragmode: width < 500 ? false : "zoom",
    };
    if (spec.tick) layout.xaxis.dtick = spec.tick;
    if (spec.named.length) Object.assign(layout.xaxis, { tickvals: spec.named.map((_, n) => n + 1), ticktext: spec.named });
    if (spec.ends.length) layout.xaxis.range = spec.ends;
    const legend = spec.traces.some((trace) => trace.legend);
    layout.showlegend = legend;
    if (legend) layout.margin.t = 34;
    const whole = spec.axes.reduce((sum, axis) => sum + axis.height, 0);
    let top = 1;
    spec.axes.forEach((axis, n) => {
      const part = axis.height / whole;
      const name = n ? `yaxis${n + 1}` : "yaxis";
      layout[name] = {
        title: { text: axis.title, standoff: 14 }, domain: [Math.max(top - part + (n < count - 1 ? 0.03 : 0), 0), top],
        type: axis.logarithmic ? "log" : "linear", zeroline: false, showline: true, ticks: "outside", nticks: count > 1 ? 4 : 7, ticklabeloverflow: "allow",
        exponentformat: "power",
      };
      if (axis.ends.length) layout[name].range = axis.ends;
      if (axis.rows.length) Object.assign(layout[name], { range: [axis.rows.length + 0.6, 0.4], tickvals: axis.rows.map((_, row) => row + 1), ticktext: axis.rows });
      top -= part;
    });
    if (spec.equal) Object.assign(layout.yaxis, { scaleanchor: "x", scaleratio: 1 });
    return layout;
  }

  function makePlot(spec) {
    const host = byId(`plot-${spec.name}`);
    const plot = { spec, host, cursors: element("svg", { class: "cursors" }, null), dots: [] };
    const drawn = Plotly.newPlot(host, spec.traces.map(plotlyTrace), plotlyLayout(spec, host.clientWidth),
      { displaylogo: false, responsive: false, displayModeBar: "hover", scrollZoom: false,
        // Nothing of a page leaves the machine that it is read on.
        modeBarButtonsToRemove: ["select2d", "lasso2d", "autoScale2d", "sendChartToCloud"] });
    host.append(plot.cursors);
    plot.line = element("line", { visibility: "hidden" }, plot.cursors);
    plot.nothing = document.createElement("p");
    plot.nothing.className = "nothing";
    host.append(plot.nothing);
    host.on("plotly_afterplot", () => { scaleForPrint(plot); placeCursor(plot); });
    plots.push(plot);
    followTraces(plot);
    scaleForPrint(plot);
    placeCursor(plot);
    return drawn;
  }

  // Drawings of fixed size become ones that paper scales.
  function scaleForPrint({ host, cursors }) {
    const { width, height } = host._fullLayout;
    for (const svg of [...host.querySelectorAll(".main-svg"), cursors]) svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
    cursors.setAttribute("width", width);
    cursors.setAttribute("height", height);
    host.style.setProperty("--ratio", `${width} / ${height}`);
  }

  function followTraces(plot) {
    for (const dot of plot.dots) dot.circle.remove();
    plot.dots = plot.spec.traces
      .filter((trace) => trace.followed && isChosen(trace.when) && isChosen(trace.followed))
      .map((trace) => ({ trace, circle: element("circle", { r: 4, style: trace.colour === "critical" ? "" : `stroke:${colourOf(trace.colour)}` }, plot.cursors) }));
    const shown = plot.spec.traces.some((trace) => isChosen(trace.when));
    plot.nothing.textContent = shown ? "" : `nothing was computed for ${["speed", "engine", "state"].map((key) => chosen[key]).filter(Boolean).join(", ")}`;
  }

  function cursorPlace(plot) {
    if (plot.spec.cursor === "speed") {
      const speed = speedValue();
      return speed === null ? null : plot.spec.speedScale * speed;
    }
    return plot.spec.cursor === "none" ? null : chosen.angle;
  }

  function placeCursor(plot) {
    const { host, spec, line } = plot;
    const at = cursorPlace(plot);
    const layout = host._fullLayout;
    const x = layout.xaxis;
    const pixel = at === null ? NaN : x._offset + x.l2p(at);
    const inside = spec.cursor !== "point" && pixel >= x._offset - 1 && pixel <= x._offset + x._length + 1;
    line.setAttribute("visibility", inside ? "visible" : "hidden");
    if (inside) {
      const last = layout[spec.axes.length > 1 ? `yaxis${spec.axes.length}` : "yaxis"];
      line.setAttribute("x1", pixel);
      line.setAttribute("x2", pixel);
      line.setAttribute("y1", layout.yaxis._offset);
      line.setAttribute("y2", last._offset + last._length);
    }
    for (const dot of plot.dots) placeDot(dot, at, layout);
  }

  function placeDot({ trace, circle }, at, layout) {
    const along = arrays[trace.angle === null ? trace.x : trace.angle];
    const place = at === null ? null : placeOf(along, at);
    const value = place ? between(arrays[trace.y], place) : NaN;
    const axis = layout[trace.axis ? `yaxis${trace.axis + 1}` : "yaxis"];
    const across = trace.angle === null ? at : place && between(arrays[trace.x], place);
    const cx = layout.xaxis._offset + layout.xaxis.l2p(across);
    const cy = axis._offset + axis.l2p(axis.type === "log" ? Math.log10(value) : value);
    const shown = Number.isFinite(cx) && Number.isFinite(cy) && cy >= axis._offset - 1 && cy <= axis._offset + axis._length + 1;
    circle.setAttribute("visibility", shown ? "visible" : "hidden");
    if (!shown) return;
    circle.setAttribute("cx", cx);
    circle.setAttribute("cy", cy);
  }
