"use strict";
// The page is whole without this script. With it, one time is looked at in all drawings at once,
// and the timeline and the charts show a window of time that can be zoomed and moved.
(() => {
  const run = JSON.parse(document.getElementById("run").textContent);
  const timeline = document.querySelector(".timeline");
  if (!timeline) return;
  document.body.classList.add("live");

  const LEAST = Math.min(0.2, run.duration);
  const ROW = 22;
  const drawings = [...document.querySelectorAll(".zoomed")];
  const cursors = [...document.querySelectorAll(".cursor")];
  const axes = [...document.querySelectorAll(".axis")];
  const bars = timeline.querySelector(".bars");
  const reading = document.querySelector(".reading");
  const HINT = reading.textContent;
  const ghost = document.querySelector(".plan .ghost");
  const seen = document.querySelector(".plan .seen");
  let from = 0;
  let to = run.duration;
  let now = null;
  let row = -1;

  const short = (value, digits = 2) => String(+value.toFixed(digits));

  // ---- rows that are folded away

  const FOLDS_ABOVE = 60;
  const names = [...timeline.querySelectorAll(".name")];
  const marks = run.rows.map(() => []);
  for (const bar of bars.querySelectorAll(".bar")) {
    marks[Math.floor((bar.getAttribute("y") ?? bar.getAttribute("y1")) / ROW)].push(bar);
  }
  const stripes = [...bars.querySelectorAll(".stripe")];
  const folded = new Set();
  let shown = run.rows.map((_, index) => index);

  const hasRowsBelow = (index) => run.rows[index + 1]?.depth > run.rows[index].depth;

  function arrange() {
    shown = [];
    let open = Infinity;
    run.rows.forEach(({ depth }, index) => {
      const isShown = depth <= open;
      if (isShown) open = folded.has(index) ? depth : Infinity;
      names[index].hidden = !isShown;
      for (const mark of marks[index]) {
        mark.style.display = isShown ? "" : "none";
        mark.setAttribute("transform", `translate(0 ${(shown.length - index) * ROW})`);
      }
      if (isShown) shown.push(index);
    });
    stripes.forEach((stripe, number) => { stripe.style.display = 2 * number < shown.length ? "" : "none"; });
    bars.style.height = `${shown.length * ROW}px`;
    bars.setAttribute("viewBox", `${from} 0 ${to - from} ${shown.length * ROW}`);
  }

  function fold(index, isFolded) {
    if (isFolded) folded.add(index);
    else folded.delete(index);
    const button = names[index].querySelector("button");
    button.textContent = isFolded ? "▸" : "▾";
    button.setAttribute("aria-expanded", !isFolded);
  }

  names.forEach((name, index) => {
    if (!hasRowsBelow(index)) return;
    const button = document.createElement("button");
    button.type = "button";
    button.setAttribute("aria-label", `Rows below ${run.rows[index].name}`);
    button.addEventListener("click", () => { fold(index, !folded.has(index)); arrange(); });
    name.prepend(button);
    // A long report begins with what has succeeded folded away.
    const isOpen = run.rows.length <= FOLDS_ABOVE || !run.rows[index].depth
      || run.rows[index].bars.at(-1)[2] !== "success";
    fold(index, !isOpen);
  });

  // ---- the window of time

  function show(begin, end) {
    const length = Math.min(run.duration, Math.max(LEAST, end - begin));
    from = Math.min(Math.max(0, begin), run.duration - length);
    to = from + length;
    for (const drawing of drawings) {
      const height = drawing.viewBox.baseVal.height;
      drawing.setAttribute("viewBox", `${from} 0 ${length} ${height}`);
    }
    axes.forEach(mark);
    timeline.dataset.from = from.toFixed(3);
    timeline.dataset.to = to.toFixed(3);
  }

  function mark(axis) {
    const steps = [0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 30, 60, 120, 300, 600, 1200, 3600];
    const most = axis.clientWidth < 400 ? 4 : 7;
    const step = steps.find((one) => (to - from) / one <= most) || (to - from) / most;
    axis.textContent = "";
    for (let at = Math.ceil(from / step - 1e-6) * step; at < to - 0.04 * (to - from); at += step) {
      const label = document.createElement("span");
      label.style.left = `${(100 * (at - from)) / (to - from)}%`;
      label.textContent = `${short(at)} s`;
      axis.append(label);
    }
  }

  function zoom(factor, about) {
    const length = (to - from) * factor;
    const share = (about - from) / (to - from);
    show(about - share * length, about + (1 - share) * length);
  }

  // ---- the time that is looked at

  function newest(times, time) {
    let low = 0;
    let high = times.length;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (times[middle] <= time) low = middle + 1;
      else high = middle;
    }
    return low - 1;
  }

  function look(time) {
    now = time === null ? null : Math.min(run.duration, Math.max(0, time));
    for (const cursor of cursors) {
      cursor.setAttribute("visibility", now === null ? "hidden" : "visible");
      cursor.setAttribute("x1", now ?? 0);
      cursor.setAttribute("x2", now ?? 0);
    }
    if (now !== null) timeline.dataset.now = now.toFixed(3);
    else delete timeline.dataset.now;
    tell();
    place();
    for (const chart of document.querySelectorAll(".chart")) {
      const { unit, t, v } = run.charts[chart.dataset.name];
      const index = now === null ? -1 : newest(t, now);
      chart.querySelector(".value").textContent = index < 0 ? "" : `${short(v[index])} ${unit}`;
    }
  }

  function barAt(index) {
    const near = 4 * ((to - from) / Math.max(1, bars.clientWidth));
    let best = null;
    for (const bar of run.rows[index].bars) {
      const gap = Math.max(bar[0] - now, now - bar[1], 0);
      if (gap <= near && (best === null || gap < best.gap)) best = { gap, bar };
    }
    return best && best.bar;
  }

  function tell() {
    if (now === null) {
      reading.textContent = HINT;
      return;
    }
    let text = `${short(now)} s. `;
    const bar = row >= 0 && row < run.rows.length ? barAt(row) : null;
    if (bar) {
      const [begin, end, status, message] = bar;
      text += `${run.rows[row].name}: ${status}, from ${short(begin)} s to ${short(end)} s`;
      text += ` (${short(end - begin)} s)${message ? `. ${message}` : ""}`;
    } else {
      const running = run.rows.filter((one) =>
        one.bars.some((span) => span[0] <= now && now < span[1]));
      text += running.length ? `Running: ${running.map((one) => one.name).join(" › ")}` : "";
    }
    reading.textContent = text;
  }

  function place() {
    if (!ghost) return;
    const { t, x, y, yaw } = run.poses;
    const index = now === null ? -1 : Math.max(0, newest(t, now));
    const known = index >= 0 && t.length > 0;
    ghost.setAttribute("visibility", known ? "visible" : "hidden");
    let points = "";
    if (known) {
      ghost.setAttribute("transform", `translate(${x[index]} ${y[index]}) rotate(${yaw[index]})`);
      const scan = run.scans[newest(run.scans.map((one) => one.t), now)];
      for (let i = 0; scan && i < scan.p.length; i += 2) {
        points += `M${scan.p[i] / 100} ${scan.p[i + 1] / 100}h0`;
      }
    }
    seen.setAttribute("d", points);
  }

  function move(step, at) {
    const place = shown.indexOf(row) + step;
    row = shown[Math.min(Math.max(place, 0), shown.length - 1)];
    look(at);
  }

  // ---- mouse, fingers, keys

  function timeAt(drawing, x) {
    const box = drawing.getBoundingClientRect();
    return from + ((x - box.left) / box.width) * (to - from);
  }

  function listen(drawing) {
    const fingers = new Map();
    let pinch = 0;
    const spread = () => {
      const [a, b] = [...fingers.values()];
      return [Math.max(20, Math.abs(a.x - b.x)), (a.x + b.x) / 2];
    };
    drawing.addEventListener("pointerdown", (event) => {
      fingers.set(event.pointerId, { x: event.clientX });
      drawing.setPointerCapture(event.pointerId);
      if (fingers.size === 2) [pinch] = spread();
    });
    drawing.addEventListener("pointermove", (event) => {
      const finger = fingers.get(event.pointerId);
      if (finger) {
        const moved = event.clientX - finger.x;
        finger.x = event.clientX;
        if (fingers.size === 2) {
          const [wide, middle] = spread();
          zoom(pinch / wide, timeAt(drawing, middle));
          pinch = wide;
          return;
        }
        const shift = (moved / drawing.clientWidth) * (to - from);
        if (to - from < run.duration) show(from - shift, to - shift);
      }
      row = drawing === bars
        ? shown[Math.floor((event.clientY - drawing.getBoundingClientRect().top) / ROW)] ?? -1 : -1;
      look(timeAt(drawing, event.clientX));
    });
    const release = (event) => fingers.delete(event.pointerId);
    drawing.addEventListener("pointerup", release);
    drawing.addEventListener("pointercancel", release);
    drawing.addEventListener("wheel", (event) => {
      event.preventDefault();
      if (Math.abs(event.deltaX) > Math.abs(event.deltaY)) {
        const shift = (event.deltaX / drawing.clientWidth) * (to - from);
        show(from + shift, to + shift);
      } else {
        zoom(Math.exp(event.deltaY * 0.0015), timeAt(drawing, event.clientX));
      }
    }, { passive: false });
    drawing.addEventListener("dblclick", () => show(0, run.duration));
  }
  drawings.forEach(listen);

  timeline.addEventListener("keydown", (event) => {
    const length = to - from;
    const at = now ?? from;
    const step = event.shiftKey ? length / 10 : length / 100;
    const keys = {
      ArrowLeft: () => look(at - step),
      ArrowRight: () => look(at + step),
      ArrowUp: () => move(-1, at),
      ArrowDown: () => move(1, at),
      "+": () => zoom(0.7, at),
      "=": () => zoom(0.7, at),
      "-": () => zoom(1 / 0.7, at),
      0: () => show(0, run.duration),
      Home: () => look(0),
      End: () => look(run.duration),
      Escape: () => look(null),
    };
    if (event.target !== timeline || !(event.key in keys) || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    keys[event.key]();
    if (now !== null && (now < from || now > to)) show(now - length / 2, now + length / 2);
  });

  addEventListener("resize", () => axes.forEach(mark));
  arrange();
  show(0, run.duration);
})();
