// Puts the page together: what comes is kept at once and drawn once a frame.

import { Connection } from "./connection.js";
import { CameraView } from "./camera.js";
import { drawChart } from "./chart.js";
import { Drawing, keyOf } from "./drawing.js";
import { ForkPanel } from "./fork.js";
import { MapView } from "./map.js";
import { Recorded, recordings } from "./recorded.js";
import { Report } from "./report.js";
import { LogPanel, drawGoals, drawNode, drawRequirements, drawVariables } from "./panels.js";
import { Store } from "./store.js";
import { Timeline } from "./timeline.js";
import { Tree } from "./tree.js";
import { FAILING, STATUSES, byId, element, seconds } from "./words.js";

const ARMED_MS = 5000;
const TICK_MS = 200; // between two drawings of times that only go on
const NOTICE_MS = 8000;
const STATE_STYLES = { recovering: "running", running: "running", ending: "running", observing: "running", success: "success", failure: "failure", interrupted: "failure", violated: "failure", "not exercised": "failure", untested: "failure", paused: "paused" };
const REPLAY_KEYS = { p: "play", r: "reverse", s: "change-on", S: "change-back", "+": "faster", "-": "slower", F: "fork" };
const LIVE_KEYS = { p: "pause", P: "pause_keeping_goals", r: "resume", s: "step", x: "stop", b: "breakpoint" };

const store = new Store();
let charted = null;
let isDue = false;
let ticked = 0;
let tickTimer = 0;
let drawnStops = "";
let noticeTimer = 0;
let armedTimer = 0;

const sources = recordings();
const connection = sources.length
  ? new Recorded(sources, take, onConnection, onOpen)
  : new Connection(take, onConnection, onOpen, (blob) => camera.show(blob));
const ask = (request) => connection.send(request);
const tree = new Tree(store, (index) => {
  ask({ do: "select", node: index });
  store.fresh.add("node");
  const box = drawing.boxes[index];
  if (box && drawing.selected !== keyOf(box.path)) drawing.choose(box);
  drawSoon();
});
const drawing = new Drawing((box) => { if (tree.selected !== box.index) tree.select(box.index); });
const map = new MapView(store, (isOn) => ask({ do: "map", is_on: isOn }), (fault) => ask({ do: "fault", name: fault }));
const camera = new CameraView((isOn) => ask({ do: "camera", is_on: isOn }));
const log = new LogPanel(store);
const fork = new ForkPanel(store, () => ask({ do: "play" }), say);
const report = new Report((at) => ask({ do: "go", number: at }), (index) => tree.select(index));
const timeline = new Timeline(store, (at) => ask({ do: "go", number: at }), () => {
  tree.draw(true);
  ["node", "past", "variables"].forEach((name) => store.fresh.add(name));
  drawSoon();
});

function take(told) {
  store.take(told);
  if (told.refusal) say(told.refusal);
  if (told.notice) {
    const [count, text] = told.notice;
    if (count !== store.toldNotice && text) say(text);
    store.toldNotice = count;
  }
  drawSoon();
}

function onConnection(text, isLost) {
  const box = byId("connection");
  box.textContent = text;
  box.classList.toggle("is-lost", isLost);
}

function onOpen() {
  if (store.tree) ask({ do: "select", node: tree.selected });
  if (map.isOpen) ask({ do: "map", is_on: true });
  if (camera.isOpen) ask({ do: "camera", is_on: true });
  if (charted !== null) ask({ do: "series", name: charted });
}

function say(text) {
  byId("notice").textContent = text;
  clearTimeout(noticeTimer);
  noticeTimer = setTimeout(() => { byId("notice").textContent = ""; }, NOTICE_MS);
}

// ---- drawing -------------------------------------------------------------------------------

function drawSoon() {
  if (isDue) return;
  isDue = true;
  requestAnimationFrame(draw);
}

