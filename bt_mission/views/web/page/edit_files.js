// Windows of the editor about its files: new, renamed and deleted ones, and one that changed on disk.

import { ask } from "./edit_api.js";
import { element } from "./words.js";

// Asks for a name and what to do with it. `done` gets the file to open next; null is any other one.
export function fileWindow(at, openWindow, refuse, keep, done) {
  const name = element("input", "");
  Object.assign(name, { id: "file-name", value: at.name, spellcheck: false, autocomplete: "off" });
  const perform = async (act, facts) => {
    try {
      await keep();
      const answer = await ask(act, facts);
      if (answer.error) { refuse(answer.error); return; }
      if (act !== "create") at.name = "";
      await done(answer.name ?? null);
    } catch (error) { refuse(error.message); }
  };
  const other = () => name.value.trim();
  const sure = () => openWindow(`Delete ${at.name}?`, [element("p", "", "The file and its unsaved text are deleted from the disk.")], [
    ["Delete", () => perform("delete", { name: at.name, base: at.base })],
  ]);
  const buttons = [["Create", () => perform("create", { name: other() })]];
  if (at.name) buttons.push(["Rename", () => perform("rename", { name: at.name, other: other() })], ["Delete…", sure]);
  openWindow("Files of this folder", [element("label", "", "Name: ", name)], buttons);
  name.select();
}

// Shows the lines in three versions. `take` gets the text that was put together.
export async function mergeWindow(title, words, texts, openWindow, take, more) {
  const { hunks } = await ask("merge", texts);
  const rows = hunks.map((hunk, index) => {
    if (hunk.base === hunk.theirs && hunk.base === hunk.mine) return { hunk, shown: element("pre", "merge-same", hunk.base) };
    const choices = {};
    const cell = (kind, label) => {
      const input = element("input", "");
      Object.assign(input, { type: "radio", name: `hunk-${index}`, value: kind, checked: kind === (hunk.choice || "mine") });
      choices[kind] = input;
      return element("label", "", input, `${label} `, element("pre", "", hunk[kind] || "(no lines)\n"));
    };
    const base = element("div", "", "Before ", element("pre", "", hunk.base || "(no lines)\n"));
    const shown = element("fieldset", `columns${hunk.choice ? "" : " is-bad"}`, base, cell("theirs", "On disk"), cell("mine", "Yours"));
    return { hunk, shown, choices };
  });
  const chosen = ({ hunk, choices }) => (choices ? hunk[choices.mine.checked ? "mine" : "theirs"] : hunk.base);
  const both = hunks.filter((hunk) => !hunk.choice).length;
  const note = both ? ` Both have changed the same lines in ${both} ${both > 1 ? "places" : "place"}: choose.` : "";
  openWindow(title, [element("p", "", words + note), ...rows.map(({ shown }) => shown)], [
    ["Use these lines", () => take(rows.map(chosen).join(""))], ...more,
  ]);
}
