// The series of a run: a table of numbers, taken by the names in its first line.

/** Columns by name, or nothing where there is no table. */
export function parse(text) {
  const lines = text.split(/\r?\n/).filter((line) => line !== '');
  if (lines.length < 2) return undefined;
  const names = lines[0].split(',').map((name) => name.trim());
  const columns = Object.fromEntries(names.map((name) => [name, []]));
  for (const line of lines.slice(1)) {
    const cells = line.split(',');
    // a line that is being written is not whole yet
    if (cells.length !== names.length) continue;
    names.forEach((name, k) => columns[name].push(cells[k].trim() === '' ? NaN : Number(cells[k])));
  }
  return columns.time?.length > 0 ? columns : undefined;
}

/** Which plots there are, with those of their columns that the table has. */
export function plotsOf(columns) {
  const has = (names) => names.filter((name) => columns[name]);
  const phases = Object.keys(columns).filter((name) => name.startsWith('s_'));
  return [
    { title: 'Energy', unit: 'J', lines: has(['kinetic', 'elastic', 'gravity']) },
    { title: 'Broken bonds', unit: '', lines: has(['broken']), whole: true },
    { title: 'Fragments', unit: '', lines: has(['fragments']), whole: true },
    { title: 'Time per phase', unit: 's', lines: phases },
  ].filter((plot) => plot.lines.length > 0);
}
