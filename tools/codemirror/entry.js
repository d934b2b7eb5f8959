export { EditorState, Compartment, Annotation, EditorSelection, StateEffect, StateField } from "@codemirror/state";
export { EditorView, keymap, lineNumbers, highlightActiveLine, highlightActiveLineGutter, drawSelection, hoverTooltip, Decoration, ViewPlugin, highlightSpecialChars } from "@codemirror/view";
export { history, historyKeymap, defaultKeymap, undo, redo, indentWithTab, undoDepth, isolateHistory } from "@codemirror/commands";
export { yaml } from "@codemirror/lang-yaml";
export { syntaxHighlighting, HighlightStyle, indentUnit, bracketMatching, indentOnInput, foldGutter, foldKeymap } from "@codemirror/language";
export { tags } from "@lezer/highlight";
export { setDiagnostics, lintGutter, lintKeymap } from "@codemirror/lint";
export { search, searchKeymap, highlightSelectionMatches } from "@codemirror/search";
export { autocompletion, completionKeymap, startCompletion, closeBrackets, closeBracketsKeymap } from "@codemirror/autocomplete";
