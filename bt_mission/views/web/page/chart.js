// One variable against time. A value that is not finite is null, and a gap.

import { byId } from "./words.js";

const [WIDTH, HEIGHT, EDGE] = [400, 110, 6];

const svg = (tag, attributes) => {
  const made = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  return made;
};

export function drawChart(store, name) {
  const values = name === null ? null : store.series.get(name);
  byId("chart").hidden = !values;
  if (!values) return;
  const drawing = byId("chart-drawing");
  const numbers = values.map((one) => one[1]).filter((value) => value !== null);
  if (!numbers.length) {
    byId("chart-title").textContent = `${name}: no number`;
    drawing.replaceChildren();
    byId("chart-range").replaceChildren();
    return;
  }
  const end = store.replay ? Math.max(store.replay.duration, values.at(-1)[0]) : Math.max(store.now, values.at(-1)[0]);
  const begin = store.replay ? 0 : values[0][0];
  const low = numbers.reduce((one, other) => Math.min(one, other));
  const high = numbers.reduce((one, other) => Math.max(one, other));
  const x = (at) => (WIDTH * (at - begin)) / Math.max(end - begin, 1e-9);
  const y = (value) => HEIGHT - EDGE - ((HEIGHT - 2 * EDGE) * (value - low)) / Math.max(high - low, 1e-9);
  const lines = [[]]; // a new one behind each value that is not finite
  values.forEach(([at, value], number) => {
    const until = values[number + 1]?.[0] ?? end; // a value holds until the next one
    if (value === null) lines.push([]);
    else lines.at(-1).push(...[at, until].map((time) => `${x(time).toFixed(1)},${y(value).toFixed(1)}`));
  });
  const shown = store.replay ? store.replay.at : store.past;
  drawing.replaceChildren(...lines.filter((points) => points.length).map((points) => svg("polyline", { points: points.join(" ") })));
  if (shown !== null) drawing.append(svg("line", { x1: x(shown), x2: x(shown), y1: 0, y2: HEIGHT }));
  byId("chart-title").textContent = `${name}: ${+low.toPrecision(6)} to ${+high.toPrecision(6)}${numbers.length < values.length ? ", and not finite" : ""}`;
  const range = byId("chart-range");
  range.replaceChildren(...[begin, end].map((at) => {
    const label = document.createElement("span");
    label.textContent = `${at.toFixed(1)} s`;
    return label;
  }));
}
