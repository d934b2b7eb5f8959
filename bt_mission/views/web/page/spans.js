// The timeline: for each node that ran a row, for each time that it ran a bar.

import { STATUSES, byId, element, seconds } from "./words.js";

const ROW = 22;
const INDENT = 10;
const MOST_OPEN = 40; // rows; of more, some are folded at first

export class Spans {
  // zoom: the stretch of time that is shown. select(index): called for a node that is clicked.
  constructor(zoom, select) {
    Object.assign(this, { zoom, select, rows: [], row: -1, folded: new Set() });
    this.box = byId("spans");
    this.names = byId("span-names");
    this.canvas = byId("span-bars");
    this.reading = byId("span-reading");
    this.hint = this.reading.textContent;
    zoom.drawings.add(() => this.draw());
    zoom.listen(this.canvas, (event, at) => {
      this.row = Math.floor((event.clientY - this.canvas.getBoundingClientRect().top) / ROW);
      this.read(at);
    });
    this.canvas.addEventListener("pointerleave", () => { this.reading.textContent = this.hint; });
    this.canvas.addEventListener("click", () => { if (this.rows[this.row] !== undefined) this.select(this.rows[this.row]); });
    this.names.addEventListener("click", (event) => {
      const name = event.target.closest(".name");
      if (!name) return;
      const index = Number(name.dataset.index);
      if (event.target.closest("button")) this.fold(index);
      else this.select(index);
    });
    this.box.addEventListener("keydown", (event) => this.key(event));
    byId("span-fold").addEventListener("click", () => this.foldAll());
    new ResizeObserver(() => this.draw()).observe(this.canvas);
  }

  begin(tree, spans) {
    this.tree = tree;
    this.spans = spans;
    const nodes = tree?.nodes ?? [];
    this.depth = nodes.map(() => 0);
    this.parents = new Set();
    nodes.forEach(([, , parent], index) => {
      if (!index) return;
      this.depth[index] = this.depth[parent] + 1;
      this.parents.add(parent);
    });
    this.ran = nodes.map((_, index) => (spans.rows[index] ?? []).length > 0);
    const silent = this.ran.filter((has) => !has).length;
    byId("span-silent").textContent = silent ? `${silent} ${silent === 1 ? "node" : "nodes"} never ran.` : "";
    this.folded = new Set();
    if (this.ran.length - silent > MOST_OPEN) this.foldSucceeded();
    this.arrange();
  }

  // Of many nodes, what has succeeded is folded; the way to what has not is open.
  foldSucceeded() {
    this.folded = new Set([...this.parents].filter((index) => index && this.spans.rows[index].at(-1)?.[2] === 2));
  }

  foldAll() {
    if (this.folded.size) this.folded.clear();
    else this.folded = new Set([...this.parents].filter((index) => index));
    this.arrange();
  }

  fold(index) {
    if (!this.folded.delete(index)) this.folded.add(index);
    this.arrange();
  }

  visible() {
    const nodes = this.tree?.nodes ?? [];
    const hidden = new Set();
    return nodes.map((_, index) => index).filter((index) => {
      const parent = nodes[index][2];
      if (index && (hidden.has(parent) || this.folded.has(parent))) { hidden.add(index); return false; }
      return this.ran[index];
    });
  }

  arrange() {
    this.rows = this.visible();
    byId("span-fold").textContent = this.folded.size ? "Unfold all" : "Fold all";
    this.names.replaceChildren(...this.rows.map((index) => {
      const [name, kind, , path] = this.tree.nodes[index];
      const last = STATUSES[this.spans.rows[index].at(-1)[2]];
      const row = element("div", "name", element("span", `dot ${last}`), element("span", "", name));
      row.dataset.index = index;
      row.title = `${name} (${kind}, ${path})`;
      row.style.paddingLeft = `${Math.min(this.depth[index], 8) * INDENT + 4}px`;
      if (this.parents.has(index)) {
        const button = element("button", "", this.folded.has(index) ? "▸" : "▾");
        button.type = "button";
        button.setAttribute("aria-expanded", !this.folded.has(index));
        button.setAttribute("aria-label", `${this.folded.has(index) ? "Unfold" : "Fold"} ${name}`);
        row.prepend(button);
      }
      return row;
    }));
    this.canvas.style.height = `${this.rows.length * ROW}px`;
    this.draw();
  }

  draw() {
    const { canvas, zoom } = this;
    const ratio = window.devicePixelRatio || 1;
    const [width, height] = [canvas.clientWidth, this.rows.length * ROW];
    if (!width || !height) return;
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
    const context = canvas.getContext("2d");
    context.scale(ratio, ratio);
    const style = getComputedStyle(document.documentElement);
    const colours = ["idle", "running", "success", "failure"].map((name) => style.getPropertyValue(`--${name}`).trim());
    const stripe = style.getPropertyValue("--ground").trim();
    this.rows.forEach((index, number) => {
      const top = number * ROW;
      if (number % 2 === 0) { context.fillStyle = stripe; context.fillRect(0, top, width, ROW); }
      const isInner = this.parents.has(index);
      let drawn = -1; // the last pixel that has a bar, and its status: a thousand bars in it look as one
      let status = -1;
      for (const [begin, end, now] of this.spans.rows[index]) {
        if (end < zoom.begin) continue;
        if (begin > zoom.end) break;
        const left = Math.max(zoom.share(begin) * width, -2);
        const right = Math.min(Math.max(zoom.share(end) * width, left + 2), width + 2);
        if (right <= drawn && now === status) continue;
        context.fillStyle = colours[now];
        context.globalAlpha = isInner && right - left > 3 ? 0.35 : 0.9;
        context.fillRect(left, top + 4, right - left, ROW - 8);
        [drawn, status] = [Math.floor(right), now];
      }
      context.globalAlpha = 1;
    });
  }

  look() {
    byId("span-cursor").style.left = `${100 * this.zoom.share(this.zoom.at)}%`;
  }

  // What the mouse, or the row that the keys have reached, shows at an instant.
  read(at) {
    const index = this.rows[this.row];
    if (index === undefined) return;
    const near = (4 * this.zoom.length) / Math.max(this.canvas.clientWidth, 1);
    let best = null;
    for (const span of this.spans.rows[index]) {
      const gap = Math.max(span[0] - at, at - span[1], 0);
      if (gap <= near && (!best || gap < best.gap)) best = { gap, span };
    }
    const [name] = this.tree.nodes[index];
    if (!best) { this.reading.textContent = `${name}, ${at.toFixed(2)} s`; return; }
    const [begin, end, status, text] = best.span;
    const how = status ? STATUSES[status] : "halted";
    const words = this.spans.texts[text];
    this.reading.textContent = `${name}: ${how}, ${begin.toFixed(2)} to ${end.toFixed(2)} s (${seconds(end - begin)})${words ? `. ${words}` : ""}`;
  }

  key(event) {
    if (event.target !== this.box) return;
    const steps = { ArrowUp: -1, ArrowDown: 1 }[event.key];
    if (steps) {
      this.row = Math.min(Math.max(this.row + steps, 0), this.rows.length - 1);
      this.select(this.rows[this.row]);
      this.read(this.zoom.at);
    } else if (event.key === "Enter" && this.parents.has(this.rows[this.row])) this.fold(this.rows[this.row]);
    else if (!this.zoom.key(event)) return;
    event.preventDefault();
    event.stopPropagation();
  }
}
