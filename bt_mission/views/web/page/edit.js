// The editor: one text, shown as text and as a drawing, with its checks, its run and its proof.

import { Drawing, keyOf } from "./drawing.js";
import { ask, connected } from "./edit_api.js";
import { Drafts } from "./edit_drafts.js";
import { fileWindow, mergeWindow } from "./edit_files.js";
import { foreseen } from "./edit_foresight.js";
import { Form, Palette } from "./edit_form.js";
import { FaultList, Plan, WorldEditor } from "./edit_map.js";
import { RunPane, findingList, prove, runPaths } from "./edit_run.js";
import { TextPane } from "./edit_text.js";
import { byId, element } from "./words.js";

const CHECK_MS = 250;
const STATE_MS = 1000;
const OF_FOLDER = ["banner-hidden", "banner-cut"]; // the others are about one file
const KEPT_OUTLINES = 30;
const newPage = () => crypto.randomUUID().slice(0, 8); // each opened text has a name of its own
const at = { name: "", page: newPage(), base: "", kept: "", restored: [], leads: true, isReadOnly: false, marks: [], isConflict: false, waiting: 0, round: 0, boxes: [] };
let vocabulary, text, drafts, drawing, form, palette, runs, plan, faults, world;
let checkTimer = 0;
let acts = Promise.resolve();
let opening = Promise.resolve();
const outlines = new Map(); // the boxes of the last texts, for undo

// ---- notices -----------------------------------------------------------------------------------

function banner(id, words, buttons = [], isBad = false) {
  byId(`banner-${id}`)?.remove();
  if (!words) return;
  const bar = element("div", `banner${isBad ? " is-bad" : ""}`, element("span", "", words));
  bar.id = `banner-${id}`;
  for (const [label, act] of buttons) {
    const button = element("button", "", label);
    button.type = "button";
    button.addEventListener("click", () => { bar.remove(); act(); });
    bar.append(button);
  }
  byId("banners").append(bar);
}

const refuse = (words) => banner("refusal", words, [["Close", () => {}]], true);

function openWindow(title, body, buttons) {
  byId("window-title").textContent = title;
  byId("window-body").replaceChildren(...body);
  byId("window-buttons").replaceChildren(...[...buttons, ["Close", () => {}]].map(([label, act]) => {
    const button = element("button", "", label);
    button.type = "button";
    button.addEventListener("click", () => { byId("window").close(); act(); });
    return button;
  }));
  if (!byId("window").open) byId("window").showModal();
}

function lines(differences) {
  const shown = element("pre", "");
  for (const line of differences.length ? differences : ["no difference"]) {
    shown.append(element("span", line[0] === "+" ? "plus" : line[0] === "-" ? "minus" : "", line), "\n");
  }
  return shown;
}

// ---- the text and what follows from it ---------------------------------------------------------

const isUnsaved = () => text.text !== at.base;

function showState() {
  byId("unsaved").hidden = !isUnsaved();
  const errors = at.marks.filter((mark) => mark.severity === "error").length;
  const warnings = at.marks.length - errors;
  const counted = (count, word) => (count ? [`${count} ${word}${count > 1 ? "s" : ""}`] : []);
  const button = byId("problems");
  button.textContent = [...counted(errors, "error"), ...counted(warnings, "warning")].join(", ") || "no problems";
  button.classList.toggle("has-errors", errors > 0);
  button.classList.toggle("has-warnings", !errors && warnings > 0);
  byId("save").disabled = at.isReadOnly || !at.leads;
  document.title = `${isUnsaved() ? "• " : ""}${at.name} – bt-mission edit`;
}

function changed(isAct) {
  checkSoon();
  if (drawing.findings.size) drawing.tell({ findings: new Map() });
  offerTexts();
  if (!isAct && outlines.has(text.text)) showBoxes(outlines.get(text.text));
  showState();
}

