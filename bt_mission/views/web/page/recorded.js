// A recording that is played in the page: a source of messages with the interface of a connection.

const SPACING = 500; // messages between two states that are kept
const NEAR = 200; // messages that are applied one by one; for more, the whole state is sent
const NOT_FINITE = ["inf", "-inf", "nan"]; // as variables are written
const LOG_LINES = 500;
const TRAIL_POINTS = 2000;
const MARKS = 500;
const SHOWN_ENDS = 4;
const [SLOWEST, FASTEST] = [1 / 64, 1024];
const TOO_OLD = "This browser is too old for this page. It needs Chrome 80, Firefox 113, Safari 16.4, or newer.";

// The recordings of a page: one for each robot. Empty where the page is live.
export function recordings() {
  return [...document.querySelectorAll("script.recording")].map((script) => ({
    name: script.dataset.robot, read: () => inflated(script.textContent),
  }));
}

async function inflated(text) {
  if (!window.DecompressionStream) throw new Error(TOO_OLD);
  const packed = atob(text.trim());
  const bytes = new Uint8Array(packed.length);
  for (let index = 0; index < packed.length; index++) bytes[index] = packed.charCodeAt(index);
  return new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"))).json();
}

// The number of values up to a limit, in ascending order.
export function countUntil(values, limit, of = (value) => value) {
  let [low, high] = [0, values.length];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (of(values[middle]) <= limit) low = middle + 1;
    else high = middle;
  }
  return low;
}

// What a page knows after some messages, as it would be sent to a new page.
class State {
  constructor(from = { tree: null, nodes: [], goals: [], variables: [], requirements: [], parts: {}, robot: {}, lines: 0 }) {
    this.tree = from.tree;
    this.nodes = new Map(from.nodes);
    this.goals = new Map(from.goals);
    this.variables = new Map(from.variables);
    this.requirements = new Map(from.requirements);
    this.parts = { ...from.parts };
    this.robot = { ...from.robot };
    this.lines = from.lines;
  }

  apply(message) {
    for (const [name, value] of Object.entries(message)) {
      switch (name) {
        case "tree": this.tree = value; this.nodes.clear(); break;
        case "values_are_new": this.goals.clear(); this.variables.clear(); this.requirements.clear(); break;
        case "nodes": for (const node of value) this.nodes.set(node[0], node); break;
        case "goals": for (const goal of value) this.goals.set(goal[0], goal); break;
        case "variables": for (const [variable, text] of value) this.variables.set(variable, text); break;
        case "requirements": for (const requirement of value) this.requirements.set(requirement.name, requirement); break;
        case "robot": Object.assign(this.robot, value); break;
        case "log": this.lines += value.length; break;
        case "log_is_new": break;
        default: this.parts[name] = value;
      }
    }
  }

  whole(log) {
    return {
      ...this.parts, tree: this.tree, values_are_new: true,
      nodes: [...this.nodes.values()], goals: [...this.goals.values()], variables: [...this.variables],
      requirements: [...this.requirements.values()], robot: { scan: [], targets: [], zones: [], grid: null, ...this.robot },
      log_is_new: true, log: log.slice(Math.max(this.lines - LOG_LINES, 0), this.lines),
    };
  }
}

export class Recorded {
  // sources: of recordings(). The others are those of a Connection.
  constructor(sources, take, onState, onOpen) {
    Object.assign(this, { sources, take, onState, onOpen, data: null, selected: null, notices: 0 });
    Object.assign(this, { at: 0, speed: 1, isPlaying: false, isBackwards: false });
    this.open(0);
  }

  async open(number) {
    this.onState("opening the recording", false);
    try {
      this.data = await this.sources[number].read();
    } catch (error) {
      this.onState(error.message, true);
      return;
    }
    const { data } = this;
    this.number = number;
    this.log = data.messages.flatMap((message) => message.log ?? []);
    this.kept = [new State()];
    this.index = Infinity; // so that the whole state is sent
    this.isPlaying = this.isBackwards = false;
    this.speed = data.speed ?? 1;
    this.at = this.within(data.at ?? data.duration);
    const marks = new Set(data.changes.map((at) => Math.floor((at / Math.max(data.duration, 1e-9)) * MARKS) / MARKS));
    this.take({
      replay: this.replay(), report: data.details, fork: data.fork, marks: [...marks].filter((share) => share >= 0 && share <= 1),
      choices: this.sources.length > 1 ? this.sources.map((source) => [source.name, ""]) : [],
    });
    this.onState("", false);
    this.show();
    this.onOpen();
  }

  // ---- what the page wants

  send(request) {
    if (!this.data) return;
    switch (request.do) {
      case "play": this.isPlaying ? this.pause() : this.play(); break;
      case "reverse": this.isBackwards = !this.isBackwards; this.isPlaying = !this.isAtEnd(); this.run(); break;
      case "speed": this.speed = Math.min(Math.max(this.speed * request.number, SLOWEST), FASTEST); break;
      case "go": this.at = this.within(request.number); break;
      case "change": this.step(this.data.changes, request.number, "the tree does not change after this", "nothing before this"); break;
      case "start": this.stepToStart(request.node, request.number); break;
      case "select": this.selected = request.node; break;
      case "series": this.take({ series: [request.name, this.series(request.name)] }); break;
      case "attach": this.open(this.sources.findIndex((source) => source.name === request.name)); return;
      default: return;
    }
    this.show();
  }

