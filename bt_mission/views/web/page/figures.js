// Charts against time, with the stretch of time and the cursor that the timeline has, too.

import { countUntil } from "./recorded.js";
import { element } from "./words.js";

const HEIGHT = 100;
const [TOP, BOTTOM] = [10, 92];
const PLAIN = 4; // digits

const svg = (tag, attributes) => {
  const made = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  return made;
};

export const plain = (value) => String(+value.toPrecision(PLAIN));

export class Figure {
  // chart: { name, unit, t, v, least }. instants: of a requirement, [class, time] of each.
  constructor(zoom, chart, instants = null) {
    Object.assign(this, { zoom, chart });
    const { t, v } = chart;
    let low = v.reduce((least, value) => Math.min(least, value), chart.least ?? Infinity);
    let high = v.reduce((most, value) => Math.max(most, value), instants ? 0 : -Infinity);
    if (high - low < 1e-6) high = low + 1;
    const y = (value) => BOTTOM - ((BOTTOM - TOP) * (value - low)) / (high - low);
    this.drawing = svg("svg", { preserveAspectRatio: "none", role: "img", class: instants ? "line margin" : "line" });
    this.drawing.setAttribute("aria-label", `${chart.name}${chart.unit ? `, ${chart.unit}` : ""}: ${plain(low)} to ${plain(high)}`);
    if (instants) this.drawing.append(svg("rect", { class: "below", x: 0, y: y(0), width: zoom.duration, height: Math.max(HEIGHT - y(0), 0) }));
    this.drawing.append(svg("polyline", { points: t.map((at, index) => `${at},${y(v[index]).toFixed(2)}`).join(" ") }));
    for (const [name, at] of instants ?? []) {
      if (at !== null) this.drawing.append(svg("line", { class: `instant ${name}`, x1: at, x2: at, y1: 0, y2: HEIGHT }));
    }
    const labels = (instants ? [high, 0, low] : [high, low]).filter((value, index, all) => all.indexOf(value) === index && (!instants || value === 0 || Math.abs(y(value) - y(0)) > TOP));
    this.value = element("span", "value");
    this.cursor = element("i", "cursor");
    const frame = element("div", "frame", this.drawing, this.cursor, ...labels.map((value) => {
      const label = element("span", "label", plain(value));
      label.style.top = `${y(value)}%`;
      return label;
    }));
    this.element = element("div", "figure", element("h3", "", chart.name, " ", element("small", "", chart.unit)), this.value, frame);
    this.draw = () => this.drawing.setAttribute("viewBox", `${zoom.begin} 0 ${zoom.length} ${HEIGHT}`);
    zoom.drawings.add(this.draw);
    zoom.listen(frame);
    this.draw();
  }

  look() {
    const { zoom, chart: { t, v, unit } } = this;
    this.cursor.style.left = `${100 * zoom.share(zoom.at)}%`;
    const count = countUntil(t, zoom.at + 1e-6);
    this.value.textContent = count ? `${plain(v[count - 1])} ${unit}` : "";
  }

  remove() {
    this.zoom.drawings.delete(this.draw);
    this.element.remove();
  }
}

export class Axis {
  constructor(zoom) {
    this.zoom = zoom;
    this.element = element("div", "axis");
    this.element.setAttribute("aria-hidden", "true");
    zoom.drawings.add(() => this.draw());
    new ResizeObserver(() => this.draw()).observe(this.element);
  }

  draw() {
    this.element.replaceChildren(...this.zoom.marks(this.element.clientWidth).map((at) => {
      const mark = element("span", "", `${plain(at)} s`);
      mark.style.left = `${100 * this.zoom.share(at)}%`;
      return mark;
    }));
  }
}
