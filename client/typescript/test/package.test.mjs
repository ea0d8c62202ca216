// The package as it is published: its files, its types in a browser and in Node, and its example against a real server.

import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { cpSync, mkdirSync, mkdtempSync, readFileSync, readdirSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { fileURLToPath } from 'node:url';
import { Server } from '../../../console/scripts/server.mjs';

const PACKAGE = fileURLToPath(new URL('../', import.meta.url));
const MODULES = fileURLToPath(new URL('../../../console/node_modules/', import.meta.url));

/** Settings of a fit that takes a second. */
const QUICK = { graph: { max_nodes: 30 }, search: { generations: 3, population: 6 }, refine: { passes: 2 } };

/** A project that has the package installed. */
let project = '';
/** @type {string[]} */
let files = [];

before(() => {
  project = mkdtempSync(join(tmpdir(), 'bendtwin-client-'));
  const packed = execFileSync('npm', ['pack', '--json', '--silent', '--pack-destination', project], { cwd: PACKAGE });
  // What the scripts of the package print comes first.
  const [{ filename, files: found }] = JSON.parse(packed.toString().slice(packed.toString().indexOf('[\n')));
  files = found.map((/** @type {{ path: string }} */ { path }) => path);
  const installed = join(project, 'node_modules/@bendtwin/client');
  mkdirSync(installed, { recursive: true });
  execFileSync('tar', ['-xzf', join(project, filename), '-C', installed, '--strip-components', '1']);
  cpSync(join(PACKAGE, 'examples'), project, { recursive: true });
});

after(() => rmSync(project, { recursive: true, force: true }));

test('it has its modules with their types, the licences, and nothing else', () => {
  const sources = readdirSync(join(PACKAGE, 'src')).filter((name) => !name.endsWith('.test.ts'));
  const modules = sources.flatMap((name) => ['.js', '.d.ts'].map((end) => `dist/${name.replace(/\.ts$/, end)}`));
  const texts = ['LICENSE-APACHE', 'LICENSE-MIT', 'README.md', 'package.json'];
  assert.deepEqual([...files].sort(), [...modules, ...texts].sort());
});

test('it has the version of the server, and no dependencies', () => {
  const { version, dependencies } = JSON.parse(readFileSync(join(PACKAGE, 'package.json'), 'utf8'));
  const [, wanted] = /\[workspace\.package\]\nversion = "([^"]+)"/.exec(readFileSync(join(PACKAGE, '../../Cargo.toml'), 'utf8')) ?? [];
  assert.equal(version, wanted);
  assert.equal(dependencies, undefined);
});

for (const [place, options] of [
  ['Node', { lib: ['ES2023'], types: ['node'] }],
  ['a browser', { lib: ['ES2023', 'DOM', 'DOM.Iterable'], types: [] }],
]) {
  test(`its types are right in ${place}`, () => {
    const compilerOptions = {
      ...options, target: 'ES2023', module: 'NodeNext', strict: true, noEmit: true, allowJs: true, checkJs: true,
      typeRoots: [join(MODULES, '@types')],
    };
    const use = "import { Client } from '@bendtwin/client';\nexport const version: Promise<string> = new Client()\n" +
      "  .post('/v1/fits', { body: { capture: 'captures/1' } }).then(({ name }) => name);\n" +
      "// @ts-expect-error A fit needs a capture.\nvoid new Client().post('/v1/fits', { body: {} });\n" +
      "// @ts-expect-error There is no such route.\nvoid new Client().get('/v1/nothing');\n";
    writeFileSync(join(project, 'use.mts'), use);
    const include = place === 'Node' ? ['*.mjs', 'use.mts'] : ['use.mts'];
    writeFileSync(join(project, 'tsconfig.json'), JSON.stringify({ compilerOptions, include }));
    compile();
  });
}

/** Checks the types of the project, and shows what is wrong. */
function compile() {
  try {
    execFileSync('node', [join(MODULES, 'typescript/bin/tsc'), '--project', project]);
  } catch (error) {
    assert.fail(String(/** @type {{ stdout?: Buffer }} */ (error).stdout));
  }
}

test('its example goes from a recording to the best motion', { timeout: 120_000 }, async () => {
  const server = await Server.start();
  try {
    const rope = join(project, 'rope.zip');
    await server.run('capture', 'make', 'rope', rope, '--tiny');
    const env = { ...process.env, BENDTWIN_SERVER: server.url, BENDTWIN_TOKEN: server.token };
    const said = execFileSync('node', ['rollout.mjs', rope, JSON.stringify(QUICK)], { cwd: project, env }).toString();
    assert.match(said, /^the recording is \w+$/m);
    assert.match(said, /^motion \d+ costs [\d.e-]+: node 0 ends at -?[\d.]+, -?[\d.]+, -?[\d.]+ m$/m);
  } finally {
    await server.remove();
  }
});
