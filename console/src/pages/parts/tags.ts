/** Most tags that a resource has. */
const MOST = 32;

/** Tags that were typed with spaces or commas between them, and what is wrong with them. */
export function readTags(text: string): { tags: string[]; faults: string[] } {
  const tags = [...new Set(text.split(/[\s,]+/).filter((tag) => tag !== ''))].sort();
  const faults = tags
    .filter((tag) => !/^[\p{L}\p{N}][\p{L}\p{N}\-_.:/]{0,49}$/u.test(tag))
    .map((tag) => `"${tag}" is not a tag: use up to 50 letters, digits and - _ . : /, the first a letter or digit.`);
  if (tags.length > MOST) faults.push(`${tags.length} tags are too many: use at most ${MOST}.`);
  return { tags: tags.filter((tag) => !faults.some((fault) => fault.includes(`"${tag}"`))), faults };
}
