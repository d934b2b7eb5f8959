// The panels beside the tree: lists of what is known.

import {
  SIGNS, STATUSES, byId, element, figures, goalStatus, isOpen, seconds, short, verdictRank, verdictStatus,
} from "./words.js";

const MOST_GOALS = 200;
const MOST_LINES = 500;

const sign = (status) => element("span", `sign ${STATUSES[status]}`, `${SIGNS[status]} `);

export function drawNode(store, index) {
  const box = byId("node");
  if (!store.tree) { box.replaceChildren(); return; }
  const [name, kind, , path] = store.tree.nodes[index];
  const view = store.view();
  const status = view.status[index];
  const list = element("dl");
  const add = (title, ...words) => list.append(element("dt", "", title), element("dd", "", ...words));
  add("node", element("strong", "", name), ` ${kind}, path ${path}`);
  add("status", sign(status), status ? STATUSES[status] : "not running");
  if (view.message[index]) add("says", view.message[index]);
  if (store.past === null) addPresent(store, index, status, add);
  const node = store.node?.index === index ? store.node : null;
  node?.asked.forEach((line, number) => add(number ? "" : "asked to", line));
  const goal = [...store.goals.values()].filter((one) => one[2] === name).pop();
  if (goal) add("goal", sign(goalStatus(goal[3])), `${goal[3]} at ${goal[1]}, ${goal[0].slice(0, 8)}`);
  node?.ends.forEach(([end, at, ran, words], number) => {
    const when = at === null ? "" : ` at ${at.toFixed(2)} s`;
    const took = ran ? `, ran ${seconds(ran)}` : "";
    const how = end ? STATUSES[end] : "halted";
    add(number ? "" : "ended", sign(end), `${how}${when}${took}${words && words !== how ? `: ${words}` : ""}`);
  });
  box.replaceChildren(list);
}

function addPresent(store, index, status, add) {
  const since = store.since[index];
  if (status === 1 && since !== null) add("runs for", `${seconds(store.now - since)}, since ${since.toFixed(2)} s`);
  else if (status > 1 && store.ran[index] !== null) add("ran", seconds(store.ran[index]));
  const progress = status === 1 ? store.progress[index] : null;
  if (progress && progress[1] !== null) add(progress[0] === "s" ? "time" : progress[0] || "progress", figures(progress));
}

// Only lines that have come are added, unless others are wanted than before.
export class LogPanel {
  constructor(store) {
    this.store = store;
    this.box = byId("log");
    this.filter = byId("filter");
    this.filter.addEventListener("input", () => this.draw(true));
    this.drawn = 0;
  }

  draw(anew) {
    const { box, store } = this;
    const wanted = this.filter.value.toLowerCase();
    const isAtEnd = box.scrollTop + box.clientHeight >= box.scrollHeight - 30;
    if (anew) { box.replaceChildren(); this.drawn = 0; }
    const first = store.logCount - store.log.length;
    const fresh = store.log.slice(Math.max(this.drawn - first, 0)).filter(([at, , name, text]) =>
      (store.past === null || at <= store.past) && `${name} ${text}`.toLowerCase().includes(wanted));
    this.drawn = store.logCount;
    if (!fresh.length) return;
    box.append(...fresh.slice(-MOST_LINES).map(logLine));
    while (box.children.length > MOST_LINES) box.firstChild.remove();
    if (isAtEnd || anew) box.scrollTop = box.scrollHeight;
  }
}

const logLine = ([at, status, name, text]) => element(
  "li", "",
  element("span", "when", at.toFixed(2)),
  status === null ? "" : sign(status),
  element("strong", status === null ? "" : STATUSES[status], name),
  name && text ? " " : "",
  element("span", name ? "words" : "", text),
);

export function drawGoals(store) {
  const goals = [...store.goals.values()].reverse();
  goals.sort((one, other) => isOpen(other[3]) - isOpen(one[3]));
  const sent = store.state.goals_sent;
  const open = goals.filter((one) => isOpen(one[3])).length;
  byId("goals-title").textContent = sent === null || sent === undefined ? "Goals" : `Goals: ${sent} sent, ${open} open`;
  byId("goals").replaceChildren(...goals.slice(0, MOST_GOALS).map(([id, action, owner, state, at, changed]) => element(
    "li", "",
    sign(goalStatus(state)),
    element("span", STATUSES[goalStatus(state)], state),
    ` ${seconds((isOpen(state) ? store.now : changed) - at)} ${action} `,
    element("span", "words", `${owner} ${id.slice(0, 8)}`),
  )));
}

export function drawRequirements(store) {
  const known = [...store.requirements.values()];
  byId("requirements-panel").hidden = !known.length;
  known.sort((one, other) => verdictRank(one.verdict) - verdictRank(other.verdict));
  byId("requirements").replaceChildren(...known.map((one) => {
    const status = verdictStatus(one.verdict);
    const margin = one.margin === null ? "" : ` ${one.margin >= 0 ? "+" : ""}${+one.margin.toPrecision(4)} ${one.unit}`;
    const at = one.at === null ? "" : ` at ${one.at.toFixed(2)} s`;
    return element(
      "li", "", sign(status), element("span", STATUSES[status], one.verdict), " ",
      element("strong", "", one.name), `${margin}${at} `,
      element("span", "words", one.why ? `${one.why}: ` : "", element("code", "", one.requirement)),
    );
  }));
}

export function drawVariables(store, charted, onChart) {
  const box = byId("variables");
  const names = [...store.variables.keys()];
  if (box.dataset.names !== names.join("\n")) {
    box.dataset.names = names.join("\n");
    box.replaceChildren(...names.map((name) => {
      const button = element("button", "", name);
      button.type = "button";
      button.title = "Show its values against time";
      button.addEventListener("click", () => onChart(name));
      return element("li", "", button, " ", element("span"));
    }));
  }
  names.forEach((name, number) => {
    const item = box.children[number];
    item.lastChild.textContent = short(store.variables.get(name));
    item.title = store.variables.get(name);
    item.firstChild.setAttribute("aria-pressed", name === charted);
  });
}
