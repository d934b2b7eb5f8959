// What a recorded run has besides what is played: its outcome, drawings against time, tables.

import { Axis, Figure, plain } from "./figures.js";
import { Spans } from "./spans.js";
import { byId, element, goalStatus, SIGNS, STATUSES, verdictStatus } from "./words.js";
import { Zoom } from "./zoom.js";

const LONG_TABLE = 40;
const at = (time) => (time === null ? "" : `${time.toFixed(2)} s`);
const sign = (status) => element("span", `sign ${STATUSES[status]}`, `${SIGNS[status]} `);
const ENDS = { success: 2, failure: 3, running: 1, halted: 0 };

export class Report {
  // go(at): moves the recording. select(index): selects a node.
  constructor(go, select) {
    Object.assign(this, { go, select, figures: [], goalFigures: [] });
    this.zoom = new Zoom((time) => go(Math.min(Math.max(time, 0), this.zoom.duration)));
    this.spans = new Spans(this.zoom, select);
    for (const box of document.querySelectorAll(".axis-place")) box.append(new Axis(this.zoom).element);
    byId("zoom-in").addEventListener("click", () => this.zoom.scale(0.5));
    byId("zoom-out").addEventListener("click", () => this.zoom.scale(2));
    byId("zoom-all").addEventListener("click", () => this.zoom.show(0, this.zoom.duration));
  }

  begin(store) {
    const { report, replay } = store.parts;
    this.nodes = store.tree?.nodes ?? [];
    byId("about").hidden = byId("report").hidden = false;
    document.body.classList.add("has-report");
    this.figures.forEach((figure) => figure.remove());
    this.figures = [];
    this.zoom.reset(replay.duration);
    this.drawAbout(report);
    this.spans.begin(store.tree, report.spans);
    this.drawMargins(report.requirements);
    this.drawFigures("figures-panel", "figure-list", report.charts.map((chart) => new Figure(this.zoom, chart)));
    this.drawGoals(report);
    this.drawLeaves(report.leaves);
    this.drawPictures(report);
    this.drawLog(report);
    this.drawFiles(report);
    this.zoom.show(0, this.zoom.duration);
  }

  look(time) {
    this.zoom.look(time);
    this.spans.look();
    for (const figure of [...this.figures, ...this.goalFigures]) figure.look();
  }

  drawAbout({ facts, failure, lacks }) {
    byId("lacks").hidden = !lacks;
    byId("lacks").textContent = `This recording is not whole: ${lacks}.`;
    byId("failure").hidden = !failure;
    if (failure) {
      const steps = failure.path.map((index) => {
        const step = element("button", "", this.nodes[index]?.[0] ?? "");
        step.type = "button";
        step.title = "Select this node, at the instant of the failure";
        step.addEventListener("click", () => {
          if (failure.at !== null) this.go(failure.at);
          this.select(index);
        });
        return element("li", "", step);
      });
      byId("failure-path").replaceChildren(...steps);
      byId("failure-message").textContent = [failure.message, failure.at === null ? "" : `at ${at(failure.at)}`].filter(Boolean).join(", ");
    }
    byId("facts").replaceChildren(...facts.map(([name, value]) => element("div", "", element("dt", "", name), element("dd", "", value))));
  }

  drawFigures(panel, list, figures) {
    byId(panel).hidden = !figures.length;
    byId(list).replaceChildren(...figures.map((figure) => figure.element));
    this.figures.push(...figures);
  }

  drawMargins(requirements) {
    byId("margins-panel").hidden = !requirements.length;
    byId("verdicts").replaceChildren(...requirements.map((one) => row(
      [element("b", "", one.name), element("code", "", one.requirement)],
      [sign(verdictStatus(one.verdict)), element("span", STATUSES[verdictStatus(one.verdict)], one.verdict)],
      one.margin === null ? "" : `${plain(one.margin)} ${one.unit}`,
      at(one.at),
      one.violated_at === null ? one.why : `noticed at ${at(one.violated_at)}`,
    )));
    const drawn = requirements.filter((one) => one.chart).map((one) => new Figure(
      this.zoom, { ...one.chart, name: `${one.name}: ${one.chart.name}` }, [["decides", one.at], ["violated", one.violated_at]],
    ));
    byId("margin-legend").hidden = !drawn.length;
    this.drawFigures("margins-panel", "margin-list", drawn);
    byId("margins-panel").hidden = !requirements.length;
  }

  // ---- goals

  drawGoals({ goals, goals_left_out: leftOut }) {
    byId("lives-panel").hidden = !goals.length;
    byId("lives").replaceChildren(...goals.map((goal, index) => this.goalRow(goal, index)));
    byId("lives-left-out").textContent = leftOut ? `${leftOut} more goals are in the recording.` : "";
    this.showFeedback(null);
    fold("lives-panel", goals.length);
  }

