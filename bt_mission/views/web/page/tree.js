// The tree: only the rows in view are in the page, so that thousands of nodes stay smooth.

import { SIGNS, STATUSES, byId, element, figures, seconds } from "./words.js";

const ROW = 22;
const SPARE = 6;
const INDENT = 16;

export class Tree {
  // onSelect(index): called when the user, or following, selects a node.
  constructor(store, onSelect) {
    this.store = store;
    this.onSelect = onSelect;
    this.box = byId("tree");
    this.space = byId("rows");
    this.follow = byId("follow");
    this.folded = new Set();
    this.rows = [];
    this.rowOf = new Map();
    this.drawn = new Map();
    this.selected = 0;
    this.box.addEventListener("scroll", () => this.draw(false));
    this.box.addEventListener("keydown", (event) => this.key(event));
    this.box.addEventListener("click", (event) => this.click(event));
    this.box.addEventListener("dblclick", (event) => this.click(event, true));
    new ResizeObserver(() => this.draw(false)).observe(this.box);
    this.follow.addEventListener("change", () => this.goAlong());
    byId("fold").addEventListener("click", () => this.foldAll());
    const search = byId("search");
    search.addEventListener("input", () => this.search(search.value, this.selected - 1, 1));
    search.addEventListener("keydown", (event) => {
      if (event.key === "Enter") this.search(search.value, this.selected, event.shiftKey ? -1 : 1);
      if (event.key === "Escape") this.box.focus();
    });
  }

  begin() {
    const nodes = this.store.tree?.nodes ?? [];
    const count = nodes.length;
    this.depth = new Array(count).fill(0);
    this.end = Array.from({ length: count }, (_, index) => index + 1);
    for (let index = 1; index < count; index++) this.depth[index] = this.depth[nodes[index][2]] + 1;
    for (let index = count - 1; index > 0; index--) {
      const parent = nodes[index][2];
      this.end[parent] = Math.max(this.end[parent], this.end[index]);
    }
    this.position = new Array(count).fill(1);
    this.size = new Array(count).fill(0);
    nodes.forEach(([, , parent], index) => { if (index) this.position[index] = ++this.size[parent]; });
    this.folded.clear();
    this.selected = 0;
    this.arrange();
    if (count) this.select(0, false);
  }

  hasChildren(index) { return this.end[index] > index + 1; }

  arrange() {
    this.rows = [];
    this.rowOf.clear();
    const count = this.store.tree?.nodes.length ?? 0;
    for (let index = 0; index < count; index = this.folded.has(index) ? this.end[index] : index + 1) {
      this.rowOf.set(index, this.rows.length);
      this.rows.push(index);
    }
    this.space.style.height = `${this.rows.length * ROW}px`;
    for (const row of this.drawn.values()) row.remove();
    this.drawn.clear();
    this.draw(true);
  }

  shownRow(index) {
    while (!this.rowOf.has(index)) index = this.store.tree.nodes[index][2];
    return this.rowOf.get(index);
  }

  draw(all) {
    const first = Math.max(Math.floor(this.box.scrollTop / ROW) - SPARE, 0);
    const last = Math.min(first + Math.ceil(this.box.clientHeight / ROW) + 2 * SPARE, this.rows.length);
    const wanted = new Set(this.rows.slice(first, last));
    for (const [index, row] of this.drawn) {
      if (!wanted.has(index)) { row.remove(); this.drawn.delete(index); }
    }
    for (let number = first; number < last; number++) {
      const index = this.rows[number];
      const before = this.drawn.get(index);
      if (before && !all && !this.store.touched.has(index)) continue;
      // A row stays the same element: who reads the screen is told of what is new in it only.
      const row = before ?? element("div", "row");
      this.fill(row, index, number);
      if (!before) this.space.append(row);
      this.drawn.set(index, row);
    }
  }

  // Rows of running nodes have a time that goes on.
  tick() {
    for (const index of this.drawn.keys()) {
      if (this.store.status[index] === 1) this.store.touched.add(index);
    }
  }

  fill(row, index, number) {
    const store = this.store;
    const view = store.view();
    const [name, kind, , path] = store.tree.nodes[index];
    const status = view.status[index];
    const isFolded = this.folded.has(index);
    row.id = `node-${index}`;
    row.dataset.index = index;
    row.dataset.status = STATUSES[status];
    row.style.top = `${number * ROW}px`;
    row.style.paddingLeft = `${Math.min(this.depth[index] * INDENT, this.box.clientWidth / 3)}px`;
    row.setAttribute("role", "treeitem");
    row.setAttribute("aria-level", this.depth[index] + 1);
    row.setAttribute("aria-posinset", this.position[index]);
    row.setAttribute("aria-setsize", index ? this.size[store.tree.nodes[index][2]] : 1);
    row.setAttribute("aria-selected", index === this.selected);
    if (this.hasChildren(index)) row.setAttribute("aria-expanded", !isFolded);
    const stops = store.state.breakpoints ?? [];
    const hasStop = stops.includes(path) || stops.includes(name);
    row.replaceChildren(
      element("span", "stop", hasStop ? "●" : " "),
      element("span", "fold", this.hasChildren(index) ? (isFolded ? "▸" : "▾") : ""),
      element("span", `sign ${STATUSES[status]}`, SIGNS[status]),
      element("span", STATUSES[status], name),
    );
    if (this.hasChildren(index) && kind.toLowerCase() !== name.toLowerCase()) row.append(element("span", "kind", kind.toLowerCase()));
    if (isFolded) row.append(element("span", "took", `+${this.end[index] - index - 1}`));
    if (store.past === null) this.addFigures(row, index, status);
    const words = view.message[index];
    if (words) row.append(element("span", "words", words));
    const state = hasStop ? ", breakpoint" : "";
    row.setAttribute("aria-label", `${name}, ${kind}, ${STATUSES[status]}${state}${words ? `, ${words}` : ""}`);
  }

