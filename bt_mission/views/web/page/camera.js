// The robot's camera: its pictures are asked for only while the panel is open.

import { byId } from "./words.js";

export class CameraView {
  // ask(isOpen): called when the panel is opened or closed.
  constructor(ask) {
    this.canvas = byId("camera");
    this.isOpen = false;
    byId("camera-toggle").addEventListener("click", () => {
      this.isOpen = !this.isOpen;
      byId("camera-toggle").setAttribute("aria-expanded", this.isOpen);
      this.canvas.hidden = !this.isOpen;
      byId("camera-title").textContent = this.isOpen ? "Camera: waiting for a picture" : "Camera";
      ask(this.isOpen);
    });
  }

  async show(blob) {
    const picture = await createImageBitmap(blob);
    if (!this.isOpen) return;
    Object.assign(this.canvas, { width: picture.width, height: picture.height });
    this.canvas.getContext("2d").drawImage(picture, 0, 0);
    byId("camera-title").textContent = "Camera";
  }
}
