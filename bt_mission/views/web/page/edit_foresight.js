// What the drawing shows after an act, as long as the server has not changed the text yet.

import { keyOf } from "./drawing.js";

const EMPTY = { kind: "", name: "", detail: "", family: "other", glyph: "", start: 0, end: 0, is_empty: true, takes_list: false, values: {} };

// The boxes as nodes with those below them; `step` leads from a node to one below it.
function nodesOf(boxes) {
  const nodes = boxes.map((box) => ({ box, step: box.path, below: [], above: null }));
  nodes.forEach((node, index) => {
    const { parent } = boxes[index];
    if (parent < 0) return;
    node.step = node.box.path.slice(boxes[parent].path.length);
    node.above = nodes[parent];
    node.above.below.push(node);
  });
  return nodes;
}

const isListed = (step) => typeof step[step.length - 1] === "number";

// A new node of a kind, as the server has outlined its template.
function newNode(kind) {
  const rows = kind.boxes.map((box) => ({ ...box, parent: box.parent - 1 }));
  return nodesOf(rows)[0];
}

function copyOf(node) {
  return { ...node, below: node.below.map(copyOf) };
}

// Puts a node at a target; false where there is no place for it.
function put(nodes, target, node) {
  const length = typeof target[target.length - 1] === "number" ? 2 : 1;
  const [holder, step] = [keyOf(target.slice(0, -length)), target.slice(-length)];
  const above = nodes.find(({ box }) => keyOf(box.path) === holder);
  if (!above) return false;
  const at = above.below.findIndex((one) => keyOf(one.step) === keyOf(step));
  if (length === 1 && at >= 0 && !above.below[at].box.is_empty) return false;
  Object.assign(node, { step, above });
  above.below.splice(at < 0 ? above.below.length : at, length === 1 && at >= 0 ? 1 : 0, node);
  return true;
}

// Removes a node: from a list, or so that its place is empty.
function take(node) {
  const { below } = node.above;
  const empty = { box: EMPTY, step: node.step, below: [], above: node.above };
  below.splice(below.indexOf(node), 1, ...(isListed(node.step) ? [] : [empty]));
}

function replace(node, other) {
  const { below } = node.above;
  below[below.indexOf(node)] = Object.assign(other, { step: node.step, above: node.above });
}

// The boxes of nodes in order, with their paths as they are now.
function boxesOf(root) {
  const boxes = [];
  const paths = new Map();
  const walk = (node, path, parent) => {
    const index = boxes.length;
    boxes.push({ ...node.box, path, parent });
    paths.set(node, path);
    let number = 0;
    for (const one of node.below) walk(one, [...path, ...(isListed(one.step) ? [one.step[0], number++] : one.step)], index);
  };
  walk(root, [], -1);
  return [boxes, paths];
}

const ACTS = {
  add: (nodes, { target }, node, kind) => { const made = newNode(kind); return put(nodes, target, made) ? made : null; },
  copy: (nodes, { path }, node) => {
    const last = path[path.length - 1];
    const made = copyOf(node);
    return typeof last === "number" && put(nodes, [...path.slice(0, -1), last + 1], made) ? made : null;
  },
  delete: (nodes, facts, node) => {
    const { below } = node.above;
    const at = below.indexOf(node);
    take(node);
    return below[at] ?? node.above;
  },
  move: (nodes, { target }, node) => {
    const moved = { ...node };
    const isInside = node.box.path.every((part, index) => part === target[index]);
    if (isInside || !put(nodes, target, moved)) return null;
    take(node);
    return moved;
  },
  wrap: (nodes, facts, node, kind) => {
    const outer = newNode(kind);
    const place = outer.below.find((one) => one.box.is_empty);
    replace(node, outer);
    if (kind.boxes[0].takes_list) outer.below = [Object.assign(node, { step: [kind.kind, 0], above: outer })];
    else if (place) outer.below[outer.below.indexOf(place)] = Object.assign(node, { step: place.step, above: outer });
    else return null;
    return outer;
  },
  unwrap: (nodes, facts, node) => {
    if (node.below.length !== 1 || node.below[0].box.is_empty) return null;
    replace(node, node.below[0]);
    return node.below[0];
  },
  set: (nodes, { keys, value }, node) => {
    if (keyOf(keys) !== '["name"]') return null;
    node.box = { ...node.box, name: value ?? "" };
    return node;
  },
};

// The boxes after an act, and the path that is selected then; null where only the server can know.
export function foreseen(boxes, facts, kinds) {
  const nodes = nodesOf(boxes);
  const node = facts.path && nodes.find(({ box }) => keyOf(box.path) === keyOf(facts.path));
  if (!ACTS[facts.do] || (facts.path && !node?.above)) return null;
  const chosen = ACTS[facts.do](nodes, facts, node, kinds.find((one) => one.kind === facts.kind));
  if (!chosen) return null;
  const [after, paths] = boxesOf(nodes[0]);
  return { boxes: after, selected: paths.get(chosen) };
}
