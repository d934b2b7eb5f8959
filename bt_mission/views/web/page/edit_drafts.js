// Unsaved texts beside their file: each page keeps its own, and none is written over by another page.

import { ask } from "./edit_api.js";

export class Drafts {
  // at: the file, its text on disk, the name of this page for it, and whether it edits the file.
  constructor(at, text, banner, refuse) {
    Object.assign(this, { at, text, banner, refuse });
  }

  tell(lost) { this.banner("lost", lost && `Unsaved text cannot be kept beside the file: ${lost}`, [], true); }

  // Has the server keep what was written since the last check, however short ago.
  async keep() {
    const { at } = this;
    while (at.name && at.leads && !at.isReadOnly && this.text.text !== at.kept) {
      const written = this.text.text;
      const { error, lost } = await ask("keep", { name: at.name, page: at.page, text: written });
      if (error || lost) throw new Error(error ?? `Unsaved text cannot be kept beside the file: ${lost}`);
      at.kept = written;
    }
  }

  // Offers the texts of other pages. Each stays beside the file until it is saved or deleted.
  offer(drafts) {
    const { name } = this.at;
    for (const { page, text, saved_s: saved } of drafts) {
      this.banner(`draft-${page}`, `Unsaved text of ${name} was found beside the file, from ${new Date(1000 * saved).toLocaleString()}.`, [
        ["Restore it", () => this.restore(text, page)],
        ["Delete it", () => ask("drop", { name, pages: [page] }).catch((error) => this.refuse(error.message))],
        ["Ignore it", () => {}],
      ]);
    }
  }

  restore(written, page) {
    if (!this.at.leads) { this.refuse("Another page edits this file; take over to change it."); return; }
    this.at.restored.push(page);
    this.text.replace(written);
  }

  // Another page has taken over while this one slept: what was written here is kept, and offered.
  async keepMine(takeOver) {
    const mine = this.text.text;
    await this.keep();
    this.banner("mine", "Another page has taken over. Your unsaved text is kept beside the file.", [
      ["Take over with it", async () => { await takeOver(); this.restore(mine, this.at.page); }], ["Close", () => {}],
    ]);
  }

  // Lets other pages edit a file that is not shown here any more.
  async leave() {
    if (this.at.name) await ask("leave", { name: this.at.name, page: this.at.page });
  }
}
