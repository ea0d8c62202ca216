// Writes schema.ts of the TypeScript client, the types of requests, from the description of the HTTP API; with
// --check it fails if the file is not what would be written.

import { readFileSync, writeFileSync } from 'node:fs';
import openapiTS, { astToString } from 'openapi-typescript';

const DESCRIPTION = new URL('../../proto/src/generated/openapi.json', import.meta.url);
const FILE = new URL('../../client/typescript/src/schema.ts', import.meta.url);
const HEAD = '// Written by `npm run generate` in console from /openapi.json.\n\n';

const description = JSON.parse(readFileSync(DESCRIPTION, 'utf8'));
const text = HEAD + astToString(await openapiTS(description));
if (!process.argv.includes('--check')) writeFileSync(FILE, text);
else if (readFileSync(FILE, 'utf8') !== text) {
  console.error('client/typescript/src/schema.ts is not what the description says: run `npm run generate` in console');
  process.exitCode = 1;
}
