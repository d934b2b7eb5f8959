// The map of a world: its plan, a cross that the mouse and the keys move, and the faults of a run.

import { shape } from "./drawing.js";
import { ask } from "./edit_api.js";
import { byId, element } from "./words.js";

const [STEP, FINE] = [0.1, 0.01]; // metres of a press of an arrow
const MARGIN = 0.3;
const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };

const rounded = (number) => Math.round(number * 100) / 100 || 0;

export class Plan {
  // onPlace(x, y): the user has chosen a place, by a click or Enter. onDrop(path, x, y): has dragged
  // something there; onLeave(): wants back to the tree.
  constructor(onPlace, onDrop, onLeave) {
    Object.assign(this, { onPlace, onDrop, onLeave, plan: null, marks: [], cross: [0, 0], chosen: "" });
    this.box = byId("plan");
    this.picture = byId("plan-picture");
    this.box.addEventListener("keydown", (event) => this.key(event));
    this.picture.addEventListener("pointerdown", (event) => this.press(event));
  }

  // Shows a plan; null keeps the last one, in grey.
  show(plan) {
    this.box.classList.toggle("is-old", plan === null);
    if (plan) this.plan = plan;
    this.draw();
  }

  // marks: {text, at} of faults, those without a place left out.
  mark(marks) { this.marks = marks.filter((one) => one.at); this.draw(); }

  draw() {
    const { plan } = this;
    if (!plan) { this.picture.replaceChildren(); return; }
    const [length, width] = plan.size;
    this.picture.setAttribute("viewBox", `${-length / 2 - MARGIN} ${-width / 2 - MARGIN} ${length + 2 * MARGIN} ${width + 2 * MARGIN}`);
    const font = Math.max(length, width) / 32;
    const name = (x, y, words) => shape("text", { x, y: -y, "font-size": font }, "", words);
    const parts = [shape("rect", { x: -length / 2, y: -width / 2, width: length, height: width, "stroke-width": 0.02 }, "floor")];
    const tagged = (made, path) => { made.dataset.path = JSON.stringify(path); if (made.dataset.path === this.chosen) made.classList.add("is-chosen"); return made; };
    for (const { path, kind, x, y, yaw, size } of plan.shapes) {
      parts.push(tagged(kind === "cylinder" ? shape("circle", { cx: x, cy: -y, r: size[0] / 2 }, "shape")
        : shape("rect", { x: -size[0] / 2, y: -size[1] / 2, width: size[0], height: size[1], transform: `translate(${x} ${-y}) rotate(${-yaw})` }, "shape"), path));
    }
    for (const { path, x, y, radius, name: words } of plan.zones) parts.push(tagged(shape("circle", { cx: x, cy: -y, r: radius }, "zone"), path), name(x, y, words));
    const [x, y, yaw] = plan.spawn;
    parts.push(tagged(shape("path", { d: "M0.2 0L-0.12 0.12L-0.05 0L-0.12 -0.12Z", transform: `translate(${x} ${-y}) rotate(${-yaw})` }, "spawn"), ["spawn"]));
    for (const { text, at } of this.marks) {
      const dot = shape("rect", { x: at[0] - 0.1, y: -at[1] - 0.1, width: 0.2, height: 0.2 }, "fault");
      dot.append(shape("title", {}, "", text));
      parts.push(dot);
    }
    const [cx, cy] = this.cross;
    const arm = font;
    parts.push(shape("path", { d: `M${cx - arm} ${-cy}h${2 * arm}M${cx} ${-cy - arm}v${2 * arm}`, "stroke-width": font / 8 }, "cross"));
    this.picture.replaceChildren(...parts);
    byId("plan-words").textContent = `${plan.name}: x ${cx.toFixed(2)} m, y ${cy.toFixed(2)} m`;
  }

  // The place under the pointer, m.
  placeOf(event) {
    const point = new DOMPoint(event.clientX, event.clientY).matrixTransform(this.picture.getScreenCTM().inverse());
    return [rounded(point.x), rounded(-point.y)];
  }

  to(x, y) {
    const [length, width] = this.plan.size;
    this.cross = [Math.min(Math.max(x, -length / 2), length / 2), Math.min(Math.max(y, -width / 2), width / 2)].map(rounded);
    this.draw();
  }

  press(event) {
    if (!this.plan || event.button) return;
    event.preventDefault();
    this.box.focus();
    const { path } = event.target.dataset;
    const begin = this.placeOf(event);
    let isMoved = false;
    const move = (moved) => {
      const [x, y] = this.placeOf(moved);
      isMoved ||= Math.hypot(x - begin[0], y - begin[1]) > 0.05;
      if (isMoved) this.to(x, y);
    };
    const release = (last) => {
      document.removeEventListener("pointermove", move);
      document.removeEventListener("pointerup", release);
      const place = this.placeOf(last);
      this.to(...place);
      if (isMoved && path) this.onDrop(JSON.parse(path), begin, this.cross);
      else this.onPlace(...this.cross, path ? JSON.parse(path) : null, isMoved ? begin : null);
    };
    document.addEventListener("pointermove", move);
    document.addEventListener("pointerup", release);
  }

