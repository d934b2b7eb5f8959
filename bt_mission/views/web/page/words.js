// Words and signs for what the server tells in numbers. All text reaches the page as text only.

export const STATUSES = ["idle", "running", "success", "failure"];
export const SIGNS = ["·", "▶", "✓", "✗"];
const GOAL_STATUSES = {
  succeeded: 2, aborted: 3, rejected: 3, lost: 3, unknown: 3, canceled: 0,
};
const OPEN = ["sent", "recalled", "active", "canceling"];
const VERDICTS = { violated: 3, "not exercised": 3, unknown: 0, open: 1, holds: 2, "not applicable": 0 };
export const FAILING = ["violated", "not exercised"];

export const isOpen = (state) => OPEN.includes(state);
export const goalStatus = (state) => GOAL_STATUSES[state] ?? 1;
export const verdictStatus = (verdict) => VERDICTS[verdict] ?? 0;
export const verdictRank = (verdict) => {
  const rank = Object.keys(VERDICTS).indexOf(verdict);
  return rank < 0 ? 9 : rank;
};

export function seconds(value) {
  if (value === null || value === undefined) return "";
  if (value < 60) return `${value.toFixed(1)} s`;
  const whole = Math.floor(value);
  const [hours, minutes] = [Math.floor(whole / 3600), Math.floor((whole % 3600) / 60)];
  const two = (number) => String(number).padStart(2, "0");
  return hours ? `${hours}:${two(minutes)}:${two(whole % 60)} h` : `${minutes}:${two(whole % 60)} min`;
}

export function figures([label, value, limit]) {
  const unit = label === "s" ? " s" : "";
  const digits = unit ? 1 : Number.isInteger(value) && limit >= 3 ? 0 : 2;
  return `${value.toFixed(digits)} of ${+limit.toPrecision(4)}${unit}`;
}

export function short(value) {
  if (value.length <= 8) return value;
  const number = Number(value);
  return Number.isNaN(number) ? value : String(+number.toPrecision(6));
}

// An element with classes and children; texts become text nodes, never markup.
export function element(tag, className, ...children) {
  const made = document.createElement(tag);
  if (className) made.className = className;
  made.append(...children.filter((one) => one !== null && one !== ""));
  return made;
}

export const byId = (id) => document.getElementById(id);
