// The built console as it is committed in `built/`: its files compressed, and a table of them for the server. Beside
// them is the page of a single twin, which the server does not show but fills in for exports.

import { readFileSync, readdirSync } from 'node:fs';
import { extname, join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { gunzipSync, gzipSync } from 'node:zlib';

export const DIST = fileURLToPath(new URL('../dist/', import.meta.url));
export const BUILT = fileURLToPath(new URL('../built/', import.meta.url));
export const TABLE = 'files.rs';

/** The page of a single twin, a file of its own. */
export const EMBED = 'embed.html';

/** Most bytes of all files of the console together, and of the page of a twin, compressed. */
export const MOST_BYTES = 350_000;
export const MOST_EMBED_BYTES = 250_000;

/** @type {Record<string, string>} */
const MEDIA_TYPES = {
  '.css': 'text/css; charset=utf-8',
  '.html': 'text/html; charset=utf-8',
  '.js': 'text/javascript; charset=utf-8',
  '.svg': 'image/svg+xml',
};

/**
 * Content of all files below a folder, by their names from there.
 * @param {string} folder
 * @returns {Map<string, Buffer>}
 */
export function read(folder) {
  const entries = readdirSync(folder, { recursive: true, withFileTypes: true }).filter((entry) => entry.isFile());
  const names = entries.map((entry) => join(entry.parentPath, entry.name).slice(folder.length)).sort();
  return new Map(names.map((name) => [name, readFileSync(join(folder, name))]));
}

/**
 * The files of a build as they are committed.
 * @param {Map<string, Buffer>} files
 * @returns {Map<string, Buffer>}
 */
export function pack(files) {
  const packed = new Map([...files].map(([name, content]) => [`${name}.gz`, compress(content)]));
  packed.set(TABLE, Buffer.from(table([...files.keys()].filter((name) => name !== EMBED))));
  return packed;
}

/**
 * Committed files as they were before: compressed bytes differ between versions of zlib, their content does not.
 * @param {Map<string, Buffer>} packed
 * @returns {Map<string, Buffer>}
 */
export function unpack(packed) {
  return new Map(
    [...packed].map(([name, content]) =>
      name.endsWith('.gz') ? [name.slice(0, -'.gz'.length), gunzipSync(content)] : [name, content],
    ),
  );
}

/** @param {Buffer} content */
function compress(content) {
  const compressed = gzipSync(content, { level: 9 });
  // The byte that names the operating system: unknown, wherever it is built.
  compressed[9] = 255;
  return compressed;
}

/**
 * An expression in Rust: address, media type and content of each file.
 * @param {string[]} names
 */
function table(names) {
  const rows = names.map((name) => {
    const type = MEDIA_TYPES[extname(name)];
    if (type === undefined) throw new Error(`${name}: no media type is known for such files`);
    const address = name === 'index.html' ? '/' : `/${name}`;
    return `    ("${address}", "${type}", include_bytes!("${name}.gz")),\n`;
  });
  return `// Written by console/rebuild.\n&[\n${rows.join('')}]\n`;
}
