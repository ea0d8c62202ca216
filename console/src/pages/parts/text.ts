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

/** A text of the server as a separate sentence: it begins with a capital, unless it begins with a name, and it ends. */
export function sentence(text: string): string {
  const begun = /^\p{Ll}+(?=[\s,:;.]|$)/u.test(text) ? text.charAt(0).toUpperCase() + text.slice(1) : text;
  return /[.!?]$/.test(begun) ? begun : `${begun}.`;
}
