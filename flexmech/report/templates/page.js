// Moves the linkage and the cursors. Plotly draws each plot once; while the crank turns only SVG
// elements of this script change. The files of this folder are one script, in this order: page,
// linkage, plots, controls; all of it stands in one function.
"use strict";
(() => {
  const SVG = "http://www.w3.org/2000/svg";
  const page = JSON.parse(document.getElementById("data").textContent);
  const arrays = page.arrays.map(decoded);
  const chosen = { angle: 0 };
  const plots = [];
  const byId = (id) => document.getElementById(id);
  let linkage = null;
  let readings = [];
  let pending = false;
  let playing = false;

  function decoded(text) {
    const letters = atob(text);
    const bytes = new Uint8Array(letters.length);
    for (let n = 0; n < letters.length; n += 1) bytes[n] = letters.charCodeAt(n);
    return new Float32Array(bytes.buffer);
  }

  function element(name, attributes, parent) {
    const made = document.createElementNS(SVG, name);
    for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
    if (parent) parent.append(made);
    return made;
  }

  // ---- what is chosen ------------------------------------------------------------------------

  function isChosen(when) {
    return Object.entries(when).every(([key, name]) => chosen[key] === name);
  }

  function speedValue() {
    const found = page.choices.speed.find((each) => each.name === chosen.speed);
    return found ? found.value : null;
  }

  // Where an angle lies among increasing ones: the number before it and the share of the step.
  function placeOf(angles, angle) {
    const last = angles.length - 1;
    if (last < 0 || angle < angles[0] - 1e-4 || angle > angles[last] + 1e-4) return null;
    let low = 0;
    let high = last;
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (angles[middle] <= angle) low = middle;
      else high = middle;
    }
    const step = angles[high] - angles[low];
    const share = step > 0 ? Math.min(1, Math.max(0, (angle - angles[low]) / step)) : 0;
    if (share < 1e-4) return { low, high: low, share: 0 };
    if (share > 1 - 1e-4) return { low: high, high, share: 0 };
    return { low, high, share };
  }

  function between(values, place, width = 1, offset = 0) {
    const first = values[place.low * width + offset];
    if (!place.share) return first;
    return first + place.share * (values[place.high * width + offset] - first);
  }