// An empty file can begin as each kind of file.
function offerTexts() {
  const isEmpty = !text.text.trim() && at.name && at.leads && !at.isReadOnly;
  if (!isEmpty) banner("begin", "");
  else if (!byId("banner-begin")) banner("begin", "This file is empty. Begin with:", vocabulary.new_files.map(([name, written]) => [name, () => { text.replace(written); text.view.focus(); }]));
}

function checkSoon(delay = CHECK_MS) {
  clearTimeout(checkTimer);
  checkTimer = setTimeout(check, delay);
}

async function check() {
  const written = text.text;
  let answer;
  try {
    answer = await ask("check", { name: at.name, page: at.page, text: written });
    connected("connected", false);
  } catch (error) {
    connected(error.message || "disconnected; the text is kept in this page", true);
    return;
  }
  if (written !== text.text) return;
  if (answer.error) { refuse(answer.error); return; }
  at.kept = answer.lost ? null : written;
  at.marks = answer.marks;
  text.mark(answer.marks);
  await becomeKind(answer.kind);
  drafts.tell(answer.lost);
  showBoxes(answer.boxes);
  showProblems();
  showState();
}

// A text that becomes another kind of file is shown as one.
async function becomeKind(kind) {
  if (kind === at.kind || !text.text.trim()) return;
  const wasWorld = isWorld();
  at.kind = kind;
  if (!wasWorld && !isWorld()) return;
  plan.plan = null;
  await showMap(isWorld());
}

// Acts that wait show a later drawing already.
function showBoxes(boxes, waiting = at.waiting) {
  if (isWorld()) { showPlan().catch((error) => refuse(error.message)); return; }
  if (boxes !== null) remember(boxes);
  if (waiting) return;
  drawing.show(boxes);
  if (boxes === null) return;
  const severities = new Map();
  for (const mark of at.marks) {
    const box = mark.line ? drawing.innermost(mark.from) : null;
    const key = keyOf(box ? box.path : []);
    if (severities.get(key) !== "error") severities.set(key, mark.severity);
  }
  drawing.tell({ severities });
  form.show(drawing.current);
}

function remember(boxes) {
  at.boxes = boxes;
  outlines.delete(text.text);
  outlines.set(text.text, boxes);
  if (outlines.size > KEPT_OUTLINES) outlines.delete(outlines.keys().next().value);
}

function showProblems() {
  byId("problem-list").replaceChildren(...at.marks.map((mark) => {
    const place = mark.line ? `line ${mark.line}: ` : "";
    const go = element("button", "at", `${place}${mark.message}${mark.hint ? `; ${mark.hint}` : ""}`);
    go.type = "button";
    go.addEventListener("click", () => text.goTo(mark.from));
    const code = element("button", "code", mark.code);
    code.type = "button";
    code.addEventListener("click", () => explain(mark.code));
    return element("li", "", element("span", `${mark.severity}-dot`, "●"), go, code);
  }));
  if (!at.marks.length) { byId("problem-list").hidden = true; byId("problems").setAttribute("aria-expanded", "false"); }
}

async function explain(code) {
  const { entry } = await ask("explain", { code });
  if (!entry) return;
  const example = (title, words) => (words ? [element("b", "", title), element("pre", "", words.trim())] : []);
  openWindow(`${entry.code}: ${entry.title}`, [element("p", "", entry.cause), element("p", "", entry.cure), ...example("Wrong", entry.wrong), ...example("Right", entry.right)], []);
}

// ---- acts ----------------------------------------------------------------------------------------

// One act after another: each is about the text that the one before it has left. The drawing shows
// it at once. Acts behind one that was refused are about a tree that does not exist.
function act(facts) {
  if (!at.leads) { refuse("Another page edits this file; take over to change it."); return acts; }
  busy(1);
  foresee(facts);
  const { round } = at;
  acts = acts.then(() => (round === at.round ? perform(facts) : null)).catch((error) => { connected(error.message, true); turnBack(); }).finally(() => busy(-1));
  return acts;
}

function busy(change) {
  at.waiting += change;
  byId("drawing").setAttribute("aria-busy", at.waiting > 0);
}

