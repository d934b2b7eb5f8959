// The drawing of a tree: boxes in layers, their selection by keys and mouse, and dragging in the editor.

import { byId } from "./words.js";

const SVG = "http://www.w3.org/2000/svg";
const [WIDTH, HEIGHT] = [168, 40];
const MARGIN = 16;
const FAR = 6;
const MOST_PAINTED = 300;
const READABLE = 0.7; // the smallest zoom at which texts can be read

export function shape(tag, attributes, className = "", text = "") {
  const made = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  if (className) made.setAttribute("class", className);
  if (text) made.textContent = text;
  return made;
}

const cut = (text, most) => (text.length > most ? `${text.slice(0, most - 1)}…` : text);
export const keyOf = (path) => JSON.stringify(path);

export class Drawing {
  // onSelect(box): the user has selected a box. onAct(name, facts): the user wants a change; null
  // where the tree cannot be edited.
  constructor(onSelect, onAct = null) {
    Object.assign(this, { onSelect, onAct, boxes: [], shown: [], folded: new Set(), zoom: 1, isFitted: false, isDown: false });
    this.selected = keyOf([]);
    this.marked = null;
    this.statuses = new Map();
    this.severities = new Map();
    this.findings = new Map();
    this.stops = new Set();
    this.box = byId("drawing");
    this.picture = byId("picture");
    this.edges = shape("path", {}, "edge");
    this.nodes = shape("g", {});
    this.picture.replaceChildren(this.edges, this.nodes);
    this.box.addEventListener("keydown", (event) => this.key(event));
    this.box.addEventListener("pointerdown", (event) => this.press(event));
    this.box.addEventListener("dblclick", (event) => { const box = this.at(event.target); if (box) this.onAct?.("fields"); });
    this.box.addEventListener("wheel", (event) => {
      if (!event.ctrlKey) return;
      event.preventDefault();
      this.scale(event.deltaY < 0 ? 1.15 : 1 / 1.15);
    }, { passive: false });
    this.box.addEventListener("scroll", () => { if (this.shown.length > MOST_PAINTED) this.paintSoon(); });
    byId("turn").addEventListener("click", () => this.turn());
    byId("fold-all").addEventListener("click", () => this.foldAll());
    byId("larger").addEventListener("click", () => this.scale(1.25));
    byId("smaller").addEventListener("click", () => this.scale(0.8));
    byId("fit").addEventListener("click", () => this.fit());
    new ResizeObserver(() => requestAnimationFrame(() => this.refit())).observe(this.box);
  }

  get current() { return this.byKey?.get(this.selected) ?? null; }

  // Shows boxes; null keeps the last ones, in grey.
  show(boxes) {
    this.box.classList.toggle("is-old", boxes === null);
    if (boxes === null) return;
    this.boxes = boxes;
    boxes.forEach((box, index) => Object.assign(box, { index, key: keyOf(box.path) }));
    this.byKey = new Map(boxes.map((box) => [box.key, box]));
    this.children = boxes.map(() => []);
    for (const box of boxes) if (box.parent >= 0) this.children[box.parent].push(box);
    for (let path = JSON.parse(this.selected); !this.byKey.has(keyOf(path)) && path.length;) {
      path = path.slice(0, -1);
      this.selected = keyOf(path);
    }
    this.draw();
    this.refit();
  }

  // Lays the boxes out now, and paints them once, with the next frame.
  draw() {
    this.layOut();
    this.size();
    this.paintSoon();
  }

  paintSoon() { this.isStale ||= requestAnimationFrame(() => this.paint()) > 0; }

