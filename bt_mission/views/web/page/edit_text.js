// The text: CodeMirror with the checks, completion and hover of the server.

import * as cm from "./codemirror.js";
import { ask } from "./edit_api.js";
import { byId, element } from "./words.js";

const colours = cm.HighlightStyle.define([
  { tag: [cm.tags.propertyName, cm.tags.definition(cm.tags.propertyName)], color: "var(--running)" },
  { tag: cm.tags.comment, color: "var(--dim)", fontStyle: "italic" },
  { tag: [cm.tags.string, cm.tags.special(cm.tags.string)], color: "var(--success)" },
  { tag: [cm.tags.number, cm.tags.bool, cm.tags.null], color: "var(--warn)" },
  { tag: [cm.tags.labelName, cm.tags.typeName], color: "var(--failure)" },
]);
const look = cm.EditorView.theme({
  "&": { height: "100%", color: "var(--ink)", backgroundColor: "var(--panel)", fontSize: "13px" },
  "&.cm-focused": { outline: "2px solid var(--running)", outlineOffset: "-2px" },
  ".cm-scroller": { fontFamily: "ui-monospace, SFMono-Regular, Menlo, monospace", lineHeight: "1.5" },
  ".cm-gutters": { backgroundColor: "var(--ground)", color: "var(--dim)", borderRight: "1px solid var(--line)" },
  ".cm-activeLine, .cm-activeLineGutter": { backgroundColor: "color-mix(in srgb, var(--chosen) 40%, transparent)" },
  ".cm-cursor": { borderLeftColor: "var(--ink)" },
  "&.cm-focused > .cm-scroller > .cm-selectionLayer .cm-selectionBackground, .cm-selectionBackground": { backgroundColor: "var(--chosen)" },
  ".cm-tooltip": { backgroundColor: "var(--panel)", color: "var(--ink)", border: "1px solid var(--line)", borderRadius: "5px", maxWidth: "34rem" },
  ".cm-tooltip-autocomplete ul li[aria-selected]": { backgroundColor: "var(--chosen)", color: "var(--ink)" },
  ".cm-completionDetail": { color: "var(--dim)", fontStyle: "normal", marginLeft: "1em" },
  ".cm-completionMatchedText": { textDecoration: "none", fontWeight: "700" },
  ".cm-lintRange-error": { backgroundImage: "none", textDecoration: "underline wavy var(--failure) 1px", textUnderlineOffset: "3px" },
  ".cm-lintRange-warning": { backgroundImage: "none", textDecoration: "underline wavy var(--warn) 1px", textUnderlineOffset: "3px" },
  ".cm-diagnostic-error": { borderLeftColor: "var(--failure)" },
  ".cm-diagnostic-warning": { borderLeftColor: "var(--warn)" },
  ".cm-lint-marker-error": { content: "none", width: "8px", height: "8px", borderRadius: "50%", backgroundColor: "var(--failure)", margin: "6px 3px" },
  ".cm-lint-marker-warning": { content: "none", width: "8px", height: "8px", borderRadius: "2px", backgroundColor: "var(--warn)", margin: "6px 3px" },
  ".cm-panels": { backgroundColor: "var(--ground)", color: "var(--ink)" },
  ".cm-button": { backgroundImage: "none", backgroundColor: "var(--panel)", color: "var(--ink)", border: "1px solid var(--line)" },
  ".cm-textfield": { backgroundColor: "var(--panel)", color: "var(--ink)", border: "1px solid var(--line)" },
  ".cm-chosen-node": { backgroundColor: "color-mix(in srgb, var(--chosen) 45%, transparent)" },
  ".hover-text": { padding: "4px 8px" },
});

const setRange = cm.StateEffect.define();
const range = cm.StateField.define({
  create: () => cm.Decoration.none,
  update(marks, change) {
    marks = marks.map(change.changes);
    for (const effect of change.effects) {
      if (!effect.is(setRange)) continue;
      const lines = [];
      if (effect.value) {
        const last = change.state.doc.lineAt(effect.value[1]).number;
        for (let line = change.state.doc.lineAt(effect.value[0]).number; line <= last; line++) {
          lines.push(cm.Decoration.line({ class: "cm-chosen-node" }).range(change.state.doc.line(line).from));
        }
      }
      marks = cm.Decoration.set(lines);
    }
    return marks;
  },
  provide: (field) => cm.EditorView.decorations.from(field),
});

// What shows nothing, or turns the direction of writing: `is_shown` of core/text.py.
const HIDDEN = /[\p{Cf}\u034f\u115f\u1160\u17b4\u17b5\u180b-\u180f\u2029\u3164\uffa0\u{e0100}-\u{e01ef}]/u;

