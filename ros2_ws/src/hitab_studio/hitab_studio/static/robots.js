// Real robots: their map and what their scanners see, on the field, and the camera of the robot that is
// viewed, beside the keys of its behaviors. The map and the pictures are asked for, one after the other,
// while they are shown: the server listens to nothing that no page shows.
const CAMERA_MS = 100;
const MAP_MS = 1000;
const REST_MS = 300;
const DOT = 3; // px

// Numbers of robots with their points, from a binary frame.
export function scans(data) {
  const view = new DataView(data);
  const clouds = [];
  for (let at = 8, k = view.getUint32(4, true); k > 0; k--) {
    const [i, n] = [view.getUint32(at, true), view.getUint32(at + 4, true)];
    clouds.push({ i, points: new Float32Array(data, at + 8, 2 * n) });
    at += 8 + 8 * n;
  }
  return { t: "scans", clouds };
}

export class Robots {
  constructor(field) {
    this.field = field;
    this.off = false; // whether a person has hidden the camera
    this.clear();
    this.again(() => this.askForMap());
    this.again(() => this.askForPicture());
  }

  // Another swarm may number its pictures in the same way.
  clear() {
    this.clouds = [];
    this.map = null;
    this.mapNumber = this.pictureNumber = 0;
  }

  // Calls a function for ever; it tells after how long it is to be called again.
  again(ask) {
    const next = async () => {
      let wait = MAP_MS;
      try {
        wait = await ask();
      } catch {} // the server is away: it comes back
      setTimeout(next, wait);
    };
    next();
  }

  // -- the map

  async askForMap() {
    if (!this.field.roster.real || document.hidden) return REST_MS;
    const answer = await fetch(`/robots/map?after=${this.mapNumber}`);
    if (answer.status !== 200) return MAP_MS;
    const image = await createImageBitmap(await answer.blob());
    this.mapNumber = Number(answer.headers.get("X-Number"));
    this.map = { ...JSON.parse(answer.headers.get("X-Place")), image };
    this.recolor();
    return MAP_MS;
  }

  // The picture has opacities alone.
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
    if (!this.map || !this.field.roster.real) return;
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

  // -- what scanners see

  take({ clouds }) {
    this.clouds = clouds;
  }

  drawScans(c) {
    const { field } = this;
    if (!field.roster.real) return;
    c.fillStyle = field.colors.accent;
    for (const { points } of this.clouds) {
      for (let k = 0; k < points.length; k += 2) {
        const [px, py] = field.toScreen(points[k], points[k + 1]);
        c.fillRect(px - DOT / 2, py - DOT / 2, DOT, DOT);
      }
    }
  }

  // -- the camera

  // What the server says of the camera of the robot that is viewed stands in the overlay.
  async askForPicture() {
    const figure = this.figure();
    const told = document.getElementById("camera-of")?.dataset;
    if (!figure) return REST_MS;
    figure.hidden = !told;
    if (!told) return REST_MS;
    if (told.agent !== figure.dataset.agent) {
      figure.dataset.agent = told.agent;
      this.pictureNumber = 0;
      this.show(null, told);
    }
    const [canvas, caption] = figure.querySelectorAll("canvas, figcaption span");
    caption.textContent = this.off ? "" : this.broken || told.caption;
    figure.classList.toggle("silent", told.silent !== undefined);
    canvas.hidden = this.off || !told.topic || !this.pictureNumber;
    if (this.off || !told.topic || document.hidden) return REST_MS;
    const after = `agent=${encodeURIComponent(told.agent)}&after=${this.pictureNumber}`;
    const answer = await fetch(`/robots/camera?${after}`);
    if (answer.status !== 200) return CAMERA_MS;
    this.pictureNumber = Number(answer.headers.get("X-Number"));
    try {
      this.show(await createImageBitmap(await answer.blob()), told);
      this.broken = "";
    } catch {
      this.broken = `${told.topic} sends a picture that the browser cannot show`;
    }
    return CAMERA_MS;
  }

  show(image, told) {
    const canvas = this.figure().querySelector("canvas");
    [canvas.width, canvas.height] = image ? [image.width, image.height] : [1, 1];
    canvas.setAttribute("aria-label", `What the camera of ${told.agent} sees`);
    if (image) canvas.getContext("2d").drawImage(image, 0, 0);
    image?.close();
  }

  // The place on the page, filled once.
  figure() {
    const figure = document.getElementById("camera");
    if (!figure || figure.firstChild) return figure;
    figure.innerHTML =
      '<canvas role="img"></canvas><figcaption><span data-test="camera-caption"></span>' +
      '<button class="small" data-test="camera-off">Hide</button></figcaption>';
    const button = figure.querySelector("button");
    button.addEventListener("click", () => {
      this.off = !this.off;
      button.textContent = this.off ? "Camera" : "Hide";
      figure.classList.toggle("off", this.off);
    });
    return figure;
  }
}
