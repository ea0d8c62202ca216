/** Odd multipliers of the lanes, with many bits set and different ones each. */
const MULTIPLIERS = [0x9e3779b1, 0x85ebca6b, 0xc2b2ae35, 0x27d4eb2f] as const;

/**
 * A word of 32 hexadecimal digits for a text: by it an upload that was begun before is found again.
 *
 * Distinguishes the files of one person, and does not prevent deliberate collisions; the browser's
 * digests exist on pages over TLS and on this machine only.
 */
export function fingerprint(text: string): string {
  const lanes = Uint32Array.from(MULTIPLIERS);
  for (let index = 0; index < text.length; index += 1) {
    const unit = text.charCodeAt(index);
    for (let lane = 0; lane < 4; lane += 1) step(lanes, lane, unit);
  }
  // What came last has to reach all bits of all lanes.
  for (let round = 0; round < 8; round += 1) {
    for (let lane = 0; lane < 4; lane += 1) step(lanes, lane, lanes[(lane + 1) % 4] ?? 0);
  }
  return [...lanes].map((lane) => lane.toString(16).padStart(8, '0')).join('');
}

function step(lanes: Uint32Array, lane: number, value: number): void {
  const mixed = Math.imul((lanes[lane] ?? 0) ^ value, MULTIPLIERS[lane] ?? 1);
  lanes[lane] = mixed ^ (mixed >>> 15);
}

/** Facts that identify a file without reading it. */
export interface FileFacts {
  readonly path: string;
  readonly size: number;
  /** Milliseconds since 1970. */
  readonly lastModified: number;
}

/** Fingerprint of files by name, size and time of change, in their order. */
export function fingerprintOf(files: readonly FileFacts[]): string {
  return fingerprint(JSON.stringify(files.map((f) => [f.path, f.size, f.lastModified])));
}
