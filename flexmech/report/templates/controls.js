  // ---- what the reader does ------------------------------------------------------------------

  function redraw() {
    pending = false;
    const turned = byId("angle-now");
    if (turned) turned.textContent = `${Math.round(chosen.angle)}°`;
    drawLinkage();
    writeReadings();
    plots.forEach(placeCursor);
  }

  function redrawSoon() {
    if (pending) return;
    pending = true;
    requestAnimationFrame(redraw);
  }

  function turnTo(angle) {
    chosen.angle = angle;
    const slider = byId("angle");
    slider.setAttribute("aria-valuetext", `${Math.round(angle)} degrees`);
    redrawSoon();
  }

  function choose(key, name) {
    chosen[key] = name;
    for (const plot of plots) {
      followTraces(plot);
      if (plot.spec.traces.some((trace) => key in trace.when)) {
        Plotly.restyle(plot.host, { visible: plot.spec.traces.map((trace) => isChosen(trace.when)) });
      }
    }
    makeReadings();
    writeLegend();
    redrawSoon();
  }

  function makeControls() {
    for (const key of ["speed", "mode", "engine", "state"]) {
      const names = page.choices[key].map((each) => each.name);
      const start = key === "speed" || key === "state" ? names.length - 1 : 0;
      if (names.length) chosen[key] = names[start];
      const select = byId(`choose-${key}`);
      if (!select) continue;
      select.selectedIndex = start;
      select.addEventListener("change", () => choose(key, select.value));
    }
    const slider = byId("angle");
    if (!slider) return;
    const angles = arrays[page.linkage.angle];
    [slider.min, slider.max] = [angles[0], angles[angles.length - 1]];
    slider.value = String(Math.min(60, angles[angles.length - 1]));
    chosen.angle = Number(slider.value);
    slider.addEventListener("input", () => turnTo(Number(slider.value)));
    byId("amplitude").addEventListener("input", redrawSoon);
    byId("show-run").addEventListener("change", () => { writeLegend(); redrawSoon(); });
    byId("play").addEventListener("click", play);
    const still = window.matchMedia("(prefers-reduced-motion: reduce)").matches;
    if (document.body.classList.contains("brief") && !still) play();
  }

  function play() {
    playing = !playing;
    const button = byId("play");
    button.textContent = playing ? "Stop" : "Turn";
    button.setAttribute("aria-pressed", String(playing));
    if (playing) requestAnimationFrame((now) => turnOn(now, now));
  }

  // A turn takes six seconds; where the linkage cannot turn fully it goes back to its start.
  function turnOn(before, now) {
    if (!playing) return;
    const slider = byId("angle");
    const [first, last] = [Number(slider.min), Number(slider.max)];
    const angle = chosen.angle + ((now - before) * 60) / 1000;
    chosen.angle = angle > last ? first + ((angle - last) % (last - first || 1)) : angle;
    slider.value = String(Math.round(chosen.angle));
    redraw();
    requestAnimationFrame((next) => turnOn(now, next));
  }

  function makeTheme() {
    const root = document.documentElement;
    const dark = window.matchMedia("(prefers-color-scheme: dark)");
    const follow = () => { root.dataset.theme = dark.matches ? "dark" : "light"; };
    follow();
    dark.addEventListener("change", follow);
    byId("theme").addEventListener("click", () => { root.dataset.theme = root.dataset.theme === "dark" ? "light" : "dark"; });
  }

  // ---- tables --------------------------------------------------------------------------------

  function sortBy(table, column) {
    const heading = table.tHead.rows[0].cells[column];
    const upward = heading.getAttribute("aria-sort") !== "ascending";
    for (const each of table.tHead.rows[0].cells) each.removeAttribute("aria-sort");
    heading.setAttribute("aria-sort", upward ? "ascending" : "descending");
    const rows = [...table.tBodies[0].rows];
    const key = (row) => row.cells[column].textContent.trim();
    rows.sort((a, b) => (upward ? 1 : -1) * compared(key(a), key(b)));
    table.tBodies[0].append(...rows);
  }

  function compared(a, b) {
    const [x, y] = [a, b].map((text) => parseFloat(text.replace(/^[<>≈]\s*/, "").replace("−", "-")));
    if (Number.isNaN(x) && Number.isNaN(y)) return a.localeCompare(b);
    if (Number.isNaN(x)) return 1;
    return Number.isNaN(y) ? -1 : x - y;
  }

  function makeTables() {
    for (const table of document.querySelectorAll("table.sortable")) {
      [...table.tHead.rows[0].cells].forEach((cell, n) => cell.firstElementChild.addEventListener("click", () => sortBy(table, n)));
    }
  }

  function fitPlots() {
    for (const plot of plots) {
      const width = plot.host.clientWidth;
      if (width && Math.abs(width - plot.host._fullLayout.width) > 1) Plotly.relayout(plot.host, { width });
    }
  }

  // A screen that is not narrow has room for all that the answers say.
  if (window.innerWidth > 900) {
    for (const each of document.querySelectorAll(".answer details")) {
      each.open = true;
      each.classList.add("whole");
    }
  }

  makeTheme();
  makeControls();
  makeLinkage();
  makeReadings();
  makeTables();
  writeLegend();
  redraw();
  // What is on the screen comes first, each plot in a frame of its own, so that the page answers
  // meanwhile; then the others, when there is nothing else to do. Paper wants all of them at once.
  let waiting = [];
  const whenIdle = window.requestIdleCallback || ((call) => setTimeout(call, 1));

  function drawWaiting(next, done) {
    if (!waiting.length) {
      done();
      return;
    }
    makePlot(waiting.shift());
    next(() => drawWaiting(next, done));
  }

  function drawPlots() {
    const onScreen = (spec) => byId(`plot-${spec.name}`).getBoundingClientRect().top < window.innerHeight;
    const later = page.plots.filter((spec) => !onScreen(spec));
    const { dataset } = document.documentElement;
    waiting = page.plots.filter(onScreen);
    drawWaiting(requestAnimationFrame, () => {
      dataset.opened = "yes";
      performance.mark("opened");
      waiting = later;
      drawWaiting(whenIdle, () => { dataset.ready = "yes"; performance.mark("ready"); });
    });
  }

  function prepareForPaper() {
    while (waiting.length) makePlot(waiting.shift());
    for (const each of document.querySelectorAll("details")) each.open = true;
  }

  let resized = 0;
  window.addEventListener("resize", () => { clearTimeout(resized); resized = setTimeout(fitPlots, 120); });
  window.addEventListener("beforeprint", prepareForPaper);
  // Plotly stands behind this script: the linkage turns before it is read.
  document.addEventListener("DOMContentLoaded", drawPlots);
})();
