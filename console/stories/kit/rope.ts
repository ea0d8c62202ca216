import type { Server } from '../../scripts/server.mjs';
import { call, until } from './made';

/** Settings with which a fit takes a second. */
const QUICK = ['search.generations=1', 'refine.passes=1'];

/** The id of a twin of a simulated rope, which is recorded and fitted at a server. */
export async function fittedRope(server: Server, name = 'rope'): Promise<string> {
  await server.run('capture', 'make', 'rope', 'rope.zip', '--tiny', '--force');
  const capture = JSON.parse(await server.run('--json', 'capture', 'push', 'rope.zip')) as { name: string };
  const settings = QUICK.flatMap((setting) => ['--set', setting]);
  const started = await server.run('--json', 'fit', 'start', capture.name, '--name', name, ...settings);
  const fit = JSON.parse(started) as { name: string };
  let twin: string | null = null;
  await until(async () => {
    const now = await call<Fit>(server, 'GET', `/v1/${fit.name}`);
    if (now.job.state === 'FAILED') throw new Error(`the fit failed: ${now.job.fault?.message}`);
    twin = now.twin;
    return twin !== null;
  });
  return String(twin).replace('twins/', '');
}

interface Fit {
  readonly twin: string | null;
  readonly job: { readonly state: string; readonly fault: { readonly message: string } | null };
}