  // Boxes that look as they did before keep their elements.
  paint() {
    this.isStale = false;
    const seen = this.inView();
    const lines = [];
    for (const box of this.shown) {
      for (const child of this.below(box)) if (seen(box, child)) lines.push(this.edge(box, child));
    }
    this.edges.setAttribute("d", lines.join(""));
    const free = new Map();
    for (const group of this.nodes.children) {
      if (free.has(group.look)) free.get(group.look).push(group); else free.set(group.look, [group]);
    }
    const groups = this.shown.filter((box) => seen(box, box)).map((box) => {
      const look = this.look(box);
      const group = free.get(look)?.shift() ?? this.node(box, look);
      const facts = { transform: `translate(${box.x} ${box.y})`, id: `box-${box.index}`, "aria-level": box.depth + 1, "aria-selected": box.key === this.selected };
      for (const [name, value] of Object.entries(facts)) if (group.getAttribute(name) !== String(value)) group.setAttribute(name, value);
      return group;
    });
    for (const unused of free.values()) for (const group of unused) group.remove();
    let next = this.nodes.firstChild;
    for (const group of groups) {
      if (group === next) next = next.nextSibling; else this.nodes.insertBefore(group, next);
    }
    this.box.setAttribute("aria-activedescendant", this.current ? `box-${this.current.index}` : "");
  }

  // Of a large tree only what is in view is painted, and some of what is around it.
  inView() {
    if (this.shown.length <= MOST_PAINTED) return () => true;
    const view = this.box;
    const [left, top] = [view.scrollLeft / this.zoom, view.scrollTop / this.zoom];
    const [right, bottom] = [left + view.clientWidth / this.zoom, top + view.clientHeight / this.zoom];
    return (one, other) => Math.max(one.x, other.x) + WIDTH >= left && Math.min(one.x, other.x) <= right
      && Math.max(one.y, other.y) + HEIGHT >= top && Math.min(one.y, other.y) <= bottom;
  }

  below(box) { return this.folded.has(box.key) ? [] : this.children[box.index]; }

  // A tidy tree: leaves in order, parents in the middle of their children.
  layOut() {
    this.shown = [];
    let next = MARGIN;
    const [step, layer] = this.isDown ? [WIDTH + 14, HEIGHT + 34] : [HEIGHT + 12, WIDTH + 30];
    const place = (box, depth) => {
      this.shown.push(box);
      const children = this.below(box);
      for (const child of children) place(child, depth + 1);
      const first = children[0];
      const at = first ? (first.across + children[children.length - 1].across) / 2 : next;
      if (!first) next += step;
      box.across = at;
      box.depth = depth;
      box.x = this.isDown ? at : MARGIN + depth * layer;
      box.y = this.isDown ? MARGIN + depth * layer : at;
    };
    if (this.boxes.length) place(this.boxes[0], 0);
    const deepest = this.shown.reduce((most, box) => Math.max(most, box.depth), 0);
    const along = MARGIN * 2 + deepest * layer + (this.isDown ? HEIGHT : WIDTH);
    [this.width, this.height] = this.isDown ? [next + MARGIN, along] : [along, next + MARGIN];
  }

  edge(box, child) {
    const [x1, y1] = this.isDown ? [box.x + WIDTH / 2, box.y + HEIGHT] : [box.x + WIDTH, box.y + HEIGHT / 2];
    const [x2, y2] = this.isDown ? [child.x + WIDTH / 2, child.y] : [child.x, child.y + HEIGHT / 2];
    const bend = this.isDown ? `${x1} ${(y1 + y2) / 2} ${x2} ${(y1 + y2) / 2}` : `${(x1 + x2) / 2} ${y1} ${(x1 + x2) / 2} ${y2}`;
    return `M${x1} ${y1}C${bend} ${x2} ${y2}`;
  }

  // All that an element of a box shows, but not its place.
  look(box) {
    const { key } = box;
    return [
      box.is_empty ? "empty: add a node" : box.name || box.kind, box.kind, box.detail, box.name, box.family, box.glyph, this.isDown, box.parent >= 0,
      this.children[box.index].length > 0 && (this.folded.has(key) ? "folded" : "open"), this.statuses.get(key) ?? "", this.severities.get(key) ?? "",
      this.findings.get(key) ?? "", this.stops.has(key), key === this.marked,
    ].join("\u0001");
  }