function foresee(facts) {
  if (isWorld() || byId("drawing").classList.contains("is-old")) return;
  const after = foreseen(drawing.boxes, facts, vocabulary.kinds);
  if (!after) return;
  drawing.selected = keyOf(after.selected);
  drawing.show(after.boxes);
  drawing.reveal();
}

function turnBack(words = "") {
  at.round++;
  if (words) refuse(words);
  if (!isWorld()) drawing.show(at.boxes);
}

async function perform(facts) {
  const written = text.text;
  const answer = await ask("act", { ...facts, text: written });
  if (answer.error) { turnBack(answer.error); return; }
  banner("refusal", "");
  if (written !== text.text) { turnBack("The text has changed meanwhile; do it again."); return; }
  if (!answer.edits.length) { if (at.waiting === 1) drawing.show(at.boxes); return; }
  text.apply(answer.edits);
  if (isWorld()) { checkSoon(0); await showPlan(); return; }
  showBoxes(answer.boxes, at.waiting - 1);
  checkSoon();
  if (at.waiting > 1) return;
  if (facts.do !== "set") choosePlace(facts, answer.edits);
  else drawing.choose(drawing.byKey.get(keyOf(facts.path)), false);
}

// Selects the node that an act has put somewhere.
function choosePlace(facts, edits) {
  let shift = 0;
  let start = null;
  for (const edit of edits) {
    if (edit.insert.trim()) start = edit.from + shift;
    shift += edit.insert.length - (edit.to - edit.from);
  }
  const candidates = drawing.boxes.filter((box) => box.path.length > 1 || box.path[0] === "tree");
  const box = facts.do === "delete" ? drawing.current
    : candidates.filter((one) => !one.is_empty && one.start >= (start ?? 0)).sort((one, other) => one.start - other.start || one.path.length - other.path.length)[0];
  drawing.choose(box ?? drawing.current, false);
}

// The place for a new node: an empty one, the end of a list, or behind the selection.
function targetOf(box) {
  if (!drawing.boxes.length || !drawing.children[0]?.some((one) => one.path[0] === "tree")) return null;
  if (!box || !box.path.length) box = drawing.boxes.find((one) => one.path.length === 1);
  if (box.is_empty) return box.path;
  if (box.takes_list) return drawing.endOf(box);
  const empty = drawing.children[box.index].find((one) => one.is_empty);
  if (empty) return empty.path;
  const last = box.path[box.path.length - 1];
  if (typeof last === "number") return [...box.path.slice(0, -1), last + 1];
  return box.path;
}

function insert(kind) {
  const target = targetOf(drawing.current);
  const value = vocabulary.kinds.find((one) => one.kind === kind).template;
  return act(target === null ? { do: "begin", value } : { do: "add", kind, target, value });
}

function wanted(name, facts = {}) {
  const box = drawing.current;
  const path = box?.path ?? [];
  const last = path[path.length - 1];
  const isNode = path.length && !(path[0] === "trees" && path.length === 2);
  const listed = isNode && typeof last === "number";
  if (name === "palette") { byId("palette-filter").focus(); return; }
  if (name === "insert") { insert(facts.kind); return; }
  if (name === "add") {
    const value = vocabulary.kinds.find((one) => one.kind === facts.kind).template;
    act(drawing.boxes.length > 1 ? { do: "add", kind: facts.kind, target: facts.target, value } : { do: "begin", value });
    return;
  }
  if (name === "move") { act({ do: "move", path: facts.path, target: facts.target }); return; }
  if (name === "undo") { text.undo(); return; }
  if (name === "redo") { text.redo(); return; }
  if (name === "map") {
    if (isWorld()) return;
    const isWanted = byId("map-work").hidden;
    showMap(isWanted).catch((error) => refuse(error.message));
    if (!isWanted) byId("drawing").focus();
    return;
  }
  if (name === "run-from") { runFrom().catch((error) => refuse(error.message)); return; }
  if (name === "fields" || name === "name") {
    const input = name === "name" ? byId("form").elements.name ?? byId("form").elements.mission : byId("form").querySelector("input, select");
    input?.focus();
    return;
  }
  if (!isNode) { refuse("Select a node in the tree first."); return; }
  if (name === "run-to") { runTo(box); return; }
  if (name === "drop") {
    if (drawing.marked === null) { refuse("Mark a node with x first."); return; }
    act({ do: "move", path: JSON.parse(drawing.marked), target: targetOf(box) });
    drawing.marked = null;
  } else if (name === "earlier") {
    if (listed && last > 0) act({ do: "move", path, target: [...path.slice(0, -1), last - 1] });
  } else if (name === "later") {
    if (listed && last + 1 < drawing.children[box.parent].length) act({ do: "move", path, target: [...path.slice(0, -1), last + 2] });
  } else if (name === "wrap") {
    act({ do: "wrap", path, kind: facts.kind, value: vocabulary.kinds.find((one) => one.kind === facts.kind).wrapper });
  } else {
    act({ do: name, path });
  }
}

