"use strict";
/* Offers the other versions of a page. They lie in folders beside this one, named in versions.json,
   the newest first. From a file:// address nothing can be fetched: then there is no choice. */
document.addEventListener("DOMContentLoaded", async () => {
  const label = document.querySelector(".versions");
  const own = new URL(document.documentElement.dataset.content_root, location.href);
  let versions;
  try {
    versions = await (await fetch(new URL("../versions.json", own))).json();
  } catch {
    return;
  }
  const current = own.pathname.split("/").at(-2);
  const select = label.querySelector("select");
  select.replaceChildren(...versions.map((name) => new Option(name, name, false, name === current)));
  label.hidden = versions.length < 2;
  select.addEventListener("change", async () => {
    const other = new URL(`../${select.value}/`, own);
    const page = new URL(location.href.slice(own.href.length), other);
    const found = await fetch(page, { method: "HEAD" });
    location.assign(found.ok ? page : other);
  });
});
