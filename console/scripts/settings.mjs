// Writes src/pages/fits/known.json, the settings that the form of a new fit knows, from the tables of
// docs/use/settings.md; a unit test compares the two.

import { readFileSync, writeFileSync } from 'node:fs';
import { fileURLToPath } from 'node:url';

const DOCUMENT = new URL('../../docs/use/settings.md', import.meta.url);
const FILE = new URL('../src/pages/fits/known.json', import.meta.url);

/**
 * The settings of fits in the documentation, in its order: name, default as JSON (empty: none), what
 * is allowed, and the first sentence about it.
 * @returns {[string, string, string, string][]}
 */
export function documentedSettings() {
  const [fits = ''] = readFileSync(DOCUMENT, 'utf8').split('# Settings of an ingest');
  return [...fits.matchAll(/^\| `([a-z_0-9.]+)` \|([^|]*)\|([^|]*)\| (.*) \|$/gm)].map(([, ...cells]) => {
    const [name = '', standard = '', allowed = '', meaning = ''] = cells.map((cell) => cell.trim().replaceAll('`', ''));
    const isSwitch = allowed === '' && ['true', 'false'].includes(standard);
    const text = meaning.replace(/\[([^\]]*)\]\([^)]*\)/g, '$1');
    const [sentence = ''] = /^.*?\.(?= [A-Z0-9]|$)/.exec(text) ?? [];
    return [name, standard, isSwitch ? 'true, false' : allowed, sentence];
  });
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  const rows = documentedSettings().map((row) => `  ${JSON.stringify(row)}`);
  writeFileSync(FILE, `[\n${rows.join(',\n')}\n]\n`);
}