// Runs the text, and pauses before a node starts.
function runTo(box) {
  const [before] = [...runPaths(drawing)].find(([, key]) => key === keyOf(box.path)) ?? [];
  if (at.isReadOnly) refuse("This page is read-only: start it without --read-only.");
  else if (before === undefined || box.is_empty) refuse("Select a node of the mission's own tree first.");
  else run(before);
}

function run(before) {
  runs.start(at.name, text.text, { before, faults: faults?.texts ?? [] }).catch((error) => connected(error.message, true));
}

// Shows the instant and what has changed since the run, then continues from there with the text.
async function runFrom() {
  const [instant, refusal] = runs.instant();
  if (refusal) { refuse(refusal); return; }
  const texts = faults?.texts ?? [];
  const gone = runs.faults.find((one) => !texts.includes(one));
  if (gone) { refuse(`'${gone}' is a part of the run: run the mission again without it.`); return; }
  const more = texts.filter((one) => !runs.faults.includes(one));
  const { lines: differences } = await ask("differ", { before: runs.text, after: text.text });
  const words = "The run is repeated up to this instant. Nodes that start after it are those of the text as it is now; what runs there keeps the values with which it started.";
  openWindow(`Continue from ${instant.toFixed(2)} s with this text?`, [element("p", "", words), lines([...differences, ...more.map((one) => `+ fault ${one}`)])], [
    ["Continue", () => runs.start(at.name, text.text, { from: instant, faults: more }).catch((error) => connected(error.message, true))],
  ]);
}

// ---- the map ---------------------------------------------------------------------------------------

const isWorld = () => at.kind === "world";

async function showPlan() {
  const written = text.text;
  const { plan: read } = await ask("plan", { name: at.name, text: written });
  if (written !== text.text) return;
  plan.show(read);
  if (isWorld()) world.show();
}

async function showMap(isWanted) {
  byId("map-work").hidden = !isWanted;
  byId("drawing-panel").classList.toggle("has-map", isWanted);
  byId("show-map").setAttribute("aria-pressed", isWanted);
  byId("drawing-title").textContent = isWanted ? "Map" : "Tree";
  byId("map-work").classList.toggle("of-world", isWorld());
  for (const id of ["tool", "delete-thing"]) byId(id).hidden = !isWorld();
  for (const id of ["save-scenario", "show-map"]) byId(id).hidden = isWorld();
  for (const id of ["run", "run-to", "prove"]) byId(id).disabled = at.isReadOnly || isWorld();
  byId("things-title").textContent = isWorld() ? "On the map" : "Faults";
  if (!isWanted) return;
  if (isWorld()) {
    world ??= new WorldEditor((await ask("forms")).forms, plan, act);
    plan.marks = [];
    await showPlan();
    return;
  }
  await needFaults();
  plan.chosen = "";
  await showPlan();
  faults.show();
  plan.mark(faults.faults);
  byId("plan").focus();
}

async function needFaults() {
  if (faults) return;
  const { kinds } = await ask("faults");
  const instant = () => { const [shown, refusal] = runs.instant(); return refusal ? 0 : Math.round(shown * 100) / 100; };
  const make = (fault) => (runs.isPlaying ? runs.make(fault) : refuse("Run the mission first: 'Now' is for a run that plays."));
  faults ??= new FaultList(kinds, instant, make, () => plan.mark(faults.faults), refuse);
}

