import { h } from '../ui/dom';
import { colourAt, type ColourMap, type Range } from './colour';

const STEPS = 32;

/** Meaning of colours: a quantity with its unit, and the values at both ends, in text beside the colours. */
export class Legend {
  readonly element = h('div', { class: 'legend', hidden: true });

  /** Explains a colour map. */
  show(quantity: string, unit: string, range: Range, map: ColourMap): void {
    const bar = h('div', { class: 'legend-bar', role: 'img', 'aria-label': `from ${map.name}` });
    for (let step = 0; step < STEPS; step += 1) {
      const [r, g, b] = colourAt(map, step / (STEPS - 1)).map((part) => Math.round(255 * part));
      const cell = h('span');
      cell.style.backgroundColor = `rgb(${r}, ${g}, ${b})`;
      bar.append(cell);
    }
    const texts = [range.low, range.high].map((end) => h('span', {}, number(end)));
    const ends = h('div', { class: 'legend-ends' }, ...texts);
    this.element.replaceChildren(h('div', {}, unit === '' ? quantity : `${quantity} [${unit}]`), bar, ends);
    this.element.hidden = false;
  }

  /** Hides the legend: no value is shown by colour. */
  hide(): void {
    this.element.hidden = true;
  }
}

/** A number of three digits. */
export function number(value: number): string {
  const digits = Number(value.toPrecision(3));
  return Math.abs(digits) >= 1e5 || (digits !== 0 && Math.abs(digits) < 1e-3) ? digits.toExponential() : String(digits);
}