function draw() {
  isDue = false;
  const fresh = new Set(store.fresh);
  store.fresh.clear();
  const isTick = fresh.has("tick") || (fresh.has("clock") && performance.now() - ticked >= TICK_MS);
  if (isTick) {
    ticked = performance.now();
    fresh.add("tick");
    clearTimeout(tickTimer);
  } else if (fresh.has("clock")) {
    clearTimeout(tickTimer);
    tickTimer = setTimeout(() => { store.fresh.add("tick"); drawSoon(); }, TICK_MS);
  }
  const has = (...names) => names.some((name) => fresh.has(name));
  if (has("tree") && store.isNewTree) { store.isNewTree = false; tree.begin(); drawing.boxes = []; }
  if (has("state", "tick", "factor", "hint", "choices", "is_read_only", "replay")) drawState();
  if (has("state")) tree.goAlong();
  if (store.past === null) {
    if (isTick) tree.tick();
    const stops = String(store.state.breakpoints);
    tree.draw(has("tree") || stops !== drawnStops);
    drawnStops = stops;
  }
  if (has("tree", "nodes", "state", "past")) drawDrawing();
  store.touched.clear();
  if (has("tree", "nodes", "node", "goals", "tick")) drawNode(store, tree.selected);
  if (has("log", "log_is_new", "past")) log.draw(has("log_is_new", "past"));
  if (has("goals", "values_are_new", "tick", "tree")) drawGoals(store);
  if (has("requirements", "values_are_new", "tree")) drawRequirements(store);
  if (has("variables", "values_are_new", "tree")) drawVariables(store, charted, chart);
  if (has("variables", "series", "replay", "tick", "past")) drawChart(store, charted);
  if (has("faults", "state")) byId("map-tool").hidden = !store.parts.faults || Boolean(store.parts.is_read_only) || store.isOver;
  if (fresh.has("faults")) map.draw();
  if (fresh.has("robot")) {
    if ("grid" in store.robot && store.robot.grid !== map.grid) { map.grid = store.robot.grid; map.takeGrid(); }
    map.draw();
  }
  if (has("tick", "replay", "marks", "tree", "state")) timeline.draw();
  if (has("replay", "fork")) fork.draw();
  if (has("report")) report.begin(store);
  if (has("replay") && store.parts.report) report.look(store.replay.at);
  document.documentElement.dataset.drawn = Number(document.documentElement.dataset.drawn ?? 0) + 1;
}

function drawState() {
  const { state, parts, replay } = store;
  byId("mission").textContent = state.mission || "no mission";
  document.title = `${state.mission || "no mission"} ${state.verdict ?? ""} · bt-mission`;
  const status = byId("status");
  status.textContent = state.verdict ?? "";
  status.className = `pill ${STATE_STYLES[state.verdict] ?? "idle"}`;
  const verdicts = [...store.requirements.values()].map((one) => one.verdict);
  const failing = FAILING.map((word) => [verdicts.filter((one) => one === word).length, word]).filter(([count]) => count);
  byId("figures").textContent = [
    store.tree ? seconds(parts.clock?.elapsed) : "",
    parts.factor && !store.isOver ? `${parts.factor.toFixed(1)} x real time` : "",
    state.charge === null || state.charge === undefined ? "" : `battery ${state.charge.toFixed(0)} %`,
    ...failing.map(([count, word]) => `${count} of ${verdicts.length} requirements ${word}`),
    replay ? `recording ${replay.source}` : state.is_there === false && state.source ? `${state.source} is not there` : "",
    state.file_note || "",
    replay?.missing ? `lacks ${replay.missing}` : "",
  ].filter(Boolean).join(" · ");
  byId("reason").textContent = state.reason || "";
  byId("live-keys").hidden = byId("live-controls").hidden = Boolean(replay) || Boolean(parts.is_read_only);
  byId("replay-keys").hidden = byId("replay-controls").hidden = !replay;
  for (const name of Object.values(LIVE_KEYS)) byId(name).disabled = !(state.can ?? []).includes(name);
  if (replay) label("play", replay.is_playing ? "Pause" : "Play", replay.is_playing ? "pause" : "play");
  byId("camera-panel").hidden = Boolean(replay);
  const idle = state.status === "idle" ? "No mission runs: the next one that is sent is shown here." : "";
  byId("hint").textContent = store.tree ? "" : parts.hint || idle;
  byId("hint").hidden = !byId("hint").textContent;
  drawChoices(parts.choices ?? [], replay ? replay.robot : state.source);
}

function label(name, text, icon = "") {
  const button = byId(name);
  button.lastElementChild.textContent = text;
  if (icon) button.querySelector("use").setAttribute("href", `#icon-${icon}`);
}

// Buttons are made anew only for other names, or a press of one would be lost in between.
function drawChoices(choices, shown) {
  const box = byId("choice-list");
  byId("choices").hidden = !choices.length;
  byId("choices-title").textContent = shown ? store.replay ? "Robot" : "Shown of several executives" : "There are several executives: choose one";
  const names = JSON.stringify(choices);
  if (box.dataset.names !== names) {
    box.dataset.names = names;
    box.replaceChildren(...choices.map(([name, fault]) => {
      const button = element("button", "", fault ? `${name} (${fault})` : name);
      button.type = "button";
      button.addEventListener("click", () => ask({ do: "attach", name }));
      return element("li", "", button);
    }));
  }
  choices.forEach(([name], number) => {
    box.children[number].firstChild.setAttribute("aria-pressed", name === shown);
  });
}

function chart(name) {
  charted = charted === name ? null : name;
  if (charted !== null) ask({ do: "series", name });
  store.fresh.add("variables");
  drawSoon();
}

