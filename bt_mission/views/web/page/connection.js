// The WebSocket: connects again when it is lost, and is then told everything anew.

const FIRST_MS = 300;
const LONGEST_MS = 5000;

export class Connection {
  // take(told): called with each message. onState(text, isLost): how the connection stands.
  // onOpen(): called each time it stands, to ask again for what the page has open.
  // onPicture(blob): called with each picture of the camera.
  constructor(take, onState, onOpen, onPicture) {
    Object.assign(this, { take, onState, onOpen, onPicture, wait: FIRST_MS, socket: null });
    this.connect();
  }

  connect() {
    const url = new URL("live", location.href);
    url.protocol = "ws:";
    const socket = new WebSocket(url);
    this.socket = socket;
    socket.onopen = () => {
      this.wait = FIRST_MS;
      this.onState("connected", false);
      this.onOpen();
    };
    socket.onmessage = (event) => {
      if (typeof event.data === "string") this.take(JSON.parse(event.data));
      else this.onPicture(event.data);
    };
    socket.onclose = (event) => this.lost(event);
  }

  async lost(event) {
    const why = event.reason ? `: ${event.reason}` : "";
    this.onState(`disconnected${why}; reconnecting`, true);
    const answer = await fetch("icon.svg").catch(() => null);
    if (answer && answer.status === 403) {
      this.onState((await answer.text()).trim(), true);
      return;
    }
    setTimeout(() => this.connect(), this.wait);
    this.wait = Math.min(this.wait * 2, LONGEST_MS);
  }

  send(request) {
    if (this.socket?.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify(request));
  }
}