  goalRow(goal, index) {
    const since = (time) => (time === null || goal.sent === null ? null : time - goal.sent);
    const status = goal.status ? goalStatus(goal.status) : 1;
    const more = [
      goal.accepted !== null && since(goal.accepted) > 0 ? `accepted after ${at(since(goal.accepted))}` : "",
      goal.handed_over !== null && goal.handed_over !== goal.end ? `released after ${at(since(goal.handed_over))}` : "",
      goal.cancel === null ? "" : `cancel after ${at(since(goal.cancel))}`,
      goal.messages ? `${goal.messages} x feedback` : "",
    ].filter(Boolean);
    const number = element("button", "", String(index + 1));
    number.type = "button";
    number.title = "Go to the instant at which it was sent, and draw its feedback";
    number.addEventListener("click", () => {
      if (goal.sent !== null) this.go(goal.sent);
      this.showFeedback(goal, index);
    });
    const made = row(
      number, goal.action, goal.owner, at(goal.sent), at(since(goal.end)) || "?",
      [sign(status), goal.status || "no end is known", ...more.map((text) => element("small", "", text))],
      fields(goal.values), goal.result ? fields(goal.result) : "",
    );
    ["#", "action", "node", "sent", "took", "outcome", "goal", "result"].forEach((name, cell) => { made.children[cell].dataset.label = name; });
    made.id = `goal-${index + 1}`;
    return made;
  }

  showFeedback(goal, index) {
    this.goalFigures.forEach((figure) => figure.remove());
    this.goalFigures = (goal?.feedback ?? []).map((chart) => new Figure(this.zoom, chart));
    byId("feedback").hidden = goal === null;
    if (goal === null) return;
    byId("feedback-title").textContent = this.goalFigures.length
      ? `Feedback of goal ${index + 1} to ${goal.action}` : `Goal ${index + 1} to ${goal.action} has no feedback with numbers that change`;
    byId("feedback-list").replaceChildren(...this.goalFigures.map((figure) => figure.element));
    this.look(this.zoom.at);
  }

  // ---- what is read

  drawLeaves(leaves) {
    byId("leaves-panel").hidden = !leaves.length;
    byId("leaves").replaceChildren(...leaves.map(([index, ends, spent]) => row(
      this.nodes[index]?.[0] ?? "",
      String(Object.values(ends).reduce((sum, count) => sum + count, 0)),
      Object.entries(ends).flatMap(([status, count]) => [sign(ENDS[status] ?? 0), `${count} ${status} `]),
      at(spent),
    )));
    fold("leaves-panel", leaves.length);
  }

  drawPictures({ pictures, pictures_in_all: inAll }) {
    byId("pictures-panel").hidden = !pictures.length;
    byId("pictures").replaceChildren(...pictures.map(({ name, t, type, data }) => {
      const image = element("img");
      image.src = `data:${type === "image/png" ? type : "image/jpeg"};base64,${data}`;
      image.alt = name;
      return element("figure", "", image, element("figcaption", "", `${name.split("/").at(-1)}, ${at(t)}`));
    }));
    const rest = inAll - pictures.length;
    byId("pictures-left-out").textContent = rest ? `${rest} more are in the recording.` : "";
  }

  drawLog({ log, lines_left_out: leftOut }) {
    byId("ros-log-panel").hidden = !log.length;
    byId("ros-log").replaceChildren(...log.map(([time, level, name, text]) => element(
      "li", level, element("span", "when", time.toFixed(2)), element("b", "", level), element("span", "", text), element("small", "", name),
    )));
    byId("ros-log-left-out").textContent = leftOut ? `${leftOut} more lines are in the recording.` : "";
  }

  drawFiles({ files, made }) {
    byId("files-panel").hidden = !files.length;
    byId("files").replaceChildren(...files.flatMap(([name, text]) => [element("h3", "", name), element("pre", "", text)]));
    byId("made").replaceChildren(...made.flatMap(([name, value]) => [element("dt", "", name), element("dd", "", value)]));
  }
}

function row(...cells) {
  return element("tr", "", ...cells.map((cell) => element("td", "", cell === "" ? "" : element("div", "", ...[cell].flat()))));
}

const fields = (pairs) => element("code", "", ...pairs.map(([name, text]) => element("span", "field", `${name} `, element("b", "", text))));

// A long table is folded at first.
function fold(panel, count) {
  const box = byId(panel).querySelector("details");
  box.open = count <= LONG_TABLE;
  box.firstElementChild.textContent = `${count} ${count === 1 ? "row" : "rows"}`;
}
