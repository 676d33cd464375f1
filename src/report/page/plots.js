// Plots that answer: a cursor at the chosen place, what stands under the pointer, a curve that is
// drawn anew at every place.

const SVG = 'http://www.w3.org/2000/svg';

// The area of a plot with its scales.
class Plot {
  constructor(area) {
    this.area = area;
    this.svg = area.ownerSVGElement;
    for (const key of ['x', 'y']) {
      const [low, high, kind] = area.dataset[key].split(' ');
      const log = kind === 'log', value = log ? Math.log : (v) => v;
      const from = value(Number(low)), to = value(Number(high));
      this[key] = {
        share: (v) => (value(v) - from) / (to - from),
        value: (u) => (log ? Math.exp(from + u * (to - from)) : from + u * (to - from)),
      };
    }
    const number = (name) => Number(area.getAttribute(name));
    this.frame = {
      left: number('x'), top: number('y'), width: number('width'), height: number('height'),
    };
  }

  at(x, y) {
    const { left, top, width, height } = this.frame;
    return [left + width * this.x.share(x), top + height * (1 - this.y.share(y))];
  }

  // The value on the x axis under the pointer.
  under(event) {
    const box = this.area.getBoundingClientRect();
    const share = Math.max(0, Math.min(1, (event.clientX - box.left) / box.width));
    return this.x.value(share);
  }

  element(kind, attributes) {
    const made = document.createElementNS(SVG, kind);
    for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
    this.svg.append(made);
    return made;
  }

  moveCursor(x) {
    const { top, height } = this.frame, [at] = this.at(x, 1);
    this.cursor ??= this.element('line', { class: 'cursor' });
    const ends = { x1: at, x2: at, y1: top, y2: top + height };
    for (const [key, value] of Object.entries(ends)) this.cursor.setAttribute(key, value.toFixed(1));
  }

  // A line through points; what lies outside is cut off at the edge.
  curve(name, points) {
    this.curves ??= {};
    this.curves[name] ??= this.element('path', { class: `live ${name}` });
    const { top, height } = this.frame;
    const inside = ([x, y]) => `${x.toFixed(1)} ${Math.max(top, Math.min(top + height, y)).toFixed(1)}`;
    this.curves[name].setAttribute('d', 'M' + points.map((p) => inside(this.at(...p))).join('L'));
  }
}

// A small box with text beside the pointer.
const tip = document.createElement('div');
tip.className = 'tip';
tip.hidden = true;
function showTip(event, lines) {
  tip.replaceChildren(...lines.map((text) => {
    const line = document.createElement('div');
    line.textContent = text;
    return line;
  }));
  tip.hidden = false;
  const { width, height } = tip.getBoundingClientRect();
  const left = event.clientX + 14 + width > innerWidth ? event.clientX - 14 - width : event.clientX + 14;
  tip.style.left = `${Math.max(4, left)}px`;
  tip.style.top = `${Math.max(4, Math.min(event.clientY + 14, innerHeight - height - 4))}px`;
}
