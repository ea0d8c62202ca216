import { h } from './dom';
import type { Child } from './dom';

let fields = 0;

/** A control with its label, and what helps to fill it in. */
export function field(label: string, control: HTMLElement, hint?: Child): HTMLElement {
  fields += 1;
  control.id ||= `field-${fields}`;
  const described = hint === undefined ? null : h('p', { class: 'hint', id: `${control.id}-hint` }, hint);
  if (described !== null) control.setAttribute('aria-describedby', described.id);
  return h('div', { class: 'field' }, h('label', { for: control.id }, label), control, described);
}

/** The share of something that is done, 0..=1, with a label for screen readers. */
export function progress(label: string, fraction: number | null): HTMLProgressElement {
  const value = fraction === null ? {} : { value: fraction.toFixed(3) };
  return h('progress', { max: '1', 'aria-label': label, ...value });
}

/** Facts by name, as a list of terms. */
export function facts(pairs: readonly (readonly [string, Child])[]): HTMLElement {
  return h('dl', { class: 'facts' }, ...pairs.map(([term, fact]) => h('div', {}, h('dt', {}, term), h('dd', {}, fact))));
}
