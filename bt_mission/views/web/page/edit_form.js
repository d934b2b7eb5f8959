// The palette of new nodes, and the form of the selected node.

import { byId, element } from "./words.js";

const NUMBER = /^[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?$/;
const FAMILIES = { composite: "Flow", decorator: "Around a node", condition: "Conditions", action: "Actions", message: "Messages", subtree: "Trees", other: "Other" };
const USUAL = ["name", "timeout", "cancel_when", "on_cancel", "outputs", "memory", "succeed_when"];

function control(tag, attributes) {
  const made = document.createElement(tag);
  Object.assign(made, attributes);
  return made;
}

export class Palette {
  // onTake(kind): by a click. onDrag(event, kind): by the mouse.
  constructor(kinds, onDrag, onTake) {
    Object.assign(this, { kinds, onDrag, onTake });
    this.filter = byId("palette-filter");
    this.filter.addEventListener("input", () => this.draw());
    this.filter.addEventListener("keydown", (event) => {
      if (event.key === "Escape") { this.filter.value = ""; this.draw(); byId("drawing").focus(); }
      if (event.key !== "Enter") return;
      event.preventDefault();
      const first = this.matching()[0];
      if (!first) return;
      this.filter.value = "";
      this.draw();
      byId("drawing").focus();
      onTake(first.kind);
    });
    this.draw();
  }

  matching() {
    const wanted = this.filter.value.trim().toLowerCase();
    const found = this.kinds.filter((one) => one.kind.includes(wanted));
    return found.sort((one, other) => Number(other.kind === wanted) - Number(one.kind === wanted));
  }

  draw() {
    const list = byId("palette-list");
    const matching = this.matching();
    const parts = [];
    for (const [family, title] of Object.entries(FAMILIES)) {
      const kinds = matching.filter((one) => one.family === family);
      if (!kinds.length) continue;
      parts.push(element("h3", "", title));
      for (const one of kinds) {
        const button = element("button", family, element("i", "", one.glyph), element("span", "", one.kind));
        Object.assign(button, { type: "button", title: one.text, id: `new-${one.kind}` });
        button.style.color = "";
        if (this.filter.value && one === matching[0]) button.classList.add("is-first");
        button.addEventListener("pointerdown", (event) => { if (!event.button) this.onDrag(event, one.kind); });
        button.addEventListener("keydown", (event) => {
          if (event.key === "Enter" || event.key === " ") { event.preventDefault(); this.onTake(one.kind); }
        });
        parts.push(button);
      }
    }
    list.replaceChildren(...parts);
  }
}

export class Form {
  // onSet(box, keys, value, isText): a field has a new value; null removes it.
  constructor(vocabulary, onSet) {
    this.kinds = new Map(vocabulary.kinds.map((one) => [one.kind, one]));
    this.mission = vocabulary.mission;
    this.names = { world: vocabulary.worlds, robot: vocabulary.robots };
    this.onSet = onSet;
    this.form = byId("form");
    this.form.addEventListener("submit", (event) => event.preventDefault());
    this.shown = "";
  }

  show(box) {
    const told = JSON.stringify(box && [box.path, box.kind, box.values]);
    if (told === this.shown) return;
    const kept = this.form.contains(document.activeElement) ? document.activeElement.name : "";
    const isOpen = this.form.querySelector("details")?.open;
    this.shown = told;
    this.box = box;
    if (!box || box.is_empty) {
      this.form.replaceChildren(element("div", "title", element("span", "", box ? "An empty place: choose a new node, or drop one here." : "Choose a new node to begin a mission.")));
      return;
    }
    const kind = this.kinds.get(box.kind);
    const fields = box.path.length ? kind?.fields ?? [] : this.mission;
    const title = element("div", "title", element("b", "", box.name || box.kind), element("span", "", box.path.length ? kind?.text ?? "" : "The mission: its world, robot and inputs."));
    const isUsual = (field) => !box.path.length ? !["nodes", "include", "follow", "places", "limits", "servers", "requirements", "nature", "observe", "description"].includes(field.keys[0]) || this.isWritten(field)
      : field.keys.length > 1 || field.keys[0] === box.kind || USUAL.includes(field.keys[0]) || this.isWritten(field);
    const more = fields.filter((field) => !isUsual(field));
    const parts = [title, element("div", "fields", ...fields.filter(isUsual).flatMap((field) => this.rows(field)))];
    if (more.length) {
      const details = element("details", "", element("summary", "", `${more.length} more fields`), element("div", "fields", ...more.flatMap((field) => this.rows(field))));
      details.open = isOpen ?? false;
      parts.push(details);
    }
    this.form.replaceChildren(...parts);
    if (kept) this.form.elements[kept]?.focus();
  }

  isWritten(field) {
    const key = field.keys.join(".");
    return Object.keys(this.box.values).some((one) => one === key || one.startsWith(`${key}.`));
  }

  // The rows of a field; a mapping has one for each of its keys, and one for a new key.
  rows(field) {
    const key = field.keys.join(".");
    const inner = Object.keys(this.box.values).filter((one) => one.startsWith(`${key}.`) && !(key in this.box.values));
    const isMapping = field.type === "yaml" && (inner.length || (!(key in this.box.values) && ["outputs", "inputs", "set"].includes(field.keys[field.keys.length - 1])));
    if (!isMapping) return [this.row(field, field.keys, field.keys[field.keys.length - 1], field.is_required)];
    const rows = inner.map((one) => this.row({ ...field, type: "yaml" }, [...field.keys, one.slice(key.length + 1)], `${field.keys[field.keys.length - 1]}: ${one.slice(key.length + 1)}`));
    return [...rows, this.newRow(field)];
  }

  newRow(field) {
    const last = field.keys[field.keys.length - 1];
    const name = control("input", { name: `${field.keys.join(".")} name`, placeholder: "name" });
    const value = control("input", { name: `${field.keys.join(".")} value`, placeholder: "value" });
    name.setAttribute("aria-label", `New name in ${last}`);
    value.setAttribute("aria-label", `New value in ${last}`);
    const set = () => { if (name.value.trim() && value.value.trim()) this.set(field, [...field.keys, name.value.trim()], value.value); };
    for (const input of [name, value]) input.addEventListener("change", set);
    const row = element("div", "row-of", element("span", "quiet", `${last}: new`), element("span", "entry", name, value));
    return row;
  }

  row(field, keys, words, isRequired = false) {
    const written = this.box.values[keys.join(".")] ?? "";
    const names = this.box.path.length ? null : this.names[keys[0]];
    const options = names ?? field.options;
    let input;
    if (options?.length) {
      input = control("select", {});
      for (const option of new Set(["", ...options, written])) input.append(control("option", { value: option, textContent: option || (field.default ? `${field.default} (default)` : "–") }));
      input.value = written;
    } else {
      input = control("input", { value: written, placeholder: field.default || (field.type === "condition" ? "condition" : ""), spellcheck: false });
    }
    input.name = keys.join(".");
    input.addEventListener("change", () => this.set(field, keys, input.value));
    const label = element("label", isRequired ? "is-required" : "", element("span", "", words),
      element("span", "entry", input, field.unit ? element("span", "unit", field.unit) : ""));
    const remarks = [field.words, field.text].filter(Boolean).join(" · ");
    if (remarks) { label.append(element("small", "", remarks)); label.title = remarks; }
    return label;
  }

  set(field, keys, value) {
    const text = value.trim();
    if (!text) { this.onSet(this.box, keys, null, false); return; }
    const isPlain = field.type !== "text" && (NUMBER.test(text) || ["true", "false"].includes(text) || (field.type === "yaml" && /^[[{'"]/.test(text)));
    this.onSet(this.box, keys, text, !isPlain);
  }
}
