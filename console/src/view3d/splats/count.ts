import { h } from '../../ui/dom';

/** A line over the picture that says how many splats are drawn. */
export class SplatCount {
  readonly element = h('p', { class: 'splat-count', hidden: true });

  /** Says how many of all splats are drawn. */
  show(drawn: number, count: number): void {
    const all = count.toLocaleString('en');
    const text = drawn < count ? `${drawn.toLocaleString('en')} of ${all} splats` : `${all} splats`;
    this.element.hidden = false;
    if (this.element.textContent === text) return;
    this.element.textContent = text;
    this.element.title = drawn < count ? 'Fewer splats are drawn, so that pictures come 30 times a second' : '';
  }

  /** Says nothing. */
  hide(): void {
    this.element.hidden = true;
  }
}
