import { execFileSync } from 'node:child_process';
import { mkdtempSync, readFileSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { inflateRawSync } from 'node:zlib';
import { binary, type Server } from '../../scripts/server.mjs';
import { tar } from '../../src/pages/upload/tar';

/** A folder for the files of a story. */
export function folder(): string {
  return mkdtempSync(join(tmpdir(), 'bendtwin-story-'));
}

/** A small simulated capture, as `bendtwin capture make` writes it: an archive or, by its name, a folder. */
export function makeCapture(path: string, ...options: string[]): string {
  return makeFull(path, ...options, '--tiny');
}

/** An archive of two small simulated recordings of one object, each of which moves it otherwise. */
export async function makeTwo(folder: string): Promise<string> {
  const takes = ['0', '1'].flatMap((take) => {
    const made = makeCapture(join(folder, `take${take}.zip`), 'toy', '--frames', '12', '--take', take);
    return unzip(readFileSync(made)).map(({ path, bytes }) => ({ path: `take${take}/${path}`, file: new Blob([bytes]) }));
  });
  const document = { path: 'recordings.json', file: new Blob(['{"format": "bendtwin-recordings", "version": 1}']) };
  const file = join(folder, 'two.tar');
  writeFileSync(file, new Uint8Array(await tar([document, ...takes]).arrayBuffer()));
  return file;
}

/** The files in a ZIP archive without a comment, by its directory. */
function unzip(archive: Buffer): { path: string; bytes: Uint8Array<ArrayBuffer> }[] {
  const end = archive.length - 22;
  let at = archive.readUInt32LE(end + 16);
  return Array.from({ length: archive.readUInt16LE(end + 10) }, () => {
    const [method, packed, name] = [archive.readUInt16LE(at + 10), archive.readUInt32LE(at + 20), archive.readUInt16LE(at + 28)];
    const path = archive.toString('utf8', at + 46, at + 46 + name);
    const head = archive.readUInt32LE(at + 42);
    const from = head + 30 + archive.readUInt16LE(head + 26) + archive.readUInt16LE(head + 28);
    at += 46 + name + archive.readUInt16LE(at + 30) + archive.readUInt16LE(at + 32);
    const content = archive.subarray(from, from + packed);
    return { path, bytes: new Uint8Array(method === 0 ? content : inflateRawSync(content)) };
  }).filter(({ path }) => !path.endsWith('/'));
}

/** A simulated capture of full size. */
export function makeFull(path: string, ...options: string[]): string {
  execFileSync(binary(), ['capture', 'make', ...options, path], { stdio: 'ignore' });
  return path;
}

/** Sends a capture by the API and waits until it has been read. */
export async function sendCapture(server: Server, path: string, displayName: string): Promise<string> {
  const query = new URLSearchParams({ display_name: displayName });
  const { name } = await call<{ name: string }>(server, 'POST', `/v1/captures?${query}`, readFileSync(path));
  await until(async () => {
    const { ingest } = await call<{ ingest: { state: string } }>(server, 'GET', `/v1/${name}`);
    return ['SUCCEEDED', 'FAILED'].includes(ingest.state);
  });
  return name;
}

/** A request to the API with JSON or bytes. */
export async function call<T>(server: Server, method: string, path: string, body?: unknown): Promise<T> {
  const isBytes = body instanceof Uint8Array;
  const headers: Record<string, string> = isBytes ? {} : { 'content-type': 'application/json' };
  if (!server.options.includes('none')) headers['authorization'] = `Bearer ${server.token}`;
  const content = body === undefined ? {} : { body: isBytes ? new Uint8Array(body) : JSON.stringify(body) };
  const answer = await fetch(server.url + path, { method, headers, ...content });
  if (!answer.ok) throw new Error(`${method} ${path}: ${await answer.text()}`);
  return answer.status === 204 ? (undefined as T) : ((await answer.json()) as T);
}

/** Asks again until it is so. */
export async function until(isSo: () => Promise<boolean>, seconds = 600): Promise<void> {
  const end = Date.now() + 1000 * seconds;
  while (!(await isSo())) {
    if (Date.now() > end) throw new Error('it did not come to that in time');
    await new Promise((resolve) => setTimeout(resolve, 100));
  }
}

/** An archive of some files and of `bytes` bytes that no reader reads. */
export async function padded(files: Record<string, string>, bytes: number): Promise<Uint8Array> {
  const all = Object.entries(files).map(([path, from]) => ({ path, file: new Blob([readFileSync(from)]) }));
  const padding = new Uint8Array(bytes).map((_, index) => (index * 2654435761) >>> 24);
  return new Uint8Array(
    await tar([...all, { path: 'toy/notes/padding.bin', file: new Blob([padding]) }]).arrayBuffer(),
  );
}