export class TextPane {
  // onChange(isTyped): the text has changed. onCursor(offset): the cursor is elsewhere. refuse(words): shows an error.
  constructor(onChange, onCursor, refuse) {
    this.name = "";
    this.refuse = refuse;
    this.onCursor = onCursor;
    const root = byId("text").attachShadow({ mode: "open" });
    this.editable = new cm.Compartment();
    this.extensions = [
      cm.lineNumbers(), cm.foldGutter(), cm.highlightActiveLine(), cm.highlightActiveLineGutter(),
      cm.highlightSpecialChars({ addSpecialChars: HIDDEN }),
      cm.history(), cm.drawSelection(), cm.indentOnInput(), cm.bracketMatching(), cm.closeBrackets(),
      cm.yaml(), cm.syntaxHighlighting(colours), look, cm.indentUnit.of("  "), range,
      cm.search(), cm.highlightSelectionMatches(), cm.lintGutter(),
      cm.autocompletion({ override: [(context) => this.complete(context)], icons: false }),
      cm.hoverTooltip((view, at) => this.hover(view, at)),
      this.editable.of([]),
      cm.EditorView.contentAttributes.of({ "aria-label": "Text of the mission" }),
      cm.keymap.of([
        { key: "F12", run: () => { this.goToDefinition(); return true; } },
        { key: "Mod-y", run: cm.redo },
        ...cm.closeBracketsKeymap, ...cm.completionKeymap, ...cm.searchKeymap, ...cm.historyKeymap,
        ...cm.foldKeymap, ...cm.lintKeymap, ...cm.defaultKeymap, cm.indentWithTab,
      ]),
      cm.EditorView.updateListener.of((update) => {
        if (update.docChanged) onChange(update.transactions.some((one) => one.isUserEvent("act")));
        else if (update.selectionSet && this.view.hasFocus) this.onCursor(update.state.selection.main.head);
      }),
    ];
    this.view = new cm.EditorView({ parent: root, root, state: this.stateOf("") });
  }

  stateOf(text) { return cm.EditorState.create({ doc: text, extensions: this.extensions }); }

  open(name, text) {
    this.name = name;
    this.view.setState(this.stateOf(text));
  }

  get text() { return this.view.state.doc.toString(); }

  get length() { return this.view.state.doc.length; }

  // Replaces all, as one change that can be undone.
  replace(text) {
    this.apply([{ from: 0, to: this.length, insert: text }]);
  }

  apply(changes, position = null) {
    const spec = { changes, userEvent: "act", annotations: cm.isolateHistory.of("full") };
    if (position !== null) spec.selection = { anchor: position };
    this.view.dispatch(spec);
  }

  setEditable(isEditable) {
    this.view.dispatch({ effects: this.editable.reconfigure(isEditable ? [] : [cm.EditorState.readOnly.of(true)]) });
  }

  mark(marks) {
    const end = this.length;
    const within = (offset) => Math.min(offset, end);
    this.view.dispatch(cm.setDiagnostics(this.view.state, marks.map((mark) => ({
      from: within(mark.from), to: within(Math.max(mark.to, mark.from)), severity: mark.severity,
      source: mark.code, message: mark.hint ? `${mark.message}; ${mark.hint}` : mark.message,
    }))));
  }

  // Shows the lines of a node, without taking the focus.
  show(start, end, isScrolled) {
    const [from, to] = [Math.min(start, this.length), Math.min(end, this.length)];
    const effects = [setRange.of(from < to ? [from, to] : null)];
    if (isScrolled) effects.push(cm.EditorView.scrollIntoView(from, { y: "center" }));
    this.view.dispatch({ effects });
  }

  goTo(offset) {
    const at = Math.min(offset, this.length);
    this.view.dispatch({ selection: { anchor: at }, effects: cm.EditorView.scrollIntoView(at, { y: "center" }) });
    this.view.focus();
  }

  undo() { cm.undo(this.view); }

  redo() { cm.redo(this.view); }

  async complete(context) {
    const before = context.matchBefore(/[\w$./-]*/);
    if (!context.explicit && !/[\w$]$/.test(before?.text ?? "")) return null;
    const answer = await ask("complete", { name: this.name, text: context.state.doc.toString(), at: context.pos }).catch(() => null);
    if (answer?.error && context.explicit) this.refuse(answer.error);
    if (!answer?.options?.length) return null;
    // Enter behind a whole word ends the line.
    const word = context.state.sliceDoc(answer.from, context.pos);
    if (!context.explicit && answer.options[0].label === word) return null;
    return {
      from: answer.from,
      filter: false,
      options: answer.options.map((option) => ({
        label: option.label, detail: option.detail, info: option.text || undefined, apply: option.insert,
      })),
    };
  }

  async hover(view, at) {
    const answer = await ask("hover", { name: this.name, text: view.state.doc.toString(), at }).catch(() => null);
    if (!answer?.option) return null;
    const { label, detail, text } = answer.option;
    return {
      pos: at,
      create: () => ({ dom: element("div", "hover-text", element("b", "", label), detail ? ` ${detail}` : "", text ? element("div", "", text) : "") }),
    };
  }

  async goToDefinition() {
    const answer = await ask("define", { text: this.text, at: this.view.state.selection.main.head });
    if (typeof answer.at === "number") this.goTo(answer.at);
  }
}