// The tree as a drawing: its boxes when it is first shown, and their statuses.
function drawDrawing() {
  if (byId("drawing").hidden || !store.tree) return;
  const { nodes } = store.tree;
  if (!drawing.boxes.length) {
    const parents = new Set(nodes.slice(1).map((node) => node[2]));
    const kindOf = (kind, name, index) => (parents.has(index) && kind.toLowerCase() !== name.toLowerCase() ? kind.toLowerCase() : "");
    drawing.show(nodes.map(([name, kind, parent, path], index) => ({
      path: path.split(".").map(Number), parent: index ? parent : -1, kind: kindOf(kind, name, index), name, detail: "", family: "other", glyph: "", is_empty: false, takes_list: false,
    })));
    drawing.selected = keyOf(drawing.boxes[tree.selected].path);
    drawing.orient();
  }
  const { status } = store.view();
  const stops = store.state.breakpoints ?? [];
  const keys = drawing.boxes.map((box) => keyOf(box.path));
  drawing.tell({
    statuses: new Map(keys.map((key, index) => [key, STATUSES[status[index]]]).filter(([, words]) => words !== STATUSES[0])),
    stops: new Set(keys.filter((_, index) => stops.includes(nodes[index][3]) || stops.includes(nodes[index][0]))),
  });
}

function showDrawing(isWanted) {
  for (const id of ["drawing", "drawing-tools"]) byId(id).hidden = !isWanted;
  for (const id of ["tree", "fold"]) byId(id).hidden = isWanted;
  byId("as-drawing").setAttribute("aria-pressed", isWanted);
  drawDrawing();
  if (!isWanted) tree.draw(true);
  byId(isWanted ? "drawing" : "tree").focus();
}

// ---- what the user wants ---------------------------------------------------------------------

function press(name) {
  const button = byId(name);
  if (!button.disabled && !button.closest("[hidden]")) button.click();
}

for (const name of ["pause", "pause_keeping_goals", "resume", "step"]) {
  byId(name).addEventListener("click", () => ask({ do: name }));
}
byId("as-drawing").addEventListener("click", () => showDrawing(byId("drawing").hidden));
byId("breakpoint").addEventListener("click", () => ask({ do: "breakpoint", node: tree.selected }));
byId("stop").addEventListener("click", () => {
  const button = byId("stop");
  if (button.classList.contains("armed")) {
    disarm();
    ask({ do: "stop" });
    return;
  }
  button.classList.add("armed");
  label("stop", "Stop: press again");
  say("Stop again stops the mission; anything else does not");
  armedTimer = setTimeout(disarm, ARMED_MS);
});

function disarm() {
  clearTimeout(armedTimer);
  byId("stop").classList.remove("armed");
  label("stop", "Stop");
}

document.addEventListener("click", (event) => {
  if (!byId("stop").contains(event.target)) disarm();
});
const replayActs = {
  play: { do: "play" }, reverse: { do: "reverse" },
  faster: { do: "speed", number: 2 }, slower: { do: "speed", number: 0.5 },
  "change-on": { do: "change", number: 1 }, "change-back": { do: "change", number: -1 },
};
for (const [name, request] of Object.entries(replayActs)) byId(name).addEventListener("click", () => ask(request));
for (const [name, steps] of [["start-on", 1], ["start-back", -1]]) {
  byId(name).addEventListener("click", () => {
    byId("follow").checked = false;
    ask({ do: "start", node: tree.selected, number: steps });
  });
}

document.addEventListener("keydown", (event) => {
  const isText = event.target instanceof HTMLInputElement && (event.target.type === "search" || event.target.readOnly);
  if (isText || event.ctrlKey || event.metaKey || event.altKey) return;
  if (event.key === "?") return showKeys(!byId("keys").open);
  if (byId("keys").open) return;
  if (event.key !== "x") disarm();
  const names = store.replay ? REPLAY_KEYS : LIVE_KEYS;
  if (event.key in names) press(names[event.key]);
  else if (event.key === "/") { event.preventDefault(); byId("search").focus(); }
  else if (event.key === "n" || event.key === "N") tree.search(byId("search").value, tree.selected, event.key === "n" ? 1 : -1);
  else if (event.key === "f") byId("follow").click();
  else if (event.key === "d") byId("as-drawing").click();
});

function showKeys(isWanted) {
  if (isWanted) byId("keys").showModal();
  else byId("keys").close();
}
byId("show-keys").addEventListener("click", () => showKeys(true));
byId("close-keys").addEventListener("click", () => showKeys(false));

// ---- light and dark --------------------------------------------------------------------------

const prefersDark = matchMedia("(prefers-color-scheme: dark)");
function setTheme(theme) {
  document.documentElement.dataset.theme = theme;
  map.takeGrid();
  map.draw();
  timeline.drawMarks();
}
prefersDark.addEventListener("change", () => setTheme(prefersDark.matches ? "dark" : "light"));
byId("theme").addEventListener("click", () => setTheme(document.documentElement.dataset.theme === "dark" ? "light" : "dark"));
setTheme(prefersDark.matches ? "dark" : "light");
const isFramed = self !== top;
document.body.classList.toggle("is-framed", isFramed);
if (isFramed || matchMedia("(min-width: 1000px) and (min-height: 640px)").matches) byId("map-toggle").click();
