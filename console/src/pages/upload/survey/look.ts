import type { Package } from '../select';
import { entryOf, type Listing } from './entries';
import { closed, surveyOf, type Survey } from './survey';
import { listTar, listTarGz } from './tar_list';
import { listZip } from './zip';

/** Looks into what is about to be sent, without reading more than names, heads and documents. */
export async function look(source: Package): Promise<Survey> {
  if (source.kind === 'folder') return surveyOf(source.files.map(({ path, file }) => entryOf(path, file)), true);
  const { file } = source;
  const [first = 0, second = 0] = new Uint8Array(await file.slice(0, 2).arrayBuffer());
  if (first === 0x50 && second === 0x4b) return ofListing(await listZip(file), 'ZIP');
  if (first === 0x1f && second === 0x8b) return ofListing(await listTarGz(file), 'tar.gz');
  if (first === 0x89 && second === 0x4d) return closed('MCAP recording', 'Its topics are looked at after the upload.');
  if (first === 0x28 && second === 0xb5) return closed('Compressed recording', 'It is looked at after the upload.');
  const tar = await listTar(file);
  return tar === null ? closed('Markers of motion capture', '', true) : ofListing(tar, 'tar');
}

function ofListing(listing: Listing | null, form: string): Survey | Promise<Survey> {
  if (listing === null) return closed(`${form} archive`, 'It seems to be damaged or cut off: its files cannot be listed.');
  return surveyOf(listing.entries, listing.isWhole);
}
