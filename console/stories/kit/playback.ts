import type { Server } from '../../scripts/server.mjs';
import { PREFIX, headLength, readHead } from '../../src/playback/file/head';
import type { Placed } from './board';

/** The calibrated cameras of a capture that a server has read. */
export async function camerasOf(server: Server, capture: string): Promise<Placed[]> {
  const answer = await fetch(`${server.url}/v1/${capture}/playback`);
  const bytes = new Uint8Array(await answer.arrayBuffer());
  const data = PREFIX + headLength(bytes);
  const [sequence] = readHead(bytes.subarray(PREFIX, data)).sequences;
  return (sequence?.cameras ?? []).map(({ intrinsics, poses: [first] }) => {
    const pose = Array.from(new Float32Array(bytes.slice(data + first, data + first + 48).buffer));
    return { ...intrinsics, pose };
  });
}
