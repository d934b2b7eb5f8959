// The map: walls and zones, the robot and its way, what its lidar sees, where it is sent.

import { byId, goalStatus } from "./words.js";

const MARGIN = 0.3;
const LEAST = 3;
const ROBOT = 0.18;
const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };

export class MapView {
  // ask(isOpen): called when the panel is opened or closed. make(fault): one is to begin now.
  constructor(store, ask, make) {
    Object.assign(this, { store, make, cross: null, scaling: null });
    this.canvas = byId("map");
    this.toggle = byId("map-toggle");
    this.walls = null;
    this.isOpen = false;
    this.toggle.addEventListener("click", () => {
      this.isOpen = !this.isOpen;
      this.toggle.setAttribute("aria-expanded", this.isOpen);
      this.canvas.hidden = !this.isOpen;
      ask(this.isOpen);
      this.draw();
    });
    new ResizeObserver(() => this.draw()).observe(this.canvas);
    this.tool = byId("map-tool");
    this.tool.addEventListener("change", () => this.takeTool());
    this.canvas.addEventListener("click", (event) => {
      if (!this.tool.value || !this.scaling) return;
      const frame = this.canvas.getBoundingClientRect();
      this.cross = this.scaling.back(event.clientX - frame.left, event.clientY - frame.top);
      this.put();
    });
    this.canvas.addEventListener("keydown", (event) => this.key(event));
  }

  // With a tool the map can have the focus: its arrows move a cross, and Enter places.
  takeTool() {
    const isOn = Boolean(this.tool.value);
    this.canvas.classList.toggle("places", isOn);
    this.canvas.setAttribute("role", isOn ? "application" : "img");
    if (isOn) this.canvas.tabIndex = 0; else this.canvas.removeAttribute("tabindex");
    this.cross = isOn ? (this.store.robot.pose ?? [0, 0]).slice(0, 2) : null;
    if (isOn) this.canvas.focus();
    this.draw();
  }

  key(event) {
    if (!this.cross || event.ctrlKey || event.metaKey || event.altKey) return;
    const arrow = ARROWS[event.key];
    if (arrow) this.cross = this.cross.map((at, axis) => at + arrow[axis] * (event.shiftKey ? 0.01 : 0.1));
    else if (event.key === "Enter") this.put();
    else if (event.key === "Escape") { this.tool.value = ""; this.takeTool(); this.tool.focus(); }
    else return;
    event.preventDefault();
    event.stopPropagation();
    this.draw();
  }

  put() {
    this.make(`${this.tool.value} at (${this.cross.map((at) => at.toFixed(2)).join(", ")})`);
    this.draw();
  }

  // The map as a picture, a pixel for each cell.
  takeGrid() {
    const grid = this.store.robot.grid;
    this.walls = null;
    if (!grid) return;
    const picture = new OffscreenCanvas(grid.width, grid.height);
    const context = picture.getContext("2d");
    const image = context.createImageData(grid.width, grid.height);
    const style = getComputedStyle(document.documentElement);
    const colours = [[0, 0, 0, 0], rgba(style.getPropertyValue("--unknown")), rgba(style.getPropertyValue("--wall"))];
    let cell = 0;
    const known = { left: Infinity, right: -Infinity, low: Infinity, high: -Infinity };
    for (const [kind, count] of grid.runs) {
      for (let end = cell + count; cell < end; cell++) {
        const [column, row] = [cell % grid.width, Math.floor(cell / grid.width)];
        image.data.set(colours[kind], 4 * ((grid.height - 1 - row) * grid.width + column));
        if (kind === 1) continue;
        known.left = Math.min(known.left, column);
        known.right = Math.max(known.right, column + 1);
        known.low = Math.min(known.low, row);
        known.high = Math.max(known.high, row + 1);
      }
    }
    context.putImageData(image, 0, 0);
    this.walls = picture;
    this.known = known.left < Infinity ? known : null;
  }

  places() {
    const { robot } = this.store;
    const places = [...(robot.trail ?? []), ...(robot.way ?? []), ...(robot.targets ?? [])];
    if (this.walls && this.known) {
      const { left, right, low, high } = this.known;
      for (const [column, row] of [[left, low], [left, high], [right, low], [right, high]]) places.push(this.place(column, row));
    } else places.push(...this.seen());
    if (robot.pose) places.push(robot.pose);
    for (const [, ...pose] of robot.others ?? []) places.push(pose);
    for (const [, x, y, radius] of robot.zones ?? []) places.push([x - radius, y - radius], [x + radius, y + radius]);
    return places.filter(([x, y]) => Number.isFinite(x) && Number.isFinite(y));
  }

