import { h } from '../../ui/dom';

/** A slider with its value in text beside it. */
export interface Slider {
  readonly element: HTMLElement;
  set(value: number): void;
}

/** A slider for a quantity whose values are shown with a unit; `logarithmic` for factors. */
export function slider(
  label: string,
  range: { readonly low: number; readonly high: number; readonly logarithmic?: boolean },
  show: (value: number) => string,
  changed: (value: number) => void,
): Slider {
  const steps = 100;
  const { low, high, logarithmic = false } = range;
  const valueOf = (step: number): number =>
    logarithmic ? low * (high / low) ** (step / steps) : low + ((high - low) * step) / steps;
  const stepOf = (value: number): number =>
    Math.round(steps * (logarithmic ? Math.log(value / low) / Math.log(high / low) : (value - low) / (high - low)));
  const output = h('output', {});
  const input = h('input', { type: 'range', min: 0, max: steps, 'aria-label': label });
  const tell = (): void => {
    const text = show(valueOf(input.valueAsNumber));
    output.textContent = text;
    input.setAttribute('aria-valuetext', text);
  };
  input.addEventListener('input', () => {
    tell();
    changed(valueOf(input.valueAsNumber));
  });
  return {
    element: h('label', { class: 'slider' }, h('span', {}, label), input, output),
    set: (value) => {
      if (document.activeElement === input) return;
      input.valueAsNumber = stepOf(value);
      tell();
    },
  };
}

/** A button that does something. */
export function button(text: string, onclick: () => void, attributes: Record<string, string> = {}): HTMLButtonElement {
  return h('button', { type: 'button', onclick, ...attributes }, text);
}

/** A button that is on or off. */
export function toggle(text: string, onclick: (on: boolean) => void, on = false): HTMLButtonElement {
  const element = button(text, () => {
    press(element, element.getAttribute('aria-pressed') !== 'true');
    onclick(element.getAttribute('aria-pressed') === 'true');
  }, { 'aria-pressed': String(on) });
  return element;
}

/** Shows whether a button is on. */
export function press(element: HTMLButtonElement, on: boolean): void {
  element.setAttribute('aria-pressed', String(on));
}

/** A group of controls that can be folded away. */
export function panel(title: string, isOpen: boolean, ...children: (HTMLElement | null)[]): HTMLElement {
  return h('details', { class: 'panel', open: isOpen }, h('summary', {}, title), ...children);
}