  node(box, look) {
    const { key } = box;
    const group = shape("g", { role: "treeitem" });
    group.look = look;
    const title = box.is_empty ? "empty: add a node" : box.name || box.kind;
    const detail = box.is_empty ? "" : box.name ? `${box.kind} ${box.detail}` : box.detail;
    const children = this.children[box.index];
    const status = this.statuses.get(key);
    const finding = this.findings.get(key);
    const severity = this.severities.get(key);
    if (children.length) group.setAttribute("aria-expanded", !this.folded.has(key));
    group.setAttribute("aria-label", [title, box.kind, box.detail, severity ?? "", status ?? "", this.stops.has(key) ? "breakpoint" : "", finding ? `findings: ${finding}` : ""].filter(Boolean).join(", "));
    group.setAttribute("class", ["node", box.family, box.is_empty && "is-empty", severity && `has-${severity}`,
      status && `ran-${status}`, key === this.marked && "is-marked"].filter(Boolean).join(" "));
    group.append(
      shape("rect", { width: WIDTH, height: HEIGHT }, "box"),
      shape("rect", { width: 4, height: HEIGHT - 10, x: 4, y: 5 }, "stripe"),
      shape("rect", { width: WIDTH - 12, height: 3, x: 6, y: HEIGHT - 4 }, "state"),
      shape("text", { x: 20, y: detail ? 17 : 25 }, "glyph", box.is_empty ? "" : box.glyph),
      shape("text", { x: 32, y: detail ? 17 : 25 }, "", cut(title, 20)),
    );
    if (detail) group.append(shape("text", { x: 32, y: 31 }, "detail", cut(detail, 20)));
    if (children.length && box.parent >= 0) {
      const [x, y] = this.isDown ? [WIDTH / 2, HEIGHT] : [WIDTH, HEIGHT / 2];
      const isFolded = this.folded.has(key);
      group.append(shape("circle", { cx: x, cy: y, r: 8 }, "fold"), shape("text", { x, y: y + 4 }, "fold", isFolded ? "+" : "−"));
    }
    if (this.stops.has(key)) group.append(shape("circle", { cx: 2, cy: 2, r: 6 }, "stop"));
    if (finding) group.append(shape("circle", { cx: WIDTH - 4, cy: 4, r: 8 }, "badge"), shape("text", { x: WIDTH - 4, y: 8 }, "count", String(finding)));
    group.append(shape("title", {}, "", [title, box.kind, box.detail].filter(Boolean).join("\n")));
    return group;
  }

  size() {
    this.picture.setAttribute("width", this.width * this.zoom);
    this.picture.setAttribute("height", this.height * this.zoom);
    this.picture.setAttribute("viewBox", `0 0 ${this.width} ${this.height}`);
  }

  scale(factor) {
    this.isFitted = false;
    this.zoom = Math.min(Math.max(this.zoom * factor, 0.08), 2.5);
    this.draw();
  }

  // Fits the drawing into its pane as far as it stays readable, with the selected box in view; also
  // when either changes later, until the user zooms.
  fit() {
    this.isFitted = true;
    this.zoom = Math.max(this.fitting(), READABLE);
    this.draw();
    this.reveal();
  }

  refit() { if (this.isFitted && this.box.clientWidth) this.fit(); }

  fitting() { return Math.min(this.box.clientWidth / this.width, this.box.clientHeight / this.height, 1); }

  // Draws the tree in the direction in which it is larger, left to right if both are alike.
  orient() {
    const zooms = [false, true].map((isDown) => { this.isDown = isDown; this.layOut(); return this.fitting(); });
    this.direct(zooms[1] > zooms[0]);
    this.fit();
  }

  direct(isDown) {
    this.isDown = isDown;
    byId("turn").textContent = isDown ? "Left-right" : "Top-down";
    this.draw();
  }

  turn() {
    this.direct(!this.isDown);
    this.refit();
    this.reveal();
  }