// Faults that began by a click are those of the run, and those of the next one.
async function takeFaults(begun) {
  const isNew = (one) => !runs.faults.includes(one.text);
  const more = begun.filter(isNew);
  runs.faults = [...runs.faults, ...more.map((one) => one.text)];
  await needFaults();
  faults.take(more.filter((one) => !faults.texts.includes(one.text)));
}

// Shows the scenario file of the mission with the faults, and writes it.
async function saveScenario() {
  const isSame = runs.text === text.text && runs.from === null && JSON.stringify(runs.faults) === JSON.stringify(faults.texts);
  const outcome = isSame && ["success", "failure"].includes(runs.status) ? runs.status : "any";
  const facts = { name: at.name, text: text.text };
  const answer = await ask("scenario", { ...facts, faults: faults.texts, outcome });
  if (answer.error) { refuse(answer.error); return; }
  const name = element("input", "");
  Object.assign(name, { id: "scenario-name", value: answer.file, spellcheck: false });
  const label = element("label", "", "File: ", name);
  const write = async () => {
    const written = await ask("scenario", { ...facts, file: name.value.trim(), scenario: answer.scenario });
    if (written.error) refuse(written.error);
    else { banner("written", `Written: ${written.file}`, [["Close", () => {}]]); await listFiles(); }
  };
  openWindow("Save as scenario?", [label, element("pre", "", answer.scenario), ...answer.errors.map((one) => element("p", "error-dot", one))], answer.errors.length ? [] : [["Save", write]]);
}

// ---- files -----------------------------------------------------------------------------------------

async function listFiles() {
  const answer = await ask("files");
  at.isReadOnly = answer.is_read_only;
  if (answer.hidden.length) banner("hidden", `Not shown, since the name is not plain text in UTF-8: ${answer.hidden.join(", ")}`, [["Close", () => {}]]);
  if (answer.is_cut) banner("cut", `Not all files are shown, but ${answer.files.length}. Open the editor in a folder with fewer.`, [["Close", () => {}]]);
  at.kinds = new Map(answer.files.map((one) => [one.name, one.kind]));
  byId("run").disabled = byId("run-to").disabled = byId("prove").disabled = at.isReadOnly;
  byId("file-acts").hidden = at.isReadOnly || answer.is_single;
  const select = byId("files");
  select.replaceChildren(...answer.files.map(({ name, is_unsaved: unsaved }) => {
    const option = element("option", "", unsaved ? `${name} (unsaved)` : name);
    option.value = name;
    return option;
  }));
  select.value = at.name;
  return answer.files;
}

// Opens one file after another; of those that wait, only the last.
async function openFile(name) {
  at.wanted = name;
  const before = opening;
  const stay = (words) => { refuse(words); byId("files").value = at.name; };
  opening = before.then(() => (at.wanted === name ? show(name, stay) : null)).catch((error) => stay(error.message));
  await opening;
  if (at.name !== name) return;
  await share();
  if (at.leads) await check();
  else await look();
  drawing.orient();
}

async function show(name, stay) {
  const opened = await ask("open", { name });
  if (opened.error) { stay(opened.error); return; }
  try {
    await drafts.keep();
    await drafts.leave();
  } catch (error) { stay(`${error.message}; save it before you open another file.`); return; }
  clearTimeout(checkTimer);
  for (const one of [...byId("banners").children]) if (!OF_FOLDER.includes(one.id)) one.remove();
  byId("proof").hidden = true;
  drawing.findings = new Map();
  faults = null;
  Object.assign(at, { kind: at.kinds.get(name) ?? "mission" });
  plan.plan = null;
  plan.chosen = "";
  Object.assign(at, { name, base: opened.text, kept: opened.text, page: newPage(), restored: [], leads: true, marks: [], isConflict: false });
  text.open(name, opened.text);
  text.setEditable(true);
  at.boxes = [];
  outlines.clear();
  drawing.selected = keyOf([]);
  drawing.show([]);
  drafts.offer(opened.drafts);
  await showMap(isWorld());
  offerTexts();
  byId("files").value = name;
  location.hash = encodeURIComponent(name);
  showState();
}