  play() {
    if (this.isAtEnd()) this.at = this.isBackwards ? this.data.duration : 0;
    this.isPlaying = true;
    this.run();
  }

  pause() { this.isPlaying = false; }

  stepToStart(node, steps) {
    const { details: { spans }, messages } = this.data;
    const starts = (spans.rows[node] ?? []).map((span) => span[0]);
    const name = messages.find((message) => message.tree)?.tree.nodes[node]?.[0];
    this.step(starts, steps, `'${name}' does not start later`, `'${name}' does not start before this`);
  }

  step(times, steps, noneAfter, noneBefore) {
    this.isPlaying = false;
    const later = steps > 0;
    const index = later ? countUntil(times, this.at + 5e-4) : countUntil(times, this.at - 5e-4) - 1;
    if (times[index] === undefined) this.take({ notice: [++this.notices, later ? noneAfter : noneBefore] });
    else this.at = this.within(times[index]);
  }

  series(name) {
    let values = [];
    let offset = 0;
    this.data.messages.forEach((message, index) => {
      if (message.tree) { values = []; offset = message.tree.start - this.data.start; }
      const found = (message.variables ?? []).find((variable) => variable[0] === name);
      const value = NOT_FINITE.includes(found?.[1]) ? null : Number(found?.[1] || "text");
      if (!Number.isNaN(value)) values.push([this.data.times[index] - offset, value]);
    });
    return values;
  }

  // ---- the time that is shown

  within(at) { return Math.min(Math.max(at, 0), this.data.duration); }

  isAtEnd() { return this.isBackwards ? this.at <= 0 : this.at >= this.data.duration; }

  run() {
    if (this.isRunning) return;
    this.isRunning = true;
    let before = performance.now();
    const frame = (now) => {
      if (!this.isPlaying) { this.isRunning = false; return; }
      this.at = this.within(this.at + ((this.isBackwards ? -1 : 1) * this.speed * Math.max(now - before, 0)) / 1000);
      before = now;
      if (this.isAtEnd()) {
        this.isPlaying = false;
        if (!this.isBackwards && this.data.cut) this.take({ notice: [++this.notices, `the recording ends here: ${this.data.cut}`] });
      }
      this.show();
      requestAnimationFrame(frame);
    };
    requestAnimationFrame(frame);
  }

  replay() {
    const { data } = this;
    return {
      at: this.at, duration: data.duration, speed: this.speed, is_playing: this.isPlaying, is_backwards: this.isBackwards,
      cut: data.cut, missing: data.missing, source: data.source, robot: this.sources[this.number]?.name ?? "",
    };
  }

  // The state after so many messages, from the last one that is kept before it.
  stateAfter(count) {
    const kept = Math.min(Math.floor(count / SPACING), this.kept.length - 1);
    const state = new State(this.kept[kept]);
    for (let index = kept * SPACING; index < count; index++) {
      state.apply(this.data.messages[index]);
      if ((index + 1) % SPACING === 0 && (index + 1) / SPACING === this.kept.length) this.kept.push(new State(state));
    }
    return state;
  }

  show() {
    const { data } = this;
    const count = countUntil(data.times, this.at + 1e-6);
    const isNear = count >= this.index && count - this.index <= NEAR;
    this.take({ replay: this.replay() });
    if (!isNear) {
      this.state = this.stateAfter(count);
      this.take(this.state.whole(this.log));
    } else {
      for (const message of data.messages.slice(this.index, count)) {
        this.state.apply(message);
        this.take(message);
      }
    }
    this.index = count;
    const { tree, parts } = this.state;
    const now = Math.max(this.at - (tree ? tree.start - data.start : 0), 0);
    this.take({ clock: { now, elapsed: parts.ended ?? now }, robot: this.robot(), ...(tree && this.selected !== null ? { node: this.node(now) } : {}) });
  }

  node(now) {
    const { spans, asked } = this.data.details;
    const rows = spans.rows[this.selected] ?? [];
    const ended = rows.filter(([, end, status]) => status !== 1 && end <= now + 1e-6).slice(-SHOWN_ENDS).reverse();
    return {
      index: this.selected, asked: asked[this.selected] ?? [],
      ends: ended.map(([begin, end, status, text]) => [status, end, end - begin, spans.texts[text]]),
    };
  }

  robot() {
    const { poses, others, details: { truth, collisions, stops, goals } } = this.data;
    const until = (track) => {
      const count = countUntil(track.t, this.at + 1e-6);
      const step = Math.max(Math.floor(count / TRAIL_POINTS), 1);
      const points = [];
      for (let index = 0; index < count; index += step) points.push([track.x[index], track.y[index]]);
      const pose = count ? [track.x[count - 1], track.y[count - 1], track.yaw[count - 1]] : null;
      if (pose) points.push(pose.slice(0, 2));
      return { pose, points };
    };
    const [known, real] = [until(poses), until(truth)];
    const isPast = (at) => at !== null && at <= this.at + 1e-6;
    return {
      pose: known.pose ?? real.pose, trail: known.points, way: real.points,
      others: Object.entries(others).map(([name, track]) => [name, ...(until(track).pose ?? [NaN, NaN, NaN])]),
      collisions: collisions.filter(([at]) => isPast(at)), stops: stops.filter(([at]) => isPast(at)),
      ends: goals.map((goal, number) => [number + 1, goal]).filter(([, goal]) => goal.place && isPast(goal.end))
        .map(([number, goal]) => [...goal.place, number, goal.status]),
    };
  }
}