  fold(box, isFolded) {
    if (isFolded) this.folded.add(box.key); else this.folded.delete(box.key);
    this.draw();
  }

  foldAll() {
    if (this.folded.size) this.folded.clear();
    else for (const box of this.boxes) if (box.path.length > 1 && this.children[box.index].length) this.folded.add(box.key);
    this.draw();
  }

  // What the checks, a run and a proof say of boxes.
  tell(facts) {
    Object.assign(this, facts);
    if (this.boxes.length) this.draw();
  }

  innermost(offset) {
    let best = null;
    for (const box of this.boxes) if (box.path.length && box.start <= offset && offset <= box.end && (!best || box.start >= best.start)) best = box;
    return best;
  }

  choose(box, isByUser = true) {
    if (!box) return;
    let isHidden = false;
    for (let above = this.boxes[box.parent]; above; above = this.boxes[above.parent]) isHidden = this.folded.delete(above.key) || isHidden;
    const before = this.current;
    this.selected = box.key;
    if (isHidden || this.isStale) this.draw();
    else for (const one of [before, box]) if (one) byId(`box-${one.index}`)?.setAttribute("aria-selected", one === box);
    this.box.setAttribute("aria-activedescendant", `box-${box.index}`);
    this.reveal();
    this.onSelect(box, isByUser);
  }

  reveal() {
    const box = this.current;
    if (!box || box.x === undefined) return;
    const [x, y, width, height] = [box.x, box.y, WIDTH, HEIGHT].map((one) => one * this.zoom);
    const view = this.box;
    if (x < view.scrollLeft || x + width > view.scrollLeft + view.clientWidth) view.scrollLeft = x - view.clientWidth / 3;
    if (y < view.scrollTop || y + height > view.scrollTop + view.clientHeight) view.scrollTop = y - view.clientHeight / 3;
  }

  at(target) {
    const group = target.closest?.(".node");
    return group ? this.boxes[Number(group.id.slice(4))] : null;
  }

  // ---- the mouse -------------------------------------------------------------------------

  press(event) {
    const box = this.at(event.target);
    if (!box || event.button) return;
    if (event.target.classList.contains("fold")) { this.fold(box, !this.folded.has(box.key)); return; }
    this.choose(box);
    this.box.focus();
    event.preventDefault();
    if (this.onAct && box.path.length > 1 && !box.is_empty) this.drag(event, { path: box.path });
  }

  // Follows the pointer until it is released: over a place, the act is done.
  drag(event, carried) {
    const [x, y] = [event.clientX, event.clientY];
    let target = null;
    let isFar = false;
    const move = (moved) => {
      isFar ||= Math.hypot(moved.clientX - x, moved.clientY - y) > FAR;
      if (!isFar) return;
      document.body.style.cursor = "grabbing";
      target = this.placeAt(moved.clientX, moved.clientY);
      this.hint(target);
    };
    const release = () => {
      document.removeEventListener("pointermove", move);
      document.removeEventListener("pointerup", release);
      document.removeEventListener("pointercancel", release);
      document.body.style.cursor = "";
      this.hint(null);
      if (isFar && target) this.onAct(carried.path ? "move" : "add", { ...carried, target: target.path });
      else if (!isFar && carried.kind) this.onAct("insert", carried);
    };
    document.addEventListener("pointermove", move);
    document.addEventListener("pointerup", release);
    document.addEventListener("pointercancel", release);
  }

  // The place under the pointer: an empty one, into a list, or before or behind a box.
  placeAt(clientX, clientY) {
    const under = document.elementFromPoint(clientX, clientY);
    const box = under && this.at(under);
    if (!box) return null;
    if (box.is_empty || (!box.path.length && !this.children[0]?.length)) return { path: box.path.length ? box.path : ["tree"], box, side: "in" };
    const frame = under.closest(".node").querySelector(".box").getBoundingClientRect();
    const share = this.isDown ? (clientX - frame.left) / frame.width : (clientY - frame.top) / frame.height;
    if (box.takes_list && share > 0.25 && share < 0.75) return { path: this.endOf(box), box, side: "in" };
    const last = box.path[box.path.length - 1];
    if (typeof last !== "number") return box.takes_list ? { path: this.endOf(box), box, side: "in" } : null;
    return { path: [...box.path.slice(0, -1), share < 0.5 ? last : last + 1], box, side: share < 0.5 ? "before" : "behind" };
  }