// Shows the drawing of a text that another page edits.
async function look() {
  const answer = await ask("look", { text: text.text, name: at.name });
  at.marks = answer.marks;
  text.mark(answer.marks);
  showBoxes(answer.boxes);
  showProblems();
  showState();
}

async function save(isForced = false) {
  const written = text.text;
  const answer = await ask("save", { name: at.name, page: at.page, text: written, base: at.base, is_forced: isForced, restored: at.restored });
  if ("theirs" in answer) { showConflict(answer.theirs); return; }
  if (answer.error) { refuse(answer.error); return; }
  at.base = written;
  at.kept = text.text === written ? written : null;
  at.restored = [];
  at.isConflict = false;
  banner("conflict", "");
  banner("saved", "Saved.");
  setTimeout(() => banner("saved", ""), 1500);
  showState();
}

// Shows base, disk and page side by side; the text of the page stays in its undo history.
function showConflict(theirs) {
  const words = theirs === null ? "The file no longer exists." : "Another program has written the file since it was opened here.";
  const texts = { base: at.base, theirs: theirs ?? "", mine: text.text };
  const take = (merged) => { at.base = theirs ?? ""; at.isConflict = false; text.replace(merged); showState(); };
  return mergeWindow(`${at.name} has changed on disk`, words, texts, openWindow, take, [
    ["Overwrite with mine", () => save(true)],
    ["Take the text on disk", () => take(theirs ?? "")],
  ]);
}

// Opens the file that another act has left; without one the first of the folder.
async function openNext(name) {
  const files = await listFiles();
  const next = name ?? files[0]?.name;
  if (next) await openFile(next);
  else { at.name = ""; at.base = at.kept = ""; text.replace(""); drawing.show([]); showState(); }
}

async function showDifference() {
  if (!isUnsaved()) { save(); return; }
  if (at.isConflict && at.compare) { await at.compare(); return; }
  const answer = await ask("differ", { before: at.base, after: text.text });
  openWindow(`Save ${at.name}?`, [answer.error ? element("p", "", answer.error) : lines(answer.lines)], [["Save", () => save()]]);
  byId("window-buttons").querySelector("button").focus();
}

// Tells the server that the page is here; of two pages with one file, the second follows.
async function share(isTaking = false) {
  if (!at.name) return;
  const { name, page } = at;
  const facts = { name, page, base: at.base, take: isTaking };
  if (at.leads || isTaking) facts.text = text.text;
  const answer = await ask("state", facts);
  if (page !== at.page) return;
  if (answer.error) { refuse(answer.error); return; }
  connected("connected", false);
  if (at.leads && !answer.leads && isUnsaved() && text.text !== answer.text) await drafts.keepMine(() => share(true));
  if (answer.leads !== at.leads) text.setEditable(answer.leads);
  at.leads = answer.leads;
  if (answer.leads) {
    banner("follows", "");
    if (answer.is_changed && facts.base === at.base && !at.isConflict) { // not by a save meanwhile
      at.isConflict = true;
      const words = answer.exists ? `${at.name} has changed on disk.` : `${at.name} is not on disk any more; saving writes it again.`;
      at.compare = answer.exists ? async () => showConflict((await ask("open", { name: at.name })).text) : null;
      banner("conflict", words, at.compare ? [["Compare", at.compare]] : []);
    }
  } else {
    const words = answer.is_asleep ? "Another page edits this file, and sleeps or was lost; this one shows its text." : "Another page edits this file; this one follows.";
    if (byId("banner-follows")?.firstChild.textContent !== words) banner("follows", words, [["Take over", () => share(true)]]);
    if (answer.text !== text.text) { text.open(at.name, answer.text); text.setEditable(false); at.marks = []; await look(); }
  }
  showState();
}