  // Where the lidar has seen something, m.
  seen() {
    const { scan = [] } = this.store.robot;
    return Array.from({ length: scan.length / 2 }, (_, index) => [scan[2 * index] / 100, scan[2 * index + 1] / 100]);
  }

  place(column, row) {
    const { resolution, origin: [x, y, yaw] } = this.store.robot.grid;
    const [across, along] = [column * resolution, row * resolution];
    return [x + Math.cos(yaw) * across - Math.sin(yaw) * along, y + Math.sin(yaw) * across + Math.cos(yaw) * along];
  }

  draw() {
    if (!this.isOpen) return;
    const { canvas, store } = this;
    const { robot } = store;
    const ratio = window.devicePixelRatio || 1;
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    if (!width || !height) return;
    if (canvas.width !== Math.round(width * ratio)) canvas.width = Math.round(width * ratio);
    if (canvas.height !== Math.round(height * ratio)) canvas.height = Math.round(height * ratio);
    const context = canvas.getContext("2d");
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, width, height);
    const frame = robot.frame && robot.frame !== "map" ? ` in ${robot.frame}` : "";
    const where = robot.pose ? `Map: x ${robot.pose[0].toFixed(2)}  y ${robot.pose[1].toFixed(2)} m${frame}` : "Map";
    byId("map-title").textContent = where;
    const places = this.places();
    if (!places.length) return;
    const xs = places.map((one) => one[0]);
    const ys = places.map((one) => one[1]);
    const least = (all) => all.reduce((one, other) => Math.min(one, other));
    const most = (all) => all.reduce((one, other) => Math.max(one, other));
    const [left, right, low, high] = [least(xs), most(xs), least(ys), most(ys)];
    const scale = Math.min(width / Math.max(right - left + 2 * MARGIN, LEAST), height / Math.max(high - low + 2 * MARGIN, LEAST));
    const x = (at) => width / 2 + (at - (left + right) / 2) * scale;
    const y = (at) => height / 2 - (at - (low + high) / 2) * scale;
    this.scaling = { back: (px, py) => [(px - width / 2) / scale + (left + right) / 2, (low + high) / 2 - (py - height / 2) / scale] };
    const style = getComputedStyle(document.documentElement);
    const colour = (name) => style.getPropertyValue(`--${name}`).trim();
    if (this.walls) this.drawWalls(context, x, y, scale);
    for (const zone of robot.zones ?? []) this.drawZone(context, zone, x, y, scale, colour("ink"));
    const trail = [...(robot.trail ?? []), ...(robot.pose ? [robot.pose] : [])];
    // Where a simulation knows the true way, the one that the robot assumes is dashed.
    const hasWay = Boolean(robot.way?.length);
    if (hasWay) this.drawLine(context, robot.way, x, y, colour("trail"));
    context.setLineDash(hasWay ? [5, 4] : []);
    this.drawLine(context, trail, x, y, colour(hasWay ? "warn" : "trail"));
    context.setLineDash([]);
    for (const [, length, px, py] of robot.stops ?? []) this.drawStop(context, x(px), y(py), length, colour("trail"));
    this.drawEnds(context, robot.ends ?? [], x, y, colour);
    for (const [, px, py] of robot.collisions ?? []) this.drawCollision(context, x(px), y(py), colour("failure"));
    context.fillStyle = colour("scan");
    for (const [px, py] of this.seen()) context.fillRect(x(px) - 1, y(py) - 1, 2.5, 2.5);
    (robot.targets ?? []).forEach(([px, py], number) => this.drawTarget(context, x(px), y(py), number, colour("failure")));
    for (const [name, ...pose] of robot.others ?? []) {
      this.drawRobot(context, pose, x, y, scale, colour("trail"));
      context.fillText(name, x(pose[0]) + 8, y(pose[1]) - 6);
    }
    if (robot.pose) this.drawRobot(context, robot.pose, x, y, scale, colour("running"));
    for (const [, at] of store.parts.faults ?? []) if (at) this.drawFault(context, x(at[0]), y(at[1]), colour("failure"));
    if (this.cross) this.drawCross(context, x(this.cross[0]), y(this.cross[1]), colour("running"));
  }

  drawWalls(context, x, y, scale) {
    const { grid } = this.store.robot;
    const [ox, oy, yaw] = grid.origin;
    const cell = grid.resolution * scale;
    context.save();
    context.translate(x(ox), y(oy));
    context.rotate(-yaw);
    context.imageSmoothingEnabled = false;
    context.drawImage(this.walls, 0, -grid.height * cell, grid.width * cell, grid.height * cell);
    context.restore();
  }

  drawZone(context, [name, px, py, radius, colour], x, y, scale, ink) {
    context.fillStyle = colour;
    context.globalAlpha = 0.35;
    context.beginPath();
    context.arc(x(px), y(py), radius * scale, 0, 2 * Math.PI);
    context.fill();
    context.globalAlpha = 1;
    context.fillStyle = ink;
    context.textAlign = "center";
    context.fillText(name, x(px), y(py + radius) - 3);
    context.textAlign = "start";
  }

  drawLine(context, points, x, y, colour) {
    context.beginPath();
    points.forEach(([px, py], number) => (number ? context.lineTo(x(px), y(py)) : context.moveTo(x(px), y(py))));
    context.strokeStyle = colour;
    context.lineWidth = 1.5;
    context.stroke();
  }

  drawFault(context, x, y, colour) {
    context.strokeStyle = colour;
    context.lineWidth = 1.5;
    context.strokeRect(x - 5, y - 5, 10, 10);
  }

  drawCross(context, x, y, colour) {
    context.strokeStyle = colour;
    context.lineWidth = 1;
    context.beginPath();
    for (const [dx, dy] of [[9, 0], [0, 9]]) { context.moveTo(x - dx, y - dy); context.lineTo(x + dx, y + dy); }
    context.stroke();
  }

  drawTarget(context, x, y, number, colour) {
    context.strokeStyle = colour;
    context.fillStyle = colour;
    context.beginPath();
    context.arc(x, y, 5, 0, 2 * Math.PI);
    context.stroke();
    context.fillText(String(number + 1), x + 7, y + 4);
  }

  drawStop(context, x, y, length, colour) {
    context.fillStyle = colour;
    context.globalAlpha = 0.25;
    context.beginPath();
    context.arc(x, y, Math.min(3 + 0.5 * length, 12), 0, 2 * Math.PI);
    context.fill();
    context.globalAlpha = 1;
  }

  drawCollision(context, x, y, colour) {
    context.strokeStyle = colour;
    context.lineWidth = 2.5;
    context.beginPath();
    for (const [dx, dy] of [[6, 6], [6, -6]]) { context.moveTo(x - dx, y - dy); context.lineTo(x + dx, y + dy); }
    context.stroke();
  }

  // Where goals have ended: a dot for each place, and the numbers of its goals.
  drawEnds(context, ends, x, y, colour) {
    const places = [];
    for (const [px, py, number, status] of ends) {
      const near = places.find((place) => Math.hypot(place.x - x(px), place.y - y(py)) < 14);
      if (near) { near.numbers.push(number); near.status = Math.max(near.status, goalStatus(status)); } else places.push({ x: x(px), y: y(py), numbers: [number], status: goalStatus(status) });
    }
    for (const place of places) {
      context.fillStyle = colour(["idle", "running", "success", "failure"][place.status]);
      context.beginPath();
      context.arc(place.x, place.y, 4, 0, 2 * Math.PI);
      context.fill();
      const { numbers } = place;
      context.fillText(`${numbers.length > 4 ? "… " : ""}${numbers.slice(-4).join(", ")}`, place.x + 6, place.y - 5);
    }
  }

  drawRobot(context, [px, py, yaw], x, y, scale, colour) {
    const size = Math.max(ROBOT * scale, 6);
    context.save();
    context.translate(x(px), y(py));
    context.rotate(-yaw);
    context.fillStyle = colour;
    context.beginPath();
    context.moveTo(size, 0);
    context.lineTo(-0.8 * size, 0.7 * size);
    context.lineTo(-0.4 * size, 0);
    context.lineTo(-0.8 * size, -0.7 * size);
    context.fill();
    context.restore();
  }
}

function rgba(text) {
  const hex = text.trim().slice(1);
  return [0, 2, 4].map((at) => parseInt(hex.slice(at, at + 2), 16)).concat(255);
}