  addFigures(row, index, status) {
    const store = this.store;
    const took = status === 1 && store.since[index] !== null
      ? Math.max(store.now - store.since[index], 0)
      : status > 1 && store.ran[index] ? store.ran[index] : null;
    if (took !== null) row.append(element("span", "took", seconds(took)));
    const progress = status === 1 ? store.progress[index] : null;
    if (progress && progress[1] !== null && progress[2] > 0) {
      const meter = element("meter");
      Object.assign(meter, { max: progress[2], value: Math.min(progress[1], progress[2]) });
      row.append(meter, element("span", "share", figures(progress)));
    }
  }

  // ---- the selection ---------------------------------------------------------------------

  select(index, byHand = true) {
    if (!this.store.tree || index === undefined) return;
    if (byHand) this.follow.checked = false;
    const before = this.selected;
    this.selected = index;
    for (const one of [before, index]) {
      this.drawn.get(one)?.setAttribute("aria-selected", one === index);
    }
    this.box.setAttribute("aria-activedescendant", `node-${index}`);
    this.show(index);
    this.onSelect(index);
  }

  show(index) {
    const top = this.shownRow(index) * ROW;
    const height = this.box.clientHeight;
    if (top < this.box.scrollTop) this.box.scrollTop = top;
    else if (top + ROW > this.box.scrollTop + height) this.box.scrollTop = top + ROW - height;
    this.draw(false);
  }

  goAlong() {
    const tip = this.store.state.tip;
    if (!this.follow.checked || tip === null || tip === undefined || !this.store.tree) return;
    if (tip !== this.selected && tip < this.store.tree.nodes.length) this.select(tip, false);
  }

  fold(index, isFolded) {
    if (!this.hasChildren(index)) return;
    if (isFolded) this.folded.add(index); else this.folded.delete(index);
    this.arrange();
  }

  foldAll() {
    if (this.folded.size) this.folded.clear();
    else this.rows.forEach((index) => { if (index && this.hasChildren(index)) this.folded.add(index); });
    if (this.store.tree) {
      this.arrange();
      this.select(this.rows[this.shownRow(this.selected)], false);
    }
  }

  search(text, from, step) {
    const nodes = this.store.tree?.nodes ?? [];
    const wanted = text.toLowerCase();
    const found = byId("found");
    found.textContent = "";
    if (!wanted || !nodes.length) return;
    const has = (words) => words.toLowerCase().includes(wanted);
    const matches = (index) => has(nodes[index][0]) || has(nodes[index][1]) || has(this.store.message[index]);
    for (let offset = 1; offset <= nodes.length; offset++) {
      const index = (from + step * offset + 2 * nodes.length) % nodes.length;
      if (!matches(index)) continue;
      const above = this.store.path(index).slice(0, -1);
      if (above.some((one) => this.folded.has(one))) {
        above.forEach((one) => this.folded.delete(one));
        this.arrange();
      }
      this.select(index);
      return;
    }
    found.textContent = "not in the tree";
  }

  // ---- keys and the mouse ----------------------------------------------------------------

  key(event) {
    if (!this.rows.length || event.ctrlKey || event.metaKey || event.altKey) return;
    const row = this.shownRow(this.selected);
    const index = this.rows[row];
    const page = Math.max(Math.floor(this.box.clientHeight / ROW) - 1, 1);
    const go = (to) => this.select(this.rows[Math.min(Math.max(to, 0), this.rows.length - 1)]);
    const acts = {
      ArrowDown: () => go(row + 1),
      ArrowUp: () => go(row - 1),
      PageDown: () => go(row + page),
      PageUp: () => go(row - page),
      Home: () => go(0),
      End: () => go(this.rows.length - 1),
      ArrowRight: () => (this.folded.has(index) ? this.fold(index, false) : this.hasChildren(index) && go(row + 1)),
      ArrowLeft: () => {
        if (this.hasChildren(index) && !this.folded.has(index)) this.fold(index, true);
        else if (index) this.select(this.store.tree.nodes[index][2]);
      },
      Enter: () => this.fold(index, !this.folded.has(index)),
      " ": () => this.fold(index, !this.folded.has(index)),
    };
    if (!(event.key in acts)) return;
    event.preventDefault();
    this.follow.checked = false;
    acts[event.key]();
  }

  click(event, isDouble = false) {
    const row = event.target.closest(".row");
    if (!row) return;
    const index = Number(row.dataset.index);
    if (event.target.className === "fold" ? !isDouble : isDouble) this.fold(index, !this.folded.has(index));
    this.select(index);
  }
}
