// Finds room for names: no name lies on another one, on a thing, or on the knob of one.
export class Labels {
  constructor() {
    this.taken = [];
  }

  // Keeps names away from here.
  block(x, y, width, height) {
    this.taken.push([x, y, x + width, y + height]);
  }

  // Returns how much of what is there would be covered, px².
  covered(x, y, width, height) {
    const [right, bottom] = [x + width, y + height];
    const shared = ([l, t, r, b]) =>
      Math.max(0, Math.min(r, right) - Math.max(l, x)) * Math.max(0, Math.min(b, bottom) - Math.max(t, y));
    return this.taken.reduce((sum, box) => sum + shared(box), 0);
  }

  // Returns the left top corner of a name beside a thing, or nothing if there is no room; what must
  // be named is named all the same, where it covers least.
  place(x, y, gap, width, height, must) {
    const places = [
      [x - width / 2, y + gap],
      [x - width / 2, y - gap - height],
      [x + gap, y - height / 2],
      [x - gap - width, y - height / 2],
    ];
    const covered = places.map((place) => this.covered(...place, width, height));
    const least = Math.min(...covered);
    const place = least === 0 || must ? places[covered.indexOf(least)] : null;
    if (place) this.block(...place, width, height);
    return place;
  }
}
