// The state of the mission, and how its nodes have changed.

const MOST_CHANGES = 100000;
const LOG_LINES = 2000;

export class Store {
  constructor() {
    this.parts = {};
    this.robot = {};
    this.node = null;
    this.log = [];
    this.logCount = 0;
    this.series = new Map();
    this.past = null; // the time that is looked at, s; null is now
    this.fresh = new Set(); // kinds of news that have not been drawn
    this.touched = new Set(); // nodes that have changed and not been drawn
    this.begin(null, null);
  }

  // past: { begin, changes } with the changes of nodes since the mission's start; not for recordings.
  begin(tree, past) {
    const before = this.tree;
    const isSame = before && tree && before.run === tree.run && before.nodes.length === tree.nodes.length;
    this.tree = tree;
    const count = tree ? tree.nodes.length : 0;
    this.status = new Uint8Array(count);
    this.message = new Array(count).fill("");
    this.since = new Array(count).fill(null);
    this.ran = new Array(count).fill(null);
    this.progress = new Array(count).fill(null);
    this.goals = new Map();
    this.variables = new Map();
    this.requirements = new Map();
    this.changes = past?.changes ?? [];
    this.base = { status: this.status.slice(), message: this.message.slice() };
    this.baseTime = past?.begin ?? 0;
    this.pastView = null;
    if (!isSame) {
      this.past = null;
      this.isNewTree = true;
      this.series.clear();
      this.node = null;
    }
  }

  get state() { return this.parts.state ?? {}; }
  get isOver() { return ["success", "failure", "interrupted"].includes(this.state.status); }
  get replay() { return this.parts.replay ?? null; }
  get now() { return this.parts.clock?.now ?? 0; }

  take(told) {
    if ("tree" in told) { this.begin(told.tree, told.past); this.fresh.add("tree"); }
    if (told.values_are_new) {
      for (const name of ["goals", "variables", "requirements"]) { this[name].clear(); this.fresh.add(name); }
    }
    for (const [name, value] of Object.entries(told)) {
      switch (name) {
        case "tree": case "past": case "values_are_new": case "log_is_new": break;
        case "nodes": case "goals": case "variables": case "requirements": case "log": case "robot": case "node": case "series": break;
        default: this.parts[name] = value;
      }
      this.fresh.add(name);
    }
    if (told.nodes) this.takeNodes(told.nodes, !this.replay && !("tree" in told));
    for (const goal of told.goals ?? []) this.goals.set(goal[0], goal);
    for (const [name, value] of told.variables ?? []) this.takeVariable(name, value);
    for (const requirement of told.requirements ?? []) this.requirements.set(requirement.name, requirement);
    if (told.log_is_new) this.log = [];
    if (told.log) {
      this.logCount += told.log.length;
      this.log.push(...told.log);
      if (this.log.length > LOG_LINES) this.log.splice(0, this.log.length - LOG_LINES);
    }
    if (told.robot) Object.assign(this.robot, told.robot);
    if (told.node) this.node = told.node;
    if (told.series) this.series.set(told.series[0], told.series[1]);
  }

  // keeps: add what is new to the changes; those that came with the tree are in them.
  takeNodes(rows, keeps) {
    for (const [index, status, message, since, ran, progress] of rows) {
      if (keeps && (this.status[index] !== status || this.message[index] !== message)) {
        this.changes.push([status === 1 && since !== null && status !== this.status[index] ? since : this.now, index, status, message]);
      }
      this.status[index] = status;
      this.message[index] = message;
      this.since[index] = since;
      this.ran[index] = ran;
      this.progress[index] = progress;
      this.touched.add(index);
    }
    if (this.changes.length > MOST_CHANGES) this.forget(MOST_CHANGES / 2);
  }

  forget(count) {
    for (const [time, index, status, message] of this.changes.splice(0, count)) {
      this.base.status[index] = status;
      this.base.message[index] = message;
      this.baseTime = time;
    }
  }

  takeVariable(name, value) {
    this.variables.set(name, value);
    const series = this.series.get(name);
    if (series && !this.replay && Number.isFinite(Number(value))) series.push([this.now, Number(value)]);
  }

  // The statuses and messages at the time that is looked at.
  view() {
    if (this.past === null) return this;
    if (this.pastView?.at === this.past) return this.pastView;
    const status = this.base.status.slice();
    const message = this.base.message.slice();
    for (const [time, index, now, words] of this.changes) {
      if (time > this.past) break;
      status[index] = now;
      message[index] = words;
    }
    this.pastView = { at: this.past, status, message };
    return this.pastView;
  }

  path(index) {
    const path = [index];
    while (index) { index = this.tree.nodes[index][2]; path.push(index); }
    return path.reverse();
  }
}
