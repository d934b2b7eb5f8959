// The run of the text, in a frame; its statuses in the drawing; the proof.

import { ask } from "./edit_api.js";
import { keyOf } from "./drawing.js";
import { STATUSES, byId, element } from "./words.js";

const POLL_MS = 50;
const wait = (ms) => new Promise((done) => { setTimeout(done, ms); });

export class RunPane {
  // onStatuses(statuses of paths, breakpoints): those of a run. onFaults(faults): those that began
  // by a click in the run. onError(text).
  constructor(onStatuses, onFaults, onError) {
    Object.assign(this, { onStatuses, onFaults, onError, number: 0, socket: null, text: null, faults: [] });
    byId("run-stop").addEventListener("click", () => this.stop());
  }

  // before: the path of the node before which the run pauses; from: the instant of the last run
  // from which this one continues.
  // faults: those of the run, and of a continued one those that are new.
  async start(name, text, { before = "", from = null, faults = [] }) {
    const number = ++this.number;
    this.leave();
    byId("panes").classList.add("has-run");
    byId("run-panel").hidden = false;
    byId("run-frame").hidden = true;
    byId("run-lines").hidden = true;
    byId("run-state").textContent = "starting";
    const isEditable = byId("editable").checked && from === null;
    Object.assign(this, { executive: "", status: "", paused: null, from });
    if (from === null) Object.assign(this, { text, faults });
    const facts = { name, text, speed: byId("speed").value, faults };
    const answer = from === null ? await ask("run", { ...facts, is_editable: isEditable, before }) : await ask("fork", { ...facts, at: from });
    if (answer.error) { this.fail([answer.error]); return; }
    while (number === this.number) {
      const run = await ask("ran");
      if (run.state === "over") { this.fail(run.lines); return; }
      if (run.state === "served") break;
      await wait(POLL_MS);
    }
    if (number !== this.number) return;
    this.describe("");
    byId("apply").hidden = !isEditable;
    byId("run-frame").hidden = false;
    byId("run-frame").src = "run/";
    this.watch();
  }

  fail(lines) {
    byId("run-state").textContent = this.from === null ? "did not start" : `cannot continue from ${this.from.toFixed(2)} s`;
    byId("run-lines").hidden = false;
    byId("run-lines").textContent = lines.join("\n");
  }

  describe(words) {
    byId("run-state").textContent = [this.from === null ? "" : `from ${this.from.toFixed(2)} s with the text as it is`, words].filter(Boolean).join("; ");
  }

  // The instant that is shown, in seconds, and why the run cannot continue from there.
  // A recording has no pauses, so a paused run continues from the instant of its pause at the latest.
  instant() {
    if (this.text === null) return [0, "Run the mission first."];
    if (byId("run-frame").hidden) return this.from === null ? [0, "The mission did not run."] : [this.from, ""];
    if (["", "running", "ending"].includes(this.status)) return [0, "Pause the run, or wait for its end."];
    const shown = Number(byId("run-frame").contentDocument.getElementById("time").value);
    return [this.status === "paused" ? Math.min(shown, this.paused) : shown, ""];
  }

  leave() {
    this.socket?.close();
    this.socket = null;
    byId("apply").hidden = true;
    byId("run-frame").src = "about:blank";
    this.onStatuses(new Map(), []);
  }

  async stop() {
    this.number++;
    this.leave();
    byId("run-panel").hidden = true;
    byId("panes").classList.remove("has-run");
    await ask("run", { stop: true });
  }

  get isPlaying() { return this.socket !== null && ["running", "paused"].includes(this.status); }

  // Makes a fault in the run that plays.
  make(fault) {
    this.isAsking = true;
    this.socket.send(JSON.stringify({ do: "fault", name: fault }));
  }

  // Reads the statuses of the nodes of the mission's own tree.
  watch() {
    const url = new URL("run/live", location.href);
    url.protocol = "ws:";
    const socket = new WebSocket(url);
    this.socket = socket;
    let paths = [];
    let stops = [];
    const statuses = new Map();
    socket.onmessage = (event) => {
      if (typeof event.data !== "string") return;
      const changes = JSON.parse(event.data);
      if (changes.notice?.[1] && this.isAsking) { this.isAsking = false; if (!changes.faults) this.onError(changes.notice[1]); }
      if (changes.faults?.length) this.onFaults(changes.faults.map(([text, place]) => ({ text, at: place })));
      if (changes.source) this.executive = changes.source;
      if (changes.tree) paths = changes.tree.nodes.map((node) => node[3]);
      for (const [index, status] of changes.nodes ?? []) statuses.set(paths[index], STATUSES[status]);
      for (const [time, , words] of changes.log ?? []) if (words === "mission paused") this.paused ??= time;
      if (changes.state) {
        const { status, reason, breakpoints } = changes.state;
        this.status = status;
        this.describe(status === "paused" ? `paused: ${reason}` : "");
        stops = breakpoints;
      }
      if (changes.tree || changes.nodes || changes.state) this.onStatuses(statuses, stops);
    };
  }
}

// The paths of boxes as a run names its nodes: the numbers of children from the root.
export function runPaths(drawing) {
  const paths = new Map();
  const tree = drawing.boxes.find((box) => box.path.length === 1 && box.path[0] === "tree");
  const take = (box, path) => {
    paths.set(path, keyOf(box.path));
    drawing.children[box.index].forEach((child, number) => take(child, `${path}.${number}`));
  };
  if (tree) take(tree, "0");
  return paths;
}

export async function prove(name, text, show) {
  const started = await ask("prove", { name, text });
  if (started.error) { show(null, [started.error]); return; }
  let proof = await ask("proved");
  while (!proof.is_over) {
    await wait(10 * POLL_MS);
    proof = await ask("proved");
  }
  show(proof.result, proof.lines);
}

// The findings: one that opens selects its first node, and shows its steps.
export function findingList(result, nameOf, select) {
  return element("ul", "findings", ...result.findings.map((one) => {
    const places = one.nodes.length > 1 ? one.nodes.map((node) => {
      const go = element("button", "", nameOf(node));
      go.type = "button";
      go.addEventListener("click", () => select(node));
      return go;
    }) : [];
    const steps = one.steps.length ? one.steps.map((step) => element("li", "", step)) : [element("li", "", "at once")];
    const details = element("details", "", element("summary", "", one.text), element("div", "bar", ...places), element("ol", "", ...steps));
    details.name = "finding";
    details.addEventListener("toggle", () => { if (details.open && one.nodes.length) select(one.nodes[0]); });
    return element("li", "", details);
  }));
}
