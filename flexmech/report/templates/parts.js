  // ---- what belongs to the linkage: masses, bodies, springs, dampers, loads -----------------------

  // Lengths are over the linkage's extent, as in the pictures of flexmech.plots.
  const SIZES = { mark: 0.017, block: 0.03, spring: 0.018, wall: 0.03, spiral: 0.04, arrow: 0.17, torque: 0.06, aside: 0.045 };

  // Elements below the joints; each part knows how it is placed by the frames of the links.
  function makeParts(root) {
    const { given, size } = linkage;
    const group = element("g", { class: "parts" }, root);
    const made = [];
    const largest = Math.max(...given.parts.masses.map((mass) => mass.kg));
    const name = (shape, words) => { element("title", {}, shape).textContent = words; };
    for (const spring of given.parts.springs) {
      const ends = (frames) => spring.ends.map((end) => endOf(end, frames));
      if (spring.stiff) {
        const line = element("polyline", { class: "spring" }, group);
        name(line, `spring ${spring.name}`);
        made.push((frames) => setPoints(line, zigzag(...ends(frames))));
      }
      if (spring.damped) {
        const damper = element("path", { class: "spring damper" }, group);
        name(damper, `damper ${spring.name}`);
        made.push((frames) => damper.setAttribute("d", dashpotPath(...ends(frames), spring.stiff)));
      }
      for (const [n, end] of spring.ends.entries()) {
        if (!end.ground) continue;
        const wall = element("path", { class: "ground" }, group);
        made.push((frames) => wall.setAttribute("d", wallAt(end.ground, endOf(spring.ends[1 - n], frames))));
      }
    }
    for (const body of given.parts.bodies) {
      const plate = element("polygon", { class: "plate" }, group);
      const arm = element("polyline", { class: "spring" }, group);
      const mark = element("path", { class: "body", d: `M${-SIZES.mark * size} 0h${2 * SIZES.mark * size}M0 ${-SIZES.mark * size}v${2 * SIZES.mark * size}M${SIZES.mark * size} 0A${SIZES.mark * size} ${SIZES.mark * size} 0 1 1 ${-SIZES.mark * size} 0A${SIZES.mark * size} ${SIZES.mark * size} 0 1 1 ${SIZES.mark * size} 0` }, group);
      name(mark, `body of ${body.kg} kg`);
      made.push((frames) => {
        const link = body.at[0];
        const along = body.at[1] * given.links[link].length;
        setPoints(plate, body.outline.map(([x, y]) => pointOf(frames[link], along + x, y)));
        const centre = pointOf(frames[link], along + body.offset[0], body.offset[1]);
        setPoints(arm, [pointOf(frames[link], along, 0), centre]);
        moveTo(mark, centre);
      });
    }
    for (const mass of given.parts.masses) {
      const disc = element("circle", { class: "mass", r: 0.025 * size * Math.sqrt(mass.kg / largest) }, group);
      name(disc, `point mass of ${mass.kg} kg`);
      made.push((frames) => moveTo(disc, placeAt(mass.at, frames)));
    }
    for (const spring of given.parts.joint_springs) {
      const { at } = given.parts.joints.find((joint) => joint.name === spring.joint);
      const looks = [spring.torsional ? ["spring", spiralPath()] : null, spring.radial ? ["bearing", ringPath(1)] : null, spring.torsion_damped ? ["spring damper", bentDashpotPath()] : null, spring.radially_damped ? ["bearing", ringPath(1.4)] : null];
      for (const [look, d] of looks.filter(Boolean)) {
        const shape = element("path", { class: look, d }, group);
        made.push((frames) => moveTo(shape, placeAt(at, frames)));
      }
    }
    return made;
  }

  // Arrows, above the joints.
  function makeLoads(root) {
    const { given, size } = linkage;
    const strength = (load) => Math.hypot(...load.force);
    const largest = Math.max(...given.parts.loads.map(strength));
    const made = [];
    for (const load of given.parts.loads) {
      const varies = load.over !== "constant";
      const add = (d) => {
        const group = element("g", { class: varies ? "load varies" : "load" }, root);
        const words = { constant: "load", crank_angle: "load over the crank angle", time: "load over time" };
        element("title", {}, group).textContent = `${words[load.over]}: ${load.name}`;
        element("path", { class: "shaft", d: d.shaft }, group);
        element("path", { class: "head", d: d.head }, group);
        return group;
      };
      if (strength(load) > 0) {
        const long = SIZES.arrow * size * (0.6 + (0.4 * strength(load)) / largest);
        const head = 0.38 * long;
        const gap = SIZES.block * size;
        const arrow = add({ shaft: `M${-long - gap} 0H${-head - gap}`, head: `M${-gap} 0l${-head} ${0.3 * head}v${-0.6 * head}z` });
        made.push((frames) => {
          const turned = load.axes === "link" ? frames[load.at[0]] : { cos: 1, sin: 0 };
          const angle = Math.atan2(load.force[1], load.force[0]) + Math.atan2(turned.sin, turned.cos);
          const place = placeAt(load.at, frames);
          // Beside a spring or a block on its line, on the upper side.
          const taken = given.parts.springs.some((spring) => spring.ends.some((end) => isAt(endOf(end, frames), place))) || given.parts.joints.some((joint) => joint.kind === "slider" && isAt(placeAt(joint.at, frames), place));
          const side = taken ? (Math.cos(angle) < 0 ? -1 : 1) * SIZES.aside * size : 0;
          moveTo(arrow, [place[0] - side * Math.sin(angle), place[1] + side * Math.cos(angle)], angle);
        });
      }
      if (load.torque) {
        const r = SIZES.torque * size;
        const bent = add({ shaft: `M${r / 2} ${0.866 * r}A${r} ${r} 0 1 0 ${-r} 0`, head: `M${-r} ${0.6 * r}l${0.3 * r} ${-0.6 * r}h${-0.6 * r}z` });
        made.push((frames) => moveTo(bent, placeAt(load.at, frames), 0, load.torque < 0));
      }
    }
    return made;
  }

  function placeAt(at, frames) {
    return pointOf(frames[at[0]], at[1] * linkage.given.links[at[0]].length, 0);
  }

  function endOf(end, frames) {
    return end.ground ?? placeAt(end.at, frames);
  }

  function isAt(one, other) {
    return Math.hypot(one[0] - other[0], one[1] - other[1]) < 1e-6 * linkage.size;
  }

  // A shape that is drawn around the origin, there; turned to the left by an angle in rad.
  function moveTo(shape, [x, y], angle = 0, mirrored = false) {
    shape.setAttribute("transform", `translate(${x} ${-y}) rotate(${(-angle * 180) / Math.PI})${mirrored ? " scale(1 -1)" : ""}`);
  }

  function zigzag(first, second) {
    const along = [second[0] - first[0], second[1] - first[1]];
    const long = Math.hypot(...along);
    const half = long ? (SIZES.spring * linkage.size) / long : 0;
    const points = [first];
    for (let n = 0; n <= 12; n += 1) {
      const share = 0.15 + (0.7 * n) / 12;
      const aside = n % 12 === 0 ? 0 : half * (n % 2 ? 1 : -1);
      points.push([first[0] + share * along[0] - aside * along[1], first[1] + share * along[1] + aside * along[0]]);
    }
    return [...points, second];
  }

  // A piston in an open cup: places along a line from 0 to 1, and across it in half widths of the cup.
  function dashpotLines(from, to, cup) {
    const middle = (from + to) / 2;
    return [
      [[from, 0], [middle, 0]],
      [[middle, -0.7], [middle, 0.7]],
      [[middle - cup, -1], [middle + cup, -1], [middle + cup, 1], [middle - cup, 1]],
      [[middle + cup, 0], [to, 0]],
    ];
  }

  function pathThrough(lines, placed) {
    return lines.map((line) => `M${line.map(([share, aside]) => { const [x, y] = placed(share, aside); return `${x} ${-y}`; }).join("L")}`).join("");
  }

  // From place to place, or below the spring that is there.
  function dashpotPath(first, second, beside) {
    const along = [second[0] - first[0], second[1] - first[1]];
    const long = Math.hypot(...along);
    const half = SIZES.spring * linkage.size;
    const down = along[0] < 0 || (along[0] === 0 && along[1] < 0) ? -1 : 1;
    const normal = long ? [(down * along[1]) / long, (-down * along[0]) / long] : [0, 0];
    const [from, to, away] = beside ? [0.12, 0.88, 2.4] : [0, 1, 0];
    const cup = long ? Math.min((1.5 * half) / long, 0.25) : 0;
    const lines = dashpotLines(from, to, cup);
    if (beside) lines.push([[from, -away], [from, 0]], [[to, -away], [to, 0]]);
    return pathThrough(lines, (share, aside) => [0, 1].map((n) => first[n] + share * along[n] + (aside + away) * half * normal[n]));
  }

  // Around the origin, above it.
  function bentDashpotPath() {
    const fine = dashpotLines(0, 1, 0.2).map((line) => line.flatMap((point, n) => (n ? Array.from({ length: 8 }, (_, m) => [0, 1].map((k) => line[n - 1][k] + ((m + 1) / 8) * (point[k] - line[n - 1][k]))) : [point])));
    return pathThrough(fine, (share, aside) => {
      const [turn, out] = [((25 + 130 * share) * Math.PI) / 180, 0.065 * linkage.size * (1 + 0.22 * aside)];
      return [out * Math.cos(turn), out * Math.sin(turn)];
    });
  }

  // The direction of gravity, in the upper left corner.
  function drawGravity(root, [left, , , high], room) {
    const [x, y] = linkage.given.parts.gravity;
    const strength = Math.hypot(x, y);
    if (!strength) return;
    const long = 0.14 * linkage.size;
    const arrow = element("g", { class: "gravity" }, root);
    element("title", {}, arrow).textContent = `gravity: ${Number(strength.toPrecision(4))} m/s²`;
    element("path", { class: "shaft", d: `M${-long / 2} 0H${0.15 * long}` }, arrow);
    element("path", { class: "head", d: `M${long / 2} 0l${-0.35 * long} ${0.12 * long}v${-0.24 * long}z` }, arrow);
    moveTo(arrow, [left - room / 3, high + room - 0.8 * long], Math.atan2(y, x));
  }

  // A hatched line across the direction from another place, hatched beyond it.
  function wallAt(place, other) {
    const half = SIZES.wall * linkage.size;
    const long = Math.hypot(place[0] - other[0], place[1] - other[1]) || 1;
    const [x, y] = [(place[0] - other[0]) / long, (place[1] - other[1]) / long];
    const at = (across, away) => [place[0] - across * y + away * x, place[1] + across * x + away * y];
    const text = ([a, b]) => `${a} ${-b}`;
    let path = `M${text(at(-half, 0))}L${text(at(half, 0))}`;
    for (const across of [-0.8, -0.4, 0, 0.4, 0.8]) path += `M${text(at(across * half, 0))}L${text(at((across - 0.4) * half, 0.6 * half))}`;
    return path;
  }

  function spiralPath() {
    const points = [];
    for (let n = 0; n <= 48; n += 1) {
      const [turn, out] = [(n * Math.PI) / 12, SIZES.spiral * linkage.size * (0.4 + (0.6 * n) / 48)];
      points.push(`${out * Math.cos(turn)} ${-out * Math.sin(turn)}`);
    }
    return `M${points.join("L")}`;
  }

  function ringPath(wide) {
    const r = 0.024 * wide * linkage.size;
    return `M${r} 0A${r} ${r} 0 1 1 ${-r} 0A${r} ${r} 0 1 1 ${r} 0`;
  }

  // Strokes below a line along x from one place to another.
  function hatching(from, to, y, deep) {
    let path = "";
    for (let x = from + deep / 2; x <= to; x += deep) path += `M${x} ${y}l${-deep / 2} ${deep}`;
    return path;
  }
