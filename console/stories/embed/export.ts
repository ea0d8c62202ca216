import { readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { DIST, EMBED } from '../../scripts/built.mjs';
import type { Server } from '../../scripts/server.mjs';

/** Writes the web page of a twin of a server to a folder, and gives its path and the twin's file. */
export async function exportPage(server: Server, twin: string, folder: string): Promise<{ page: string; file: Buffer }> {
  const [page, safetensors] = [join(folder, 'twin.html'), join(folder, 'twin.safetensors')];
  await server.run('twin', 'export', twin, safetensors);
  const file = readFileSync(safetensors);
  // A server that was built earlier has no page, or another.
  if (process.env['BENDTWIN_CONSOLE'] === 'dist') {
    const { display_name: name } = JSON.parse(await server.run('--json', 'twin', 'show', twin)) as { display_name: string };
    const template = readFileSync(join(DIST, EMBED), 'utf8');
    const title = name.replace(/[&<>]/g, (letter) => `&#${letter.charCodeAt(0)};`);
    writeFileSync(page, template.replace('{{name}}', () => title).replace('{{twin}}', () => file.toString('base64')));
  } else await server.run('twin', 'export', twin, page);
  return { page, file };
}
