// Finds room for names: no name lies on another one, or on a thing.
export class Labels {
  constructor() {
    this.taken = [];
  }

  // Keeps names away from here.
  block(x, y, width, height) {
    this.taken.push([x, y, x + width, y + height]);
  }

  isFree(x, y, width, height) {
    const [right, bottom] = [x + width, y + height];
    return !this.taken.some(([l, t, r, b]) => x < r && l < right && y < b && t < bottom);
  }

  // Returns the left top corner of a name beside a thing, or nothing if there is no room; what must
  // be named is named below it all the same.
  place(x, y, gap, width, height, must) {
    const places = [
      [x - width / 2, y + gap],
      [x - width / 2, y - gap - height],
      [x + gap, y - height / 2],
      [x - gap - width, y - height / 2],
    ];
    const free = places.find((place) => this.isFree(...place, width, height));
    const place = free || (must ? places[0] : null);
    if (place) this.block(...place, width, height);
    return place;
  }
}
