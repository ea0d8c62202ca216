// Writes src/api/schema.ts, the types of requests, from the description that a server gives of its
// API; with --check it fails if the file is not what would be written.

import { readFileSync, writeFileSync } from 'node:fs';
import openapiTS, { astToString } from 'openapi-typescript';
import { Server } from './server.mjs';

const FILE = new URL('../src/api/schema.ts', import.meta.url);
const HEAD = '// Written by `npm run generate` from /openapi.json.\n\n';

const server = await Server.start(['--workers', '0']);
try {
  const description = await (await fetch(`${server.url}/openapi.json`)).json();
  const text = HEAD + astToString(await openapiTS(description));
  if (!process.argv.includes('--check')) writeFileSync(FILE, text);
  else if (readFileSync(FILE, 'utf8') !== text) {
    console.error('src/api/schema.ts is not what the server describes: run `npm run generate` in console');
    process.exitCode = 1;
  }
} finally {
  await server.remove();
}