  key(event) {
    if (!this.plan || event.ctrlKey || event.metaKey || event.altKey) return;
    const arrow = ARROWS[event.key];
    if (arrow) {
      event.preventDefault();
      const step = event.shiftKey ? FINE : STEP;
      this.to(this.cross[0] + arrow[0] * step, this.cross[1] + arrow[1] * step);
    } else if (event.key === "Enter" || event.key === " ") {
      event.preventDefault();
      this.onPlace(...this.cross, null, null);
    } else if (event.key === "m") this.onLeave();
    else if (event.key === "Delete") this.onDelete?.();
  }
}

// A field of a form: its name, an input or a choice, its unit and what it takes.
export function fieldRow(field, value = "") {
  const input = document.createElement(field.options?.length ? "select" : "input");
  Object.assign(input, { name: field.name, placeholder: field.default, spellcheck: false });
  for (const option of field.options?.length ? new Set(["", ...field.options]) : []) {
    const made = element("option", "", option || (field.default ? `${field.default} (default)` : "–"));
    made.value = option;
    input.append(made);
  }
  input.value = value;
  const row = element("label", field.is_required ? "is-required" : "", element("span", "", field.label ?? field.name),
    element("span", "entry", input, field.unit ? element("span", "unit", field.unit) : ""), element("small", "", [field.words, field.text].filter(Boolean).join(" · ")));
  return row;
}

const textOf = (path) => path.join(".");

// Replace the items of a list; a button that had the focus gives it to the one in its place.
function refill(list, items) {
  const buttons = () => [...list.querySelectorAll("button")];
  const place = buttons().indexOf(document.activeElement);
  list.replaceChildren(...items);
  if (place >= 0) buttons().slice(0, place + 1).pop()?.focus();
}

// The things of a world file: a tool that places or selects them, their list, and a form.
export class WorldEditor {
  // act(facts): changes the text.
  constructor(forms, plan, act) {
    Object.assign(this, { forms, plan, act, begin: null });
    this.tool = byId("tool");
    const option = (value, words) => { const made = element("option", "", words); made.value = value; return made; };
    this.tool.replaceChildren(option("", "Select and move"), ...forms.map(({ section, name }) => option(section, name === "start" ? "Move the start" : `New ${name}`)));
    this.tool.addEventListener("change", () => { this.begin = null; byId("plan").focus(); });
    byId("delete-thing").addEventListener("click", () => this.delete());
  }

  get things() { return [...this.plan.plan.shapes, ...this.plan.plan.zones, { path: ["spawn"], name: "start", x: this.plan.plan.spawn[0], y: this.plan.plan.spawn[1] }]; }

  get path() { return this.plan.chosen ? JSON.parse(this.plan.chosen) : null; }

  choose(path) {
    this.plan.chosen = path ? JSON.stringify(path) : "";
    this.plan.draw();
    this.show();
  }

  place(x, y, path, begin) {
    const section = this.tool.value;
    if (!section) { this.choose(path ?? this.at(x, y)); return; }
    const from = begin ?? this.begin;
    if (section === "walls" && !from) {
      this.begin = [x, y];
      byId("plan-words").textContent = `A wall from (${x}, ${y}): choose its other end.`;
      return;
    }
    this.begin = null;
    this.act({ do: "place", section, begin: from ?? [x, y], end: [x, y] });
  }

  drop(path, begin, end) {
    if (this.tool.value) { this.place(...end, null, begin); return; }
    this.plan.chosen = JSON.stringify(path);
    this.act({ do: "shift", path, by: [rounded(end[0] - begin[0]), rounded(end[1] - begin[1])] });
  }

  // The thing at a place; of several the last one.
  at(x, y) {
    const isIn = (one) => {
      const [dx, dy] = [x - one.x, y - one.y];
      if (!one.size) return Math.hypot(dx, dy) <= (one.radius ?? 0.15);
      if (one.kind === "cylinder") return Math.hypot(dx, dy) <= one.size[0] / 2;
      const yaw = (one.yaw * Math.PI) / 180;
      return Math.abs(dx * Math.cos(yaw) + dy * Math.sin(yaw)) <= one.size[0] / 2 && Math.abs(dy * Math.cos(yaw) - dx * Math.sin(yaw)) <= one.size[1] / 2;
    };
    return this.things.filter(isIn).pop()?.path ?? null;
  }

  delete() {
    const { path } = this;
    if (!path || path[0] === "spawn") return;
    this.plan.chosen = "";
    this.act({ do: "delete", path });
  }

