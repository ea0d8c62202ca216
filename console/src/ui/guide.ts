import { h, type Child } from './dom';

/** How messages of the server name a section of the guide from cameras to a twin. */
const REFERENCE = /docs\/use\/cameras\.md(?:#([a-z][a-z0-9-]*))?/;

/** A text, or a reference to a section of the guide, whose name is empty if it names the whole. */
export type Piece = { readonly text: string } | { readonly section: string };

/** A message in pieces: references to the guide, with or without backticks, and the texts around them. */
export function pieces(message: string): Piece[] {
  const found: Piece[] = [];
  let last = 0;
  for (const match of message.matchAll(new RegExp(`(\`?)${REFERENCE.source}\\1`, 'g'))) {
    if (match.index > last) found.push({ text: message.slice(last, match.index) });
    found.push({ section: match[2] ?? '' });
    last = match.index + match[0].length;
  }
  if (last < message.length) found.push({ text: message.slice(last) });
  return found;
}

/** A message whose references to the guide are links, which open beside this page; `text` makes the rest. */
export function withGuide(message: string, text: (text: string) => Child = (own) => own): Child[] {
  return pieces(message).map((piece) => ('section' in piece ? guideLink(piece.section) : text(piece.text)));
}

/** A link to a section of the guide. */
export function guideLink(section: string, text = section === '' ? 'the guide' : `the guide, ${section}`): HTMLElement {
  const href = section === '' ? '/guide.html' : `/guide.html#${section}`;
  const note = h('span', { class: 'visually-hidden' }, ' (opens in a new tab)');
  return h('a', { href, target: '_blank', rel: 'noopener' }, text, note);
}
