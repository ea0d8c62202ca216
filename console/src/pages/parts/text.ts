import { h } from '../../ui/dom';
import { withGuide } from '../../ui/guide';

/**
 * A text of the server: it may be written in any direction, as may the names in it, what stands
 * between backticks is code, and references to the guide are links.
 */
export function prose(text: string): HTMLElement {
  return h('bdi', {}, ...withGuide(text, (part) => {
    const parts = part.split(/`([^`]+)`/);
    return parts.map((own, index) => (index % 2 === 1 ? h('code', {}, h('bdi', {}, own)) : own));
  }));
}

/** A name within a sentence: marks of direction in it end with it. */
export function isolated(name: string): string {
  return `\u2068${name}\u2069`;
}
