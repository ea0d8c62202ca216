// Writes `built/` from `dist/`; with --check it compares the two instead and fails if they differ.

import { mkdirSync, rmSync, writeFileSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { BUILT, DIST, EMBED, MOST_BYTES, MOST_EMBED_BYTES, pack, read, unpack } from './built.mjs';

const packed = pack(read(DIST));
const different = names();
if (process.argv.includes('--check')) check();
else write();
weigh();

// Another zlib compresses the same content to other bytes: a folder of the same content stays.
function write() {
  if (different.length === 0) return;
  rmSync(BUILT, { recursive: true, force: true });
  for (const [name, content] of packed) {
    const path = join(BUILT, name);
    mkdirSync(dirname(path), { recursive: true });
    writeFileSync(path, content);
  }
}

/** Names of the files of another content. */
function names() {
  const committed = unpack(read(BUILT));
  const wanted = unpack(packed);
  const all = new Set([...committed.keys(), ...wanted.keys()]);
  return [...all].filter((name) => !(committed.get(name)?.equals(wanted.get(name) ?? Buffer.of(0)) ?? false));
}

function check() {
  if (different.length === 0) return;
  console.error(`console/built is not what the sources make:\n  ${different.join('\n  ')}`);
  console.error('run console/rebuild and commit console/built');
  process.exit(1);
}

function weigh() {
  const files = [...packed].filter(([name]) => name.endsWith('.gz'));
  const isEmbed = (/** @type {[string, Buffer]} */ [name]) => name === `${EMBED}.gz`;
  const fits = weighFiles('console', files.filter((file) => !isEmbed(file)), MOST_BYTES);
  if (!weighFiles('page of a twin', files.filter(isEmbed), MOST_EMBED_BYTES) || !fits) process.exit(1);
}

/**
 * Says how large files are; false, with a list of them, if they are too large together.
 * @param {string} what
 * @param {[string, Buffer][]} files
 * @param {number} most
 */
function weighFiles(what, files, most) {
  const bytes = files.reduce((sum, [, content]) => sum + content.length, 0);
  console.log(`${what}: ${files.length} files, ${bytes} bytes compressed, ${most} at most`);
  if (bytes <= most) return true;
  for (const [name, content] of files.sort(([, a], [, b]) => b.length - a.length)) {
    console.error(`${String(content.length).padStart(8)} ${name}`);
  }
  return false;
}
