// The stretch of time that all drawings against time show, and how mouse, fingers and keys move it.

const LEAST_S = 0.02;
const STEPS = [0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 30, 60, 120, 300, 600, 1200, 3600];

export class Zoom {
  // go(at): called when the user points at an instant.
  constructor(go) { Object.assign(this, { go, begin: 0, end: 1, duration: 1, at: 0, drawings: new Set() }); }

  reset(duration) {
    this.duration = Math.max(duration, LEAST_S);
    this.show(0, this.duration);
  }

  get length() { return this.end - this.begin; }
  share(at) { return (at - this.begin) / this.length; }

  show(begin, end) {
    const length = Math.min(this.duration, Math.max(LEAST_S, end - begin));
    this.begin = Math.min(Math.max(0, begin), this.duration - length);
    this.end = this.begin + length;
    for (const draw of this.drawings) draw();
  }

  scale(factor, about = this.at) {
    const share = Math.min(Math.max(this.share(about), 0), 1);
    const at = this.begin + share * this.length;
    const length = this.length * factor;
    this.show(at - share * length, at + (1 - share) * length);
  }

  // Keep the instant that is shown in view.
  look(at) {
    this.at = at;
    if (at < this.begin || at > this.end) this.show(at - this.length / 2, at + this.length / 2);
  }

  // Dragging and clicking go to an instant; two fingers, or the wheel with Ctrl, zoom.
  // onPoint(event, at): called when the mouse is over it.
  listen(box, onPoint = () => {}) {
    const fingers = new Map();
    let pinch = 0;
    const timeAt = (x) => {
      const place = box.getBoundingClientRect();
      return this.begin + ((x - place.left) / place.width) * this.length;
    };
    const spread = () => {
      const [one, other] = [...fingers.values()];
      return [Math.max(20, Math.abs(one - other)), (one + other) / 2];
    };
    box.addEventListener("pointerdown", (event) => {
      if (event.button) return;
      fingers.set(event.pointerId, event.clientX);
      box.setPointerCapture(event.pointerId);
      if (fingers.size === 2) [pinch] = spread();
      else this.go(timeAt(event.clientX));
    });
    box.addEventListener("pointermove", (event) => {
      onPoint(event, timeAt(event.clientX));
      if (!fingers.has(event.pointerId)) return;
      fingers.set(event.pointerId, event.clientX);
      if (fingers.size === 2) {
        const [wide, middle] = spread();
        this.scale(pinch / wide, timeAt(middle));
        pinch = wide;
      } else this.go(timeAt(event.clientX));
    });
    for (const name of ["pointerup", "pointercancel"]) {
      box.addEventListener(name, (event) => fingers.delete(event.pointerId));
    }
    box.addEventListener("wheel", (event) => {
      if (Math.abs(event.deltaX) > Math.abs(event.deltaY)) {
        const shift = (event.deltaX / box.clientWidth) * this.length;
        this.show(this.begin + shift, this.end + shift);
      } else if (event.ctrlKey) this.scale(Math.exp(event.deltaY * 0.0015), timeAt(event.clientX));
      else return;
      event.preventDefault();
    }, { passive: false });
    box.addEventListener("dblclick", () => this.show(0, this.duration));
  }

  // Returns whether a key was one of those that move in time.
  key(event) {
    const step = event.shiftKey ? this.length / 10 : this.length / 100;
    const acts = {
      ArrowLeft: () => this.go(this.at - step),
      ArrowRight: () => this.go(this.at + step),
      "+": () => this.scale(0.7),
      "=": () => this.scale(0.7),
      "-": () => this.scale(1 / 0.7),
      0: () => this.show(0, this.duration),
      Home: () => this.go(0),
      End: () => this.go(this.duration),
    };
    if (!(event.key in acts) || event.ctrlKey || event.metaKey || event.altKey) return false;
    acts[event.key]();
    return true;
  }

  // The instants at which an axis of this width has marks.
  marks(width) {
    const most = width < 400 ? 4 : 7;
    const step = STEPS.find((candidate) => this.length / candidate <= most) ?? this.length / most;
    const marks = [];
    for (let at = Math.ceil(this.begin / step - 1e-6) * step; at < this.end - 0.04 * this.length; at += step) marks.push(at);
    return marks;
  }
}