  show() {
    if (!this.plan.plan) return;
    if (this.path && !this.things.some((one) => textOf(one.path) === textOf(this.path))) this.plan.chosen = "";
    const { path } = this;
    byId("delete-thing").disabled = !path || path[0] === "spawn";
    refill(byId("things"), this.things.map((one) => {
      const button = element("button", "", one.name);
      button.type = "button";
      button.setAttribute("aria-pressed", path !== null && textOf(one.path) === textOf(path));
      button.addEventListener("click", () => this.choose(one.path));
      return element("li", "", button);
    }));
    const form = byId("plan-form");
    const kept = form.contains(document.activeElement) ? document.activeElement.name : "";
    if (!path) { delete form.dataset.shown; form.replaceChildren(element("div", "title", element("span", "", "Select something, or choose what a click places."))); return; }
    const { name, fields } = this.forms.find((one) => one.section === path[0]);
    const values = this.plan.plan.values[textOf(path)] ?? {};
    const shown = JSON.stringify([path, values]);
    if (form.dataset.shown === shown) return;
    const rows = fields.map((field) => {
      const row = fieldRow(field, values[field.name] ?? "");
      row.querySelector("input").addEventListener("change", (event) => this.set(path, field.name, event.target.value.trim()));
      return row;
    });
    form.replaceChildren(element("div", "title", element("b", "", this.things.find((one) => textOf(one.path) === textOf(path)).name), element("span", "", name)), element("div", "fields", ...rows));
    form.dataset.shown = shown;
    if (kept) form.elements[kept]?.focus();
  }

  set(path, name, value) {
    const isPlain = /^[-+.\d[{]/.test(value);
    const [at, keys] = path[0] === "spawn" ? [[], ["spawn", name]] : [path, [name]];
    this.act({ do: "set", path: at, keys, value: value || null, is_text: Boolean(value) && !isPlain });
  }
}

// The faults of the next run: a form that writes them, and their list.
export class FaultList {
  // instant(): the time at which a fault begins by default. make(fault): makes one in the run that
  // plays. onChange(). onError(text).
  constructor(kinds, instant, make, onChange, onError) {
    Object.assign(this, { kinds, instant, make, onChange, onError, faults: [] });
    this.form = byId("plan-form");
    this.form.addEventListener("submit", (event) => { event.preventDefault(); if (this.isShown) this.add(); });
  }

  get isShown() { return !byId("map-work").hidden && this.form.elements.fault !== undefined; }

  show(name = "spawn_box") {
    const kind = this.kinds.find((one) => one.name === name);
    const choice = document.createElement("select");
    choice.name = "fault";
    choice.setAttribute("aria-label", "Fault");
    for (const area of new Set(this.kinds.map((one) => one.area))) {
      const group = document.createElement("optgroup");
      group.label = area;
      for (const one of this.kinds) if (one.area === area) group.append(element("option", "", one.name));
      choice.append(group);
    }
    choice.value = name;
    choice.addEventListener("change", () => this.show(choice.value));
    const when = document.createElement("select");
    when.name = "word";
    when.setAttribute("aria-label", "When it begins");
    for (const word of ["at", "after", "when"]) when.append(element("option", "", word));
    const begins = document.createElement("input");
    Object.assign(begins, { name: "begins", value: String(this.instant()), title: "seconds, or for 'when' a condition such as speed > 0.1" });
    begins.setAttribute("aria-label", "Seconds, or a condition");
    const add = element("button", "primary", "Add");
    add.type = "submit";
    const now = element("button", "", "Now");
    Object.assign(now, { type: "button", title: "Make this fault in the run that plays" });
    now.addEventListener("click", () => this.makeNow());
    const title = element("div", "title", choice, element("span", "when", when, begins), add, now, element("span", "", kind.text));
    delete this.form.dataset.shown;
    this.form.replaceChildren(title, element("div", "fields", ...kind.fields.map((one) => fieldRow(one))));
    this.list();
  }

  // Takes a place on the map into the form: of an obstacle, if the chosen fault has no place.
  place(x, y) {
    if (!this.form.elements.at) this.show();
    this.form.elements.at.value = `(${x}, ${y})`;
    this.form.querySelector("button").focus();
  }

  // The fault of the form, as text; null after an error.
  async written(begins) {
    const { elements } = this.form;
    const kind = this.kinds.find((one) => one.name === elements.fault.value);
    const values = Object.fromEntries(kind.fields.map(({ name }) => [name, elements[name].value.trim()]).filter(([, value]) => value));
    const answer = await ask("fault", { begins, fault: kind.name, values });
    if (!answer.error) return answer;
    this.onError(answer.error);
    return null;
  }

  async add() {
    const { elements } = this.form;
    const fault = await this.written(`${elements.word.value} ${elements.begins.value.trim()}`);
    if (!fault) return;
    if (elements.at) elements.at.value = "";
    this.take([fault]);
    byId("plan").focus();
  }

  async makeNow() {
    const fault = await this.written("at 0");
    if (fault) this.make(fault.text.slice(fault.text.indexOf(": ") + 2));
  }

  take(faults) {
    this.faults.push(...faults);
    this.list();
    this.onChange();
  }

  list() {
    refill(byId("things"), this.faults.map((one) => {
      const remove = element("button", "", "Remove");
      remove.type = "button";
      remove.setAttribute("aria-label", `Remove ${one.text}`);
      remove.addEventListener("click", () => { this.faults.splice(this.faults.indexOf(one), 1); this.list(); this.onChange(); });
      return element("li", "", element("span", "", one.text), remove);
    }));
    byId("save-scenario").disabled = !this.faults.length;
  }

  get texts() { return this.faults.map((one) => one.text); }
}
