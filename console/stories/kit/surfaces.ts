import type { BrowserContext } from 'playwright-core';
import type { Api } from '../../src/api/client';
import { openTwinFile } from '../../src/api/twin_file';
import type { SurfaceReply } from '../../src/view3d/surface/surface';
import { base64, indices } from '../../src/view3d/tensor';

const TYPES = { F32: 'FLOAT32', U32: 'UINT32', U8: 'UINT8' } as const;

/** Answers requests for surfaces with those in the files of twins. */
export async function serveSurfaces(context: BrowserContext, url: string): Promise<void> {
  await context.route(
    (address) => /^\/v1\/twins\/[^/]+\/surface$/.test(address.pathname),
    async (route) => {
      const twin = new URL(route.request().url()).pathname.split('/')[3]!;
      const headers = await route.request().allHeaders();
      const authorization: Record<string, string> = headers['authorization'] ? { authorization: headers['authorization'] } : {};
      const api = {
        fetch: (path: string, init: RequestInit) => {
          return fetch(url + path, { ...init, headers: { ...(init.headers as Record<string, string>), ...authorization } });
        },
      } as unknown as Api;
      await route.fulfill({ json: await surfaceOf(api, twin) });
    },
  );
}

async function surfaceOf(api: Api, twin: string): Promise<SurfaceReply> {
  const { tensors, read } = await openTwinFile(api, twin, new AbortController().signal);
  const of = async (name: string): Promise<NonNullable<SurfaceReply['triangles']> | undefined> => {
    const entry = tensors.get(name) as { dtype: keyof typeof TYPES; shape: number[]; data_offsets: [number, number] } | undefined;
    if (entry === undefined) return undefined;
    return { dtype: TYPES[entry.dtype], shape: entry.shape, data: base64(await read(...entry.data_offsets)) };
  };
  const [counts, nodes, weights, frames, offsets] = await Promise.all(
    ['weight_count', 'weight_node', 'weight', 'frame', 'offset'].map((name) => of(`surface.${name}`)),
  );
  const [triangles, colors, lengths, along, radii] = await Promise.all(
    ['triangle', 'color', 'tube_length', 'tube_node', 'tube_radius'].map((name) => of(`surface.${name}`)),
  );
  let sum = 0;
  const starts = Uint32Array.from([0, ...indices(lengths, 'lengths')], (length) => (sum += length));
  return JSON.parse(JSON.stringify({
    carriers: { weight_counts: counts, weight_nodes: nodes, weights, frames, offsets },
    triangles, colors,
    ...(lengths === undefined ? {} : {
      tube_starts: { dtype: 'UINT32', shape: [starts.length], data: base64(new Uint8Array(starts.buffer)) },
      tube_nodes: along, tube_radii: radii,
    }),
  })) as SurfaceReply;
}
