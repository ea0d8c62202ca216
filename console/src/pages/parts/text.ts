import { h, nodes } from '../../ui/dom';

/**
 * A text of the server: it may be written in any direction, as may the names in it, and what stands
 * between backticks is code.
 */
export function prose(text: string): HTMLElement {
  const parts = text.split(/`([^`]+)`/);
  return h(
    'bdi',
    {},
    ...nodes(parts.map((part, index) => (index % 2 === 1 ? h('code', {}, h('bdi', {}, part)) : part))),
  );
}

/** A name within a sentence: marks of direction in it end with it. */
export function isolated(name: string): string {
  return `\u2068${name}\u2069`;
}