async function keepSharing() {
  try {
    await share();
  } catch (error) {
    connected(`${error.message || "disconnected"}; unsaved text stays in this page`, true);
  }
  setTimeout(keepSharing, STATE_MS);
}

// ---- the page ----------------------------------------------------------------------------------------

function listen() {
  for (const name of ["unwrap", "copy", "delete", "earlier", "later"]) byId(name).addEventListener("click", () => { wanted(name); byId("drawing").focus(); });
  byId("undo").addEventListener("click", () => text.undo());
  byId("redo").addEventListener("click", () => text.redo());
  byId("save").addEventListener("click", showDifference);
  byId("file-acts").addEventListener("click", () => fileWindow(at, openWindow, refuse, () => drafts.keep(), openNext));
  byId("files").addEventListener("change", () => openFile(byId("files").value).catch((error) => connected(error.message, true)));
  byId("run").addEventListener("click", () => run(""));
  byId("run-to").addEventListener("click", () => wanted("run-to"));
  byId("show-map").addEventListener("click", () => wanted("map"));
  byId("save-scenario").addEventListener("click", () => saveScenario().catch((error) => refuse(error.message)));
  byId("run-from").addEventListener("click", () => wanted("run-from"));
  byId("apply").addEventListener("click", () => apply().catch((error) => refuse(error.message)));
  byId("prove").addEventListener("click", () => startProof().catch((error) => connected(error.message, true)));
  byId("close-proof").addEventListener("click", closeProof);
  byId("problems").addEventListener("click", () => {
    const list = byId("problem-list");
    list.hidden = !list.hidden || !at.marks.length;
    byId("problems").setAttribute("aria-expanded", !list.hidden);
  });
  const wrap = byId("wrap");
  for (const kind of vocabulary.wrappers) { const option = element("option", "", kind); option.value = kind; wrap.append(option); }
  wrap.addEventListener("change", () => { if (wrap.value) wanted("wrap", { kind: wrap.value }); wrap.value = ""; byId("drawing").focus(); });
  document.addEventListener("keydown", (event) => {
    if ((event.ctrlKey || event.metaKey) && event.key.toLowerCase() === "s") { event.preventDefault(); showDifference(); }
    if (event.key === "F6") { event.preventDefault(); if (document.activeElement === byId("text")) byId("drawing").focus(); else text.view.focus(); }
    if (event.key === "?" && document.activeElement === byId("drawing")) byId("keys").showModal();
  });
  byId("show-keys").addEventListener("click", () => byId("keys").showModal());
  byId("close-keys").addEventListener("click", () => byId("keys").close());
  window.onbeforeunload = (event) => { if (isUnsaved() && at.leads) { drafts.keep().catch(() => {}); event.preventDefault(); } };
  window.onpagehide = () => navigator.sendBeacon("api/leave", JSON.stringify({ name: at.name, page: at.page }));
  document.addEventListener("visibilitychange", () => { if (document.hidden) drafts.keep().catch((error) => drafts.tell(error.message)); });
  const dark = matchMedia("(prefers-color-scheme: dark)");
  const setTheme = (theme) => { document.documentElement.dataset.theme = theme; };
  dark.addEventListener("change", () => setTheme(dark.matches ? "dark" : "light"));
  byId("theme").addEventListener("click", () => setTheme(document.documentElement.dataset.theme === "dark" ? "light" : "dark"));
  setTheme(dark.matches ? "dark" : "light");
}

// Shows what the text would change of the run, then applies it.
async function apply() {
  const facts = { name: at.name, text: text.text, executive: runs.executive };
  const shown = await ask("revise", { ...facts, "--dry-run": true });
  if (shown.error) { refuse(shown.error); return; }
  const send = async (more) => {
    const answer = await ask("revise", { ...facts, ...more });
    if (!answer.is_possible) openWindow("Not applied", [element("pre", "", answer.lines.join("\n"))], []);
    else banner("applied", "Applied to the run.", [["Close", () => {}]]);
  };
  openWindow("Apply to the run?", [element("pre", "", shown.lines.join("\n"))], shown.is_possible
    ? [["Apply", () => send({})], ["Apply, keep running goals", () => send({ "--keep-goals": true })]] : []);
}

