// Real robots: the map and the scans on the field, and the camera picture of the viewed robot beside
// the buttons of its behaviors. Binary frames begin with their kind (robots/robot_messages.py).
const DOT = 3; // px; width of a point of a scan
const SCANS = 2;
const MAP = 3;
const PICTURE = 4;

export function layer(data) {
  const view = new DataView(data);
  const t = { [SCANS]: "scans", [MAP]: "map", [PICTURE]: "picture" }[view.getUint32(0, true)];
  if (t === "scans") return { t, points: new Float32Array(data, 4) };
  if (t === "picture") return { t, image: new Blob([data.slice(4)]) };
  const [x, y, yaw, resolution] = new Float32Array(data, 4, 4);
  return { t, x, y, yaw, resolution, image: new Blob([data.slice(20)]) };
}

export class Robots {
  constructor(field) {
    this.field = field;
    this.clear();
  }

  clear() {
    this.points = [];
    this.map = null;
  }

  take(message) {
    if (message.t === "scans") this.points = message.points;
    else if (message.t === "map") this.takeMap(message);
    else if (message.t === "picture") this.showPicture(message);
  }

  async takeMap(message) {
    this.map = { ...message, image: await createImageBitmap(message.image) };
    this.recolor();
  }

  // Colors the map for the theme: its image contains only opacities.
  recolor() {
    if (!this.map) return;
    const { image } = this.map;
    const canvas = new OffscreenCanvas(image.width, image.height);
    const c = canvas.getContext("2d");
    c.drawImage(image, 0, 0);
    c.globalCompositeOperation = "source-in";
    c.fillStyle = this.field.colors.ink;
    c.fillRect(0, 0, image.width, image.height);
    this.map.canvas = canvas;
    this.field.redraw();
  }

  drawMap(c) {
    if (!this.map?.canvas || !this.field.roster.real) return;
    const { x, y, yaw, resolution, canvas } = this.map;
    const cell = resolution * this.field.view.scale;
    const [width, height] = [canvas.width * cell, canvas.height * cell];
    c.save();
    c.translate(...this.field.toScreen(x, y));
    c.rotate(-yaw);
    c.imageSmoothingEnabled = cell < 1;
    c.drawImage(canvas, 0, -height, width, height);
    c.restore();
  }

  drawScans(c) {
    const { field, points } = this;
    if (!field.roster.real) return;
    c.fillStyle = field.colors.accent;
    for (let k = 0; k < points.length; k += 2) {
      const [px, py] = field.toScreen(points[k], points[k + 1]);
      c.fillRect(px - DOT / 2, py - DOT / 2, DOT, DOT);
    }
  }

  async showPicture(message) {
    const image = await createImageBitmap(message.image);
    const canvas = document.querySelector("#camera canvas");
    if (!canvas) return;
    [canvas.width, canvas.height] = [image.width, image.height];
    canvas.getContext("2d").drawImage(image, 0, 0);
    image.close();
  }
}
