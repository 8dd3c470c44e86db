  // ---- the linkage ---------------------------------------------------------------------------

  function makeLinkage() {
    const root = byId("linkage");
    if (!root) return;
    const given = page.linkage;
    const [left, low, right, high] = given.box;
    const room = 0.11 * given.extent;
    const size = [right - left + 2 * room, high - low + 2 * room];
    root.setAttribute("viewBox", [left - room, -high - room, ...size].join(" "));
    linkage = { given, root, size: given.extent, letters: 0.045 * Math.max(size[0], size[1]) };
    drawSupports();
    if (given.path) element("path", { class: "path", d: pathOf(arrays[given.path.places]) }, root);
    const blocks = given.joints.map((joint) => (joint.direction === null ? null : makeBlock(root, joint)));
    for (const kind of ["rigid", "run", "shape"]) {
      linkage[kind] = given.links.map((link) => {
        const look = kind === "rigid" && link.rigid ? "rigid stiff" : kind;
        return element("polyline", { class: look }, root);
      });
    }
    const parts = makeParts(root);
    linkage.joints = given.joints.map((joint, n) => {
      const kind = joint.kind === "clamp" ? "joint clamp" : joint.turns ? "joint" : "hidden";
      const half = 0.017 * linkage.size;
      const weld = joint.welded ? element("rect", { class: "weld", x: -half, y: -half, width: 2 * half, height: 2 * half }, root) : null;
      const circle = element("circle", { class: kind, r: 0.013 * linkage.size }, root);
      const name = element("text", { "font-size": linkage.letters }, root);
      name.textContent = joint.name;
      const at = [joint.link, joint.end === "start" ? 0 : 1];
      return { ...joint, circle, name, block: blocks[n], weld, loaded: given.parts.loads.some((load) => `${load.at}` === `${at}`) };
    });
    linkage.parts = [...parts, ...makeLoads(root)];
    drawGravity(root, given.box, room);
    const bar = roundLength(0.25 * linkage.size);
    const [x, y] = [left - room / 2, -low + 0.75 * room];
    element("path", { class: "bar", d: `M${x} ${y}h${bar}` }, root);
    const words = element("text", { class: "small", x, y: y - 0.2 * linkage.letters, "font-size": 0.8 * linkage.letters }, root);
    words.textContent = `${Number((1e3 * bar).toPrecision(3))} mm`;
  }

  // What slides on a line, with a piece of the line: hatched below where the ground carries it.
  function makeBlock(root, joint) {
    const [long, high] = [SIZES.block * linkage.size, 0.6 * SIZES.block * linkage.size];
    const block = element("g", {}, root);
    if (joint.guide === null) {
      const side = Math.cos(joint.direction) < -1e-9 ? -1 : 1;
      const rail = `M${-4 * long} ${high}h${8 * long}${hatching(-4 * long, 4 * long, high, 0.8 * high)}`;
      element("path", { class: "ground", d: rail, transform: `scale(${side})` }, block);
    } else element("path", { class: "guide", d: `M${-4 * long} 0h${8 * long}` }, block);
    element("rect", { class: "joint", x: -long, y: -high, width: 2 * long, height: 2 * high }, block);
    return block;
  }

  function pathOf(places) {
    let text = "";
    for (let i = 0; i < places.length; i += 2) text += `${i ? "L" : "M"}${places[i]} ${-places[i + 1]}`;
    return text;
  }

  function roundLength(length) {
    const decade = 10 ** Math.floor(Math.log10(length));
    return decade * [1, 2, 5].filter((n) => n * decade <= length).pop();
  }

  function drawSupports() {
    const { given, root, size } = linkage;
    const place = placeOf(arrays[given.angle], arrays[given.angle][0]);
    for (const joint of given.joints.filter((each) => ["clamp", "pivot"].includes(each.kind))) {
      const frame = frameOf(given.links[joint.link], place);
      const [x, y] = pointOf(frame, joint.end === "start" ? 0 : given.links[joint.link].length, 0);
      const [half, deep] = [0.028 * size, 0.05 * size];
      const ground = `M${x} ${-y}l${-half} ${deep}h${2 * half}zm${-1.8 * half} ${deep}h${3.6 * half}`;
      element("path", { class: "ground", d: ground + hatching(x - 1.8 * half, x + 1.8 * half, -y + deep, 0.025 * size) }, root);
      if (joint.kind === "clamp") element("circle", { class: "shaft", cx: x, cy: -y, r: 0.026 * size }, root);
    }
  }

  function frameOf(link, place) {
    const origin = arrays[link.origin];
    const turn = between(arrays[link.turn], place);
    return { x: between(origin, place, 2, 0), y: between(origin, place, 2, 1), cos: Math.cos(turn), sin: Math.sin(turn) };
  }

  function pointOf(frame, along, across) {
    return [frame.x + frame.cos * along - frame.sin * across, frame.y + frame.sin * along + frame.cos * across];
  }

  // Points of every link, its displacements (stored in its frame) times a factor.
  function displaced(frames, stored, factor) {
    const values = arrays[stored.values];
    const place = placeOf(arrays[stored.angle], chosen.angle);
    const count = stored.stations;
    const width = frames.length * count * 2;
    return frames.map((frame, number) => {
      const { length } = linkage.given.links[number];
      const points = [];
      for (let station = 0; station < count; station += 1) {
        const offset = (number * count + station) * 2;
        const u = place ? factor * between(values, place, width, offset) : 0;
        const v = place ? factor * between(values, place, width, offset + 1) : 0;
        points.push(pointOf(frame, (length * station) / (count - 1) + u, v));
      }
      return points;
    });
  }

  function setPoints(line, points) {
    line.setAttribute("points", points.map(([x, y]) => `${x.toFixed(6)},${(-y).toFixed(6)}`).join(" "));
  }

  function drawLinkage() {
    if (!linkage) return;
    const { given } = linkage;
    const place = placeOf(arrays[given.angle], chosen.angle);
    if (!place) return;
    const frames = given.links.map((link) => frameOf(link, place));
    const ends = frames.map((frame, n) => [pointOf(frame, 0, 0), pointOf(frame, given.links[n].length, 0)]);
    ends.forEach((points, n) => setPoints(linkage.rigid[n], points));
    const amplitude = Number(byId("amplitude").value);
    const shape = given.shapes.find((each) => isChosen(each.when));
    drawDisplaced("shape", frames, shape, amplitude * given.enlargedTo * linkage.size);
    const run = byId("show-run").checked ? given.runs.find((each) => isChosen(each.when)) : null;
    drawDisplaced("run", frames, run, run ? run.enlargement : 0);
    for (const joint of linkage.joints) {
      const [x, y] = ends[joint.link][joint.end === "start" ? 0 : 1];
      if (joint.block) {
        const frame = joint.guide === null ? { cos: 1, sin: 0 } : frames[joint.guide];
        const turned = Math.atan2(frame.sin, frame.cos) + joint.direction;
        joint.block.setAttribute("transform", `translate(${x} ${-y}) rotate(${(-turned * 180) / Math.PI})`);
      }
      if (joint.weld) {
        const { cos, sin } = frames[joint.link];
        moveTo(joint.weld, [x, y], Math.atan2(sin, cos));
      }
      joint.circle.setAttribute("cx", x);
      joint.circle.setAttribute("cy", -y);
      // Beside the arrows of loads.
      joint.name.setAttribute("text-anchor", joint.loaded ? "end" : "start");
      joint.name.setAttribute("x", x + (joint.loaded ? -0.022 : joint.kind === "clamp" ? 0.034 : 0.022) * linkage.size);
      joint.name.setAttribute("y", -y - (joint.loaded ? 0.035 : 0.022) * linkage.size);
    }
    for (const move of linkage.parts) move(frames);
  }

  function drawDisplaced(kind, frames, stored, factor) {
    const there = stored && placeOf(arrays[stored.angle], chosen.angle);
    const points = there ? displaced(frames, stored, factor) : null;
    linkage[kind].forEach((line, n) => {
      line.setAttribute("visibility", points ? "visible" : "hidden");
      if (points) setPoints(line, points[n]);
    });
  }

  function writeLegend() {
    if (!linkage) return;
    const parts = ["<span>grey: rigid links</span>"];
    if (linkage.given.shapes.some((each) => isChosen(each.when))) parts.push("<b class=\"shape\">solid: mode shape</b>, amplitude free");
    const run = linkage.given.runs.find((each) => isChosen(each.when));
    if (run && byId("show-run").checked) parts.push(`<b class="run">dashed: deflection</b>, enlarged ${run.enlargement} times`);
    else if (linkage.given.runs.length) parts.push("no run at this choice");
    for (const [kind, words] of [["bodies", "crossed circle: centre of a body"], ["masses", "disc: point mass"]]) {
      if (linkage.given.parts[kind].length) parts.push(words);
    }
    const [fixed, varying] = [false, true].map((varies) => linkage.given.parts.loads.some((load) => (load.over !== "constant") === varies));
    if (fixed) parts.push("black arrow: load");
    if (varying) parts.push("dashed arrow: load that varies, where it is largest");
    const { springs, joint_springs: inJoints, gravity } = linkage.given.parts;
    if (springs.some((one) => one.damped) || inJoints.some((one) => one.torsion_damped)) parts.push("piston in a cup: damper");
    if (Math.hypot(...gravity)) parts.push(`grey arrow: gravity (${Number(Math.hypot(...gravity).toPrecision(4))} m/s²)`);
    byId("linkage-legend").innerHTML = parts.join("; ");
  }

  // ---- numbers at the crank angle ------------------------------------------------------------

  function makeReadings() {
    const parent = byId("readings");
    if (!parent) return;
    parent.replaceChildren();
    readings = page.readings.filter((each) => isChosen(each.when)).map((each) => ({ ...each }));
    for (const group of new Set(readings.map((each) => each.group))) {
      const table = document.createElement("table");
      table.createCaption().textContent = group;
      for (const reading of readings.filter((each) => each.group === group)) {
        const row = table.insertRow();
        if (reading.mode && chosen.mode === `mode ${reading.mode}`) row.className = "chosen";
        row.insertCell().textContent = reading.label;
        reading.cell = row.insertCell();
        reading.cell.className = "number";
        reading.cell.dataset.reading = `${reading.group}, ${reading.label}`;
        const error = reading.error === null ? "" : ` ± ${reading.error.toPrecision(1)}`;
        reading.after = `${error} ${reading.unit}`;
      }
      parent.append(table);
    }
  }

  function writeReadings() {
    for (const reading of readings) {
      const place = placeOf(arrays[reading.angle], chosen.angle);
      const value = place ? between(arrays[reading.value], place) : NaN;
      const about = place && place.share ? "≈ " : "";
      reading.cell.textContent = Number.isFinite(value) ? `${about}${value.toFixed(reading.decimals)}${reading.after}` : "–";
    }
  }
