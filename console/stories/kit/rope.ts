import type { Server } from '../../scripts/server.mjs';
import { call, until } from './made';

/** Settings with which a fit takes seconds: a single start that hardly searches. */
export const QUICK = { search: { generations: 1, starts: 1 }, refine: { passes: 1 } };
/** Settings with which it takes a second, for twins whose motion does not matter: few nodes. */
export const COARSE = { ...QUICK, graph: { max_nodes: 30 } };

/** The id of a twin of a small simulated rope, which is recorded and fitted at a server. */
export async function fittedRope(server: Server, name = 'rope', settings: object = COARSE): Promise<string> {
  return (await fitted(server, name, ['rope', '--tiny'], settings)).twin;
}

/** Ids of a capture of a simulated scene (options of `capture make`), and of a twin that is fitted to it. */
export async function fitted(
  server: Server,
  name: string,
  scene: readonly string[],
  settings: object = QUICK,
): Promise<{ capture: string; twin: string }> {
  await server.run('capture', 'make', ...scene, 'made.zip', '--force');
  const capture = JSON.parse(await server.run('--json', 'capture', 'push', 'made.zip', '--name', name)) as { name: string };
  const twin = await twinOf(server, capture.name, name, settings);
  return { capture: capture.name.replace('captures/', ''), twin };
}

/** Fits a twin to a capture, and gives its id. */
export async function twinOf(server: Server, capture: string, display_name: string, settings: object): Promise<string> {
  const fit = await call<Fit>(server, 'POST', '/v1/fits', { capture, display_name, settings });
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
  readonly name: string;
  readonly twin: string | null;
  readonly job: { readonly state: string; readonly fault: { readonly message: string } | null };
}
