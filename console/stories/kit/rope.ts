import type { Server } from '../../scripts/server.mjs';
import { call, until } from './made';

/** Settings with which a fit takes a second. */
const QUICK = ['search.generations=1', 'refine.passes=1'];

/** The id of a twin of a small simulated rope, which is recorded and fitted at a server. */
export async function fittedRope(server: Server, name = 'rope'): Promise<string> {
  return (await fitted(server, name, ['rope', '--tiny'])).twin;
}

/** Ids of a capture of a simulated scene (options of `capture make`), and of a twin that is fitted to it. */
export async function fitted(
  server: Server,
  name: string,
  scene: readonly string[],
  settings = QUICK,
): Promise<{ capture: string; twin: string }> {
  await server.run('capture', 'make', ...scene, 'made.zip', '--force');
  const capture = JSON.parse(await server.run('--json', 'capture', 'push', 'made.zip', '--name', name)) as { name: string };
  const set = settings.flatMap((setting) => ['--set', setting]);
  const started = await server.run('--json', 'fit', 'start', capture.name, '--name', name, ...set);
  const fit = JSON.parse(started) as { name: string };
  let twin: string | null = null;
  await until(async () => {
    const now = await call<Fit>(server, 'GET', `/v1/${fit.name}`);
    if (now.job.state === 'FAILED') throw new Error(`the fit failed: ${now.job.fault?.message}`);
    twin = now.twin;
    return twin !== null;
  });
  return { capture: capture.name.replace('captures/', ''), twin: String(twin).replace('twins/', '') };
}

interface Fit {
  readonly twin: string | null;
  readonly job: { readonly state: string; readonly fault: { readonly message: string } | null };
}
