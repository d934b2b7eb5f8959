// The command that forks a recording at the instant that is shown: people run it on a terminal.

import { byId } from "./words.js";

export class ForkPanel {
  // pause(): has the recording stand still. say(text): tells the user.
  constructor(store, pause, say) {
    Object.assign(this, { store, pause, say });
    this.panel = byId("fork-panel");
    this.button = byId("fork");
    this.command = byId("fork-command");
    this.button.addEventListener("click", () => this.toggle());
    byId("fork-copy").addEventListener("click", () => this.copy());
    this.panel.addEventListener("keydown", (event) => {
      if (event.key === "Escape") this.toggle();
    });
  }

  toggle() {
    const { fork } = this.store.parts;
    if (fork.refusal) { this.say(fork.refusal); return; }
    this.panel.hidden = !this.panel.hidden;
    this.button.setAttribute("aria-expanded", !this.panel.hidden);
    if (this.panel.hidden) { this.button.focus(); return; }
    if (this.store.replay.is_playing) this.pause();
    this.draw();
    this.command.focus();
    this.command.select();
  }

  draw() {
    const { parts: { fork }, replay } = this.store;
    this.button.hidden = !fork;
    if (!fork || !replay || this.panel.hidden) return;
    const text = `${fork.command} ${replay.at.toFixed(3)}`;
    if (this.command.value === text) return;
    this.command.value = text;
    if (document.activeElement === this.command) this.command.select();
  }

  async copy() {
    try {
      await navigator.clipboard.writeText(this.command.value);
      this.say("copied");
    } catch {
      this.command.focus();
      this.command.select();
      this.say("this browser does not copy by itself: press Ctrl-C");
    }
  }
}