  endOf(box) { return [...box.path, box.kind, this.children[box.index].length]; }

  hint(target) {
    byId("drop-line")?.remove();
    for (const one of this.picture.querySelectorAll(".is-target")) one.classList.remove("is-target");
    if (!target) return;
    if (target.side === "in") { byId(`box-${target.box.index}`)?.classList.add("is-target"); return; }
    const { x, y } = target.box;
    const far = target.side === "behind";
    const line = this.isDown ? { x1: x + (far ? WIDTH + 7 : -7), x2: x + (far ? WIDTH + 7 : -7), y1: y, y2: y + HEIGHT }
      : { x1: x, x2: x + WIDTH, y1: y + (far ? HEIGHT + 6 : -6), y2: y + (far ? HEIGHT + 6 : -6) };
    this.picture.append(shape("line", { id: "drop-line", ...line }));
  }

  // ---- keys ------------------------------------------------------------------------------

  key(event) {
    if (!this.boxes.length) { if (this.onAct && event.key === "a") { event.preventDefault(); this.onAct("palette"); } return; }
    const box = this.current ?? this.boxes[0];
    const siblings = box.parent >= 0 ? this.children[box.parent] : [box];
    const at = siblings.indexOf(box);
    const order = this.shown;
    const beside = (step) => siblings[at + step] ?? order[order.indexOf(box) + step];
    const go = (to) => to && this.choose(to);
    const [next, previous, inward, outward] = this.isDown ? ["ArrowRight", "ArrowLeft", "ArrowDown", "ArrowUp"] : ["ArrowDown", "ArrowUp", "ArrowRight", "ArrowLeft"];
    const inner = () => (this.folded.has(box.key) ? this.fold(box, false) : go(this.children[box.index][0]));
    if (this.onAct && event.altKey && (event.key === "ArrowUp" || event.key === "ArrowDown")) {
      event.preventDefault();
      this.onAct(event.key === "ArrowUp" ? "earlier" : "later");
      return;
    }
    const command = event.ctrlKey || event.metaKey;
    if (this.onAct && command && "zy".includes(event.key.toLowerCase())) {
      event.preventDefault();
      this.onAct(event.key === "z" ? "undo" : "redo");
      return;
    }
    if (command || event.altKey) return;
    const moves = {
      [next]: () => go(beside(1)), [previous]: () => go(beside(-1)), [inward]: inner,
      [outward]: () => go(this.boxes[box.parent]), Home: () => go(order[0]), End: () => go(order[order.length - 1]),
      " ": () => this.fold(box, !this.folded.has(box.key)), t: () => this.turn(), 0: () => this.fit(),
    };
    const acts = this.onAct === null ? moves : {
      ...moves, Enter: () => this.onAct("fields"), F2: () => this.onAct("name"),
      Delete: () => this.onAct("delete"), Backspace: () => this.onAct("delete"), a: () => this.onAct("palette"), w: () => byId("wrap").focus(),
      u: () => this.onAct("unwrap"), c: () => this.onAct("copy"), r: () => this.onAct("run-to"), R: () => this.onAct("run-from"), m: () => this.onAct("map"),
      x: () => { this.marked = this.selected; this.draw(); }, v: () => this.onAct("drop"), Escape: () => { this.marked = null; this.draw(); },
      "+": () => this.scale(1.25), "-": () => this.scale(0.8),
    };
    if (!(event.key in acts)) return;
    event.preventDefault();
    acts[event.key]();
  }
}