async function startProof() {
  const button = byId("prove");
  const written = text.text;
  const keys = runPaths(drawing);
  button.disabled = true;
  button.textContent = "Proving…";
  try {
    await prove(at.name, written, (result, said) => showProof(result, said, written, keys));
  } finally {
    button.disabled = false;
    button.textContent = "Prove";
  }
}

// Shows the findings below the drawing, and their numbers at the nodes of the text that was proved.
function showProof(result, said, written, keys) {
  if (!result) { openWindow("The proof did not start", [element("pre", "", said.join("\n"))], []); return; }
  const findings = new Map();
  for (const node of result.findings.flatMap((one) => one.nodes)) {
    const key = keys.get(node);
    if (key && text.text === written) findings.set(key, (findings.get(key) ?? 0) + 1);
  }
  drawing.tell({ findings });
  const boxOf = (node) => drawing.byKey.get(keys.get(node));
  const names = new Map([...keys.keys()].map((node) => [node, boxOf(node)?.name || boxOf(node)?.kind || node]));
  const whole = result.exhaustive ? "Every answer was explored." : `Not every answer was explored: ${result.why_not.join("; ")}.`;
  const count = result.findings.length;
  byId("proof-title").textContent = count ? `${count} ${count > 1 ? "findings" : "finding"}` : "No findings";
  byId("proof-scope").textContent = `${whole} ${result.states} states.`;
  byId("proof-list").replaceChildren(findingList(result, (node) => names.get(node) ?? node, (node) => {
    if (text.text === written) drawing.choose(boxOf(node));
    else refuse("The text has changed since this proof: prove it again.");
  }));
  byId("proof").hidden = false;
}

function closeProof() {
  byId("proof").hidden = true;
  drawing.tell({ findings: new Map() });
  byId("drawing").focus();
}

async function begin() {
  vocabulary = await ask("vocabulary");
  drawing = new Drawing((box, isByUser) => {
    form.show(box);
    text.show(box.start, box.path.length ? box.end : box.start, isByUser);
  }, wanted);
  form = new Form(vocabulary, (box, keys, value, isText) => act({ do: "set", path: box.path, keys, value, is_text: isText }));
  text = new TextPane(changed, (offset) => {
    const box = drawing.innermost(offset);
    if (box && keyOf(box.path) !== drawing.selected) drawing.choose(box, false);
  }, refuse);
  drafts = new Drafts(at, text, banner, refuse);
  palette = new Palette(vocabulary.kinds, (event, kind) => { event.preventDefault(); drawing.drag(event, { kind }); }, insert);
  runs = new RunPane((statuses, breakpoints) => {
    const paths = runPaths(drawing);
    const ran = [...statuses].filter(([path, status]) => paths.has(path) && status !== "idle");
    const stops = [...paths].filter(([path, key]) => breakpoints.some((one) => one === path || one === drawing.byKey.get(key).name));
    drawing.tell({ statuses: new Map(ran.map(([path, status]) => [paths.get(path), status])), stops: new Set(stops.map(([, key]) => key)) });
  }, (begun) => takeFaults(begun).catch((error) => refuse(error.message)), refuse);
  plan = new Plan(
    (...place) => (isWorld() ? world : faults).place(...place),
    (path, begin, end) => { if (isWorld()) world.drop(path, begin, end); else faults.place(...end); },
    () => wanted("map"),
  );
  plan.onDelete = () => { if (isWorld()) world.delete(); };
  listen();
  const files = await listFiles();
  const named = decodeURIComponent(location.hash.slice(1));
  const first = files.find((one) => one.name === named) ?? files.find((one) => one.kind === "mission") ?? files[0];
  if (first) await openFile(first.name);
  else refuse("This folder has no YAML file: create one with the button Files.");
  connected("connected", false);
  setTimeout(keepSharing, STATE_MS);
}

begin().catch((error) => connected(error.message, true));
