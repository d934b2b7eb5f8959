// The timeline of a recording, or of a mission since its start.

import { byId } from "./words.js";

const SEND_MS = 100;

export class Timeline {
  // go(at): moves a recording. onPast(): called when another instant is looked at.
  constructor(store, go, onPast) {
    Object.assign(this, { store, go, onPast, isHeld: false, pending: null });
    this.range = byId("time");
    this.range.addEventListener("pointerdown", () => { this.isHeld = true; });
    for (const name of ["pointerup", "pointercancel", "change"]) {
      this.range.addEventListener(name, () => { this.isHeld = false; });
    }
    this.range.addEventListener("input", () => this.move(Number(this.range.value)));
    byId("live").addEventListener("click", () => this.look(null));
    new ResizeObserver(() => this.drawMarks()).observe(byId("marks"));
  }

  move(at) {
    if (!this.store.replay) {
      this.look(at >= Number(this.range.max) ? null : at);
      return;
    }
    const isWaiting = this.pending !== null;
    this.pending = at;
    if (!isWaiting) {
      setTimeout(() => { this.go(this.pending); this.pending = null; }, SEND_MS);
    }
  }

  look(at) {
    this.store.past = at;
    this.onPast();
    this.draw();
  }

  draw() {
    const { store, range } = this;
    const replay = store.replay;
    const begin = replay ? 0 : store.baseTime;
    const end = replay ? replay.duration : Math.max(store.now, begin);
    const at = replay ? replay.at : (store.past ?? end);
    range.min = begin;
    range.max = Math.max(end, begin + 0.001);
    if (!this.isHeld && this.pending === null) range.value = at;
    range.setAttribute("aria-valuetext", `${at.toFixed(1)} seconds`);
    byId("live").hidden = replay !== null || store.past === null;
    const how = replay ? describe(replay) : store.past === null ? (store.isOver ? "the end" : "now") : store.isOver ? "the past" : "the past; the mission is running";
    byId("at").textContent = `${at.toFixed(2)} of ${end.toFixed(2)} s  ${how}`;
    this.drawMarks();
  }

  drawMarks() {
    const canvas = byId("marks");
    const { store } = this;
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    if (!width) return;
    canvas.width = width;
    canvas.height = height;
    const context = canvas.getContext("2d");
    const style = getComputedStyle(document.documentElement);
    const [begin, end] = [Number(this.range.min), Number(this.range.max)];
    context.fillStyle = style.getPropertyValue("--line");
    const bar = (share) => context.fillRect(Math.round(share * (width - 1)), 0, 1, 6);
    if (store.replay) { (store.parts.marks ?? []).forEach(bar); return; }
    const seen = new Set();
    const failures = new Set();
    for (const [time, , status] of store.changes) {
      const place = Math.round(((time - begin) / Math.max(end - begin, 1e-9)) * (width - 1));
      (status === 3 ? failures : seen).add(place);
    }
    for (const place of seen) context.fillRect(place, 0, 1, 6);
    context.fillStyle = style.getPropertyValue("--failure");
    for (const place of failures) context.fillRect(place, 0, 1, 8);
  }
}

function describe(replay) {
  if (replay.is_playing) return `${replay.is_backwards ? "backwards" : "playing"} ${+replay.speed.toPrecision(4)} x`;
  if (replay.at >= replay.duration) return replay.cut ? "cut here" : "at the end";
  return `${replay.at <= 0 ? "at the start" : "paused"} ${+replay.speed.toPrecision(4)} x`;
}
