import { nameOf, packagesOf, type FolderFile, type Package } from './select';

/** Files and folders that were dropped. To be called in the event itself: it is empty afterwards. */
export function packagesOfDrop(data: DataTransfer): Promise<Package[]> {
  const items = [...data.items].filter((item) => item.kind === 'file');
  const entries = items.flatMap((item): (FileSystemEntry | File)[] => {
    const entry = item.webkitGetAsEntry();
    const file = item.getAsFile();
    return entry !== null ? [entry] : file !== null ? [file] : [];
  });
  return gathered(entries.map((entry) => (entry instanceof File ? packagesOfFiles([entry]) : packagesOfEntry(entry))));
}

/** Files that were chosen; those of a folder have a path from it on. */
export async function packagesOfFiles(files: readonly File[]): Promise<Package[]> {
  const folders = new Map<string, FolderFile[]>();
  const packages: Package[] = [];
  for (const file of files) {
    const at = file.webkitRelativePath.indexOf('/');
    if (at < 0) {
      packages.push({ kind: 'file', name: nameOf(file.name), file });
      continue;
    }
    const folder = file.webkitRelativePath.slice(0, at);
    const own = folders.get(folder) ?? [];
    own.push({ path: file.webkitRelativePath.slice(at + 1), file });
    folders.set(folder, own);
  }
  return [...packages, ...(await gathered([...folders].map(([name, own]) => packagesOf(name, own))))];
}

async function packagesOfEntry(entry: FileSystemEntry): Promise<Package[]> {
  if (isFile(entry)) return packagesOfFiles([await fileOf(entry)]);
  const files: FolderFile[] = [];
  await collect(entry as FileSystemDirectoryEntry, '', files);
  return packagesOf(entry.name, files);
}

/** Puts all files below a folder into `files`. Hidden ones are passed over. */
async function collect(folder: FileSystemDirectoryEntry, prefix: string, files: FolderFile[]): Promise<void> {
  const reader = folder.createReader();
  for (;;) {
    // A folder of more than a hundred entries is given in parts.
    const entries = await new Promise<FileSystemEntry[]>((resolve, reject) => reader.readEntries(resolve, reject));
    if (entries.length === 0) return;
    const shown = entries.filter(({ name }) => !name.startsWith('.'));
    await Promise.all(
      shown.map(async (entry) => {
        const path = prefix + entry.name;
        if (isFile(entry)) files.push({ path, file: await fileOf(entry) });
        else await collect(entry as FileSystemDirectoryEntry, `${path}/`, files);
      }),
    );
  }
}

function fileOf(entry: FileSystemFileEntry): Promise<File> {
  return new Promise((resolve, reject) => entry.file(resolve, reject));
}

function isFile(entry: FileSystemEntry): entry is FileSystemFileEntry {
  return entry.isFile;
}

async function gathered(all: readonly Promise<Package[]>[]): Promise<Package[]> {
  return (await Promise.all(all)).flat();
}
