// Requests to the server of the editor, and whether it can be reached.

import { byId } from "./words.js";

export async function ask(name, facts = {}) {
  const answer = await fetch(`api/${name}`, {
    method: "POST",
    headers: { "Content-Type": "application/json" },
    body: JSON.stringify(facts),
  }).catch(() => { throw new Error("The editor cannot be reached"); });
  if (answer.headers.get("Content-Type") !== "application/json") throw new Error((await answer.text()).trim());
  return answer.json();
}

export function connected(text, isLost) {
  const pill = byId("connection");
  pill.textContent = text;
  pill.classList.toggle("is-lost", isLost);
  pill.hidden = !isLost;
}
